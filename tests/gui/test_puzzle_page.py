"""The puzzle page on small puzzles: open, solve, look, judge, lock, reject, carry, undo, export; late answers, bad input."""

import csv
import json
import random
import sqlite3
import threading
from dataclasses import replace

import numpy as np
import pytest
from jigsaw import PX, cut_small, picture
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication

from engine.errors import BadInput
from engine.puzzles import solving
from engine.puzzles.imagefile import png_bytes, read_image
from engine.puzzles.piecefolder import write_pieces
from engine.puzzles.solution import Pin
from engine.puzzles.solving import candidate_joins
from gui import folders
from gui.main_window import MainWindow
from gui.pages.puzzle.edits import NO_WISHES
from gui.pages.puzzle.files import CutDialog, PuzzleFiles
from gui.pages.puzzle.hands import pin_of
from gui.pages.puzzle.solving import Cut, check_droppable
from gui.pages.puzzle.state import frame_known, opened
from gui.startup import open_window
from gui.views.puzzle_scene import bins, join_key, join_keys, seams


@pytest.fixture
def window(qtbot, tmp_path, monkeypatch):
    monkeypatch.setenv("CONCORD_HOME", str(tmp_path / "data"))
    made = MainWindow(dark=False)
    made.furnish()
    qtbot.addWidget(made)
    made.show()
    made.activateWindow()
    qtbot.waitUntil(made.isActiveWindow)
    qtbot.waitUntil(lambda: made.judging.handle is not None)
    made.show_page("puzzle")
    made.puzzle.page._lively = lambda: False  # pictures are there at once
    yield made
    made.close()


@pytest.fixture
def ready(window, qtbot):
    """A puzzle of 24 pieces, solved."""
    window.puzzle.session.update(**opened(*cut_small(), "small"))
    window.puzzle.solve()
    settle(window, qtbot)
    assert state(window).solution is not None, window.messages.text.text()
    return window


def settle(window, qtbot):
    qtbot.waitUntil(lambda: not (window.jobs.busy() or window.study_jobs.busy() or window.studies.jobs.busy()), timeout=60_000)


def state(window):
    return window.puzzle.session.state


def press(window, qtbot, key):
    qtbot.keyClick(window.puzzle.page.view, key)
    settle(window, qtbot)


def choose(window, row=0):
    """Select a join by its row and return its name."""
    key = join_key(state(window).solution.joins.sides[row])
    window.puzzle.session.update(selected=key, preview=None, piece=-1)
    return key


def votes(window):
    """The votes as another program reads them from the file, while the window is open."""
    with sqlite3.connect(f"file:{window.session.state.study}?mode=ro", uri=True) as connection:
        return dict(connection.execute("SELECT item_id, answer FROM current_vote"))


# --- opening and solving


def test_a_puzzle_is_solved_shown_and_compared_with_the_truth(ready):
    now, page = state(ready), ready.puzzle.page
    assert now.solution.placed.all()
    assert page.view.layout_shown.placed.all()
    assert len(page.view.overlay.seams) == len(now.solution.joins) == 6 * 3 + 5 * 4
    assert now.marks.scores.direct == 1
    assert page.view.overlay.caption == ""
    ready.puzzle.page.toggle_truth()
    assert "in place 100 %" in page.view.overlay.caption
    assert not len(page.view.overlay.wrong_pieces)
    assert "24 pieces · all placed" in ready.status.text.text()
    assert len(now.items) == len(now.solution.joins)


def test_the_window_starts_on_a_picture_or_a_folder(qtbot, tmp_path, monkeypatch):
    """A folder of pieces is there at once, a picture after somebody said how to cut it."""
    monkeypatch.setenv("CONCORD_HOME", str(tmp_path / "data"))
    pieces, asked = tmp_path / "pieces", []
    write_pieces(cut_small()[0], pieces)
    monkeypatch.setattr(PuzzleFiles, "ask_cut", lambda _, path: asked.append(path))
    for path in (str(pieces), "beach.jpg"):
        made = MainWindow(dark=False)
        qtbot.addWidget(made)
        open_window(made, (path,))
        qtbot.waitUntil(lambda made=made: made.furnished and not made.jobs.busy() and not made.study_jobs.busy(), timeout=60_000)
        assert made.page == "puzzle"
        assert (state(made).puzzle is not None) == (path == str(pieces)), made.messages.text.text()
        made.close()
    assert asked == ["beach.jpg"]


