"""The page of a collection in the window: opening, parts, pairs with their support, cancelling, exporting."""

import json

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt

from engine.shapes import collection_matching
from engine.shapes.families.collection import off_text
from gui.main_window import MainWindow
from gui.pages.collection.state import kept_count, row_of
from gui.pages.shapes.arrange import arranged, listed
from gui.views.collection_layout import corner


def write_bar(folder, shape, name):
    path = folder / f"{name}.off"
    path.write_text(off_text(shape.mesh))
    path.with_suffix(".seg").write_text("\n".join(map(str, shape.segmentation.labels)))
    return str(path)


@pytest.fixture
def files(tmp_path, make_bar):
    folder = tmp_path / "bars"
    folder.mkdir()
    return [write_bar(folder, make_bar(k), f"bar {k}") for k in (4, 5, 6)]


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
    window.files.drop(files)
    settle(window, qtbot)
    assert window.collection.session.state.found is not None, window.messages.text.text()
    return window


def settle(window, qtbot):
    qtbot.waitUntil(lambda: not (window.jobs.busy() or window.study_jobs.busy() or window.studies.jobs.busy()), timeout=60_000)


def state(window):
    return window.collection.session.state


def page(window):
    return window.collection.page.made


def drawn(window, qtbot):
    qtbot.waitUntil(lambda: page(window).view.ready, timeout=30_000)
    return page(window).view


# --- opening


def test_the_page_is_made_when_it_is_first_shown(window):
    assert window.collection.page.made is None
    window.actions_by_id["page-collection"].trigger()
    assert page(window).stack.currentIndex() == 0
    assert page(window).panel.isHidden()


def test_three_dropped_meshes_are_a_collection(ready):
    assert ready.page == "collection"
    assert state(ready).found.names == ("bar 4", "bar 5", "bar 6")
    assert page(ready).parts.rowCount() == state(ready).found.part_count > 0
    assert page(ready).pairs.rowCount() == 3
    assert "3 shapes · 3 pairs" in ready.status.text.text()
    assert not page(ready).panel.isHidden()


def test_a_folder_of_meshes_is_a_collection_and_two_meshes_are_a_pair(window, files, qtbot, tmp_path):
    window.files.drop([str(tmp_path / "bars")])
    settle(window, qtbot)
    assert len(state(window).found.shapes) == 3
    window.files.drop(files[:2])
    settle(window, qtbot)
    assert window.page == "shapes"


def test_a_mesh_that_cannot_be_read_is_named_and_the_others_are_shown(window, files, qtbot, tmp_path):
    bad = tmp_path / "bad.off"
    bad.write_text("OFF\n1 1 0\n")
    window.files.drop([*files, str(bad)])
    settle(window, qtbot)
    assert len(state(window).found.shapes) == 3
    assert window.messages.text.text().startswith("bad.off was left out")


def test_a_shape_in_one_segment_is_shown_until_it_turns_out_useless(window, files, qtbot, tmp_path, make_bar):
    files.append(write_bar(tmp_path, make_bar(1), "whole"))
    seen = []
    window.collection.session.changed.connect(lambda _old, new, _names: seen.append((new.found is None, new.names)))
    window.files.drop(files)
    settle(window, qtbot)
    assert seen[0] == (True, ("bar 4", "bar 5", "bar 6", "whole"))
    assert "matching" in window.status.text.text() or state(window).found is not None
    assert state(window).names == ("bar 4", "bar 5", "bar 6") == state(window).found.names
    assert len(drawn(window, qtbot).scenes) == 3
    assert window.messages.text.text().startswith("whole was left out: whole has one single segment")


def test_too_few_good_meshes_leave_what_was_shown(ready, qtbot, tmp_path):
    before = state(ready).found
    folder = tmp_path / "bad"
    folder.mkdir()
    for name in "abc":
        (folder / f"{name}.off").write_text("nothing")
    ready.files.drop([str(folder)])
    settle(ready, qtbot)
    assert state(ready).found is before
    assert "at least two shapes" in ready.messages.text.text()


def test_the_work_can_be_stopped_and_started_again(window, files, qtbot, monkeypatch):
    real, seen = collection_matching.propose, []

    def slow(*args, **kwargs):
        seen.append(1)
        while len(seen) == 1 and window.jobs.busy():  # until it is stopped
            pass
        return real(*args, **kwargs)

    monkeypatch.setattr(collection_matching, "propose", slow)
    window.files.drop(files)
    qtbot.waitUntil(lambda: bool(seen), timeout=30_000)
    window.stop()
    settle(window, qtbot)
    qtbot.waitUntil(lambda: window.jobs._running is None, timeout=30_000)
    assert state(window).found is None
    assert "3 shapes · not matched" in window.status.text.text()
    window.actions_by_id["match-collection"].trigger()
    settle(window, qtbot)
    assert state(window).found is not None


