"""The page of results: each section says what the votes say, what is empty says what to do, and pictures come when picked."""

from datetime import UTC, datetime

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QStyledItemDelegate
from research_world import items_of, judged_study, runs_of_bars

from annotation import study
from annotation.design.designing import Design, create_design
from annotation.design.flags import Disputed
from annotation.findings.gathering import findings
from annotation.findings.overview import VolunteerRow
from annotation.findings.precision import precision_table
from annotation.findings.tables import tables
from annotation.storage.blobs import keep_shapes
from annotation.voting.majority import majority_of
from gui.jobs import Jobs
from gui.pages.choice_bar import ChoiceBar
from gui.pages.judging import Judging
from gui.pages.plots import IntervalPlot, Mark, colour_of, legend, names, placed, shortened, symbol_of
from gui.pages.quiet_table import fill, quiet_table, row_texts, still_columns
from gui.pages.results.disputed import short_pair
from gui.pages.results.match_preview import PICK, files_of, read_match
from gui.pages.results.page import CHOICES, NO_STUDY, ResultsPage
from gui.pages.results.precision import INTERVAL, LINE, NUMBERS, PRESET, marks
from gui.pages.results.tables import TablesView
from gui.pages.study.volunteers import HEADS, advice, people_cells, summary, when
from gui.session import Session, State

NOW = datetime(2026, 3, 12, 14, 0, tzinfo=UTC)
ANNA = VolunteerRow("anna", False, 12, 3, 1, 0.25, 4.21, "2026-03-01T08:00:00+00:00", "2026-03-12T09:05:00+00:00", 0.9, 2, 1,
                    ("fails gold items",))  # fmt: skip
VOTES = {"anna": dict.fromkeys(range(5), "correct"), "ben": {0: "correct", 1: "wrong", 3: "correct", 4: "wrong"}}


@pytest.fixture
def page(qtbot):
    """The page by itself; `open(path)` opens a study."""
    session, votes, jobs = Session(State(volunteer="anna")), Jobs(), Jobs()
    judging = Judging(session, votes)
    page = ResultsPage(session, judging, jobs)
    qtbot.addWidget(page)
    page.resize(1280, 680)
    page.show()

    def wait():
        qtbot.waitUntil(lambda: not votes.busy() and not jobs.busy(), timeout=30_000)

    def open_study(path):
        judging.open(path)
        qtbot.waitUntil(lambda: judging.handle is not None, timeout=20_000)
        wait()

    page.open, page.wait = open_study, wait
    yield page
    jobs.close()
    judging.close()
    page.shutdown()
    votes.close()


@pytest.fixture
def judged(page, tmp_path, make_bar):
    """The page on a study of bars on which anna and ben differ twice; `page.items` are its matches."""
    page.items = judged_study(tmp_path / "bars.db", make_bar, VOTES, votes=2, gold=0.0, practice=0)
    page.open(tmp_path / "bars.db")
    return page


def choose(page, name):
    page.bar.buttons[name].click()
    page.wait()
    return page.sections[name]


def texts(table):
    return [row_texts(table, line) for line in range(table.rowCount())]


def test_the_choices_are_those_of_the_page(page):
    assert list(page.sections) == [name for name, _ in CHOICES]
    assert page.bar.choice == "precision"


def test_without_a_study_every_section_says_what_to_do(page):
    for name in page.sections:
        page.choose(name)
        assert page.empty.text() == NO_STUDY
        assert page.stack.currentWidget() is page.empty


def test_an_empty_study_says_what_to_do(page, tmp_path):
    study.create_study(tmp_path / "e.db", name="e").close()
    page.open(tmp_path / "e.db")
    for name in ("precision", "agreement", "compared", "disputed"):
        section = choose(page, name)
        assert page.stack.currentWidget() is page.empty
        assert page.empty.text() == section.empty
    people = choose(page, "volunteers")
    assert page.stack.currentWidget() is people
    assert people.head.text() == people.empty
    assert people.buttons["packet"].isEnabled()
    assert not people.buttons["forget"].isEnabled()


