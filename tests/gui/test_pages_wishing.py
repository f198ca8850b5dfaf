"""Pinning and forbidding in the window: by hand, by answers, by votes; undone, saved, and carried to other labels."""

import json

import numpy as np
import pytest
from PySide6.QtCore import Qt

from annotation import study
from engine.shapes.carrying import carried
from engine.shapes.families.collection import off_text
from engine.shapes.segmentation import SegmentedShape, segmentation_from_labels
from engine.shapes.wishes import NO_WISHES, Wishes
from gui.main_window import MainWindow
from gui.pages.shapes.arrange import listed
from gui.pages.shapes.panels import WishStrip
from gui.pages.shapes.wishing import answered_wishes, count_text, wish_of
from gui.views.links import marked, signed
from gui.views.scene import Link

A, B, C = ((0,), (0,)), ((1,), (1,)), ((0,), (1,))


def write_bar(folder, shape, name):
    path = folder / f"{name}.off"
    path.write_text(off_text(shape.mesh))
    path.with_suffix(".seg").write_text("\n".join(map(str, shape.segmentation.labels)))
    return str(path)


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return str(tmp_path_factory.mktemp("cache"))


@pytest.fixture
def ready(qtbot, tmp_path, monkeypatch, cache, make_bar):
    """The window on two bars of five and four sections, everything listed."""
    monkeypatch.setenv("CONCORD_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("CONCORD_CACHE", cache)
    made = MainWindow(dark=False)
    made.furnish()
    qtbot.addWidget(made)
    made.show()
    qtbot.waitUntil(lambda: made.judging.handle is not None)
    made.session.update(shown="all")
    made.files.pair(write_bar(tmp_path, make_bar(5), "long"), write_bar(tmp_path, make_bar(4), "short"))
    settle(made, qtbot)
    yield made
    made.close()


def settle(window, qtbot):
    qtbot.waitUntil(lambda: not (window.jobs.busy() or window.study_jobs.busy() or window.studies.jobs.busy()), timeout=60_000)


def pairs(window):
    return {(m.source, m.target): m for m in window.session.state.matches()}


def select(window, pair):
    window.session.update(selected=pairs(window)[pair].id)


def first(window):
    return next(iter(pairs(window)))


def press(window, qtbot, key):
    qtbot.keyClick(window.shapes.view, key)
    settle(window, qtbot)


# --- pure


def test_answers_pin_and_forbid_what_is_known():
    known = {"a": A, "b": B, "c": C}
    assert answered_wishes(NO_WISHES, {"a": "correct", "b": "wrong", "z": "wrong"}, known) == Wishes((A,), (B,))
    assert answered_wishes(Wishes((A,), (B,)), {"a": "unsure", "c": "correct"}, known) == Wishes((C,), (B,))


def test_wishes_are_counted():
    assert count_text(NO_WISHES) == "nothing pinned or forbidden"
    assert count_text(Wishes((A, B), ())) == "2 pinned"
    assert count_text(Wishes((A,), (B,))) == "1 pinned, 1 forbidden"


def test_a_pinned_link_carries_a_sign_though_nobody_judged_it():
    assert signed(Link("a", (0,), (1,), pinned=True))
    assert not marked(Link("a", (0,), (1,), pinned=True))
    assert not signed(Link("a", (0,), (1,)))


def test_wishes_follow_the_faces_to_other_labels(make_bar):
    bar, other = make_bar(5), make_bar(4)
    wishes = Wishes((((0, 1), (0,)), ((2,), (2,))), (((4,), (3,)),))
    turned = SegmentedShape(bar.mesh, segmentation_from_labels(4 - bar.segmentation.labels))
    found, lost = carried(wishes, (bar, other), (turned, other))
    assert (found, lost) == (Wishes((((3, 4), (0,)), ((2,), (2,))), (((0,), (3,)),)), 0)
    joined = SegmentedShape(bar.mesh, segmentation_from_labels(np.array([0, 1, 1, 2, 2])[bar.segmentation.labels]))
    assert carried(wishes, (bar, other), (joined, other)) == (NO_WISHES, 3)
    assert carried(Wishes((((1, 2, 3, 4), (0,)),)), (bar, other), (joined, other)) == (Wishes((((1, 2), (0,)),)), 0)
    assert carried(wishes, (bar, other), (other, bar)) == (NO_WISHES, 3)


# --- by hand


def test_keys_pin_and_forbid_and_undo_brings_everything_back(ready, qtbot):
    free, pair = ready.session.state.result, first(ready)
    select(ready, pair)
    press(ready, qtbot, Qt.Key.Key_K)
    assert ready.session.state.wishes == Wishes((pair,))
    assert pairs(ready)[pair].pinned
    assert ready.shapes.wish.buttons["pinned"].isChecked()
    assert "1 pinned" in ready.shapes.wish.count.text()
    assert next(link for link in ready.shapes.view._drawing.links if link.id == pairs(ready)[pair].id).pinned
    press(ready, qtbot, Qt.Key.Key_X)
    assert ready.session.state.wishes == Wishes((), (pair,))
    assert pair not in pairs(ready)
    assert ready.session.state.result.wishes == ready.session.state.wishes
    ready.undo()
    assert pairs(ready)[pair].pinned
    ready.undo()
    assert ready.session.state.result is free
    assert not ready.session.state.wishes
    ready.undo(1)
    assert pairs(ready)[pair].pinned
    assert not ready.jobs.busy()


def test_the_same_key_takes_a_wish_back(ready, qtbot):
    pair = first(ready)
    select(ready, pair)
    for _ in range(2):
        ready.shapes.wish.buttons["pinned"].click()
        settle(ready, qtbot)
    assert not ready.session.state.wishes


def test_without_a_selection_nothing_happens(ready, qtbot):
    ready.session.update(selected="")
    assert not ready.shapes.wish.buttons["forbidden"].isEnabled()
    press(ready, qtbot, Qt.Key.Key_X)
    assert not ready.session.state.wishes
    assert "Select a match" in ready.messages.text.text()


def test_what_is_forbidden_is_listed_and_can_be_allowed_again(ready, qtbot):
    pair = first(ready)
    known = pairs(ready)[pair].id
    select(ready, pair)
    press(ready, qtbot, Qt.Key.Key_X)
    ready.session.update(shown="wishes")
    (shown,) = listed(ready.session.state)
    assert shown.id == known
    ready.shapes.list.selectRow(0)
    assert wish_of(ready.session.state, known) == "forbidden"
    assert "forbidden" in ready.shapes.why.values["Score"].text()
    press(ready, qtbot, Qt.Key.Key_X)
    assert not ready.session.state.wishes
    assert pair in pairs(ready)


def test_pins_survive_sliders_and_presets(ready, qtbot):
    wrong = ((0,), (1,))
    ready.session.update(wishes=Wishes((wrong,)))
    settle(ready, qtbot)
    for change in (lambda: ready.matching.edit("overlap_min", 0.9, True), lambda: ready.matching.choose_preset("thesis-rigid"),
                   lambda: ready.matching.edit("node_cap", 60, True)):  # fmt: skip
        change()
        settle(ready, qtbot)
        assert pairs(ready)[wrong].pinned
        assert ready.session.state.result.parameters == ready.session.state.parameters
    ready.actions_by_id["clear-pins"].trigger()
    settle(ready, qtbot)
    assert not ready.session.state.result.wishes


def test_other_labels_drop_what_no_longer_fits_with_a_sentence(ready, qtbot, tmp_path):
    ready.session.update(wishes=Wishes((((0,), (0,)), ((4,), (3,)))))
    settle(ready, qtbot)
    coarse = tmp_path / "coarse.seg"
    coarse.write_text("\n".join(str(min(label, 3)) for label in ready.session.state.source.segmentation.labels))
    ready.files.relabel(0, str(coarse))
    settle(ready, qtbot)
    assert ready.session.state.wishes == Wishes((((0,), (0,)),))
    assert ready.messages.text.text() == "1 pinned or forbidden match does not fit the new labels and was dropped."
    assert pairs(ready)[((0,), (0,))].pinned


def test_another_pair_begins_without_wishes_and_without_a_word(ready, qtbot, tmp_path, make_bar):
    ready.session.update(wishes=Wishes((A,)))
    settle(ready, qtbot)
    ready.files.pair(write_bar(tmp_path, make_bar(3), "three"), write_bar(tmp_path, make_bar(4), "four"))
    settle(ready, qtbot)
    assert not ready.session.state.wishes
    assert ready.session.state.result.source.file.endswith("three.off")
    assert ready.messages.isHidden()
    ready.undo()
    assert ready.session.state.wishes == Wishes((A,))


def test_segments_edited_in_place_carry_the_wishes_along(ready, qtbot):
    ready.session.update(wishes=Wishes((((0,), (0,)), ((4,), (3,)))))
    settle(ready, qtbot)
    source = ready.session.state.source
    turned = SegmentedShape(source.mesh, segmentation_from_labels(4 - source.segmentation.labels), source.file)
    ready.session.update(source=turned, proposals=None, prepared_with=None, result=None, selected="")
    settle(ready, qtbot)
    assert ready.session.state.wishes == Wishes((((0,), (3,)), ((4,), (0,))))
    assert pairs(ready)[((0,), (3,))].pinned


# --- by answers and votes


def test_answers_make_wishes_where_they_are_bound(ready, qtbot):
    ids = [m.id for m in listed(ready.session.state)]
    known = {m.id: (m.source, m.target) for m in ready.session.state.matches()}
    ready.session.update(selected=ids[0])
    press(ready, qtbot, Qt.Key.Key_J)
    assert not ready.session.state.wishes
    ready.actions_by_id["bind-answers"].trigger()
    settle(ready, qtbot)
    assert ready.session.state.bound
    assert ready.actions_by_id["bind-answers"].isChecked()
    assert ready.session.state.wishes == Wishes((known[ids[0]],))
    other = next(i for i in ready.session.state.result.ids if i != ids[0])
    known = {m.id: (m.source, m.target) for m in ready.session.state.matches()}
    ready.session.update(selected=other)
    press(ready, qtbot, Qt.Key.Key_F)
    assert ready.session.state.wishes.forbidden == (known[other],)
    assert other not in ready.session.state.result.ids
    press(ready, qtbot, Qt.Key.Key_Backspace)
    assert ready.session.state.wishes.forbidden == ()
    ready.actions_by_id["bind-answers"].trigger()
    ready.session.update(selected=ready.session.state.result.ids[-1])
    press(ready, qtbot, Qt.Key.Key_F)
    assert ready.session.state.wishes.forbidden == ()


def test_answers_bind_again_when_their_pair_is_opened_again(ready, qtbot, tmp_path, make_bar):
    known, files = next(iter(pairs(ready).items())), [ready.session.state.source.file, ready.session.state.target.file]
    ready.session.update(selected=known[1].id)
    press(ready, qtbot, Qt.Key.Key_F)
    ready.wishing.bind(True)
    settle(ready, qtbot)
    ready.files.pair(write_bar(tmp_path, make_bar(3), "three"), write_bar(tmp_path, make_bar(4), "four"))
    settle(ready, qtbot)
    assert not ready.session.state.wishes
    ready.files.pair(*files)
    settle(ready, qtbot)
    assert ready.session.state.wishes == Wishes((), (known[0],))
    assert known[0] not in pairs(ready)


def test_the_votes_of_all_become_anchors_in_one_step(ready, qtbot):
    good, bad = listed(ready.session.state)[:2]
    ready.enrol()
    settle(ready, qtbot)
    for code in ("anna", "bert"):
        study.record_vote(ready.judging.handle, good.id, code, "correct")
        study.record_vote(ready.judging.handle, bad.id, code, "wrong")
    ready.actions_by_id["votes-as-pins"].trigger()
    settle(ready, qtbot)
    assert ready.session.state.wishes == Wishes(((good.source, good.target),), ((bad.source, bad.target),))
    assert "1 pinned and 1 forbidden by the votes" in ready.messages.text.text()
    assert ready.session.state.match(good.id).pinned
    assert bad.id not in ready.session.state.result.ids
    ready.undo()
    assert not ready.session.state.wishes


def test_pinning_enrols_nothing_in_the_study(ready, qtbot):
    select(ready, first(ready))
    press(ready, qtbot, Qt.Key.Key_J)
    with ready.judging.handle.reading() as connection:
        before = connection.exec_driver_sql("SELECT count(*) FROM run").scalar()
    ready.session.update(wishes=Wishes((((0,), (1,)),)))
    settle(ready, qtbot)
    with ready.judging.handle.reading() as connection:
        assert connection.exec_driver_sql("SELECT count(*) FROM run").scalar() == before


# --- files


def test_wishes_are_saved_with_the_results_and_read_again(ready, qtbot, tmp_path):
    wishes = Wishes((((0,), (1,)),), (((4,), (3,)),))
    ready.session.update(wishes=wishes)
    settle(ready, qtbot)
    (tmp_path / "out").mkdir()
    ready.files.write_result(tmp_path / "out")
    assert json.loads((tmp_path / "out" / "matches.json").read_text())["wishes"]["pinned"] == [{"source": [0], "target": [1]}]
    ready.wishing.clear()
    settle(ready, qtbot)
    ready.wish_files.read(tmp_path / "out" / "wishes.json")
    settle(ready, qtbot)
    assert ready.session.state.result.wishes == wishes


def test_a_damaged_file_is_a_sentence_and_changes_nothing(ready, qtbot, tmp_path):
    ready.session.update(wishes=Wishes((A,)))
    settle(ready, qtbot)
    (tmp_path / "w.json").write_text('{"schema"')
    ready.wish_files.read(tmp_path / "w.json")
    assert "no file of wishes" in ready.messages.text.text()
    assert ready.session.state.wishes == Wishes((A,))


def test_volunteers_see_nothing_of_it(ready, qtbot):
    ready.session.update(wishes=Wishes((A,)))
    settle(ready, qtbot)
    ready.enrol()
    settle(ready, qtbot)
    ready.show_page("study")
    settle(ready, qtbot)
    assert not ready.actions_by_id["pin-match"].isEnabled()
    assert not ready.actions_by_id["votes-as-pins"].isEnabled()
    assert not ready.study.findChildren(WishStrip)
    assert not ready.shapes.wish.isVisible()