def test_what_was_stopped_shows_the_parameters_of_what_is_there(ready, qtbot):
    before = state(ready).found
    ready.collection.edit("partners", 2, True)
    assert ready.jobs.busy("collection")
    ready.stop()
    settle(ready, qtbot)
    assert state(ready).found is before
    assert state(ready).parameters == before.parameters
    assert page(ready).form.rows["partners"].value == before.parameters.partners


def test_a_double_click_on_a_pair_opens_it_once(ready, qtbot):
    page(ready).panel.setCurrentIndex(1)
    wanted = []
    page(ready).pair_wanted.connect(wanted.append)
    table = page(ready).pairs
    at = table.visualItemRect(table.item(1, 0)).center()
    qtbot.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=at)
    qtbot.mouseDClick(table.viewport(), Qt.MouseButton.LeftButton, pos=at)
    settle(ready, qtbot)
    assert wanted == [1]


# --- parts


def test_a_part_lights_up_in_all_shapes(ready, qtbot):
    view = drawn(ready, qtbot)
    found, part = state(ready).found, 0
    segment = int(np.flatnonzero(found.parts[0] == part)[0])
    rows, columns = np.nonzero(view._tiles[0].segments == segment)
    middle = np.argmin(np.abs(rows - rows.mean()) + np.abs(columns - columns.mean()))
    side, (left, top) = view.grid.side, corner(view.grid, 0)
    size = view._tiles[0].segments.shape[0]
    at = QPoint(left + int(columns[middle] * side / size), top + int(rows[middle] * side / size))
    qtbot.mouseClick(view, Qt.MouseButton.LeftButton, pos=at)
    assert state(ready).part == view.lit == page(ready).parts.currentRow() == part
    images = [view._image(row) for row in range(3)]
    colours = [{image.pixelColor(x, y).name() for x in range(0, image.width(), 3) for y in range(0, image.height(), 3)}
               for image in images]  # fmt: skip
    assert all(any(_colourful(name) for name in own) for own in colours)  # each shape has it
    qtbot.mouseClick(view, Qt.MouseButton.LeftButton, pos=at)
    assert state(ready).part == -1


def _colourful(name):
    r, g, b = (int(name[k : k + 2], 16) for k in (1, 3, 5))
    return max(r, g, b) - min(r, g, b) > 40


def test_keys_step_through_the_parts(ready, qtbot):
    count = state(ready).found.part_count
    seen = []
    for _ in range(count + 1):
        qtbot.keyClick(page(ready).view, Qt.Key.Key_N)
        seen.append(state(ready).part)
    assert seen == [*range(count), -1]
    qtbot.keyClick(page(ready).view, Qt.Key.Key_P)
    assert state(ready).part == count - 1


def test_part_from_is_followed_without_matching_again(ready):
    results = state(ready).found.results
    page(ready).form.rows["part_from"].slider.setValue(0)
    assert state(ready).found.results is results
    assert state(ready).found.parameters.part_from == 0.05
    assert page(ready).parts.rowCount() == state(ready).found.part_count
    assert not ready.jobs.busy()


def test_other_parameters_match_again(ready, qtbot):
    before = state(ready).found
    page(ready).form.edited.emit("lift_sparsity", 0.6, True)
    settle(ready, qtbot)
    assert state(ready).found is not before
    assert state(ready).found.parameters.lift_sparsity == 0.6
    page(ready).form.edited.emit("partners", 1, True)
    assert "partners" in ready.messages.text.text()


def test_a_drag_turns_all_shapes_and_r_turns_them_back(ready, qtbot):
    view = drawn(ready, qtbot)
    before = [tile.segments.copy() for tile in view._tiles]
    start = QPoint(*corner(view.grid, 0)) + QPoint(20, 20)
    qtbot.mousePress(view, Qt.MouseButton.LeftButton, pos=start)
    qtbot.mouseMove(view, start + QPoint(80, 0))
    qtbot.mouseRelease(view, Qt.MouseButton.LeftButton, pos=start + QPoint(80, 0))
    drawn(ready, qtbot)
    assert all((a != t.segments).any() for a, t in zip(before, view._tiles, strict=True))
    assert state(ready).part == -1
    ready.reset_view()
    drawn(ready, qtbot)
    assert all((a == t.segments).all() for a, t in zip(before, view._tiles, strict=True))