def test_precision_is_that_of_the_table_and_is_drawn(judged):
    rows = precision_table(judged.judging.handle)
    section = judged.precision
    assert judged.stack.currentWidget() is section
    assert judged.content.rows == rows
    found = texts(section.table)
    assert [row[0] for row in found] == ["careful", "daring"]
    assert [row[4] for row in found] == ["4 of 4", "5 of 6"]
    assert [row[8] for row in found] == ["50 %", "40 %"]  # two matches are tied
    assert section.plot.marks == tuple(marks(rows))
    assert [m.share for m in section.plot.marks] == [row.micro for row in rows]
    assert "careful" in section.legend.text()


def test_the_preset_of_the_thesis_replaces_the_table(judged):
    judged.precision.thesis.setChecked(True)
    judged.wait()
    section = judged.precision
    assert section.table.isHidden()
    (table,) = tables(findings(judged.judging.handle, preset="thesis"), "precision")
    assert [row_texts(section.as_thesis.tables[0], line) for line in range(len(table.rows))] == [tuple(row) for row in table.rows]
    assert judged.preset == "thesis"
    judged.precision.thesis.setChecked(False)
    judged.wait()
    assert not section.table.isHidden()


@pytest.mark.parametrize("name", ["agreement", "compared"])
def test_tables_of_a_section_are_those_that_are_exported(judged, name):
    section = choose(judged, name)
    assert judged.stack.currentWidget() is section
    found = [table for part in section.names for table in tables(findings(judged.judging.handle), part) if table.rows]
    assert len(section.view.tables) == len(found)
    for widget, table in zip(section.view.tables, found, strict=True):
        assert texts(widget) == [tuple(cell.strip() for cell in row) for row in table.rows]
    assert [remark.text() for remark in section.view.remarks] == [table.remark for table in found]


def test_a_wide_table_is_scrolled_by_the_view_and_has_no_bars_of_its_own(judged, qtbot):
    view = TablesView()
    qtbot.addWidget(view)
    view.resize(300, 200)
    view.show()
    view.show_tables(tables(findings(judged.judging.handle), "compared"))
    QApplication.processEvents()
    (table,) = view.tables
    assert table.width() >= table.horizontalHeader().length() > view.viewport().width()
    assert view.horizontalScrollBar().isVisible()
    assert not table.horizontalScrollBar().isVisible()
    assert not table.verticalScrollBar().isVisible()


def test_figures_follow_votes(judged):
    section = choose(judged, "agreement")
    before = texts(section.view.tables[0])
    study.record_vote(judged.judging.handle, judged.items[1], "ben", "correct")
    judged.judging.refresh()
    judged.wait()
    judged.wait()
    assert texts(section.view.tables[0]) != before


def test_figures_are_worked_out_once_for_all_sections_and_never_kept_over_a_vote(judged, monkeypatch):
    worked = []
    monkeypatch.setattr("gui.pages.results.page.findings", lambda handle: worked.append(handle) or findings(handle))
    for name in ("agreement", "compared", "disputed", "agreement"):
        choose(judged, name)
    assert len(worked) == 1
    judged.bar.buttons["agreement"].click()
    study.record_vote(judged.judging.handle, judged.items[1], "ben", "correct")
    judged.judging.refresh()  # while the figures may still be on their way
    judged.wait()
    judged.wait()
    section = choose(judged, "disputed")
    assert [row.item for row in section.rows] == [judged.items[4]]


def test_a_disputed_match_is_shown_when_it_is_picked(judged, qtbot):
    section = choose(judged, "disputed")
    assert [row.item for row in section.rows] == sorted([judged.items[1], judged.items[4]])
    assert section.chosen == section.rows[0].item  # the first is picked by itself
    judged.wait()
    first = section.preview.shown
    assert not isinstance(first, str), first
    assert first.segments == ((1,), (1,))
    section.table.selectRow(1)
    judged.wait()
    assert section.preview.shown is not first
    with qtbot.waitSignal(section.opened) as wanted:
        section.open_button.click()
    assert wanted.args == [section.rows[1].item]


def test_the_picked_match_stays_picked_and_one_that_is_settled_goes(judged):
    section = choose(judged, "disputed")
    section.table.selectRow(1)
    last = section.chosen
    section.show_content(findings(judged.judging.handle))
    assert section.chosen == last
    study.record_vote(judged.judging.handle, last, "ben", "correct")
    section.show_content(findings(judged.judging.handle))
    assert section.chosen != last
    assert len(section.rows) == 1


