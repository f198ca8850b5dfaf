"""The random over-segmenter: connected pieces, the wanted number, no slivers, the same for the same seed."""

from itertools import pairwise

import numpy as np
import pytest

from engine.errors import BadParameter
from engine.shapes.families import FAMILIES, VARIANTS, make_shape
from engine.shapes.mesh import Mesh, face_areas
from engine.shapes.oversegmentation import (
    SLIVER,
    connected_pieces,
    face_neighbours,
    oversegment,
    without_teeth,
)

BOTH = [(family, variant) for family in FAMILIES for variant in VARIANTS]


def strip(n: int) -> Mesh:
    """A straight strip of n unit squares, two triangles each."""
    x = np.arange(n + 1.0)
    vertices = np.vstack([np.c_[x, 0 * x, 0 * x], np.c_[x, 0 * x + 1, 0 * x]])
    k = np.arange(n)
    faces = np.vstack([np.c_[k, k + 1, k + n + 2], np.c_[k, k + n + 2, k + n + 1]])
    return Mesh(vertices, faces, "strip")


def pieces_within(mesh: Mesh, label: np.ndarray) -> int:
    pairs = face_neighbours(mesh.faces)
    return int(connected_pieces(pairs[label[pairs[:, 0]] == label[pairs[:, 1]]], len(label)).max()) + 1


def test_two_triangles_with_a_common_edge_are_neighbours_once():
    assert face_neighbours(np.array([[0, 1, 2], [2, 1, 3], [4, 5, 6]])).tolist() == [[0, 1]]


def test_a_face_between_two_of_another_label_takes_it():
    pairs = np.array([[0, 1], [1, 2], [2, 3], [3, 4]])
    assert without_teeth(pairs, np.array([0, 0, 1, 0, 0])).tolist() == [0, 0, 0, 0, 0]
    assert without_teeth(pairs, np.array([0, 0, 1, 1, 1])).tolist() == [0, 0, 1, 1, 1]


def test_a_strip_is_cut_across_into_connected_runs():
    mesh = strip(60)
    cut = oversegment(mesh, np.zeros(120, dtype=int), segments=5, seed=1)
    assert cut.count == 5
    assert pieces_within(mesh, cut.labels) == 5
    column = mesh.vertices[mesh.faces].mean(axis=1)[:, 0]
    spans = sorted((column[cut.labels == k].min(), column[cut.labels == k].max()) for k in range(5))
    assert all(a[1] <= b[0] + 1 for a, b in pairwise(spans))


@pytest.mark.parametrize(("family", "variant"), BOTH)
def test_every_segment_is_connected_inside_one_part_and_no_sliver(family, variant):
    shape = make_shape(family, 1, variant=variant)
    regions = pieces_within(shape.mesh, shape.part)
    cut = oversegment(shape.mesh, shape.part, segments=regions + 6, seed=2)
    assert cut.count == regions + 6
    assert pieces_within(shape.mesh, cut.labels) == cut.count
    area = face_areas(shape.mesh)
    uncut = np.bincount(shape.part, area).min()
    share = np.bincount(cut.labels, area) / area.sum()
    assert share.min() >= min(SLIVER, uncut / area.sum())
    for k in range(cut.count):
        assert len(np.unique(shape.part[cut.labels == k])) == 1


def test_the_seed_alone_decides_the_cuts():
    shape = make_shape("lamps", 1)
    first, again, other = (oversegment(shape.mesh, shape.part, segments=12, seed=s).labels for s in (5, 5, 6))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


@pytest.mark.parametrize("variant", VARIANTS)
def test_fewer_segments_than_parts_joins_neighbours(variant):
    shape = make_shape("animals", 2, variant=variant)
    cut = oversegment(shape.mesh, shape.part, segments=8, seed=0)
    assert cut.count == 8
    for part in range(shape.part.max() + 1):
        assert len(np.unique(cut.labels[shape.part == part])) == 1


def test_merging_by_chance_leaves_segments_that_span_parts():
    shape = make_shape("animals", 2)
    spans = [
        sum(len(np.unique(shape.part[cut.labels == k])) > 1 for k in range(cut.count))
        for cut in (oversegment(shape.mesh, shape.part, segments=24, seed=0, merge=m) for m in (0.0, 0.6))
    ]
    assert spans[0] == 0
    assert spans[1] > 0


def test_a_single_triangle_cannot_be_cut_and_stays_whole():
    cut = oversegment(Mesh(np.eye(3), np.array([[0, 1, 2]])), np.zeros(1, dtype=int), segments=4, seed=0)
    assert cut.count == 1


@pytest.mark.parametrize("bad", [{"segments": 1}, {"segments": 4, "merge": 1.5}, {"segments": 4, "merge": -0.1}])
def test_bad_parameters_are_refused(bad):
    with pytest.raises(BadParameter):
        oversegment(strip(4), np.zeros(8, dtype=int), seed=0, **bad)
