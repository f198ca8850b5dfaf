"""Motions that lay one shape upon another: a shape finds itself again however it is turned."""

import numpy as np
import pytest

from engine.shapes.alignment import alignments
from engine.shapes.families import make_shape
from engine.shapes.families.generated import random_rotation
from engine.shapes.mesh import Mesh
from engine.shapes.segmentation import SegmentedShape, segmentation_from_labels
from engine.shapes.surfacepoints import surface_points


def points_of(shape, rotation=None, seed=0):
    vertices = shape.mesh.vertices if rotation is None else shape.mesh.vertices @ rotation.T
    segmented = SegmentedShape(Mesh(vertices, shape.mesh.faces, "shape"), segmentation_from_labels(shape.part))
    return surface_points(segmented, count=300, seed=seed)


@pytest.mark.parametrize("family", ["lamps", "aeroplanes", "animals"])
def test_a_turned_shape_is_turned_back(family):
    shape = make_shape(family, 3)
    rotation = random_rotation(np.random.default_rng(8))
    best = alignments(points_of(shape), points_of(shape, rotation, seed=1))[0]
    apart = points_of(shape).points @ best.rotation.T - points_of(shape, rotation).points
    assert np.sqrt((apart**2).sum(axis=1).mean()) < 0.1  # radii are about 1


def test_motions_are_sorted_different_rotations():
    a, b = points_of(make_shape("vases", 3)), points_of(make_shape("vases", 4))
    found = alignments(a, b)
    assert 1 <= len(found) <= 4
    assert [one.cost for one in found] == sorted(one.cost for one in found)
    for one in found:
        assert one.rotation @ one.rotation.T == pytest.approx(np.eye(3), abs=1e-9)
        assert np.linalg.det(one.rotation) == pytest.approx(1)
        assert (len(one.onto), len(one.back)) == (len(a.weight), len(b.weight))
        assert one.onto.max() < len(b.weight)
        assert one.back.max() < len(a.weight)
    for k, one in enumerate(found):
        assert all(np.trace(one.rotation @ other.rotation.T) < 2.7 for other in found[:k])


def test_the_cost_does_not_change_when_either_shape_is_turned():
    a, b = make_shape("animals", 5), make_shape("animals", 6)
    rng = np.random.default_rng(2)
    plain = alignments(points_of(a), points_of(b))[0].cost
    turned = alignments(points_of(a, random_rotation(rng)), points_of(b, random_rotation(rng)))[0].cost
    assert turned == pytest.approx(plain, rel=0.05)