def test_a_match_whose_shapes_are_gone_is_explained(page, tmp_path, make_bar):
    runs, _ = runs_of_bars(make_bar)
    with create_design(tmp_path / "s.db", runs, Design(gold=0.0, practice=0)) as handle:
        item = items_of(runs)[0]
        assert "is neither at" in read_match(handle, item, {})
        keep_shapes(handle, [make_bar(3, "one0"), make_bar(4, "two0")])
        assert not isinstance(read_match(handle, item, {}), str)
        assert "no item" in read_match(handle, "nothing", {})


def test_files_of_a_match(tmp_path):
    (tmp_path / "a.off").write_text("")
    both = {"source": {"file": str(tmp_path / "a.off")}, "target": {"file": str(tmp_path / "a.off")}}
    assert files_of(both) == (str(tmp_path / "a.off"),) * 2
    assert files_of({**both, "target": {"file": "gone.off"}}) is None
    assert files_of({"pieces": []}) is None


def test_volunteers_and_their_flags_are_in_words(judged, qtbot):
    section = choose(judged, "volunteers")
    assert [row[0] for row in texts(section.table)] == ["anna", "ben"]
    assert [row[1] for row in texts(section.table)] == ["5", "4"]
    section.table.selectRow(1)
    assert section.chosen == "ben"
    with qtbot.waitSignal(section.wanted) as wanted:
        section.buttons["packet"].click()
    assert wanted.args == ["packet", "ben"]


def test_cells_of_a_volunteer():
    cells = dict(zip(HEADS, people_cells(ANNA, NOW), strict=True))
    assert cells == {"volunteer": "anna", "judged": "12", "left": "3", "time a vote": "4.2 s", "with the majority": ".90",
                     "gold": "2 of 3", "unsure": "25 %", "last vote": "today 09:05", "to look at": "fails gold items"}  # fmt: skip
    new = ANNA._replace(adjudicates=True, seconds=None, unsure=None, agreement=None, gold_right=0, gold_wrong=0, last="", flags=())
    assert people_cells(new, NOW) == ("anna  (adjudicator)", "12", "3", "–", "–", "–", "–", "–", "–")


def test_days_are_told_as_people_do():
    assert when("2026-03-11T23:00:00+00:00", NOW) == "yesterday"
    assert when("2026-03-01T08:00:00+00:00", NOW) == "1 March"
    assert when("2025-12-31T08:00:00+00:00", NOW) == "31 December 2025"
    assert when("no time", NOW) == "–"


def test_what_to_do_next():
    tied = Disputed("x", majority_of(["correct", "wrong"]), True)
    assert summary([ANNA], [tied]) == "1 volunteer · 12 answers · 1 match unresolved, 1 of them for an adjudicator"
    assert "make them adjudicator" in advice([ANNA], [tied])
    assert "No vote is removed" in advice([ANNA], [])
    assert "No vote is removed" in advice([ANNA._replace(adjudicates=True)], [tied])
    assert advice([ANNA._replace(flags=())], []) == ""


def test_marks_stand_side_by_side_in_their_group():
    given = [Mark("vases", "a", 0.5), Mark("vases", "b", 0.7), Mark("lamps", "a", 0.1)]
    assert names(given) == (["vases", "lamps"], ["a", "b"])
    at = placed(given)
    assert [row for _, row, _ in at] == [0, 1, 0]
    assert at[0][0] + at[1][0] == pytest.approx(0)
    assert at[0][0] < at[1][0]
    assert at[2][0] == 1  # alone in its group
    assert legend(given).count("<span") == 2
    assert "&lt;i&gt;" in legend([Mark("g", "<i>", 0.5)])


def test_more_series_than_colours_are_told_apart_by_their_symbols():
    assert len({(colour_of(row), symbol_of(row)) for row in range(40)}) == 40
    assert legend([Mark("g", f"m{k}", 0.5) for k in range(12)]).count("●") == 1