def test_nothing_runs_before_somebody_presses_solve(window, qtbot):
    window.puzzle.session.update(**opened(*cut_small(), "small"))
    assert not window.jobs.busy()
    assert "press Solve" in window.status.text.text()
    assert not window.puzzle.page.view.layout_shown.placed.any()
    assert window.puzzle.page.bar.solve_button.isEnabled()
    qtbot.mouseClick(window.puzzle.page.bar.solve_button, Qt.MouseButton.LeftButton)
    assert window.jobs.busy("puzzle")
    assert not window.puzzle.page.bar.solve_button.isEnabled()
    assert "press Solve" not in window.status.text.text() + window.puzzle.page.join.facts.text()
    settle(window, qtbot)
    assert window.puzzle.page.bar.solve_button.text() == "Solve again"


def test_an_image_is_cut_as_asked_and_a_folder_of_pieces_read_without_truth(window, qtbot, tmp_path, monkeypatch):
    (tmp_path / "beach.png").write_bytes(png_bytes(picture(8, 6)))
    answer_dialog(monkeypatch, pieces=12, turned=True, seed=7)
    window.puzzle.drop([str(tmp_path / "beach.png")])
    qtbot.waitUntil(lambda: state(window).puzzle is not None)
    puzzle = state(window).puzzle
    assert (puzzle.count, puzzle.turned, puzzle.name) == (12, True, "beach")
    assert state(window).truth is not None
    assert window.windowTitle().startswith("beach")
    folder = tmp_path / "shards"
    folder.mkdir()
    for k, piece in enumerate(cut_small()[0].pieces):
        (folder / f"shard {k}.png").write_bytes(png_bytes(piece.image))
    window.puzzle.drop([str(folder)])
    settle(window, qtbot)
    assert (state(window).puzzle.count, state(window).truth) == (24, None)
    assert window.puzzle.page.bar.truth_button.isHidden()
    window.puzzle.solve()
    settle(window, qtbot)
    assert state(window).solution.placed.all()
    assert state(window).marks is None
    window.puzzle.page.toggle_truth()
    assert "cut from a picture" in window.messages.text.text()


def test_the_example_opens_from_the_empty_page(window, qtbot):
    assert not window.puzzle.page.invitation.isHidden()
    assert window.puzzle.page.panel.isHidden()
    window.puzzle.open_example()
    settle(window, qtbot)
    assert state(window).puzzle.count > 200
    assert window.puzzle.page.invitation.isHidden()
    assert not window.puzzle.page.panel.isHidden()


@pytest.mark.parametrize("content", [b"not a picture", b""])
def test_a_bad_picture_is_one_sentence_and_the_puzzle_before_stays(ready, qtbot, tmp_path, content):
    before = state(ready)
    (tmp_path / "bad.png").write_bytes(content)
    ready.puzzle.drop([str(tmp_path / "bad.png")])
    settle(ready, qtbot)
    assert "bad.png" in ready.messages.text.text()
    assert "Traceback" not in ready.messages.text.text()
    assert state(ready).puzzle is before.puzzle
    assert state(ready).solution is before.solution


def test_what_cannot_be_dropped_is_said(window, tmp_path):
    window.puzzle.drop([str(tmp_path / "a.png"), str(tmp_path / "b.png")])
    assert "Drop one picture" in window.messages.text.text()
    assert check_droppable([str(tmp_path)]) == ("folder", str(tmp_path))
    with pytest.raises(BadInput):
        check_droppable([])


def test_folders_and_pictures_go_to_the_puzzle_page_and_meshes_to_the_shapes(window, qtbot, tmp_path, monkeypatch):
    assert window.puzzle.takes([str(tmp_path)])
    assert window.puzzle.takes(["a.PNG"])
    assert not window.puzzle.takes(["a.off", "b.png"])
    assert not window.puzzle.takes([])
    window.show_page("shapes")
    asked = []
    monkeypatch.setattr(window.puzzle.files, "ask_cut", asked.append)
    window.files.drop(["beach.jpg"])
    assert asked == ["beach.jpg"]
    assert window.page == "puzzle"
    window.puzzle.page.view.files_dropped.emit(["lamp.off"])
    assert "drop the target" in window.messages.text.text()


def answer_dialog(monkeypatch, pieces, turned=False, seed=0):
    """Let the next dialog be answered at once."""

    def exec_(dialog):
        dialog.pieces.setValue(pieces)
        dialog.turned.setChecked(turned)
        dialog.seed.setValue(seed)
        return CutDialog.DialogCode.Accepted

    monkeypatch.setattr(CutDialog, "exec", exec_)


