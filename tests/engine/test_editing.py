"""Segments changed by hand, on bars whose answers are known."""

import numpy as np
import pytest
from world import bar

from engine.errors import BadInput
from engine.shapes.editing import (
    compacted,
    grown,
    merged,
    names_of,
    next_label,
    repainted,
    split_by_patches,
    split_by_plane,
)
from engine.shapes.facegraph import face_graph

LABELS = np.array([0, 0, 1, 1, 2, 2, 5])


@pytest.fixture
def long_bar():
    """Six sections of a bar, one segment; the graph of its 52 faces and the place of each along it."""
    mesh = bar([1.0] * 6).mesh
    return face_graph(mesh), mesh.vertices[mesh.faces].mean(axis=1)[:, 0]


def test_merging_keeps_the_lowest_label_and_all_others():
    assert merged(LABELS, [5, 1]).tolist() == [0, 0, 1, 1, 2, 2, 1]
    assert LABELS.tolist() == [0, 0, 1, 1, 2, 2, 5]
    for chosen in ([], [1], [1, 9]):
        with pytest.raises(BadInput, match="at least two"):
            merged(LABELS, chosen)


def test_merging_does_not_depend_on_the_order():
    assert (merged(merged(LABELS, [0, 1]), [0, 2]) == merged(LABELS, [2, 0, 1])).all()


def test_a_plane_cuts_a_segment_and_the_larger_part_keeps_its_label(long_bar):
    graph, x = long_bar
    labels = split_by_plane(graph, np.zeros(52, int), 0, x - 2.01)
    assert (labels[x > 2.01] == 0).all()
    assert (labels[x < 2.01] == 1).all()
    with pytest.raises(BadInput, match="across it"):
        split_by_plane(graph, labels, 1, x - 7.0)


def test_a_plane_cuts_only_the_segment_that_is_meant(long_bar):
    graph, x = long_bar
    before = (x > 3).astype(int)
    after = split_by_plane(graph, before, 0, x - 1.01)
    assert (after[x > 3] == 1).all()
    assert set(after[x < 3]) == {0, 2}


def test_a_cut_through_two_arms_makes_a_piece_of_each():
    mesh = bar([1.0] * 6).mesh
    graph = face_graph(mesh)
    x = mesh.vertices[mesh.faces].mean(axis=1)[:, 0]
    labels = split_by_plane(graph, np.zeros(52, int), 0, np.abs(x - 3) - 1.01)
    assert len(np.unique(labels)) == 3
    assert labels[np.argmin(x)] != labels[np.argmax(x)]


def test_splitting_by_patches_gives_the_number_asked_for(long_bar):
    graph, _ = long_bar
    for parts in (2, 3, 5):
        labels = split_by_patches(graph, np.zeros(52, int), 0, parts)
        assert np.unique(labels).tolist() == list(range(parts))
        size = np.bincount(labels, graph.area)
        assert size[0] == size.max()
    with pytest.raises(BadInput, match="2 to 20"):
        split_by_patches(graph, np.zeros(52, int), 0, 1)
    one = np.r_[1, np.zeros(51, int)]
    with pytest.raises(BadInput, match="1 faces, too few"):
        split_by_patches(graph, one, 1, 2)
    with pytest.raises(BadInput, match="Choose a segment"):
        split_by_patches(graph, one, 7, 2)


def test_painting_moves_faces_and_an_emptied_segment_is_gone():
    after = repainted(LABELS, np.array([6, 0]), 2)
    assert after.tolist() == [2, 0, 1, 1, 2, 2, 2]
    assert compacted(after, {}).count == 3
    assert next_label(LABELS) == 6


def test_the_brush_grows_with_its_radius_and_never_over_a_gap(long_bar):
    graph, _ = long_bar
    sizes = [len(grown(graph, 10, radius)) for radius in (0.0, 0.05, 0.2, 0.5, 5.0)]
    assert sizes[0] == 1
    assert sizes == sorted(sizes)
    assert sizes[-1] == 52
    assert grown(graph, 10, 0.3)[0] == 10
    near = np.linalg.norm(graph.centre[grown(graph, 10, 0.3)] - graph.centre[10], axis=1)
    assert near.max() <= 0.3
    from world import boxes

    apart = face_graph(boxes([((0, 0, 0), (1, 1, 1)), ((1.01, 0, 0), (2, 1, 1))]).mesh)
    assert (grown(apart, 0, 9.0) < 12).all()


def test_names_stay_with_their_segments_and_new_ones_get_free_numbers():
    names = {0: 7, 1: "arm", 2: 3}
    assert names_of(LABELS, names) == {0: 7, 1: "arm", 2: 3, 5: 8}
    found = compacted(merged(LABELS, [0, 2]), names)
    assert found.names == (7, "arm", 8)
    assert found.labels.tolist() == [0, 0, 1, 1, 0, 0, 2]
