"""Shape distributions against what geometry says of spheres, rods and cubes."""

import numpy as np
import pytest
import trimesh
from world import boxes

from engine.shapes.distributions import BINS, DISTRIBUTIONS, shape_distributions
from engine.shapes.families.generated import random_rotation
from engine.shapes.mesh import Mesh, face_areas
from engine.shapes.segmentation import SegmentedShape, segmentation_from_labels

WIDTH = {"d1": 2.5 / BINS, "d2": 3.5 / BINS, "d3": 2.0 / BINS, "d4": 1.2 / BINS, "a3": 1.0 / BINS}


def described(shape, members=None, seed=0):
    count = shape.segmentation.count
    members = np.ones((1, count), dtype=bool) if members is None else np.array(members, dtype=bool)
    area = np.bincount(shape.segmentation.labels, face_areas(shape.mesh), minlength=count)
    return shape_distributions(shape, members, area, seed=seed)


def mean(histogram, name):
    return float(histogram @ ((np.arange(BINS) + 0.5) * WIDTH[name]))


def sphere():
    ball = trimesh.creation.icosphere(4)
    return SegmentedShape(Mesh(np.asarray(ball.vertices), np.asarray(ball.faces)), segmentation_from_labels(np.zeros(len(ball.faces))))


def test_a_sphere():
    """All points lie one radius from the middle; chords are shorter than d with probability d²/4."""
    found = described(sphere())
    assert mean(found["d1"][0], "d1") == pytest.approx(1.0, abs=0.02)
    assert found["d1"][0].max() > 0.5
    edges = (np.arange(BINS) + 1.0) * WIDTH["d2"]
    assert np.cumsum(found["d2"][0]) == pytest.approx(np.minimum(edges**2 / 4, 1.0), abs=0.04)


def test_a_rod():
    """Two points are a third of the length apart; of three, one in three sees the others at opposite sides."""
    found = described(boxes([((0, 0, 0), (100, 0.1, 0.1))]))
    assert mean(found["d2"][0], "d2") == pytest.approx(np.sqrt(12) / 3, abs=0.03)
    assert found["a3"][0][-2:].sum() == pytest.approx(1 / 3, abs=0.03)
    assert found["a3"][0][:2].sum() == pytest.approx(2 / 3, abs=0.03)
    assert mean(found["d4"][0], "d4") < 0.03


def test_a_cube():
    """Two points are .52141 sides apart on one face, .92639 on two; the root mean square radius is √(5/12) sides."""
    found = described(boxes([((0, 0, 0), (1, 1, 1))]))
    assert mean(found["d2"][0], "d2") == pytest.approx((0.52141 + 5 * 0.92639) / 6 / np.sqrt(5 / 12), abs=0.02)


def test_a_flat_sheet_encloses_no_volume():
    corners = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]], float)
    sheet = SegmentedShape(Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]])), segmentation_from_labels([0, 0]))
    found = described(sheet)
    assert found["d4"][0][0] == pytest.approx(1.0)
    assert mean(found["d3"][0], "d3") > 0.2


def test_every_distribution_sums_to_one(lamp):
    members = np.array([[1, 0, 0, 0, 0], [1, 1, 0, 0, 0], [1, 1, 1, 1, 1]], dtype=bool)
    found = described(lamp, members)
    assert tuple(found) == DISTRIBUTIONS
    for values in found.values():
        assert values.shape == (3, BINS)
        assert values.dtype == np.float32
        assert values.sum(axis=1) == pytest.approx(1.0)


def test_pose_and_size_do_not_matter(lamp):
    members = np.array([[1, 0, 0, 0, 0], [0, 1, 1, 1, 0]])
    turn = random_rotation(np.random.default_rng(3))
    moved = SegmentedShape(Mesh(7.0 * lamp.mesh.vertices @ turn.T + [5, -3, 1], lamp.mesh.faces), lamp.segmentation)
    a, b = described(lamp, members), described(moved, members)
    for name in DISTRIBUTIONS:
        assert np.abs(a[name] - b[name]).sum(axis=1).max() < 0.01


def test_a_union_is_described_as_if_it_were_one_segment(lamp):
    """Up to the noise of sampling, which is far below the distance of two different parts."""
    joined = np.where(lamp.segmentation.labels == 2, 1, lamp.segmentation.labels)
    one = SegmentedShape(lamp.mesh, segmentation_from_labels(joined))
    union, segment = described(lamp, [[0, 1, 1, 0, 0]]), described(one, [[0, 1, 0, 0]])
    other = described(lamp, [[0, 0, 0, 1, 0]])
    for name in DISTRIBUTIONS:
        noise = np.abs(union[name] - segment[name]).sum()
        assert noise < 0.2
        assert noise < 0.4 * np.abs(union[name] - other[name]).sum()


def test_a_row_depends_on_no_other_row_and_the_seed_moves_the_points(lamp):
    members = np.array([[1, 1, 0, 0, 0], [0, 0, 0, 1, 1], [0, 1, 1, 1, 0]])
    every, one, other = described(lamp, members), described(lamp, members[1:2]), described(lamp, members, seed=1)
    for name in DISTRIBUTIONS:
        assert np.array_equal(every[name][1:2], one[name])
        assert not np.array_equal(every[name], other[name])