def test_more_pieces_than_the_pixels_allow_are_refused_in_a_sentence(window, qtbot, tmp_path, monkeypatch):
    (tmp_path / "tiny.png").write_bytes(png_bytes(picture(1, 1)))
    answer_dialog(monkeypatch, pieces=5000)
    window.puzzle.drop([str(tmp_path / "tiny.png")])
    qtbot.waitUntil(lambda: "too small" in window.messages.text.text())
    assert state(window).puzzle is None


def test_the_dialog_gives_back_what_was_chosen(window):
    dialog = CutDialog(picture(), "a.png", Cut("merged", 33, True, 5), window)
    assert dialog.how() == Cut("merged", 33, True, 5)
    dialog.kind.setCurrentIndex(3)
    dialog.pieces.setValue(80)
    assert dialog.how() == Cut("triangles", 80, True, 5)
    dialog.deleteLater()


# --- looking and judging


def test_a_click_on_a_join_opens_the_close_up_with_its_partners(ready, qtbot):
    page = ready.puzzle.page
    page.bar.slider.setValue(100)
    assert page.view.overlay.shown.all()
    segment = seams(page.view.layout_shown, state(ready).solution.joins)[5]
    at = page.view.view.to_screen(segment.mean(axis=0)).round().astype(int)
    qtbot.mouseClick(page.view, Qt.MouseButton.LeftButton, pos=page.view.rect().topLeft() + _point(at))
    assert state(ready).row == 5
    assert page.join.closeup.pair.pixels.shape[2] == 4
    assert "confidence" in page.join.facts.text()
    partners = page.join.strip.partners
    assert partners
    assert [p.current for p in partners].count(True) == 1
    assert page.view.overlay.selected == 5


def _point(at):
    from PySide6.QtCore import QPoint

    return QPoint(int(at[0]), int(at[1]))


def test_n_goes_from_the_most_doubtful_join_on(ready, qtbot):
    ready.puzzle.session.update(below=1.0)
    order = np.argsort(state(ready).solution.joins.confidence, kind="stable").tolist()
    seen = []
    for _ in range(3):
        press(ready, qtbot, Qt.Key.Key_N)
        seen.append(state(ready).row)
    press(ready, qtbot, Qt.Key.Key_P)
    assert seen == order[:3]
    assert state(ready).row == order[1]


def test_the_slider_hides_the_certain_joins(ready):
    page, joins = ready.puzzle.page, state(ready).solution.joins
    page.bar.slider.setValue(80)
    assert state(ready).below == 0.8
    assert page.view.overlay.shown.tolist() == (joins.confidence < 0.8).tolist()
    page.bar.slider.setValue(0)
    assert not page.view.overlay.shown.any()


def test_j_and_f_are_on_the_disk_at_once_and_colour_the_joins(ready, qtbot):
    ready.puzzle.session.update(below=1.0)
    first = choose(ready, 2)
    item = state(ready).item
    press(ready, qtbot, Qt.Key.Key_J)
    assert votes(ready) == {item: "correct"}
    assert state(ready).selected not in (None, first)  # the next one is asked
    assert ready.puzzle.page.view.overlay.judged == {2: "correct"}
    second = state(ready).item
    press(ready, qtbot, Qt.Key.Key_F)
    assert votes(ready) == {item: "correct", second: "wrong"}
    assert set(ready.puzzle.page.view.overlay.judged.values()) == {"correct", "wrong"}
    press(ready, qtbot, Qt.Key.Key_Backspace)
    assert votes(ready) == {item: "correct"}
    assert state(ready).item == second


def test_votes_survive_solving_again_and_undo_and_another_start(ready, qtbot):
    key = choose(ready, 4)
    item = state(ready).item
    press(ready, qtbot, Qt.Key.Key_F)
    ready.puzzle.session.update(**opened(*cut_small(seed=9), "small"))  # the same pieces in another order
    ready.puzzle.solve()
    settle(ready, qtbot)
    rows = [k for k, found in enumerate(state(ready).items) if found == item]
    assert len(rows) == 1
    assert ready.puzzle.page.view.overlay.judged == {rows[0]: "wrong"}
    ready.puzzle.session.undo()  # solving
    ready.puzzle.session.undo()  # opening
    assert votes(ready) == {item: "wrong"}
    assert ready.puzzle.page.view.overlay.judged == {4: "wrong"}
    assert join_keys(state(ready).solution.joins)[4] == key


def test_the_first_vote_puts_the_run_into_the_study(ready, qtbot):
    choose(ready, 1)
    press(ready, qtbot, Qt.Key.Key_J)
    with sqlite3.connect(f"file:{ready.session.state.study}?mode=ro", uri=True) as connection:
        runs = connection.execute("SELECT kind, set_name FROM run").fetchall()
        items = connection.execute("SELECT count(*) FROM item").fetchone()[0]
    assert runs == [("puzzle", "small")]
    assert items == len(set(state(ready).items))


