"""The ceiling of a pair: by hand, and above whatever matches score."""

import numpy as np
import pytest

from engine.evaluation.ceiling import ceiling
from engine.evaluation.correspondence import evaluate_tables

SINGLE = np.eye(2, dtype=bool)


def test_pure_segments_can_be_matched_perfectly():
    table = np.array([[2.0, 0], [0, 3]])
    most = ceiling(table, table, SINGLE, SINGLE)
    assert (most.lenient, most.strict, most.precision, most.recall) == (True, True, 1, 1)


def test_a_mixed_segment_caps_the_transfer():
    source, target = np.array([[1.0, 3], [0, 4]]), np.array([[4.0, 0], [0, 4]])
    most = ceiling(source, target, SINGLE, SINGLE)
    # Source: 3 of the mixed segment by the second class, 4. Target: the first class is at best a quarter of a node, 4.
    assert most.right == pytest.approx(3 + 4 + 4 * 0.25 + 4)
    assert most.recall == pytest.approx(12 / 16)
    assert (most.kept_right, most.kept) == pytest.approx((3 + 4 + 4, 4 + 4 + 4))


def test_a_part_without_a_counterpart_lowers_no_ceiling():
    source, target = np.array([[4.0, 0], [0, 4]]), np.array([[2.0, 0], [2, 0]])
    most = ceiling(source, target, SINGLE, SINGLE)
    assert (most.right, most.kept, most.area) == pytest.approx((8, 8, 12))
    assert (most.precision, most.recall) == (1, 1)


def test_shapes_without_a_common_class_have_no_right_pair():
    source, target = np.array([[1.0, 0, 0], [2, 0, 0]]), np.array([[0, 1.0, 0], [0, 0, 1]])
    most = ceiling(source, target, SINGLE, SINGLE)
    assert (most.lenient, most.strict, most.right, most.kept) == (False, False, 0, 0)
    assert np.isnan([most.precision, most.recall]).all()


def test_the_whole_shape_is_no_node():
    table = np.array([[2.0, 2], [2, 2]])
    whole = ceiling(table, table, np.array([[True, True]]), np.array([[True, True]]))
    assert (whole.lenient, whole.right) == (False, 0)


@pytest.mark.parametrize("seed", range(8))
def test_no_set_of_matches_of_the_nodes_transfers_more(seed):
    rng = np.random.default_rng(seed)
    source, target = (rng.random((n, 4)) * (rng.random((n, 4)) < 0.5) + 0.01 for n in (6, 8))
    nodes = [np.vstack([np.eye(n, dtype=bool), rng.random((12, n)) < 0.4]) for n in (6, 8)]
    most = ceiling(source, target, *nodes)
    for _ in range(20):
        rows = rng.integers([len(nodes[0]), len(nodes[1])], size=(rng.integers(1, 12), 2))
        matches = [(np.flatnonzero(nodes[0][i]), np.flatnonzero(nodes[1][j])) for i, j in rows]
        assert evaluate_tables(source, target, matches).transfer_recall <= most.recall + 1e-12
