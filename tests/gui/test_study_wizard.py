"""The steps of a new study: one decision each, bad input told at its field, and what is wanted at the end."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel
from research_world import items_of, known, run_of, runs_of_bars

from annotation.design.designing import Design, draw_design
from annotation.design.planning import Expectations, needed, votes_each
from engine.errors import BadInput
from engine.parameters import declared
from engine.shapes.families.collection import off_text
from engine.shapes.meshfile import load_shape
from gui.pages.study.calculator import expected_of, given_text
from gui.pages.study.design_form import DesignForm, decimals
from gui.pages.study.sources import Source, counted, counts_text, hours_text, plan_text, plural, shape_source, truth_of
from gui.pages.study.wizard import STEPS, StudyWizard
from gui.pages.study.wizard_results import problem
from gui.pages.study.wizard_steps import Place, ending_for, suggested, with_password


@pytest.fixture
def runs(make_bar):
    return runs_of_bars(make_bar)[0]


@pytest.fixture
def jobs():
    """What was asked to be read: (work, done, failed); nothing runs by itself."""
    return []


@pytest.fixture
def wizard(qtbot, runs, jobs, tmp_path):
    items = items_of(runs)
    answers = known(items, {0: "correct", 1: "wrong", 2: "correct"})
    sources = [Source("first", tuple(runs[:2])), Source("second", tuple(runs[2:]))]
    made = StudyWizard(sources, lambda work, done, words, failed: jobs.append((work, done, failed)), lambda: answers, str(tmp_path))
    made.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose, False)
    qtbot.addWidget(made)
    made.show()
    return made


def to(wizard, name):
    """Go forward to a step."""
    while STEPS[wizard.number][0] != name:
        before = wizard.number
        wizard.forward()
        assert wizard.number == before + 1, wizard.error.text()


def test_every_field_of_the_design_has_a_row_with_its_default_and_its_doc(wizard):
    forms = [step.form for step in wizard.steps if hasattr(step, "form")]
    rows = {name: row for form in forms for name, row in form.rows.items()}
    assert set(rows) == set(Design.model_fields)
    for info in declared(Design):
        assert rows[info.name].value == info.default
        assert rows[info.name].help.text() == info.doc
        assert rows[info.name].caption.text() or rows[info.name].editor.text()


def test_what_is_ticked_is_counted_once_whoever_proposed_it(wizard, runs):
    assert wizard.count.text() == "6 matches of 2 methods on 2 pairs"
    wizard.results.table.item(1, 0).setCheckState(Qt.CheckState.Unchecked)
    assert wizard.count.text() == "3 matches of 2 methods on 1 pair"
    assert counted([Source("", tuple(runs))])[:2] == (6, 2)
    assert "4 matches of 1 method" in counts_text([Source("", tuple(runs[::2]))])


def test_a_plan_is_drawn_anew_only_where_it_may_differ(wizard, monkeypatch):
    drawn = []
    monkeypatch.setattr("gui.pages.study.wizard.draw_design", lambda *a, **k: drawn.append(a) or draw_design(*a, **k))
    to(wizard, "place")
    before = len(drawn)
    wizard.place.form.rows["name"].show_value("Another name")
    wizard.place.path.line.setText("/tmp/elsewhere.db")
    assert len(drawn) == before
    wizard.sample.form.rows["most"].show_value(4)
    assert len(drawn) == before + 1
    assert "4 matches to be judged" in wizard.place.summary.text()
    wizard.results.table.item(0, 0).setCheckState(Qt.CheckState.Unchecked)
    assert len(drawn) == before + 2
    assert "3 matches to be judged" in wizard.place.summary.text()


def test_a_letter_of_the_name_counts_nothing_anew(wizard, monkeypatch):
    to(wizard, "place")
    told = []
    monkeypatch.setattr("gui.pages.study.wizard.plan_text", lambda *a: told.append(a) or plan_text(*a))
    wizard.place.form.rows["name"].show_value("Lamps")
    assert told == []
    wizard.sample.expectations.rows["seconds"].show_value(60.0)
    assert len(told) == 1


def test_nothing_ticked_goes_nowhere(wizard):
    for line in range(2):
        wizard.results.table.item(line, 0).setCheckState(Qt.CheckState.Unchecked)
    wizard.next.click()
    assert wizard.number == 0
    assert wizard.error.text() == problem([])
    wizard.go(4)
    assert wizard.number == 0
    assert wizard.marks[0].isChecked()


def test_a_question_is_needed_and_is_asked_for_at_its_field(wizard):
    to(wizard, "question")
    wizard.question.form.rows["question"].show_value("  ")
    wizard.next.click()
    assert wizard.number == 1
    assert "write the 'question'" in wizard.question.form.rows["question"].error.text()
    assert not wizard.question.form.rows["guideline"].error.isVisible()
    wizard.question.form.rows["question"].show_value("Same?")
    wizard.next.click()
    assert wizard.number == 2


def test_overlap_is_for_studies_that_stop_early(wizard):
    rows = wizard.votes.form.rows
    assert rows["overlap"].isEnabled()
    rows["adaptive"].show_value(False)
    assert not rows["overlap"].isEnabled()
    rows["adaptive"].show_value(True)
    rows["votes"].show_value(2)
    assert not rows["overlap"].isEnabled()
    assert not rows["adaptive"].isEnabled()


def test_the_calculator_says_what_an_interval_takes_and_its_number_can_be_taken(wizard):
    to(wizard, "sample")
    step = wizard.sample
    expected = Expectations()
    found = needed(expected, Design(gold=0.0, gold_least=0, practice=0))
    assert step.use.text() == f"Ask {found.matches}"
    assert f"{found.pairs} pairs with {found.matches} matches" in step.answer.text()
    step.expectations.rows["half_width"].show_value(0.2)
    assert step.expected.half_width == pytest.approx(0.2)
    wider = needed(step.expected, Design())
    assert wider.matches < found.matches
    step.use.click()
    assert step.values()["most"] == wider.matches
    step.expectations.rows["half_width"].show_value(0.005)
    step.expectations.rows["correlation"].show_value(1.0)
    assert "Ask" in step.use.text() or "ask for a wider one" in step.answer.text()


def test_what_the_results_at_hand_give():
    assert "One pair alone" in given_text(10, 1, Expectations())
    few, many = given_text(100, 10, Expectations()), given_text(10000, 1000, Expectations())
    assert few.startswith("Your 100 matches on 10 pairs")
    assert few != many


def test_known_answers_come_from_a_table_whose_faults_are_told_beside_it(wizard, runs, tmp_path):
    to(wizard, "checks")
    checks = wizard.checks
    assert checks.form.isHidden()
    checks.source.buttons["csv"].click()
    assert checks.path.isVisible()
    checks.path.line.setText(str(tmp_path / "none.csv"))
    wizard.next.click()
    assert "cannot be read" in checks.path.error.text()
    table = tmp_path / "known.csv"
    table.write_text(f"item,answer\n{items_of(runs)[0]},maybe\n")
    checks.path.line.setText(str(table))
    assert not checks.path.error.isVisible()
    wizard.next.click()
    assert "line 2" in checks.path.error.text()
    table.write_text(f"item,answer\n{items_of(runs)[0]},correct\n")
    wizard.next.click()
    assert STEPS[wizard.number][0] == "place"
    assert list(wizard.known) == [items_of(runs)[0]]


def test_own_votes_make_gold_and_practice_and_the_summary_counts_them(wizard):
    to(wizard, "checks")
    wizard.checks.source.buttons["own"].click()
    wizard.checks.form.rows["gold_least"].show_value(2)
    wizard.checks.form.rows["practice"].show_value(1)
    to(wizard, "place")
    text = wizard.place.summary.text()
    assert "6 matches of 2 methods on 2 pairs." in text
    assert "3 matches to be judged, 2 gold, 1 practice" in text
    assert "for each of 3 volunteers" in text


def test_the_cost_of_a_plan_is_that_of_its_votes(runs):
    design, expected = Design(votes=3, adaptive=False, gold=0.0, practice=0), Expectations(volunteers=3, seconds=10)
    cost = expected_of(draw_design(runs, design), design, expected)
    each = votes_each(3, False, expected.disagreement, expected.abstention, 3)
    assert cost.votes == pytest.approx(6 * each)
    assert cost.hours == pytest.approx(6 * each * 10 / 3600 / 3)
    everybody = Design(votes=0, gold=0.0, practice=0)
    assert expected_of(draw_design(runs, everybody), everybody, expected).votes == pytest.approx(18)


def test_a_study_is_wanted_whole(wizard, qtbot, tmp_path):
    to(wizard, "place")
    wizard.place.form.rows["name"].show_value("My bars")
    assert wizard.place.path.line.text() == str(tmp_path / "My bars.db")
    wizard.place.ways.buttons["folder"].click()
    assert wizard.place.path.line.text() == str(tmp_path / "My bars.concord")
    with qtbot.waitSignal(wizard.wanted) as wanted:
        wizard.next.click()
    (found,) = wanted.args
    assert found.design == Design(name="My bars", gold=0.0, gold_least=0, practice=0)
    assert found.place == Place("folder", str(tmp_path / "My bars.concord"))
    assert [source.title for source in found.sources] == ["first", "second"]
    assert not wizard.next.isEnabled()
    wizard.failed("The disk is full.")
    assert wizard.next.isEnabled()
    assert wizard.place.path.error.text() == "The disk is full."


def test_a_place_that_is_taken_or_missing_is_told_at_the_path(wizard, tmp_path):
    to(wizard, "place")
    (tmp_path / "there.db").write_text("")
    for path, said in ((tmp_path / "there.db", "exists already"), (tmp_path / "no" / "x.db", "no folder"), ("", "Choose where")):
        wizard.place.path.line.setText(str(path))
        wizard.next.click()
        assert said in wizard.place.path.error.text()
    wizard.place.ways.buttons["server"].click()
    assert wizard.place.password.isVisible()
    wizard.next.click()
    assert "postgresql://" in wizard.place.path.error.text()


def test_sets_are_renamed_in_their_cells(wizard):
    wizard.results.table.item(0, 1).setText("renamed")
    assert [run.set_name for source in wizard.results.chosen() for run in source.runs] == ["renamed", "renamed", "bars", "bars"]


def test_files_are_read_in_a_job_and_what_is_wrong_with_them_is_told(wizard, jobs, runs, tmp_path):
    wizard.results.read(tmp_path)
    work, done, failed = jobs.pop()
    assert "Reading" in wizard.results.busy.text()
    with pytest.raises(BadInput, match="holds no results"):
        work(lambda *_: None)
    failed("It holds no results.", "")
    assert wizard.error.text() == "It holds no results."
    assert wizard.results.busy.text() == ""
    done(Source("third", tuple(runs[:1])))
    assert wizard.results.table.rowCount() == 3
    wizard.reject()
    done(Source("late", tuple(runs[:1])))
    assert wizard.results.table.rowCount() == 3


def test_an_empty_wizard_says_what_to_do(qtbot, tmp_path):
    made = StudyWizard([], lambda *_: None, None, str(tmp_path))
    made.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose, False)
    qtbot.addWidget(made)
    made.show()
    assert made.results.empty.isVisible()
    assert not made.results.table.isVisible()
    assert not made.checks.source.buttons["own"].isEnabled()
    assert all(label.text() for label in made.results.findChildren(QLabel) if label.isVisible() and label is not made.results.busy)


def test_paths_and_addresses():
    assert ending_for("a/b", "file") == "a/b.db"
    assert ending_for("a/b.study", "file") == "a/b.study"
    assert ending_for("a/b.db", "folder") == "a/b.concord"
    assert ending_for("a/v1.2", "file") == "a/v1.2.db"
    assert ending_for("", "file") == ""
    assert with_password("postgresql://anna@host/db", "s:e@c") == "postgresql+psycopg://anna:s%3Ae%40c@host/db"
    assert with_password("postgresql://anna@host/db", "") == "postgresql://anna@host/db"


def test_a_suggested_name_is_free_and_can_be_a_name_of_a_file(tmp_path):
    assert suggested(str(tmp_path), "a/b: c", "file") == str(tmp_path / "a-b- c.db")
    (tmp_path / "study.db").write_text("")
    assert suggested(str(tmp_path), "", "file") == str(tmp_path / "study 2.db")


def test_words():
    assert [hours_text(h) for h in (0.001, 0.5, 1.6, 4.0)] == ["1 min", "30 min", "1.6 h", "4 h"]
    assert plural(1, "match", "matches") == "1 match"
    assert [decimals(step) for step in (1, 0.5, 0.01, 5)] == [0, 1, 2, 0]


def test_missing_meshes_are_told(runs):
    design = Design(gold=0.0, practice=0)
    plan = draw_design(runs, design)
    text = plan_text([Source("a", tuple(runs), (), ("long.off was not found",))], plan, expected_of(plan, design, Expectations()))
    assert "1 mesh not found (long.off was not found)" in text


def test_shares_are_shown_in_per_cent_and_kept_as_shares(qtbot):
    form = DesignForm(Design, ("gold", "overlap", "votes"))
    qtbot.addWidget(form)
    assert form.rows["gold"].editor.text() == "5 %"
    form.rows["gold"].editor.setValue(12)
    assert form.values() == {"gold": 0.12, "overlap": 0.2, "votes": 3}


# --- the truth that came along


@pytest.fixture
def at_checks(wizard, runs):
    """The wizard at its step of checks, with results of which three matches are known."""
    items = items_of(runs)
    wizard.results.sources = [source._replace(truth=lambda _, k=k: known(items, {k: "correct", 5: "wrong"}))
                              for k, source in enumerate(wizard.results.sources)]  # fmt: skip
    wizard._counted = None
    to(wizard, "checks")
    return wizard


def answer(jobs):
    """Let what was asked last come to its end."""
    work, done, _ = jobs.pop()
    done(work(lambda *_: None))


def test_the_truth_is_read_in_a_job_and_counted(at_checks, jobs, runs):
    at_checks.checks.source.buttons["truth"].setChecked(True)
    assert not at_checks.checks.path.isVisible()
    at_checks.forward()
    assert "still being read" in at_checks.error.text()
    assert len(jobs) == 1
    answer(jobs)
    assert at_checks.checks.told.text() == "3 matches are known: 2 correct, 1 wrong."
    at_checks.forward()
    assert at_checks.known == known(items_of(runs), {0: "correct", 1: "correct", 5: "wrong"})


def test_other_results_have_another_truth(at_checks, jobs):
    at_checks.checks.source.buttons["truth"].setChecked(True)
    late = jobs.pop()
    at_checks.show_step(0)
    at_checks.results.table.item(1, 0).setCheckState(Qt.CheckState.Unchecked)
    to(at_checks, "checks")
    answer(jobs)
    assert "2 matches are known" in at_checks.checks.told.text()
    late[1](late[0](lambda *_: None))  # an answer on what is no longer ticked
    assert "2 matches are known" in at_checks.checks.told.text()


def test_no_truth_and_a_failing_one_are_said_and_the_step_stays(at_checks, jobs):
    at_checks.results.sources = [source._replace(truth=None) for source in at_checks.results.sources]
    at_checks._counted = None
    at_checks.checks.source.buttons["truth"].setChecked(True)
    answer(jobs)
    assert "no .sem file" in at_checks.checks.told.text()
    at_checks.forward()
    assert "No truth came along" in at_checks.error.text()
    assert STEPS[at_checks.number][0] == "checks"


def test_classes_beside_the_meshes_tell_of_matches(tmp_path, make_bar):
    shapes = []
    for sections, name in ((3, "one"), (4, "two")):
        bar, path = make_bar(sections), tmp_path / f"{name}.off"
        path.write_text(off_text(bar.mesh))
        for ending in (".seg", ".sem"):
            path.with_suffix(ending).write_text("\n".join(map(str, bar.segmentation.labels)))
        shapes.append(load_shape(path))
    run = run_of(*shapes, "careful", [(0, 0), (1, 2)])
    source = shape_source("both", (run,), tuple(shapes))
    ids = [proposal.item.id for proposal in run.proposals]
    assert {item: one.answer for item, one in source.truth(lambda *_: None).items()} == dict(zip(ids, ("correct", "wrong"), strict=True))
    (tmp_path / "two.sem").unlink()
    assert truth_of([source], lambda *_: None) == {}


# --- names that no file can have


def test_a_very_long_name_gives_a_short_file_and_a_path_that_is_too_long_is_refused(wizard):
    to(wizard, "place")
    wizard.place.form.rows["name"].editor.setText("x" * 300)
    assert wizard.place.path.line.text().endswith("/" + "x" * 60 + ".db")
    wizard.place.path.line.setText("/tmp/" + "y" * 250 + ".db")
    wizard.forward()
    assert "too long" in wizard.place.path.error.text()
    assert wizard.next.isEnabled()


def test_the_correlation_within_a_pair_is_explained_where_it_is_asked(wizard):
    to(wizard, "sample")
    assert "intraclass" in wizard.sample.expectations.rows["correlation"].help.text()
    assert wizard.sample.expectations.rows["correlation"].help.isVisible()
    assert not wizard.sample.expectations.rows["volunteers"].help.isVisible()
