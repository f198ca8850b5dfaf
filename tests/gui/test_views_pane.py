import numpy as np
import pytest

from gui.palette import LIGHT, segment_colours
from gui.views.cameras import look_from
from gui.views.pane import Pane, most_central
from gui.views.scene import prepare


@pytest.fixture
def pane(bar, qapp):
    pane = Pane(LIGHT)
    pane.set_scene(prepare(bar))
    pane.set_colours(segment_colours(3))
    pane.camera = look_from((0, 0, 1), 3.0)
    yield pane
    pane.close()


def test_the_middle_of_each_section_picks_its_segment(pane):
    pane.image(300, 200)
    front, _ = pane.project(np.array([[-1 / 3, 0, 1 / 6], [0, 0, 1 / 6], [1 / 3, 0, 1 / 6]]))
    assert [pane.pick(x, y) for x, y in front] == [0, 1, 2]
    assert front[1] == pytest.approx([150, 100])
    assert front[0][0] < front[1][0] < front[2][0]
    assert pane.pick(2, 2) is None


def test_what_lies_behind_is_not_seen(pane):
    pane.image(300, 200)
    middle = np.array([[0, 0, 1 / 6], [0, 0, -1 / 6], [9, 0, 0]])
    assert pane.visible(middle).tolist() == [True, False, False]


def test_links_end_where_they_are_seen(pane):
    pane.camera = look_from((1, 0, 0), 3.0)
    pane.image(300, 200)
    xy, seen = pane.spots()
    assert seen[2]
    assert pane.pick(*xy[2]) == 2
    assert not seen[0]


def test_it_draws_only_when_something_changed(pane):
    first = pane.image(120, 80)
    assert pane.image(120, 80) is first
    pane.set_colours(segment_colours(3))
    assert not pane.stale
    pane.set_colours(segment_colours(3)[::-1])
    second = pane.image(120, 80)
    assert second is not first
    pane.camera = look_from((0, 1, 1), 3.0)
    assert pane.image(120, 80) is not second


def test_a_still_picture_replaces_the_quick_one(pane):
    quick = pane.image(120, 80, moving=True)
    assert pane.image(120, 80, moving=True) is quick
    still = pane.image(120, 80)
    assert still is not quick
    assert pane.image(120, 80, moving=True) is still


def test_colours_are_seen_where_the_segments_are(pane):
    pane.set_colours(np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255]], np.uint8))
    image = pane.image(300, 200)
    front, _ = pane.project(np.array([[-1 / 3, 0, 1 / 6], [0, 0, 1 / 6], [1 / 3, 0, 1 / 6]]))
    for channel, (x, y) in enumerate(front):
        colour = image.pixelColor(int(x), int(y) + 9).getRgb()[:3]
        assert np.argmax(colour) == channel
        assert max(colour) > 100
    assert image.pixelColor(1, 1).name().upper() == LIGHT.paper


def test_a_transparent_background(pane):
    pane.set_theme(LIGHT, transparent=True)
    image = pane.image(300, 200)
    assert image.pixelColor(1, 1).alpha() == 0
    assert image.pixelColor(150, 100).alpha() == 255


def test_dragging_turns_and_middle_dragging_moves(pane):
    pane.image(300, 200)
    before = pane.camera
    pane.mouse("LeftButtonPressEvent", 150, 100)
    pane.mouse("MouseMoveEvent", 190, 100)
    pane.mouse("LeftButtonReleaseEvent", 190, 100)
    turned = pane.camera
    assert np.linalg.norm(turned.position - before.position) > 0.3
    assert turned.focal == pytest.approx(before.focal)
    pane.mouse("MiddleButtonPressEvent", 150, 100)
    pane.mouse("MouseMoveEvent", 170, 100)
    pane.mouse("MiddleButtonReleaseEvent", 170, 100)
    assert np.linalg.norm(pane.camera.focal - turned.focal) > 0.01


def test_zooming_stops_at_sensible_distances(pane):
    for _ in range(100):
        pane.zoom(2.0)
    assert np.linalg.norm(pane.camera.position) == pytest.approx(0.15)
    for _ in range(100):
        pane.zoom(0.5)
    assert np.linalg.norm(pane.camera.position) == pytest.approx(40)


def test_the_most_central_of_the_seen_places():
    xy = np.array([[[0.0, 0], [10, 0], [4, 0]], [[0, 0], [1, 0], [9, 9]]])
    seen = np.array([[True, True, True], [False, False, True]])
    assert most_central(xy, seen).tolist() == [2, 2]