# --- locking, rejecting, carrying


def test_a_rejected_join_does_not_come_back_and_undo_brings_it_back(ready, qtbot):
    before = state(ready).solution
    key = choose(ready, 3)
    press(ready, qtbot, Qt.Key.Key_X)
    assert join_keys(state(ready).wishes.forbidden) == [key]
    assert key not in join_keys(state(ready).solution.joins)
    assert state(ready).solved_with is state(ready).wishes
    assert "1 rejected" in ready.status.text.text()
    ready.actions_by_id["undo"].trigger()
    settle(ready, qtbot)
    assert state(ready).solution is before
    assert state(ready).wishes is NO_WISHES
    ready.actions_by_id["redo"].trigger()
    settle(ready, qtbot)
    assert join_keys(state(ready).wishes.forbidden) == [key]


def test_a_locked_join_is_held_marked_and_let_go_again(ready, qtbot):
    key = choose(ready, 3)
    press(ready, qtbot, Qt.Key.Key_L)
    row = state(ready).row
    assert ready.puzzle.page.view.overlay.locked.tolist() == [k == row for k in range(len(state(ready).solution.joins))]
    assert "locked" in ready.puzzle.page.join.facts.text()
    assert ready.puzzle.page.join.lock.text().startswith("Unlock")
    assert key in join_keys(state(ready).solution.joins)
    press(ready, qtbot, Qt.Key.Key_L)
    assert not state(ready).wishes


def test_a_piece_in_the_tray_shows_its_sides_by_confidence_and_its_best_partner(ready, qtbot):
    ready.puzzle.hands.put_back(5)
    settle(ready, qtbot)
    assert not state(ready).solution.placed[5]
    page = ready.puzzle.page
    page.view.piece_clicked.emit(5)
    assert state(ready).preview.sides[0, 0] == 5
    first = int(state(ready).preview.sides[0, 1])
    assert "Tried out" in page.join.heading.text()
    assert len(page.view.overlay.sides) == 4
    sure = [candidate_joins(state(ready).prepared, 5, side).confidence[0] for side in range(4)]
    assert first == int(np.argmax(sure))
    assert page.view.overlay.side_bins.tolist() == bins(np.array(sure)).tolist()
    page.view.piece_clicked.emit(5)  # its next side
    assert int(state(ready).preview.sides[0, 1]) == int(np.argsort(sure)[::-1][1])
    page.view.piece_clicked.emit(4)
    assert state(ready).preview is None
    assert not len(page.view.overlay.sides)


def test_each_wish_can_be_taken_back_by_itself(ready, qtbot):
    first = choose(ready, 3)
    press(ready, qtbot, Qt.Key.Key_X)
    choose(ready, 7)
    press(ready, qtbot, Qt.Key.Key_L)
    ready.puzzle.session.update(piece=2, selected=None)
    press(ready, qtbot, Qt.Key.Key_L)
    panel = ready.puzzle.page.join
    assert panel.wishes.text() == "1 locked · 1 rejected · 1 pinned"
    panel.menu.aboutToShow.emit()
    words = [action.text() for action in panel.menu.actions() if action.text()]
    assert [text.split(":")[0] for text in words] == ["Pinned", "Rejected", "Locked", "Take back all of them"]
    assert all(f"piece {k + 1}" in words[1] for k in first[::2])
    panel.menu.actions()[1].trigger()
    settle(ready, qtbot)
    assert [len(w) for w in (state(ready).wishes.locked, state(ready).wishes.forbidden, state(ready).wishes.pinned)] == [1, 0, 1]
    panel.menu.actions()[-1].trigger()
    settle(ready, qtbot)
    assert not state(ready).wishes
    assert panel.wishes.isHidden()


def test_another_partner_is_tried_out_and_locked_into_the_picture(ready, qtbot):
    choose(ready, 6)
    strip, row = ready.puzzle.page.join.strip, state(ready).row
    other = next(k for k, partner in enumerate(strip.partners) if not partner.current)
    strip.picked.emit(other)
    wanted = join_keys(state(ready).preview)[0]
    assert wanted not in join_keys(state(ready).solution.joins)
    assert "Tried out" in ready.puzzle.page.join.heading.text()
    assert state(ready).row == row
    press(ready, qtbot, Qt.Key.Key_L)
    assert wanted in join_keys(state(ready).solution.joins)
    assert state(ready).selected == wanted


