"""Principal components, volume and area against hand-made values."""

import numpy as np
import pytest
from world import bar, boxes

from engine.shapes.families.generated import random_rotation
from engine.shapes.mesh import Mesh
from engine.shapes.segmentation import SegmentedShape, segmentation_from_labels
from engine.shapes.shapefeatures import principal_features, principal_shape, surface_covariances, volume_and_area


def test_a_line_a_disc_and_a_ball():
    found = principal_features(np.array([np.diag([1.0, 0, 0]), np.diag([0, 2.0, 2.0]), 3 * np.eye(3)]))
    line, disc, ball = found
    assert line == pytest.approx([1, 0, 0, 0, 0, 0])
    assert disc == pytest.approx([0, 1, 0, 0, np.log(2) / np.log(3), 0])
    assert ball == pytest.approx([0, 0, 1, 1, 1, 1])


def test_nothing_at_all_has_features_too():
    assert np.isfinite(principal_features(np.zeros((1, 3, 3)))).all()


def test_the_covariance_of_a_cube():
    """Four faces spread evenly over a side, two at its ends: (4/12 + 2/4)/6 = 5/36 along each axis."""
    cube = boxes([((0, 0, 0), (2, 2, 2))])
    found = surface_covariances(cube.mesh, cube.segmentation.labels, np.ones((1, 1), dtype=bool))
    assert found[0] == pytest.approx(4 * 5 / 36 * np.eye(3), abs=1e-12)


def test_a_union_is_exactly_what_it_would_be_as_one_segment(lamp):
    joined = np.where(lamp.segmentation.labels == 2, 1, lamp.segmentation.labels)
    one = SegmentedShape(lamp.mesh, segmentation_from_labels(joined))
    union = surface_covariances(lamp.mesh, lamp.segmentation.labels, np.array([[0, 1, 1, 0, 0]], dtype=bool))
    segment = surface_covariances(one.mesh, one.segmentation.labels, np.array([[0, 1, 0, 0]], dtype=bool))
    assert union == pytest.approx(segment, abs=1e-12)


def test_pose_and_size_do_not_matter(lamp):
    members = np.array([[1, 0, 0, 0, 0], [0, 1, 1, 1, 0]], dtype=bool)
    turn = random_rotation(np.random.default_rng(5))
    moved = SegmentedShape(Mesh(0.1 * lamp.mesh.vertices @ turn.T + [5, -3, 1], lamp.mesh.faces), lamp.segmentation)
    assert principal_shape(lamp, members) == pytest.approx(principal_shape(moved, members), abs=1e-5)


def test_a_long_bar_is_linear_and_a_plate_planar():
    rod, plate = principal_shape(bar([50]), np.ones((1, 1), dtype=bool))[0], principal_shape(
        boxes([((0, 0, 0), (9, 9, 0.1))]), np.ones((1, 1), dtype=bool))[0]  # fmt: skip
    assert rod[0] > 0.99
    assert plate[1] > 0.99


def test_volume_and_area_are_shares_of_the_whole():
    members = np.array([[1, 0], [0, 1], [1, 1]], dtype=bool)
    found = volume_and_area(members, np.array([6.0, 24.0]), np.array([1.0, 8.0]))
    assert np.exp(found) == pytest.approx(np.array([[6 / 30, 1 / 9], [24 / 30, 8 / 9], [1, 1]]))


def test_sheets_have_no_volume_and_are_told_by_their_area():
    found = volume_and_area(np.eye(2, dtype=bool), np.array([1.0, 3.0]), np.zeros(2))
    assert np.exp(found) == pytest.approx(np.array([[0.25, 0.25], [0.75, 0.75]]))
    part = volume_and_area(np.eye(2, dtype=bool), np.array([1.0, 3.0]), np.array([0.0, 1.0]))
    assert np.isfinite(part).all()
