"""Points on a surface and what is known at each: a sphere, a bar and a sheet have values that can be said beforehand."""

import numpy as np
import pytest
import trimesh
from world import bar

from engine.shapes.families.generated import random_rotation
from engine.shapes.mesh import Mesh
from engine.shapes.nodefeatures import node_features
from engine.shapes.segmentation import SegmentedShape, segmentation_from_labels
from engine.shapes.segmentgraph import build_segment_graph
from engine.shapes.surfacepoints import surface_points


def graph_of(shape):
    return build_segment_graph(shape, adjacency="auto", touch_distance=0.012, touch_samples=2000, seed=0)[0]


def sphere():
    mesh = trimesh.creation.icosphere(5)
    labels = (mesh.triangles_center[:, 2] > 0).astype(int)
    return SegmentedShape(Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces), "sphere"), segmentation_from_labels(labels))


def moved(shape, rotation, scale=1.0, shift=0.0):
    mesh = Mesh(scale * shape.mesh.vertices @ rotation.T + shift, shape.mesh.faces, shape.mesh.name)
    return SegmentedShape(mesh, shape.segmentation)


def test_points_are_centred_and_scaled_and_their_weights_are_shares_of_area(lamp):
    points = surface_points(lamp, count=300, seed=0)
    assert points.weight.sum() == pytest.approx(1)
    assert points.weight @ points.points == pytest.approx(np.zeros(3), abs=1e-12)
    assert points.weight @ points.radius**2 == pytest.approx(1)
    assert points.weight @ points.geodesic @ points.weight == pytest.approx(1, abs=1e-5)
    share = np.bincount(points.owner, points.weight)
    assert share == pytest.approx(graph_of(lamp).area / graph_of(lamp).area.sum())


def test_the_smallest_segment_has_three_points_at_least():
    shape = bar([100.0, 0.01, 100.0])
    assert np.bincount(surface_points(shape, count=50, seed=0).owner)[1] >= 3


def test_a_sphere_is_touched_from_within_by_itself_and_from_without_by_a_plane():
    points = surface_points(sphere(), count=500, seed=0)
    assert np.median(points.inner) == pytest.approx(1, abs=0.1)
    assert points.outer.min() == 2.0


def test_a_mesh_that_is_inside_out_has_the_same_thickness():
    shape = sphere()
    turned = SegmentedShape(Mesh(shape.mesh.vertices, shape.mesh.faces[:, ::-1], "sphere"), shape.segmentation)
    assert np.median(surface_points(turned, count=300, seed=0).inner) == pytest.approx(1, abs=0.05)


def test_distances_on_a_long_bar_are_those_along_it():
    points = surface_points(bar([20.0, 20.0]), count=600, seed=0)
    along = np.abs(points.points[:, :1] - points.points[:, 0])
    far = along > 1
    ratio = points.geodesic[far] / along[far]
    assert ratio.std() / ratio.mean() < 0.06


def test_profiles_grow_and_end_at_the_furthest_point(lamp):
    points = surface_points(lamp, count=300, seed=0)
    assert (np.diff(points.profile, axis=1) >= 0).all()
    assert points.profile[:, -1] == pytest.approx(points.geodesic.max(axis=1))


def test_features_of_nodes_do_not_change_when_a_shape_is_moved_turned_and_scaled(lamp):
    members = np.array([[1, 0, 0, 0, 0], [0, 1, 1, 0, 0], [0, 0, 0, 1, 1], [1, 1, 1, 1, 0]], dtype=bool)
    rotation = random_rotation(np.random.default_rng(4))
    found = []
    for shape in (lamp, moved(lamp, rotation, 3.0, 7.0)):
        found.append(node_features(surface_points(shape, count=300, seed=0), graph_of(shape), members))
    for name, values in found[0].items():
        assert values == pytest.approx(found[1][name], abs=2e-3), name


def test_the_middle_of_a_bar_leaves_two_pieces_and_its_end_one():
    shape = bar([3.0, 1.0, 2.0])
    members = np.array([[0, 1, 0], [1, 0, 0], [1, 1, 1]], dtype=bool)
    found = node_features(surface_points(shape, count=200, seed=0), graph_of(shape), members)
    assert np.expm1(found["rest_pieces"]) == pytest.approx([2, 1, 0])
    area = graph_of(shape).area / graph_of(shape).area.sum()
    assert found["rest_1"] == pytest.approx([area[0], area[1] + area[2], 0])
    assert found["rest_2"] == pytest.approx([area[2], 0, 0])
    assert found["size"] == pytest.approx(np.log([area[1], area[0], 1]))


def test_a_part_that_is_there_four_times_repeats_and_one_that_is_alone_does_not():
    from world import boxes

    table = boxes([((0, 0, 4), (6, 4, 4.5)), *(((x, y, 0), (x + 0.4, y + 0.4, 4)) for x in (0, 5.6) for y in (0, 3.6))])
    found = node_features(surface_points(table, count=500, seed=0), graph_of(table), np.eye(5, dtype=bool))
    assert found["repeats"][1:].min() > 2 * found["repeats"][0]


def test_a_flat_sheet_without_volume_has_finite_features():
    grid = np.array([[x, y, 0.0] for x in range(5) for y in range(5)])
    faces = [t for x in range(4) for y in range(4) for a in [5 * x + y] for t in ((a, a + 5, a + 6), (a, a + 6, a + 1))]
    shape = SegmentedShape(Mesh(grid, np.array(faces), "sheet"), segmentation_from_labels(np.repeat([0, 1], 16)))
    points = surface_points(shape, count=100, seed=0)
    found = node_features(points, graph_of(shape), np.eye(2, dtype=bool))
    assert all(np.isfinite(values).all() for values in found.values())
    assert all(np.isfinite(values).all() for values in points.arrays().values())