def test_names_beside_each_other_do_not_touch():
    assert shortened(["vases", "lamps"], 400) == ["vases", "lamps"]
    many = shortened([f"a set with a long name {k}" for k in range(30)], 1200)
    assert all(len(name) * 8 <= 40 for name in many)
    assert [name[-1] for name in many[:3]] == ["0", "1", "2"]  # what tells them apart is often at the end


class Counting(QStyledItemDelegate):
    """Counts how often a cell is measured."""

    measured = 0

    def sizeHint(self, option, index):
        self.measured += 1
        return super().sizeHint(option, index)


def test_filling_a_table_measures_each_cell_a_few_times_and_not_all_for_each(qtbot):
    table = quiet_table(("a", "b", "c"), 1, "b", None)
    qtbot.addWidget(table)
    counting = Counting(table)
    table.setItemDelegate(counting)
    table.show()
    QApplication.processEvents()
    fill(table, [("x", "y", str(k)) for k in range(100)], 1)
    QApplication.processEvents()
    before, width = counting.measured, table.columnWidth(2)
    assert 0 < before <= 4 * 300
    with still_columns(table):
        for line in range(100):
            table.item(line, 2).setText("a long text")
    assert counting.measured - before <= 4 * 300
    assert table.columnWidth(2) > width


@pytest.mark.parametrize(("width", "drawn"), [(1280, True), (760, False)])
def test_a_narrow_table_shows_the_numbers_of_an_interval_without_a_line(judged, width, drawn):
    judged.resize(width, 560)
    table = judged.precision.table
    assert table.columnWidth(INTERVAL) >= NUMBERS
    assert (table.columnWidth(INTERVAL) >= NUMBERS + LINE) == drawn
    assert table.isColumnHidden(PRESET)  # it says the same as the method in every row


def test_a_short_table_leaves_its_room_to_the_plot_and_a_long_one_gets_the_larger_part(judged):
    section, rows = judged.precision, judged.content.rows
    table, plot = section.splitter.sizes()
    assert table < plot
    section.show_content(judged.content._replace(rows=rows * 12))
    QApplication.processEvents()
    table, plot = section.splitter.sizes()
    assert table > plot
    assert section.table.height() > 8 * section.table.rowHeight(0)


def test_endings_of_meshes_are_left_out_of_the_list_of_disputed():
    assert short_pair("vase1.off – vase.2.ply") == "vase1 – vase.2"
    assert short_pair("anna.b") == "anna.b"


def test_a_plot_is_made_with_the_first_mark_and_given_back(qtbot):
    plot = IntervalPlot("precision, %")
    qtbot.addWidget(plot)
    plot.show_marks([], False)
    assert plot.plot is None
    plot.show_marks([Mark("g", "m", 0.5, 0.2, 0.9, 0.1, 1.0), Mark("g", "n", 0.4)], True)
    curves = plot.plot.getPlotItem().listDataItems()
    assert [tuple(curve.yData) for curve in curves] == [(0.1, 1.0), (0.2, 0.9), (0.5,), (0.4,)]
    plot.show_marks([Mark("g", "m", 0.5)], True)
    assert len(plot.plot.getPlotItem().listDataItems()) == 1
    plot.shutdown()
    assert plot.plot is None


def test_bands_and_intervals_are_as_wide_on_a_dense_screen_and_end_where_they_end(qtbot, monkeypatch):
    for ratio in (1.0, 2.0):
        plot = IntervalPlot("precision, %")
        qtbot.addWidget(plot)
        monkeypatch.setattr(plot, "devicePixelRatioF", lambda ratio=ratio: ratio)
        plot.show_marks([Mark("g", "m", 0.5, 0.2, 0.9, 0.1, 1.0)], False)
        pens = [curve.opts["pen"] for curve in plot.plot.getPlotItem().listDataItems()[:2]]
        assert [pen.widthF() for pen in pens] == [9 * ratio, 2 * ratio]
        assert {pen.capStyle() for pen in pens} == {Qt.PenCapStyle.FlatCap}
        plot.shutdown()


def test_one_choice_is_marked(qtbot):
    bar = ChoiceBar((("a", "A"), ("b", "B")))
    qtbot.addWidget(bar)
    said = []
    bar.chosen.connect(said.append)
    bar.buttons["b"].click()
    bar.check("a")
    assert (said, bar.choice) == (["b"], "a")
    assert PICK