# --- pairs and their support


def test_two_names_open_their_pair_with_supports(ready, qtbot):
    for row in (0, 2):
        left, top = corner(page(ready).view.grid, row)
        qtbot.mouseClick(page(ready).view, Qt.MouseButton.LeftButton, pos=QPoint(left + 20, top - 10))
    assert ready.page == "shapes"
    shown = ready.session.state
    assert (shown.source.mesh.name, shown.target.mesh.name) == ("bar 4", "bar 6")
    row = row_of(state(ready).found, (0, 2))
    assert shown.result is state(ready).found.results[row]
    assert not ready.shapes.list.isColumnHidden(5)
    values = dict(zip(shown.result.ids, state(ready).found.support(row), strict=True))
    model = ready.shapes.list.rows
    texts = [model.data(model.index(k, 5)) for k in range(model.rowCount())]
    assert [float(text) for text in texts] == [pytest.approx(values[m.id], abs=0.0051) for m in model.rows]
    settle(ready, qtbot)
    assert ready.session.state.proposals is not None  # layers and live sliders work
    assert ready.session.state.result.ids == shown.result.ids


def test_the_slider_hides_weak_matches_on_both_pages(ready, qtbot):
    ready.collection.show_pair(0)
    ready.session.update(shown="all")
    every = listed(ready.session.state)
    least = float(np.median([ready.session.state.support[m.id] for m in every])) + 0.01
    ready.shapes.least.moved.emit(least)
    kept = listed(ready.session.state)
    assert {m.id for m in kept} == {m.id for m in every if ready.session.state.support[m.id] >= least}
    assert 0 < len(kept) < len(every)
    assert {link.id for link in ready.shapes.view._drawing.links} == {m.id for m in kept}
    assert state(ready).least == least
    words = page(ready).pairs.item(0, 1).text()
    assert words == f"{len(kept)} of {len(every)}"


def test_another_pair_of_files_is_not_hidden_by_the_slider(ready, files, qtbot, tmp_path, make_bar):
    ready.session.update(least_support=1.0)
    others = [write_bar(tmp_path, make_bar(k), f"other {k}") for k in (3, 7)]
    ready.files.pair(*others)
    settle(ready, qtbot)
    assert listed(ready.session.state)
    assert ready.shapes.least.isHidden()
    assert ready.shapes.list.isColumnHidden(5)


def test_the_other_kind_of_support_changes_the_numbers(ready):
    before = dict(ready.session.state.support)
    page(ready).kind.activated.emit(1)
    assert state(ready).found.parameters.support == "matchlift"
    assert ready.session.state.support.keys() == before.keys()
    assert ready.session.state.support != before


def test_matches_can_be_sorted_by_support():
    class M:
        def __init__(self, name):
            self.id, self.score = name, 1.0

    support = {"a": 0.2, "b": 0.9, "c": float("nan")}
    order = [m.id for m in arranged([M("a"), M("c"), M("b"), M("d")], "support", {}, support)]
    assert order == ["b", "a", "c", "d"]
    assert kept_count(np.array([0.2, np.nan, 0.9]), 0.0) == 3
    assert kept_count(np.array([0.2, np.nan, 0.9]), 0.5) == 1


# --- the rest


def test_the_collection_is_exported_with_a_picture(ready, tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    ready.collection.write(folder)
    assert json.loads((folder / "collection.json").read_text())["schema"] == "concord.collection/1"
    assert "data:image/png" in (folder / "report.html").read_text()
    assert str(folder) in ready.status.text.text()


def test_dark_and_back_reach_the_tiles(ready, qtbot):
    view = drawn(ready, qtbot)
    light = view._image(0).pixelColor(0, 0).lightness()
    ready.session.update(dark=True)
    assert view._image(0).pixelColor(0, 0).lightness() < 60 < light
    ready.session.update(dark=False)
    assert view._image(0).pixelColor(0, 0).lightness() == light


def test_nothing_to_match_again_or_export_is_said(window):
    window.show_page("collection")
    window.actions_by_id["match-collection"].trigger()
    assert "no collection to match" in window.messages.text.text()
    window.actions_by_id["export-collection"].trigger()
    assert "no collection to export" in window.messages.text.text()


def test_match_again_takes_the_parameters_of_the_window(ready, qtbot):
    ready.matching.choose_preset("thesis-rigid-size")
    ready.collection.again()
    settle(ready, qtbot)
    assert state(ready).found.match_parameters.method == "thesis"
    assert state(ready).found.preset == "thesis-rigid-size"
