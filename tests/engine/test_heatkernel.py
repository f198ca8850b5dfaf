"""Heat kernel signatures against what is known of spheres, and persistent peaks by hand."""

import numpy as np
import pytest
import trimesh
from scipy.sparse.csgraph import connected_components
from world import bar, boxes

from engine.shapes.families.generated import random_rotation
from engine.shapes.heatkernel import (
    PEAKS,
    PERSISTENT,
    TIMES,
    HeatKernel,
    heat_kernel,
    mean_signatures,
    persistent_signatures,
    point_laplacian,
)
from engine.shapes.mesh import Mesh, face_areas
from engine.shapes.segmentation import SegmentedShape, segmentation_from_labels


def areas(shape):
    return np.bincount(shape.segmentation.labels, face_areas(shape.mesh))


@pytest.fixture(scope="module")
def ball():
    mesh = trimesh.creation.icosphere(4)
    return SegmentedShape(
        Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces)), segmentation_from_labels(mesh.triangles_center[:, 2] > 0)
    )


def test_heat_on_a_sphere_flows_as_its_harmonics_say(ball):
    """Eigenvalues of the unit sphere are l(l + 1), each 2l + 1 times; so k_t(x, x) · area = Σ (2l + 1) exp(-l(l + 1) t)."""
    heat = heat_kernel(ball, seed=0)
    found = np.exp(mean_signatures(heat, np.ones((1, 2), dtype=bool), areas(ball)))[0]
    degrees = np.arange(40)
    for time, value in list(zip(TIMES * 4 * np.pi, found, strict=True))[2:]:
        expected = ((2 * degrees + 1) * np.exp(-degrees * (degrees + 1) * time)).sum()
        assert value == pytest.approx(expected, rel=0.08)
    assert heat.mass.sum() == pytest.approx(4 * np.pi, rel=0.05)


def test_parts_far_apart_are_joined_once():
    rng = np.random.default_rng(0)
    points = rng.random((180, 3)) + np.repeat([[0, 0, 0], [50, 0, 0], [0, 70, 0]], [80, 60, 40], axis=0)
    stiffness, mass = point_laplacian(points)
    assert connected_components(stiffness)[0] == 1
    assert stiffness @ np.ones(len(points)) == pytest.approx(np.zeros(len(points)), abs=1e-9)
    assert abs(stiffness - stiffness.T).max() < 1e-9
    assert (mass > 0).all()


@pytest.mark.parametrize("shape", [boxes([((0, 0, 0), (1, 1, 1)), ((5, 5, 5), (6, 7, 6))]), bar([3, 5, 2])], ids=["apart", "bar"])
def test_pose_and_size_do_not_matter(shape):
    members = np.eye(shape.segmentation.count, dtype=bool)
    turn = random_rotation(np.random.default_rng(7))
    moved = SegmentedShape(Mesh(30.0 * shape.mesh.vertices @ turn.T + 4.0, shape.mesh.faces), shape.segmentation)
    a, b = (heat_kernel(s, seed=0) for s in (shape, moved))
    assert mean_signatures(a, members, areas(shape)) == pytest.approx(mean_signatures(b, members, areas(moved)), abs=0.02)
    assert np.abs(persistent_signatures(a, members) - persistent_signatures(b, members)).mean() < 0.02


def test_heat_stays_longer_at_the_ends_of_a_bar():
    shape = bar([2, 6, 2])
    found = mean_signatures(heat_kernel(shape, seed=0), np.eye(3, dtype=bool), areas(shape))
    assert (found[[0, 2], 10] > found[1, 10] + 0.1).all()


def test_the_mean_of_a_union_is_that_of_its_segments_by_area(lamp):
    heat, area = heat_kernel(lamp, seed=0), areas(lamp)
    a, b, both = np.exp(mean_signatures(heat, np.array([[1, 1, 0, 0, 0], [0, 0, 1, 1, 0], [1, 1, 1, 1, 0]]), area))
    assert both * area[:4].sum() == pytest.approx(a * area[:2].sum() + b * area[2:4].sum(), rel=1e-5)


def path(values):
    """Points in a row with the given log signatures, the same at all times, each a segment of its own."""
    count = len(values)
    signature = np.exp(np.repeat(np.array(values, float)[:, None], len(TIMES), axis=1))
    rows = np.arange(count)
    neighbours = np.stack([np.maximum(rows - 1, 0), np.minimum(rows + 1, count - 1)], axis=1)
    return HeatKernel(signature, np.ones(count), rows, neighbours)


def peaks(values, segments):
    """(birth, persistence) of the peaks of a union of points in a row, the same at all times."""
    members = np.isin(np.arange(len(values)), segments)[None]
    found = persistent_signatures(path(values), members)[0].reshape(len(PERSISTENT), 2, PEAKS)
    assert (found == found[0]).all()
    return [(round(float(b), 4), round(float(p), 4)) for b, p in found[0].T]


def test_a_peak_dies_where_a_higher_one_is_met():
    """3 lasts down to the lowest point, 2.5 down to the 1 between them."""
    assert peaks([3, 1, 2.5, 0], [0, 1, 2, 3]) == [(3, 3), (2.5, 1.5), (3, 0), (3, 0)]


def test_only_the_points_of_the_union_count():
    assert peaks([3, 1, 2.5, 0], [2, 3]) == [(2.5, 2.5), (2.5, 0), (2.5, 0), (2.5, 0)]
    assert peaks([3, 1, 2.5, 0], [0, 2, 3]) == [(3, 3), (2.5, 2.5), (3, 0), (3, 0)]


def test_the_most_persistent_come_first_and_the_rest_is_left_out():
    values = [9, 0, 2, 1, 4, 0, 5, 3, 6, 0, 8]  # peaks 9, 2, 4, 5, 6, 8 with persistences 9, 1, 4, 2, 6, 8
    assert peaks(values, range(11)) == [(9, 9), (8, 8), (6, 6), (4, 4)]


def test_the_same_seed_gives_the_same_heat(lamp):
    a, b, c = (heat_kernel(lamp, seed=seed) for seed in (2, 2, 3))
    assert np.array_equal(a.signature, b.signature)
    assert not np.array_equal(a.signature, c.signature)