def test_a_carried_piece_stays_where_it_was_put_and_the_rest_follows(ready, qtbot):
    layout = ready.puzzle.page.view.layout_shown
    piece = int(np.flatnonzero((layout.position == (0, 0)).all(axis=1))[0])
    ready.puzzle.page.view.carried.emit(piece, 2 * PX + 3, PX - 2)
    assert state(ready).wishes.pinned == (Pin(piece, 2 * PX, PX, 0),)
    assert ready.jobs.busy("puzzle")
    assert state(ready).solution.position[piece].tolist() == [2 * PX, PX]  # at once
    settle(ready, qtbot)
    assert state(ready).solution.position[piece].tolist() == [2 * PX, PX]
    assert state(ready).solved_with is state(ready).wishes
    assert ready.puzzle.page.view.overlay.pinned == (piece,)
    ready.puzzle.session.update(piece=piece)
    press(ready, qtbot, Qt.Key.Key_L)
    assert not state(ready).wishes.pinned


def test_a_piece_dragged_with_the_mouse_lands_in_its_cell(ready, qtbot):
    view = ready.puzzle.page.view
    piece = int(np.flatnonzero((view.layout_shown.position == (0, 0)).all(axis=1))[0])
    a, b = (_point(view.view.to_screen(np.array(p)).round()) for p in ((8, 8), (8 + 5 * PX, 8 + 3 * PX)))
    qtbot.mousePress(view, Qt.MouseButton.LeftButton, pos=a)
    for share in (0.4, 1.0):
        qtbot.mouseMove(view, a + (b - a) * share)
    qtbot.mouseRelease(view, Qt.MouseButton.LeftButton, pos=b)
    assert state(ready).wishes.pinned == (Pin(piece, 5 * PX, 3 * PX, 0),)


def test_pieces_are_put_together_by_hand_before_anything_is_solved(window, qtbot):
    puzzle, truth = cut_small()
    window.puzzle.session.update(**opened(puzzle, truth, "small"))
    a, b = (int(np.flatnonzero((truth.position == at).all(axis=1))[0]) for at in ((0, 0), (PX, 0)))
    window.puzzle.page.view.carried.emit(a, 1, 2)
    window.puzzle.page.view.carried.emit(b, PX + 2, -1)
    assert not window.jobs.busy()
    assert state(window).solution.placed.sum() == 2
    window.puzzle.solve()
    settle(window, qtbot)
    assert [state(window).solution.position[k].tolist() for k in (a, b)] == [[0, 0], [PX, 0]]
    assert state(window).marks.scores.direct == 1


def test_without_a_frame_a_piece_may_go_left_of_all_others(window, qtbot):
    puzzle, truth = cut_small()
    window.puzzle.session.update(**opened(replace(puzzle, frame=None), truth, "small"))
    assert not frame_known(state(window))
    window.puzzle.page.view.carried.emit(0, 100, 100)
    window.puzzle.page.view.carried.emit(1, -PX, 0)
    assert [p[:3] for p in state(window).wishes.pinned] == [(0, PX, 0), (1, 0, 0)]
    assert state(window).solution.position[[0, 1]].tolist() == [[PX, 0], [0, 0]]


def test_without_a_frame_a_new_place_means_its_neighbours(window, qtbot):
    puzzle, truth = cut_small()
    window.puzzle.session.update(**opened(replace(puzzle, frame=None), truth, "small"))
    window.puzzle.solve()
    settle(window, qtbot)
    before = state(window).solution
    piece = int(np.flatnonzero((before.position == (0, 0)).all(axis=1))[0])
    left = [k for k in join_keys(before.joins) if piece in k[::2]]
    window.puzzle.page.view.carried.emit(piece, 0, -PX + 2)  # above its own place
    held = join_keys(state(window).wishes.locked)
    assert held == []
    assert sorted(join_keys(state(window).wishes.forbidden)) == sorted(left)
    window.puzzle.session.undo()
    window.puzzle.page.view.carried.emit(piece, 6 * PX, 0)  # at the right end of the first row
    corner = int(np.flatnonzero((before.position == (5 * PX, 0)).all(axis=1))[0])
    assert join_keys(state(window).wishes.locked) == [join_key((corner, 1, piece, 3))]
    settle(window, qtbot)
    now = state(window)
    assert (now.solution.position[piece] - now.solution.position[corner]).tolist() == [PX, 0]
    assert now.solved_with is now.wishes
    assert now.solution.position[now.solution.placed].min(axis=0).tolist() == [0, 0]


