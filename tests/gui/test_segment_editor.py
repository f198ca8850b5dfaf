"""The editor of segments in the window: choosing, merging, splitting, painting, undoing, saving, and matching again."""

import threading

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QApplication

from engine.errors import BadInput
from engine.shapes.families.collection import off_text
from gui.main_window import MainWindow


def bar_file(folder, shape, name, labels=True):
    path = folder / f"{name}.off"
    path.write_text(off_text(shape.mesh))
    if labels:
        path.with_suffix(".seg").write_text("\n".join(map(str, shape.segmentation.labels)))
    return str(path)


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return str(tmp_path_factory.mktemp("cache"))


@pytest.fixture
def window(qtbot, tmp_path, monkeypatch, cache):
    monkeypatch.setenv("CONCORD_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("CONCORD_CACHE", cache)
    made = MainWindow(dark=False)
    made.furnish()
    made.segments.ask = lambda *_: "discard"  # no test waits for an answer that nobody gives
    qtbot.addWidget(made)
    made.show()
    made.activateWindow()
    qtbot.waitUntil(made.isActiveWindow)
    yield made
    made.close()


def settle(window, qtbot):
    qtbot.waitUntil(lambda: not (window.jobs.busy() or window.study_jobs.busy() or window.studies.jobs.busy()), timeout=60_000)


@pytest.fixture
def editor(window, qtbot, tmp_path, make_bar):
    """The left of two bars in the editor: five sections, 44 faces."""
    window.files.pair(bar_file(tmp_path, make_bar(5), "long"), bar_file(tmp_path, make_bar(4), "short"))
    settle(window, qtbot)
    window.actions_by_id["edit-source"].trigger()
    settle(window, qtbot)
    assert window.page == "segments", window.messages.text.text() + window.messages.details
    return window.segments


def counts(editor):
    return np.bincount(editor.state.labels).tolist()


def test_one_click_is_one_segment_and_shift_adds_or_takes_away(editor):
    editor.pick(0, False)
    assert editor.state.selected == (0,)
    editor.pick(9, True)
    assert editor.state.selected == (0, 1)
    editor.pick(0, True)
    assert editor.state.selected == (1,)
    editor.pick(-1, False)
    assert editor.state.selected == ()


def test_merging_undoing_and_redoing(editor, window):
    before = counts(editor)
    editor.choose((1, 2))
    window.actions_by_id["merge-segments"].trigger()
    assert counts(editor) == [10, 16, 0, 8, 10]
    assert editor.state.selected == (1,)
    assert editor.page.list.count() == 4
    window.actions_by_id["undo"].trigger()
    assert counts(editor) == before
    window.actions_by_id["redo"].trigger()
    assert counts(editor) == [10, 16, 0, 8, 10]


def test_splitting_keeps_the_label_of_the_largest_and_makes_new_ones(editor, window):
    editor.choose((0,))
    editor.session.update(parts=3)
    window.actions_by_id["split-segment"].trigger()
    assert len(np.unique(editor.state.labels)) == 7
    assert sum(counts(editor)[k] for k in (0, 5, 6)) == 10
    editor.deselect()
    window.actions_by_id["split-segment"].trigger()
    assert "Click the one segment" in window.messages.text.text()


def test_a_stroke_of_the_brush_is_one_step_and_paints_the_chosen_segment(editor, window):
    before = editor.state.labels
    editor.choose((4,))
    window.actions_by_id["brush"].trigger()
    editor.set_brush(0.003)
    for face in (8, 9, 10):
        editor.paint([face])
    editor.session.settle()
    assert (editor.state.labels[[8, 9, 10]] == 4).all()
    window.actions_by_id["undo"].trigger()
    assert np.array_equal(editor.state.labels, before)


def test_a_new_segment_is_painted_and_gets_a_free_name(editor, window):
    window.actions_by_id["new-segment"].trigger()
    editor.set_brush(0.003)
    editor.paint([12])
    assert editor.state.labels[12] == 5
    assert editor.state.segmentation().names == (0, 1, 2, 3, 4, 5)


def test_the_slider_segments_automatically_and_undo_brings_the_labels_back(editor, window, qtbot):
    before = editor.state.labels
    editor.page.form.edited.emit("segments", 3, True)
    settle(window, qtbot)
    assert len(np.unique(editor.state.labels)) == 3
    editor.page.form.edited.emit("segments", 7, True)
    settle(window, qtbot)
    assert len(np.unique(editor.state.labels)) == 7
    window.actions_by_id["undo"].trigger()
    window.actions_by_id["undo"].trigger()
    assert np.array_equal(editor.state.labels, before)
    assert editor.state.parameters.segments == 5


def test_saving_asks_before_a_file_of_others_is_replaced_and_only_once(editor, window, tmp_path):
    asked = []
    editor.ask = lambda *words: asked.append(words) or "stay"
    editor.choose((0, 1))
    editor.merge()
    old = (tmp_path / "long.seg").read_text()
    window.actions_by_id["save-segments"].trigger()
    assert len(asked) == 1
    assert (tmp_path / "long.seg").read_text() == old
    assert editor.state.unsaved
    editor.ask = lambda *words: asked.append(words) or "replace"
    window.actions_by_id["save-segments"].trigger()
    assert sorted(set((tmp_path / "long.seg").read_text().split())) == ["0", "2", "3", "4"]
    assert not editor.state.unsaved
    editor.choose((0, 2))
    editor.merge()
    window.actions_by_id["save-segments"].trigger()
    assert len(asked) == 2


def test_a_folder_that_cannot_be_written_is_one_sentence(editor, window, tmp_path):
    editor.choose((0, 1))
    editor.merge()
    assert not editor.write(tmp_path / "missing" / "a.seg")
    assert "cannot be written" in window.messages.text.text()
    assert editor.state.unsaved


def test_done_matches_the_pair_again_with_the_new_segments(editor, window, qtbot, tmp_path):
    editor.choose((0, 1))
    editor.merge()
    assert editor.write(tmp_path / "new.seg")
    window.actions_by_id["segments-done"].trigger()
    settle(window, qtbot)
    assert window.page == "shapes"
    assert window.session.state.source.segmentation.names == (0, 2, 3, 4)
    assert window.session.state.result is not None
    assert np.array_equal(window.session.state.result.source.segments, (0, 2, 3, 4))


def test_unsaved_edits_are_never_lost_silently(editor, window, qtbot, tmp_path, make_bar):
    asked = []
    editor.ask = lambda *words: asked.append(words[0]) or "stay"
    editor.choose((0, 1))
    editor.merge()
    window.actions_by_id["segments-done"].trigger()
    assert window.page == "segments", window.messages.text.text() + window.messages.details
    assert not window.close()
    window.files.pair(bar_file(tmp_path, make_bar(3), "other"), bar_file(tmp_path, make_bar(4), "short"))
    window.open_example()
    editor.edit(1)
    settle(window, qtbot)
    assert window.session.state.source.mesh.name == "long"
    assert len(asked) == 5
    assert len(np.unique(editor.state.labels)) == 4
    editor.ask = lambda *words: "use"
    editor.done()
    settle(window, qtbot)
    assert "in no file yet" in " ".join(window.session.state.source.notes)


def test_done_says_so_where_the_pair_has_changed_meanwhile(editor, window, make_bar):
    editor.choose((0, 1))
    editor.merge()
    window.matching.show_pair(make_bar(3), make_bar(4))
    editor.done()
    assert window.page == "segments"
    assert "not in the pair any more" in window.messages.text.text()


def test_a_mesh_without_labels_opens_with_a_notice_and_a_slider(window, qtbot, tmp_path, make_bar):
    window.files.pair(bar_file(tmp_path, make_bar(12), "bare", labels=False), bar_file(tmp_path, make_bar(4), "short"))
    settle(window, qtbot)
    assert window.session.state.source.automatic
    assert window.session.state.source.segmentation.count == 14
    assert any("automatically" in note for note in window.session.state.result.notes)
    bar = window.shapes.automatic
    assert bar.rows[0].isVisibleTo(window.shapes)
    assert not bar.rows[1].isVisibleTo(window.shapes)
    bar.rows[0].slider.setValue(6)
    bar.rows[0].slider.sliderReleased.emit()
    settle(window, qtbot)
    assert window.session.state.source.segmentation.count == 6
    window.actions_by_id["undo"].trigger()
    settle(window, qtbot)
    assert window.session.state.source.segmentation.count == 14
    assert bar.rows[0].slider.value() == 14


def test_a_segmentation_that_is_stopped_or_fails_leaves_the_slider_where_the_shape_is(window, qtbot, tmp_path, make_bar, monkeypatch):
    window.files.pair(bar_file(tmp_path, make_bar(12), "bare", labels=False), bar_file(tmp_path, make_bar(4), "short"))
    settle(window, qtbot)
    row, shape = window.shapes.automatic.rows[0], window.session.state.source
    held = threading.Event()

    def slow(*_, progress, **__):
        held.wait(20)
        progress(0.5, "held")

    def bad(*_, **__):
        raise BadInput("It cannot be cut so often.")

    for work, end in ((slow, window.stop), (bad, lambda: None)):
        monkeypatch.setattr("engine.shapes.segmenting.auto_segment", work)
        row.slider.setValue(40)
        row.slider.sliderReleased.emit()
        assert window.jobs.busy("segments")
        end()
        held.set()
        settle(window, qtbot)
        assert window.session.state.source is shape
        assert (row.slider.value(), row.number.text()) == (14, "14 segments")
    assert window.messages.text.text() == "It cannot be cut so often."
    assert window.session.state.result is not None


def test_long_names_are_cut_and_do_not_widen_the_window(window, qtbot, tmp_path, make_bar):
    name = "a_bar_that_somebody_scanned_in_a_museum_" * 4
    window.files.pair(bar_file(tmp_path, make_bar(5), name, labels=False), bar_file(tmp_path, make_bar(4), "short"))
    settle(window, qtbot)
    window.resize(1024, 700)
    QApplication.processEvents()
    assert window.width() == 1024
    words = window.shapes.automatic.rows[0].words
    assert words.toolTip() == words.text() == f"{name} has no labels and was cut automatically."
    assert words.shown().startswith("a_bar")
    assert words.shown().endswith("cut automatically.")
    assert words.fontMetrics().horizontalAdvance(words.shown()) <= words.width()


def press(view, kind, at, button=Qt.MouseButton.LeftButton, modifiers=Qt.KeyboardModifier.NoModifier):
    held = Qt.MouseButton.NoButton if kind == QEvent.Type.MouseButtonRelease else button
    event = QMouseEvent(kind, QPointF(at), view.mapToGlobal(QPointF(at)), button, held, modifiers)
    QApplication.sendEvent(view, event)


def middle_face(view):
    view.grab()
    at = QPoint(view.width() // 2, view.height() // 2)
    return at, view.face_at(QPointF(at))


def test_the_mouse_picks_paints_cuts_and_turns(editor, window):
    view = editor.page.view
    at, face = middle_face(view)
    if face < 0:
        pytest.skip("nothing can be drawn here")
    label = int(editor.state.labels[face])
    press(view, QEvent.Type.MouseButtonPress, at)
    press(view, QEvent.Type.MouseButtonRelease, at)
    assert editor.state.selected == (label,)
    editor.choose_tool("cut")
    before = len(np.unique(editor.state.labels))
    press(view, QEvent.Type.MouseButtonPress, at - QPoint(0, 150))
    press(view, QEvent.Type.MouseMove, at)
    press(view, QEvent.Type.MouseButtonRelease, at + QPoint(0, 150))
    assert len(np.unique(editor.state.labels)) > before
    editor.session.undo()
    window.actions_by_id["new-segment"].trigger()
    press(view, QEvent.Type.MouseButtonPress, at)
    press(view, QEvent.Type.MouseMove, at + QPoint(10, 0))
    press(view, QEvent.Type.MouseButtonRelease, at + QPoint(10, 0))
    assert editor.state.labels[face] == 5
    assert len(editor.session._undo) == 1
    camera = view._pane.camera
    press(view, QEvent.Type.MouseButtonPress, at, Qt.MouseButton.RightButton)
    press(view, QEvent.Type.MouseMove, at + QPoint(60, 20), Qt.MouseButton.RightButton)
    press(view, QEvent.Type.MouseButtonRelease, at + QPoint(60, 20), Qt.MouseButton.RightButton)
    assert not np.allclose(view._pane.camera.position, camera.position)
