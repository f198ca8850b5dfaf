"""The view that a volunteer begins with: marked parts are seen, both shapes alike, and the next pair is drawn ahead."""

import numpy as np
import pytest
from world import bar as long_bar

from gui.palette import DARK, LIGHT, rgb
from gui.views.cameras import candidate_directions, visibility
from gui.views.scene import prepare
from gui.views.voting_pair import VotingPairView, ready_pair
from gui.views.voting_views import best_views, part_cameras, part_scores


@pytest.fixture
def scenes(make_bar):
    return prepare(make_bar(4)), prepare(make_bar(3))


@pytest.fixture
def view(qtbot):
    view = VotingPairView()
    qtbot.addWidget(view)
    view.resize(400, 240)
    view.show()
    yield view
    view.shutdown()


def shares(view, colour):
    """Share of each half of the picture that is near a colour."""
    image = view.grab().toImage().convertToFormat(view.grab().toImage().Format.Format_RGBX8888)
    pixels = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), image.bytesPerLine() // 4, 4)[..., :3].astype(int)
    hue = pixels - pixels.mean(axis=2, keepdims=True)
    wanted = rgb(colour).astype(int) - rgb(colour).mean()
    near = (hue @ wanted) / np.maximum(np.linalg.norm(hue, axis=2) * np.linalg.norm(wanted), 1e-9) > 0.9
    near &= np.linalg.norm(hue, axis=2) > 20
    half = near.shape[1] // 2
    return near[:, :half].mean(), near[:, half:].mean()


def test_an_end_of_a_bar_is_seen_from_its_own_side(scenes):
    for end, sign in ((0, -1), (3, 1)):
        towards = best_views(scenes, ((end,), (0 if end == 0 else 2,)))[0]
        assert sign * towards[0] > 0.2  # the bar lies along x


def test_both_shapes_are_seen_from_the_same_direction_where_that_serves_both(scenes):
    first, second = best_views(scenes, ((0,), (0,)))
    assert np.array_equal(first, second)


def test_no_part_is_much_better_seen_from_elsewhere(scenes):
    directions = candidate_directions()
    for a in range(4):
        for b in range(3):
            for scene, part, view in zip(scenes, ((a,), (b,)), best_views(scenes, ((a,), (b,))), strict=True):
                share = visibility(scene, part, directions)[:, 0]
                chosen = share[int(np.argmax(directions @ view))]
                assert chosen >= 0.7 * share[directions[:, 1] > -0.5].max()


def test_a_part_counts_as_one_however_it_is_cut(make_bar):
    whole, cut = prepare(long_bar([1.0, 2.0])), prepare(long_bar([1.0, 1.0, 1.0]))
    assert np.allclose(part_scores(whole, (1,)), part_scores(cut, (1, 2)), atol=0.05)  # up to cells on the cut


def test_nobody_is_made_to_look_from_far_below_without_need(scenes):
    for a in range(4):
        for b in range(3):
            assert all(-0.5 < one[1] < 0.9 for one in best_views(scenes, ((a,), (b,))))


def test_cameras_stand_upright_at_one_distance(scenes):
    views = best_views(scenes, ((0,), (2,)))
    first, second = part_cameras(scenes, views, 0.8)
    assert np.allclose(first.up, [0, 1, 0])
    assert np.allclose(second.up, first.up)
    distances = [np.linalg.norm(camera.position - camera.focal) for camera in (first, second)]
    assert distances[0] == pytest.approx(distances[1])
    assert len(candidate_directions()) == len(part_scores(scenes[0], (0,)))


def test_the_marked_parts_are_the_only_colour(view, scenes):
    view.present(ready_pair(scenes, ((0,), (2,))))
    left, right = shares(view, LIGHT.accent)
    assert min(left, right) > 0.01
    assert max(left, right) < 0.3
    view.set_theme(DARK)
    assert min(shares(view, DARK.accent)) > 0.01


def test_a_hidden_part_shines_through(view, scenes):
    view.present(ready_pair(scenes, ((0,), (0,))))
    seen = view._drawing.panes[0].camera
    away = seen._replace(position=-seen.position * [1, 0, 1] + seen.position * [0, 1, 0])
    for pane in view._drawing.panes:
        pane.camera = away
    with_it = shares(view, LIGHT.accent)
    view._drawing.through = False
    view._drawing._recolour()
    for pane in view._drawing.panes:
        pane.camera = away
    assert sum(with_it) >= sum(shares(view, LIGHT.accent))


def test_what_was_drawn_ahead_comes_up_as_if_it_had_been_shown_directly(view, scenes, qtbot):
    first, second = ready_pair(scenes, ((0,), (2,))), ready_pair(scenes, ((3,), (1,)))
    view.present(first)
    view.draw_ahead(second)
    qtbot.waitUntil(lambda: view.drawn_ahead, timeout=10_000)
    panes = view._spare.panes
    assert not any(pane.stale for pane in panes)
    view.present(second)
    assert view._drawing.panes is panes
    ahead = view.grab().toImage()
    view.present(ready_pair(scenes, ((0,), (2,))))
    view.present(ready_pair(scenes, ((3,), (1,))))
    qtbot.waitUntil(lambda: not view._moving, timeout=10_000)  # drawn quickly at first
    assert view.grab().toImage() == ahead


def test_reset_goes_back_to_the_chosen_view_and_less_motion_turns_by_steps(view, scenes):
    view.reduced_motion = True
    view.present(ready_pair(scenes, ((0,), (2,))))
    before = view.looking_from()
    view.turn()
    assert not view.turning
    assert not np.allclose(view.looking_from(), before)
    view.reset_view()
    assert np.allclose(view.looking_from(), before)


def test_the_turntable_runs_until_it_is_pressed_again_or_the_next_pair_comes(view, scenes, monkeypatch):
    monkeypatch.setattr(VotingPairView, "calm", False)
    view.present(ready_pair(scenes, ((0,), (2,))))
    view.turn()
    assert view.turning
    view.turn()
    assert not view.turning
    view.turn()
    view.present(ready_pair(scenes, ((1,), (1,))))
    assert not view.turning


def test_views_fit_the_size_that_shapes_are_first_shown_in(qtbot, scenes):
    ready, sizes = ready_pair(scenes, ((0,), (2,))), []
    for early in (True, False):
        view = VotingPairView()
        qtbot.addWidget(view)
        view.resize(160, 300)
        if early:
            view.present(ready)
            view.resize(900, 300)
        view.resize(900, 300)
        view.show()
        if not early:
            view.present(ready_pair(scenes, ((0,), (2,))))
        view.grab()
        sizes.append(np.linalg.norm(view._drawing.panes[0].camera.position))
        view.shutdown()
    assert sizes[0] == pytest.approx(sizes[1])