def test_a_piece_thrown_into_the_tray_loses_its_joins(ready, qtbot):
    piece = 5
    ready.puzzle.hands.put_back(piece)
    assert not state(ready).solution.placed[piece]
    gone = join_keys(state(ready).wishes.forbidden)
    assert 2 <= len(gone) <= 4
    assert all(piece in key[::2] for key in gone)
    settle(ready, qtbot)
    assert not set(gone) & set(join_keys(state(ready).solution.joins))


def test_what_is_locked_together_is_carried_together(ready, qtbot):
    joins = state(ready).solution.joins
    row = next(k for k in range(len(joins)) if joins.offset[k].tolist() == [PX, 0])
    a, _, b, _ = joins.sides[row].tolist()
    choose(ready, row)
    press(ready, qtbot, Qt.Key.Key_L)
    assert ready.puzzle.page.view.group_of(a) == {a, b}
    goal = (2 * PX, 3 * PX) if state(ready).solution.position[a].tolist() != [2 * PX, 3 * PX] else (0, 0)
    ready.puzzle.page.view.carried.emit(a, *goal)
    settle(ready, qtbot)
    at = state(ready).solution.position
    assert at[a].tolist() == list(goal)
    assert at[b].tolist() == [goal[0] + PX, goal[1]]


def test_a_turned_piece_is_pinned_as_it_stands(window, qtbot):
    puzzle, truth = cut_small(turned=True)
    window.puzzle.session.update(**opened(puzzle, truth, "small"))
    window.puzzle.page.view.carried.emit(3, 1, 1)
    window.puzzle.session.update(piece=3)
    press(window, qtbot, Qt.Key.Key_Period)
    assert state(window).wishes.pinned == (Pin(3, 0, 0, 1),)
    assert pin_of(state(window).solution, 3) == Pin(3, 0, 0, 1)


def test_wishes_that_contradict_each_other_are_taken_back_with_a_sentence(ready, qtbot, monkeypatch):
    shown = state(ready).solution

    def refuse(*_, **__):
        raise BadInput("These locks contradict each other; unlock one.")

    choose(ready, 0)
    monkeypatch.setattr(solving, "assemble", refuse)
    press(ready, qtbot, Qt.Key.Key_L)
    assert "contradict" in ready.messages.text.text()
    assert state(ready).wishes is NO_WISHES
    assert state(ready).solution is shown
    assert not ready.jobs.busy()


# --- parameters, late answers, stopping


def test_a_live_parameter_assembles_again_and_a_slow_one_prepares_again(ready, qtbot):
    prepared = state(ready).prepared
    ready.puzzle.page.form.edited.emit("method", "mst", True)
    settle(ready, qtbot)
    assert state(ready).solution.parameters.method == "mst"
    assert state(ready).prepared is prepared
    ready.puzzle.page.form.edited.emit("measure", "ssd", True)
    settle(ready, qtbot)
    assert state(ready).solution.measure == "ssd"
    assert state(ready).prepared is not prepared


def held_back(monkeypatch, name):
    """Let a step of the solver wait until it is told to go on; it can be cancelled."""
    go, plain = threading.Event(), getattr(solving, name)

    def slow(*given, progress=lambda *_: None, **named):
        while not go.wait(0.005):
            progress(0.1, "held")
        return plain(*given, progress=progress, **named)

    monkeypatch.setattr(solving, name, slow)
    return go


def test_what_a_person_knows_of_the_pieces_is_declared_and_solved_anew(ready, qtbot):
    facts = ready.puzzle.page.facts
    facts.turned.setChecked(True)
    assert state(ready).puzzle.turned
    settle(ready, qtbot)
    assert state(ready).solution.placed.all()
    ready.puzzle.session.update(piece=4)
    press(ready, qtbot, Qt.Key.Key_Period)
    assert state(ready).wishes.pinned[0].quarter_turns != 0
    facts.turned.setChecked(False)
    assert state(ready).wishes.pinned == ()  # it turned a piece
    settle(ready, qtbot)
    ready.puzzle.session.update(piece=4)
    ready.puzzle.hands.turn()
    assert "not turned" in ready.status.text.text()
    ready.undo()
    ready.undo()
    settle(ready, qtbot)
    facts.pictures.setValue(2)
    settle(ready, qtbot)
    assert (state(ready).puzzle.pictures, state(ready).puzzle.frame) == (2, None)
    assert facts.after.text() == "pictures"
    ready.undo()
    ready.undo()
    settle(ready, qtbot)
    assert not facts.turned.isChecked()
    assert facts.pictures.value() == 1
    assert state(ready).marks.scores.direct == 1


