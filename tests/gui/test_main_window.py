"""The whole window on small files: matching, selecting, judging, exporting, bad input, and closing."""

import csv
import gc
import json
import sqlite3
import sys
import threading
import weakref
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QDialog, QFileDialog, QLabel, QPushButton
from sqlalchemy import delete

from annotation import study
from annotation.storage import schema
from engine.shapes import matching, proposing
from engine.shapes.families.collection import off_text
from engine.shapes.meshfile import load_shape
from engine.shapes.parameters import DEFAULT_PRESET, PRESETS
from engine.shapes.proposing import is_judged
from gui import actions
from gui.main_window import MainWindow
from gui.pages.shapes.arrange import listed
from gui.pages.shapes.matching import JUDGE, needed


def write_bar(folder, shape, name):
    path = folder / f"{name}.off"
    path.write_text(off_text(shape.mesh))
    path.with_suffix(".seg").write_text("\n".join(map(str, shape.segmentation.labels)))
    return str(path)


@pytest.fixture
def files(tmp_path, make_bar):
    folder = tmp_path / "bars"
    folder.mkdir()
    return write_bar(folder, make_bar(5), "long"), write_bar(folder, make_bar(4), "short")


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return str(tmp_path_factory.mktemp("cache"))


@pytest.fixture
def window(qtbot, tmp_path, monkeypatch, cache):
    monkeypatch.setenv("CONCORD_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("CONCORD_CACHE", cache)
    made = MainWindow(dark=False)
    made.furnish()
    qtbot.addWidget(made)
    made.show()
    made.activateWindow()
    qtbot.waitUntil(made.isActiveWindow)
    qtbot.waitUntil(lambda: made.judging.handle is not None)
    yield made
    made.close()


@pytest.fixture
def ready(window, files, qtbot):
    window.session.update(shown="all")
    window.files.pair(*files)
    settle(window, qtbot)
    assert window.session.state.result is not None, window.messages.text.text()
    assert len(window.session.state.result.ids) >= 4
    return window


def settle(window, qtbot):
    busy = (window.jobs.busy, window.study_jobs.busy, window.studies.jobs.busy, lambda: window.study.desk.busy)
    qtbot.waitUntil(lambda: not any(one() for one in busy), timeout=60_000)


def rows(window):
    return [m.id for m in listed(window.session.state)]


def votes(window):
    """The votes as another program reads them from the file, while the window is open."""
    with sqlite3.connect(f"file:{window.session.state.study}?mode=ro", uri=True) as connection:
        return dict(connection.execute("SELECT item_id, answer FROM current_vote WHERE volunteer = ?",
                                       (window.session.state.volunteer,)))  # fmt: skip


def press(window, qtbot, key):
    qtbot.keyClick(window.shapes.view if window.page == "shapes" else window.study.view, key)


# --- matching


def test_two_files_are_matched_listed_and_drawn(ready):
    assert ready.shapes.view.scenes_shown
    assert ready.shapes.list.rows.rowCount() == len(ready.session.state.result.ids)
    assert "judged yet" in ready.status.text.text()
    assert ready.windowTitle().startswith("long – short")
    assert ready.session.state.set_name == "bars"


def test_list_view_and_state_select_the_same_match(ready, qtbot):
    ids = rows(ready)
    ready.shapes.list.selectRow(1)
    assert ready.session.state.selected == ids[1]
    ready.shapes.view.link_clicked.emit(ids[2])
    assert ready.session.state.selected == ids[2]
    assert ready.shapes.list.currentIndex().row() == 2
    assert ready.shapes.view._drawing.selected == ids[2]
    ready.shapes.view.background_clicked.emit()
    assert ready.session.state.selected == ""
    assert not ready.shapes.list.selectionModel().hasSelection()


def test_a_segment_selects_a_match_that_holds_it(ready):
    match = ready.session.state.matches()[0]
    ready.shapes.view.segment_clicked.emit(1, match.target[0])
    chosen = ready.session.state.match(ready.session.state.selected)
    assert match.target[0] in chosen.target
    assert len(chosen.source + chosen.target) <= len(match.source + match.target)


def test_filter_and_order_reach_list_and_view(ready):
    ready.session.update(shown="single")
    shown = {link.id for link in ready.shapes.view._drawing.links}
    assert shown == set(rows(ready)) == {m.id for m in ready.session.state.matches() if len(m.source + m.target) == 2}
    ready.session.update(shown="all", order="-score")
    scores = [m.score for m in ready.shapes.list.rows.rows]
    assert scores == sorted(scores)


def test_a_live_slider_changes_the_matches_without_describing_again(ready, qtbot):
    proposals = ready.session.state.proposals
    slider = ready.shapes.form.rows["ratio_min"].slider
    slider.setValue(slider.maximum())
    settle(ready, qtbot)
    state = ready.session.state
    assert state.parameters.ratio_min == state.result.parameters.ratio_min == 1.0
    assert state.proposals is proposals
    assert "●" in ready.status.preset.text()


def test_an_expensive_parameter_describes_again(ready, qtbot):
    before = ready.session.state.proposals
    ready.matching.edit("layers", 4, True)
    settle(ready, qtbot)
    assert ready.session.state.proposals is not before
    assert ready.session.state.proposals.source.layers.layers == 4


def test_presets_and_undo_bring_the_results_along(ready, qtbot):
    first = ready.session.state.result
    ready.matching.choose_preset("thesis-rigid")
    settle(ready, qtbot)
    second = ready.session.state.result
    assert second.method == "thesis"
    ready.session.undo()
    assert ready.session.state.result is first
    assert ready.shapes.presets.currentText() == DEFAULT_PRESET
    ready.session.redo()
    assert ready.session.state.result is second
    assert not ready.jobs.busy()


def test_the_learned_method_looks_at_pairs_of_another_in_a_job_that_can_be_stopped(window, files, qtbot, monkeypatch):
    monkeypatch.setattr(matching, "rematch", lambda *a, rematch=matching.rematch, **k: rematched.append(a) or rematch(*a, **k))
    rematched, told, go_on, judge = [], [], threading.Event(), proposing.judge

    def held(*shapes, progress):  # on small shapes it may be through before anybody stops it
        while not go_on.wait(0.005):
            progress(0.0, "held")
        return judge(*shapes, progress=progress)

    monkeypatch.setattr(proposing, "judge", held)
    window.matching.choose_preset("top-down")
    window.files.pair(*files)
    settle(window, qtbot)
    shown, proposals = window.session.state.result, window.session.state.proposals
    window.jobs.started.connect(told.append)
    rematched.clear()
    window.matching.choose_preset("learned")
    assert needed(window.session.state) == JUDGE
    assert window.jobs.busy("judge")
    window.stop()
    settle(window, qtbot)
    state = window.session.state
    assert (state.result, state.parameters, state.preset, rematched) == (shown, PRESETS["top-down"], "top-down", [])
    window.matching.choose_preset("learned")
    window.matching.edit("probability_min", 0.4, True)  # meanwhile; it is followed when the pairs have been judged
    go_on.set()
    settle(window, qtbot)
    state = window.session.state
    assert (state.result.method, state.result.parameters.probability_min) == ("learned", 0.4)
    assert state.proposals is proposals
    assert is_judged(proposals)
    assert "Judging pairs" in told
    assert len(rematched) == 1
    window.matching.choose_preset("learned")
    assert not window.jobs.busy("judge")


def test_a_method_chosen_meanwhile_does_not_wait_for_the_judgement(window, files, qtbot):
    window.matching.choose_preset("top-down")
    window.files.pair(*files)
    settle(window, qtbot)
    window.matching.choose_preset("learned")
    window.matching.choose_preset("thesis-rigid")
    assert not window.jobs.busy("judge")
    settle(window, qtbot)
    assert window.session.state.result.method == "thesis"


def test_stopping_goes_back_to_the_parameters_of_the_shown_matches(ready, qtbot):
    shown = ready.session.state.result
    ready.matching.edit("light_fields", 10, True)
    assert ready.jobs.busy("match")
    ready.stop()
    settle(ready, qtbot)
    qtbot.wait(50)
    assert ready.session.state.result is shown
    assert ready.session.state.parameters == shown.parameters


def test_what_was_stopped_can_be_matched_again(window, qtbot, files, monkeypatch):
    held, describe = threading.Event(), matching.describe

    def slow(shape, parameters, *, progress, cache):
        while not held.wait(0.005):
            progress(0.0, "held")
        return describe(shape, parameters, progress=progress, cache=cache)

    monkeypatch.setattr(matching, "describe", slow)
    window.files.pair(*files)
    qtbot.waitUntil(lambda: window.session.state.source is not None)
    assert "Matching" in window.status.text.text()
    window.stop()
    qtbot.waitUntil(lambda: "Match again" in window.status.text.text())
    assert window.session.state.result is None
    window.actions_by_id["match-again"].trigger()
    assert "Matching" in window.status.text.text()
    held.set()
    settle(window, qtbot)
    assert window.session.state.result is not None


def test_a_chosen_match_stays_in_sight_when_its_reasons_need_room(ready, qtbot):
    ready.resize(1024, 480)
    qtbot.wait(20)
    ready.shapes.list.selectRow(len(rows(ready)) - 1)
    qtbot.wait(50)
    row = ready.shapes.list.visualRect(ready.shapes.list.currentIndex())
    assert ready.shapes.list.viewport().rect().contains(row)


def test_layers_and_nodes_can_be_walked(ready):
    ready.shapes.step_layer(1)
    assert ready.shapes.layers.words.text() == "layer 1 of 8 · 5 + 4 nodes"
    links = ready.shapes.view._drawing.links
    assert links
    assert all(1 in (m.source_layer, m.target_layer) for m in map(ready.session.state.match, [x.id for x in links]))
    ready.shapes.step_node(1)
    assert ready.shapes.layers.node_words.text() == "node 1 of 9 · source 0"
    assert ready.shapes.view._drawing.links == ()
    ready.shapes.step_layer(-5)
    assert ready.session.state.layer == 0
    assert len(ready.shapes.view._drawing.links) == len(ready.session.state.result.ids)


def test_main_matches_are_listed_first_and_a_segment_finds_the_others(ready):
    ready.session.update(shown="main")
    assert set(rows(ready)) == ready.session.state.main
    assert {link.id for link in ready.shapes.view._drawing.links} == ready.session.state.main
    ready.session.update(shown="merged")
    single = next(m for m in ready.session.state.matches() if len(m.source + m.target) == 2)
    ready.shapes.view.segment_clicked.emit(0, single.source[0])
    assert single.source[0] in ready.session.state.match(ready.session.state.selected).source
    assert ready.session.state.selected in rows(ready)


def test_labels_of_one_shape_can_be_chosen(ready, qtbot, tmp_path):
    source = ready.session.state.source
    coarse = tmp_path / "coarse.seg"
    coarse.write_text("\n".join(str(min(label, 2)) for label in source.segmentation.labels))
    ready.files.relabel(0, str(coarse))
    settle(ready, qtbot)
    assert ready.session.state.source.segmentation.count == 3
    assert ready.session.state.target.segmentation.count == 4
    coarse.write_text("1\n2\n")
    ready.files.relabel(0, str(coarse))
    settle(ready, qtbot)
    assert "label" in ready.messages.text.text()
    assert ready.session.state.source.segmentation.count == 3


# --- judging


def test_votes_by_keys_are_on_the_disk_before_the_next_match_shows(ready, qtbot):
    ids, seen = rows(ready), []
    ready.step_match(1)
    ready.session.changed.connect(
        lambda old, new, names: seen.append((old.selected, votes(ready))) if "selected" in names else None
    )
    for key in (Qt.Key.Key_J, Qt.Key.Key_F, Qt.Key.Key_Space):
        press(ready, qtbot, key)
        settle(ready, qtbot)
    assert votes(ready) == dict(zip(ids, ("correct", "wrong", "unsure"), strict=False))
    assert [shown for shown, _ in seen] == ids[:3]
    assert all(shown in on_disk for shown, on_disk in seen)
    assert ready.session.state.selected == ids[3]
    assert "2 of" in ready.status.text.text()
    assert ready.shapes.judge.state.text() == "saved ✓"


def test_the_first_key_without_a_selection_asks_the_first_question(ready, qtbot):
    press(ready, qtbot, Qt.Key.Key_J)
    settle(ready, qtbot)
    assert ready.session.state.selected == rows(ready)[0]
    assert ready.session.state.answers == {}


def test_backspace_takes_votes_back_one_by_one(ready, qtbot):
    ids = rows(ready)
    ready.step_match(1)
    for key in (Qt.Key.Key_J, Qt.Key.Key_J, Qt.Key.Key_Backspace, Qt.Key.Key_Backspace, Qt.Key.Key_Backspace):
        press(ready, qtbot, key)
        settle(ready, qtbot)
    assert votes(ready) == {}
    assert ready.session.state.selected == ids[0]
    assert ready.session.state.verdicts == {}


def test_volunteers_vote_side_by_side_and_a_tie_stays_a_tie(ready, qtbot):
    first = rows(ready)[0]
    for code, key in (("ana", Qt.Key.Key_J), ("ben", Qt.Key.Key_F)):
        ready.shapes.judge.code.setText(code)
        ready.shapes.judge.code.editingFinished.emit()
        settle(ready, qtbot)
        assert ready.session.state.answers == {}
        ready.session.update(selected=first)
        press(ready, qtbot, key)
        settle(ready, qtbot)
    assert ready.session.state.verdicts == {first: "tie"}
    ready.session.update(volunteer="ana")
    settle(ready, qtbot)
    assert ready.session.state.answers == {first: "correct"}


def test_votes_of_another_window_are_read_when_this_one_comes_to_the_front(ready, qtbot):
    first = rows(ready)[0]
    ready.judging.enrol()
    settle(ready, qtbot)
    with study.open_study(ready.session.state.study) as handle:
        study.record_vote(handle, first, "somebody", "wrong")
    other = QDialog()
    other.show()
    other.activateWindow()
    qtbot.waitUntil(lambda: not ready.isActiveWindow())
    other.close()
    ready.activateWindow()
    qtbot.waitUntil(ready.isActiveWindow)
    settle(ready, qtbot)
    assert ready.session.state.verdicts == {first: "wrong"}


def test_a_bad_code_is_refused_and_the_old_one_stays(ready):
    ready.shapes.judge.code.setText("no spaces please")
    ready.shapes.judge.code.editingFinished.emit()
    assert ready.messages.isVisible()
    assert ready.session.state.volunteer == "me"


def test_letters_typed_into_a_field_are_no_votes(ready, qtbot):
    ready.step_match(1)
    ready.shapes.judge.code.setFocus()
    ready.shapes.judge.code.clear()
    qtbot.keyClicks(ready.shapes.judge.code, "jf")
    settle(ready, qtbot)
    assert ready.shapes.judge.code.text() == "jf"
    assert ready.session.state.answers == {}


def test_letters_judge_again_once_a_number_is_entered(ready, qtbot):
    ready.step_match(1)
    chosen = ready.session.state.selected
    ready.shapes.panel.setCurrentIndex(1)
    box = ready.shapes.form.rows["K"].editor
    box.setFocus()
    qtbot.keyClick(box, Qt.Key.Key_J)
    settle(ready, qtbot)
    assert ready.session.state.answers == {}
    qtbot.keyClick(box, Qt.Key.Key_Return)
    assert not box.hasFocus()
    qtbot.keyClick(ready, Qt.Key.Key_J)
    settle(ready, qtbot)
    assert ready.session.state.answers == {chosen: "correct"}


def test_votes_outlive_the_window(ready, qtbot, files):
    ready.step_match(1)
    press(ready, qtbot, Qt.Key.Key_J)
    voted = ready.session.state.study
    ready.close()  # while it may still be saving
    with study.open_study(voted) as handle:
        assert list(study.answers(handle, "me").values()) == ["correct"]


def test_a_locked_study_loses_nothing_and_says_so(ready, qtbot, monkeypatch):
    ready.step_match(1)
    press(ready, qtbot, Qt.Key.Key_J)
    settle(ready, qtbot)
    ready.judging.handle.close()
    ready.judging.handle = study.open_study(ready.session.state.study, busy_seconds=0.1)
    before, selected = votes(ready), ready.session.state.selected
    other = sqlite3.connect(ready.session.state.study, isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    press(ready, qtbot, Qt.Key.Key_F)
    settle(ready, qtbot)
    assert "held by another program" in ready.messages.text.text()
    assert ready.session.state.selected == selected
    other.execute("ROLLBACK")
    other.close()
    assert votes(ready) == before
    press(ready, qtbot, Qt.Key.Key_F)
    settle(ready, qtbot)
    assert votes(ready) == {**before, selected: "wrong"}


def test_a_damaged_study_is_refused_and_the_open_one_stays(ready, qtbot, tmp_path):
    damaged = tmp_path / "broken.db"
    damaged.write_bytes(b"this is no database" * 100)
    handle, before = ready.judging.handle, ready.session.state.study
    ready.judging.open(damaged)
    settle(ready, qtbot)
    assert "broken.db" in ready.messages.text.text()
    assert ready.judging.handle is handle
    assert ready.session.state.study == before
    assert damaged.read_bytes() == b"this is no database" * 100


def test_a_damaged_study_of_ones_own_is_told_and_matching_goes_on(qtbot, tmp_path, monkeypatch, cache, files):
    monkeypatch.setenv("CONCORD_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("CONCORD_CACHE", cache)
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "my votes.db").write_bytes(b"damaged" * 1000)
    window = MainWindow(dark=False)
    qtbot.addWidget(window)
    window.furnish()
    window.files.pair(*files)
    settle(window, qtbot)
    assert "my votes.db" in window.messages.text.text()
    assert window.session.state.result is not None
    window.step_match(1)
    window.answer("correct")
    assert "the vote was not taken" in window.messages.text.text()
    assert window.session.state.answers == {}
    window.judging.open(tmp_path / "other.db", create=True)
    settle(window, qtbot)
    window.answer("correct")
    settle(window, qtbot)
    assert list(window.session.state.answers.values()) == ["correct"]
    window.close()


def test_a_new_study_starts_empty_and_the_old_votes_come_back(ready, qtbot, tmp_path):
    own = ready.session.state.study
    ready.step_match(1)
    press(ready, qtbot, Qt.Key.Key_J)
    settle(ready, qtbot)
    ready.judging.open(tmp_path / "fresh.db", create=True)
    settle(ready, qtbot)
    assert ready.session.state.answers == {}
    ready.judging.open(own)
    settle(ready, qtbot)
    assert list(ready.session.state.answers.values()) == ["correct"]


# --- the voting page and the results


def test_the_voting_page_asks_everything_once_and_thanks(ready, qtbot):
    ready.judging.enrol()
    settle(ready, qtbot)
    ready.show_page("study")
    settle(ready, qtbot)
    assert not ready.status.isVisible()
    asked = []
    for _ in ready.session.state.result.ids:
        asked.append(ready.study.question.asked.item_id)
        press(ready, qtbot, Qt.Key.Key_F)
        settle(ready, qtbot)
        assert asked[-1] in votes(ready)
    assert sorted(asked) == sorted(ready.session.state.result.ids)
    assert ready.study.question is None
    assert "All done" in ready.study.screen.notice.heading.text()
    press(ready, qtbot, Qt.Key.Key_Backspace)
    settle(ready, qtbot)
    assert ready.study.question.asked.item_id == asked[-1]
    assert asked[-1] not in votes(ready)


def test_a_comment_is_kept_with_the_answer_to_its_question_alone(ready, qtbot):
    ready.judging.enrol()
    settle(ready, qtbot)
    ready.show_page("study")
    settle(ready, qtbot)
    first = ready.study.question.asked.item_id
    press(ready, qtbot, Qt.Key.Key_C)
    qtbot.keyClicks(ready.study.screen.comment.line, " the jar's foot is cut ")
    qtbot.keyClick(ready.study.screen.comment.line, Qt.Key.Key_Return)
    for key in (Qt.Key.Key_J, Qt.Key.Key_F):
        press(ready, qtbot, key)
        settle(ready, qtbot)
    with sqlite3.connect(f"file:{ready.session.state.study}?mode=ro", uri=True) as connection:
        kept = dict(connection.execute("SELECT item_id, comment FROM current_vote"))
    assert kept.pop(first) == "the jar's foot is cut"
    assert list(kept.values()) == [""]


def test_the_voting_page_shows_no_method_score_or_verdict(ready, qtbot):
    ready.judging.enrol()
    settle(ready, qtbot)
    ready.show_page("study")
    settle(ready, qtbot)
    texts = " ".join(w.text() for kind in (QLabel, QPushButton) for w in ready.findChildren(kind) if w.isVisible())
    for word in ("thesis", "top-down", "precision", "majority", "score", "votes"):
        assert word not in texts.lower()
    assert ready.study.view._drawing.links == ()


def test_the_voting_page_finds_shapes_again_or_says_which_are_missing(ready, qtbot, files):
    ready.judging.enrol()
    settle(ready, qtbot)
    ready.session.update(source=None, target=None, proposals=None, result=None)
    ready.show_page("study")
    settle(ready, qtbot)
    faces = {len(surface.scene.faces) for surface in ready.study.question.pair.surfaces}
    assert faces == {len(load_shape(file).mesh.faces) for file in files[:2]}
    ready.study.desk._kept.clear()
    with open(files[0], "a") as file:
        file.write("# the same mesh\n")
    ready.show_page("study")
    settle(ready, qtbot)
    assert ready.study.question is not None
    ready.study.desk._kept.clear()
    with open(files[0], "w") as file:
        file.write("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    ready.show_page("study")
    settle(ready, qtbot)
    assert ready.study.question is not None  # the study keeps the shapes of what was added to it
    ready.study.desk._kept.clear()
    with ready.judging.handle.writing() as connection:
        connection.execute(delete(schema.blob))
    ready.show_page("study")
    settle(ready, qtbot)
    assert ready.study.question is None
    assert "long.off" in ready.study.screen.notice.text.text()


def test_the_table_of_results_follows_the_votes(ready, qtbot, tmp_path, monkeypatch):
    ready.step_match(1)
    for key in (Qt.Key.Key_J, Qt.Key.Key_J, Qt.Key.Key_F):
        press(ready, qtbot, key)
        settle(ready, qtbot)
    ready.show_page("results")
    settle(ready, qtbot)
    (row,) = ready.results.content.rows
    assert (row.method, row.set_name, row.correct, row.wrong) == (DEFAULT_PRESET, "bars", 2, 1)
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_, **__: (str(tmp_path / "table.csv"), ""))
    ready.actions_by_id["report-csv"].trigger()
    settle(ready, qtbot)
    with open(tmp_path / "table.csv", newline="") as file:
        (line,) = csv.DictReader(file)
    assert float(line["micro_precision"]) == pytest.approx(2 / 3)
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_, **__: (str(tmp_path / "nowhere" / "table.csv"), ""))
    ready.actions_by_id["report-csv"].trigger()
    settle(ready, qtbot)
    assert ready.messages.isVisible()


# --- files


def test_a_figure_and_the_matches_are_written(ready, tmp_path):
    for ending in ("png", "svg", "pdf"):
        ready.attempt(lambda e=ending: ready.shapes.view.save_figure(tmp_path / f"figure.{e}"), "written")
        assert (tmp_path / f"figure.{ending}").stat().st_size > 1000
    out = tmp_path / "out"
    out.mkdir()
    ready.files.write_result(out)
    content = json.loads((out / "matches.json").read_text())
    assert [m["id"] for m in content["matches"]] == list(ready.session.state.result.ids)
    ready.files.write_result(out / "matches.json" / "below a file")
    assert ready.messages.isVisible()


@pytest.mark.parametrize(
    ("content", "said"),
    [("", "empty"), ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", ""), ("no mesh at all", ""),
     ("OFF\n3 1 0\n0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n", ""), (None, "")],
)  # fmt: skip
def test_bad_files_are_messages_and_the_pair_stays(ready, qtbot, tmp_path, files, content, said):
    bad = tmp_path / "bad.off"
    if content is not None:
        bad.write_text(content)
    before = ready.session.state
    ready.files.drop([files[0], str(bad)])
    settle(ready, qtbot)
    assert ready.messages.isVisible()
    sentence = ready.messages.text.text()
    assert "bad" in sentence
    assert said in sentence
    assert "Traceback" not in sentence
    assert "should not have" not in sentence
    assert ready.session.state.source is before.source
    assert ready.session.state.result is before.result
    ready.messages.copy.click()
    assert sentence in QApplication.clipboard().text()


def test_one_segment_alone_is_a_message(ready, qtbot, tmp_path, make_bar, files):
    ready.files.pair(write_bar(tmp_path, make_bar(1), "single"), files[1])
    settle(ready, qtbot)
    assert "one single segment" in ready.messages.text.text()
    assert not ready.jobs.busy()


def test_what_failed_is_not_said_to_be_matching(ready, qtbot, tmp_path, make_bar, files):
    ready.files.pair(write_bar(tmp_path, make_bar(1), "single"), files[1])
    settle(ready, qtbot)
    assert "Not matched" in ready.status.text.text()
    ready.session.undo()
    settle(ready, qtbot)
    assert ready.session.state.result is not None
    assert "Not matched" not in ready.status.text.text()


def test_meshes_may_be_dropped_one_after_the_other(window, qtbot, files):
    window.files.drop([files[0]])
    assert "drop the target" in window.messages.text.text()
    window.files.drop([files[1]])
    settle(window, qtbot)
    assert window.session.state.source.mesh.name == "long"
    assert window.session.state.target.mesh.name == "short"
    assert not window.messages.isVisible()


def test_three_meshes_that_are_not_there_and_labels_alone_are_explained(window, qtbot):
    window.files.drop(["a.off", "b.off", "c.off"])
    settle(window, qtbot)
    assert window.page == "collection"
    assert "at least two shapes that can be read. a.off was left out" in window.messages.text.text()
    window.files.drop(["a.seg"])
    assert "label file" in window.messages.text.text()


@pytest.mark.parametrize("dropped", [["notes.pdf"], ["a.off", "notes.pdf"], ["1.pdf", "2.pdf", "3.pdf"]])
def test_what_is_no_mesh_is_named_when_it_is_dropped(window, dropped):
    window.files.drop(dropped)
    assert "is nothing that Concord opens; drop meshes (.off" in window.messages.text.text()
    assert dropped[-1].endswith(".pdf")
    assert window.files.waiting == ""


def test_a_folder_with_one_mesh_is_explained(window, files, tmp_path):
    folder = tmp_path / "one"
    folder.mkdir()
    (folder / "long.off").write_bytes(Path(files[0]).read_bytes())
    window.files.drop([str(folder)])
    assert "at least two shapes" in window.messages.text.text()


def test_recent_files_are_remembered(ready, files):
    ready.recent_menu.aboutToShow.emit()
    assert [a.text() for a in ready.recent_menu.actions()] == ["long.off – short.off"]


# --- the window


def test_ids_and_keys_of_actions_are_unique():
    ids = [row.id for row in actions.TABLE]
    assert len(ids) == len(set(ids))
    for page in ("shapes", "puzzle", "study", "results"):
        keys = [key for row in actions.TABLE for key in row.keys if not row.pages or page in row.pages]
        assert len(keys) == len(set(keys))
    assert {row.menu for row in actions.TABLE} == set(actions.MENUS)
    for row in actions.TABLE:
        assert all(key in actions.keys_table() for key in row.keys)
    assert "Lock the join" in actions.keys_table("puzzle")
    assert "Link cameras" not in actions.keys_table("puzzle")
    assert "Lock the join" not in actions.keys_table("shapes")


def test_dark_and_light_reach_every_page(ready, qtbot):
    light = ready.shapes.view._theme.paper
    ready.toggle_dark()
    papers = {ready.shapes.view._theme.paper, ready.study.view._theme.paper}
    assert len(papers) == 1
    assert light not in papers
    assert ready.results.delegate.dark
    ready.toggle_dark()
    assert ready.shapes.view._theme.paper == light


def test_an_unexpected_error_is_a_message(window, qtbot):
    try:
        raise RuntimeError("a slot raised")
    except RuntimeError as error:
        sys.excepthook(type(error), error, error.__traceback__)
    assert "a slot raised" in window.messages.text.text()
    assert "test_an_unexpected_error" in window.messages.details


def test_closing_while_matching_leaves_nothing(qtbot, tmp_path, monkeypatch, files):
    monkeypatch.setenv("CONCORD_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("CONCORD_CACHE", str(tmp_path / "cache"))

    def live_and_go():
        window = MainWindow(dark=True)
        window.furnish()
        window.show()
        window.files.pair(*files)
        qtbot.waitUntil(lambda: window.session.state.source is not None)
        assert window.jobs.busy()
        window.close()
        assert not window.jobs.busy()
        assert window.judging.handle is None
        assert window.shapes.view._owned == []
        window.deleteLater()
        return weakref.ref(window), weakref.ref(window.shapes.view)

    gone = live_and_go()
    qtbot.wait(50)
    gc.collect()
    qtbot.wait(10)
    assert [reference() for reference in gone] == [None, None]
