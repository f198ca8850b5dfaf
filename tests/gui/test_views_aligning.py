"""Shapes turned alike by their parts: laws of rotation on a small shape that no turn leaves as it is."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from world import LAMP, boxes

from gui.views.aligning import aligned, rotations, turned_scene
from gui.views.scene import prepare

PARTS = np.arange(6)
CRANE = [*LAMP, ((1, -0.2, 6), (4, 0.2, 6.4))]  # an arm to one side


@pytest.fixture(scope="module")
def scene():
    return prepare(boxes(CRANE, "crane"))


def centres(scene, parts):
    own = parts[scene.labels]
    return np.array([scene.centroid[own == p].mean(axis=0) for p in range(parts.max() + 1)])


@pytest.mark.parametrize("seed", range(4))
def test_turned_copies_come_to_lie_alike(scene, seed):
    rng = np.random.default_rng(seed)
    copies = [scene, *(turned_scene(scene, Rotation.random(rng=rng).as_matrix()) for _ in range(3))]
    found = aligned(copies, [PARTS] * 4)
    for other in found[1:]:
        np.testing.assert_allclose(centres(other, PARTS), centres(found[0], PARTS), atol=1e-9)
        np.testing.assert_allclose(other.points, found[0].points, atol=1e-9)


def test_a_shape_that_stands_is_turned_about_its_axis_alone(scene):
    about = Rotation.from_euler("y", 130, degrees=True).as_matrix()
    tilted = boxes([*CRANE[:5], ((1, -0.2, 5.2), (4, 0.2, 5.6))], "lower arm")
    turn = rotations([scene, scene, turned_scene(prepare(tilted), about)], [PARTS] * 3)[2]
    np.testing.assert_allclose(turn[1], [0, 1, 0], atol=1e-12)
    assert turn[0, 0] == pytest.approx(np.cos(np.radians(130)), abs=0.02)
    assert (turn @ about)[0, 0] == pytest.approx(1, abs=0.02)


def test_most_shapes_say_what_is_up(scene):
    over = Rotation.from_euler("x", 180, degrees=True).as_matrix()
    found = aligned([turned_scene(scene, over), scene, scene, scene], [PARTS] * 4)
    foot, arm = centres(found[0], PARTS)[[0, 5]]
    assert foot[1] < arm[1]
    for other in found[1:]:
        np.testing.assert_allclose(other.points, found[0].points, atol=1e-9)


def test_turns_are_proper_rotations(scene):
    rng = np.random.default_rng(1)
    mirrored = turned_scene(scene, np.diag([-1.0, 1.0, 1.0]))
    for turn in rotations([scene, mirrored, turned_scene(scene, Rotation.random(rng=rng).as_matrix())], [PARTS] * 3):
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(turn) == pytest.approx(1)


def test_what_lies_right_or_has_too_few_parts_stays(scene, make_bar):
    assert all(a is scene for a in aligned([scene, scene], [PARTS, PARTS]))
    none = np.full(6, -1)
    turned = turned_scene(scene, Rotation.from_euler("z", 90, degrees=True).as_matrix())
    assert aligned([scene, turned], [PARTS, none])[1] is turned
    assert aligned([scene, turned], [none, none]) == (scene, turned)
    bar = prepare(make_bar(5))  # its parts lie in a line
    leaning = turned_scene(bar, Rotation.from_euler("z", 40, degrees=True).as_matrix())
    assert aligned([bar, leaning], [np.arange(5)] * 2)[1] is leaning
