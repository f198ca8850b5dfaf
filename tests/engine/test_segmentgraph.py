"""Which segments touch, and how that was found."""

import numpy as np
import pytest
from world import bar, boxes

from engine.shapes.segmentation import EDGE_KINDS, segmentation_from_labels
from engine.shapes.segmentgraph import build_segment_graph, capped_volumes, sample_surface


def graph(shape, adjacency="auto", touch=0.012):
    return build_segment_graph(shape, adjacency=adjacency, touch_distance=touch, touch_samples=20_000, seed=0)


def edges(found):
    return {(int(i), int(j)): EDGE_KINDS[k] for (i, j), k in zip(found.edges, found.kind, strict=True)}


def test_a_welded_bar_is_a_chain_of_shared_vertices():
    found, notes = graph(bar([1, 2, 1, 3]))
    assert edges(found) == {(0, 1): "shared vertices", (1, 2): "shared vertices", (2, 3): "shared vertices"}
    assert notes == ()
    assert found.area == pytest.approx([5, 8, 4, 13])
    assert found.volume == pytest.approx([1, 2, 1, 3])


def test_touching_parts_are_found_by_proximity(lamp):
    found, notes = graph(lamp)
    assert {k: v for k, v in edges(found).items() if k != (1, 2)} == {
        (0, 1): "proximity", (2, 3): "proximity", (3, 4): "proximity"}  # fmt: skip
    assert edges(found)[1, 2] == "shared vertices"  # the two stem pieces have equal corners
    assert notes == ()


def test_far_parts_are_joined_by_their_closest_pair_and_reported():
    shape = boxes([((0, 0, 0), (1, 1, 1)), ((1.5, 0, 0), (2.5, 1, 1)), ((7, 0, 0), (8, 1, 1))])
    found, notes = graph(shape)
    assert edges(found) == {(0, 1): "closest pair", (1, 2): "closest pair"}
    assert "3 pieces" in notes[0]


def test_touch_distance_is_a_share_of_the_diagonal():
    shape = boxes([((0, 0, 0), (10, 1, 1)), ((10.3, 0, 0), (20, 1, 1))])
    assert set(edges(graph(shape, touch=0.01)[0]).values()) == {"closest pair"}
    assert set(edges(graph(shape, touch=0.05)[0]).values()) == {"proximity"}


def test_a_welded_mesh_gets_no_false_pairs_from_proximity():
    folded = boxes([((0, 0, 0), (1, 1, 10)), ((1.01, 0, 0), (2, 1, 10))])
    tied = bar([1, 1, 1])
    assert set(edges(graph(tied, touch=0.1)[0]).values()) == {"shared vertices"}
    assert edges(graph(folded, adjacency="shared")[0]) == {(0, 1): "closest pair"}


def test_renumbering_the_segments_renumbers_the_graph(lamp):
    order = np.array([3, 0, 4, 1, 2])
    renamed = type(lamp)(lamp.mesh, segmentation_from_labels(order[lamp.segmentation.labels]))
    one, two = edges(graph(lamp)[0]), edges(graph(renamed)[0])
    assert {tuple(sorted((int(order[i]), int(order[j])))): kind for (i, j), kind in one.items()} == two


def test_a_sheet_has_no_volume_and_a_box_its_own(lamp):
    assert capped_volumes(lamp) == pytest.approx([4 * 3 * 0.5, 0.16 * 2, 0.16 * 3, 6, 0.6 * 0.4 * 0.3])


def test_samples_lie_on_their_segments(lamp):
    points, owner = sample_surface(lamp, 2000, seed=1)
    assert np.bincount(owner).min() >= 40
    foot = points[owner == 0]
    assert (foot.min(axis=0) >= np.array([-2, -1.5, 0]) - 1e-9).all()
    assert (foot.max(axis=0) <= np.array([2, 1.5, 0.5]) + 1e-9).all()
    again, _ = sample_surface(lamp, 2000, seed=1)
    assert np.array_equal(points, again)