def test_an_answer_that_comes_too_late_is_dropped(ready, qtbot, monkeypatch):
    go = held_back(monkeypatch, "assemble")
    first = choose(ready, 2)
    ready.puzzle.hands.reject()
    qtbot.waitUntil(lambda: ready.jobs.busy("puzzle"))
    qtbot.wait(30)
    ready.puzzle.hands.clear()
    choose(ready, 8)
    ready.puzzle.hands.reject()
    go.set()
    settle(ready, qtbot)
    assert first in join_keys(state(ready).solution.joins)
    assert state(ready).solved_with is state(ready).wishes
    assert len(state(ready).wishes.forbidden) == 1


def test_another_puzzle_drops_the_answer_to_the_one_before(window, qtbot, monkeypatch):
    go = held_back(monkeypatch, "prepare")
    window.puzzle.session.update(**opened(*cut_small(), "small"))
    window.puzzle.solve()
    qtbot.wait(30)
    window.puzzle.session.update(**opened(*cut_small(4, 3), "smaller"))
    go.set()
    settle(window, qtbot)
    assert state(window).puzzle.count == 12
    assert state(window).solution is None


def test_stopping_goes_back_to_what_the_picture_was_made_with(ready, qtbot, monkeypatch):
    held_back(monkeypatch, "assemble")
    shown = state(ready).solution
    choose(ready, 2)
    ready.puzzle.hands.reject()
    qtbot.wait(30)
    ready.stop()
    settle(ready, qtbot)
    assert state(ready).solution is shown
    assert state(ready).wishes is NO_WISHES


def test_what_was_stopped_at_first_can_be_asked_again(window, qtbot, monkeypatch):
    go = held_back(monkeypatch, "prepare")
    window.puzzle.session.update(**opened(*cut_small(), "small"))
    window.puzzle.solve()
    qtbot.wait(30)
    window.stop()
    settle(window, qtbot)
    assert not state(window).asked
    assert state(window).solution is None
    go.set()
    window.puzzle.solve()
    settle(window, qtbot)
    assert state(window).solution is not None


def test_wishes_made_while_the_pieces_are_compared_are_honoured(window, qtbot, monkeypatch):
    go = held_back(monkeypatch, "prepare")
    window.puzzle.session.update(**opened(*cut_small(), "small"))
    window.puzzle.solve()
    qtbot.wait(30)
    window.puzzle.page.view.carried.emit(7, 4 * PX, 2 * PX)
    go.set()
    settle(window, qtbot)
    assert state(window).solution.position[7].tolist() == [4 * PX, 2 * PX]
    assert state(window).solved_with is state(window).wishes


# --- export and the window


