"""Measures of bars, whose areas, extents and distances are known by hand."""

import numpy as np
import pytest
from world import bar

from engine.shapes.measures import measure, segment_geodesics
from engine.shapes.mesh import Mesh
from engine.shapes.multilayer import build_multilayer_graph
from engine.shapes.parameters import preset
from engine.shapes.segmentation import SegmentedShape, SegmentGraph
from engine.shapes.segmentgraph import build_segment_graph


def members(count, *nodes):
    return np.array([[s in node for s in range(count)] for node in nodes])


def measured(shape, *nodes, seed=0):
    graph, _ = build_segment_graph(shape, adjacency="auto", touch_distance=0.012, touch_samples=2000, seed=0)
    between = segment_geodesics(shape, points=700, seed=seed)
    return measure(shape, graph, members(shape.segmentation.count, *nodes), between)


def test_sizes_are_shares_of_the_area():
    found = measured(bar([1, 2, 3]), {0}, {1}, {2}, {0, 1}, {0, 1, 2})  # 4 a unit of length, and 1 for either end
    assert found.size == pytest.approx(np.array([5, 8, 13, 13, 26]) / 26)


def test_overlap_is_the_share_of_the_first_node_that_lies_in_the_second():
    found = measured(bar([1, 2, 3]), {0}, {2}, {0, 1}, {1, 2}, {0, 1, 2})
    assert found.overlap == pytest.approx(np.array([
        [1, 0, 1, 0, 1],
        [0, 1, 0, 1, 1],
        [5 / 13, 0, 1, 8 / 13, 1],
        [0, 13 / 21, 8 / 21, 1, 1],
        [5 / 26, 13 / 26, 13 / 26, 21 / 26, 1],
    ]), abs=1e-6)  # fmt: skip


def rms_of_tube(length):
    """Of a 1 x 1 tube open at both ends: across, one coordinate is ±1/2 and the other uniform, hence 1/4 + 1/12."""
    return np.sqrt(1 / 3 + length**2 / 12)


def rms_of_bar(length):
    """Of the tube with its two unit squares: across 1/6, along (length/2)²."""
    return np.sqrt((4 * length * rms_of_tube(length) ** 2 + 2 * (1 / 6 + length**2 / 4)) / (4 * length + 2))


def test_extents_of_tubes_are_exact():
    found = measured(bar([1, 2, 1, 3]), {1}, {2}, {1, 2}, {0, 1, 2, 3})
    wanted = np.array([rms_of_tube(2), rms_of_tube(1), rms_of_tube(3), rms_of_bar(7)]) / rms_of_bar(7)
    assert found.extent == pytest.approx(wanted)


def test_extents_do_not_depend_on_the_triangles():
    shape = bar([1, 2, 1])
    a, b, c = (shape.mesh.vertices[shape.mesh.faces[:, k]] for k in range(3))
    vertices = np.concatenate([a, b, c, (a + b + c) / 3])
    n = len(a)
    faces = np.concatenate([np.c_[i * n + np.arange(n), j * n + np.arange(n), 3 * n + np.arange(n)]
                            for i, j in ((0, 1), (1, 2), (2, 0))])  # fmt: skip
    labels = type(shape.segmentation)(np.tile(shape.segmentation.labels, 3), shape.segmentation.names)
    finer = SegmentedShape(Mesh(vertices, faces, "finer"), labels)
    nodes = {0}, {1}, {1, 2}
    assert measured(finer, *nodes).extent == pytest.approx(measured(shape, *nodes).extent)


def test_distances_along_a_straight_bar_are_those_along_its_axis():
    """Means of |x - y| for x and y uniform in two quarters of a line, in units of the mean over the line, 1/3."""
    found = measured(bar([10] * 4), {0}, {1}, {2}, {3})
    steps = np.abs(np.subtract.outer(range(4), range(4)))
    assert found.geodesic == pytest.approx(np.where(steps == 0, 0.25, 0.75 * steps), abs=0.06)
    assert found.centrality == pytest.approx([1.1875, 0.8125, 0.8125, 1.1875], rel=0.05)


def test_geodesics_go_around_and_not_across():
    """The same four pieces bent to a U: its ends are near in space and as far apart as before along the surface."""
    straight = bar([10] * 4)
    x, y, z = straight.mesh.vertices.T
    bent = np.select([x < 15, x < 25], [[x, y], [np.full_like(x, 20.0), y]], [40 - x, 5 + y])
    shape = SegmentedShape(Mesh(np.c_[bent.T, z], straight.mesh.faces, "bent"), straight.segmentation)
    between = segment_geodesics(shape, points=700, seed=0)
    assert between[0, 3] > 2 * between[0, 1]


def test_laws_of_distances():
    shape = bar([3, 1, 2, 4])
    found = measured(shape, {0}, {1}, {2}, {3}, {0, 1}, {2, 3}, {0, 1, 2, 3})
    g, area = found.geodesic, np.array([13, 4, 8, 17.0])
    assert np.array_equal(g, g.T)
    assert g[6, 6] == pytest.approx(1)  # the unit: the mean distance over all of the shape
    assert found.centrality[6] == pytest.approx(1)
    assert g[6] == pytest.approx(found.centrality, rel=1e-5)
    assert area @ found.centrality[:4] / area.sum() == pytest.approx(1)
    mean = g[:2, 2:4] * area[:2, None] / area[:2].sum() * area[2:] / area[2:].sum()
    assert g[4, 5] == pytest.approx(mean.sum(), rel=1e-5)


def test_measures_are_relative_to_the_shape():
    shape = bar([3, 1, 2, 4])
    large = SegmentedShape(Mesh(100 * shape.mesh.vertices + 7, shape.mesh.faces, "large"), shape.segmentation)
    nodes = {0}, {1}, {2}, {3}, {1, 2}
    a, b = measured(shape, *nodes), measured(large, *nodes)
    for name in ("size", "extent", "centrality", "geodesic", "overlap"):
        assert getattr(b, name) == pytest.approx(getattr(a, name), rel=1e-5)


@pytest.mark.parametrize(("size_measure", "layers"), [("area", [1, 1, 1, 3, 3, 4]), ("volume", [1, 1, 1, 2, 4, 4])])
def test_the_layer_rule_takes_the_measure_that_it_is_told(size_measure, layers):
    """Eq 3.1 with L = 4: {0, 1} holds 2/3 of the area but 1/4 of the volume; {1, 2} holds 2/3 and 7/8."""
    graph = SegmentGraph(np.ones(3), np.array([1.0, 1.0, 6.0]), np.array([[0, 1], [1, 2]]), np.zeros(2))
    parameters = preset("thesis-rigid").changed(mode="connected", layers=4, size_measure=size_measure)
    found = build_multilayer_graph(graph, parameters, graph.adjacency().astype(float))
    assert found.members.tolist() == members(3, {0}, {1}, {2}, {0, 1}, {1, 2}, {0, 1, 2}).tolist()
    assert found.layer.tolist() == layers