def test_picture_positions_and_joins_are_exported(ready, tmp_path):
    ready.puzzle.files.write_picture(tmp_path / "whole.png")
    assert (read_image(tmp_path / "whole.png")[..., :3] == picture()).all()
    ready.puzzle.files.write_solution(tmp_path)
    written = json.loads((tmp_path / "solution.json").read_text())
    assert written["schema"] == "concord.solution/1"
    assert len(written["placed"]) == 24
    assert written["scores"]["direct"] == 1
    with open(tmp_path / "joins.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(state(ready).solution.joins)
    assert {row["right"] for row in rows} == {"yes"}
    assert "written" in ready.status.text.text()


def test_locks_are_exported_and_read_again(ready, qtbot, tmp_path):
    first, second = choose(ready, 3), None
    press(ready, qtbot, Qt.Key.Key_X)
    second = choose(ready, 7)
    press(ready, qtbot, Qt.Key.Key_L)
    ready.puzzle.files.write_solution(tmp_path)
    ready.puzzle.hands.clear()
    settle(ready, qtbot)
    ready.puzzle.files.read_wishes(str(tmp_path / "locks.json"))
    settle(ready, qtbot)
    assert join_keys(state(ready).wishes.forbidden) == [first]
    assert join_keys(state(ready).wishes.locked) == [second]
    (tmp_path / "locks.json").write_text("{}")
    ready.puzzle.files.read_wishes(str(tmp_path / "locks.json"))
    assert "locks.json" in ready.messages.text.text()
    assert len(state(ready).wishes.locked) == 1


def test_locks_are_there_again_when_the_same_pieces_are_opened_another_day(ready, qtbot, tmp_path):
    folder = tmp_path / "shards"
    folder.mkdir()
    for k, piece in enumerate(cut_small()[0].pieces):
        (folder / f"shard {k}.png").write_bytes(png_bytes(piece.image))
    ready.puzzle.drop([str(folder)])
    settle(ready, qtbot)
    assert not state(ready).wishes
    ready.puzzle.solve()
    settle(ready, qtbot)
    key = choose(ready, 5)
    press(ready, qtbot, Qt.Key.Key_X)
    ready.puzzle.session.update(**opened(*cut_small(4, 3), "another"))
    ready.puzzle.drop([str(folder)])
    settle(ready, qtbot)
    assert join_keys(state(ready).wishes.forbidden) == [key]
    ready.puzzle.solve()
    settle(ready, qtbot)
    assert key not in join_keys(state(ready).solution.joins)
    ready.puzzle.hands.clear()
    settle(ready, qtbot)
    ready.puzzle.drop([str(folder)])
    settle(ready, qtbot)
    assert not state(ready).wishes


def test_there_is_nothing_to_export_before_anything_is_placed(window):
    window.puzzle.files.export_picture()
    assert "no picture to export" in window.messages.text.text()


def test_keys_mean_what_they_mean_on_the_page(ready, qtbot):
    acts = ready.actions_by_id
    assert acts["lock"].isEnabled()
    assert not acts["link-cameras"].isEnabled()
    ready.show_page("shapes")
    assert not acts["lock"].isEnabled()
    assert acts["link-cameras"].isEnabled()
    assert not ready.status.preset.isHidden()
    assert "pieces" not in ready.status.text.text()
    ready.show_page("puzzle")
    assert ready.status.preset.isHidden()
    assert "24 pieces" in ready.status.text.text()


def test_undo_belongs_to_the_page_that_is_shown(ready):
    assert ready.actions_by_id["undo"].isEnabled()
    ready.show_page("shapes")
    assert not ready.actions_by_id["undo"].isEnabled()
    ready.undo()
    assert state(ready).solution is not None
    ready.show_page("puzzle")
    ready.undo()
    assert state(ready).solution is None


def test_sixty_random_hands_leave_the_page_whole(ready, qtbot, monkeypatch):
    unexpected = []
    monkeypatch.setattr("sys.excepthook", lambda kind, error, trace: unexpected.append(error))
    ready.puzzle.solving.failed.connect(lambda *texts: unexpected.append(texts))
    rng = random.Random(7)
    page, act = ready.puzzle.page, ready.actions_by_id
    names = ["undo", "redo", "solve", "next-join", "previous-join", "lock", "reject", "turn-piece", "truth", "contrast", "stop",
             "correct", "wrong", "unsure", "undo-vote", "reset-view", "dark", "clear-wishes"]  # fmt: skip

    def carry():
        page.view.carried.emit(rng.randrange(24), rng.randint(-30, 200), rng.randint(-30, 120))

    def choose_something():
        rng.choice([lambda: ready.puzzle.session.update(piece=rng.randrange(24), selected=None, preview=None),
                    lambda: page.join.strip.picked.emit(rng.randrange(4)), page.join.other_side.emit])()  # fmt: skip

    for _ in range(60):
        rng.choice([carry, carry, choose_something, choose_something, *[lambda name=name: act[name].trigger() for name in names],
                    lambda: page.bar.slider.setValue(rng.randint(0, 100)),
                    lambda: page.form.edited.emit("method", rng.choice(["mst", "greedy", "loops"]), True)])()  # fmt: skip
        QApplication.processEvents()
    settle(ready, qtbot)
    assert [said for said in unexpected if not (isinstance(said, tuple) and "BadInput" in said[1])] == []  # wishes may clash
    act["clear-wishes"].trigger()
    ready.puzzle.solve()
    settle(ready, qtbot)
    assert state(ready).solution.placed.all()
    assert state(ready).solved_with is state(ready).wishes


def test_the_volunteer_and_the_theme_are_those_of_the_window(ready, qtbot):
    ready.puzzle.page.join.judge.named.emit("anna")
    settle(ready, qtbot)
    assert ready.session.state.volunteer == state(ready).volunteer == "anna"
    assert folders.settings().value("volunteer") == "anna"
    ready.toggle_dark()
    assert state(ready).dark
    assert ready.puzzle.page.view.theme.dark


def test_a_lively_page_lets_the_picture_grow_and_ends_with_all_marks(window, qtbot):
    del window.puzzle.page._lively
    window.puzzle.session.update(**opened(*cut_small(), "small"), below=1.0)
    with qtbot.waitSignal(window.puzzle.page.view.grown, timeout=20_000):
        window.puzzle.solve()
    assert window.puzzle.page.view.layout_shown.placed.all()
    assert window.puzzle.page.view.overlay.shown.all()
