"""Diffusion pruning and voting by hand, and the fast sums against plain loops."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.consistency.candidates import k_best
from engine.consistency.diffusion import greedy, stationary
from engine.consistency.voting import containment, nesting, vote
from engine.shapes.agreement import affinity_degrees, affinity_table, isometry, overlap_agreement, overlap_scores
from engine.shapes.hops import UNREACHABLE


def none(a, others):
    return np.zeros(len(others), bool)


def test_stationary_distribution_is_the_left_eigenvector_of_the_walk():
    m = np.random.default_rng(0).random((6, 6))
    m = m + m.T
    pi = stationary(m.sum(axis=1))
    walk = m / m.sum(axis=1, keepdims=True)
    assert pi @ walk == pytest.approx(pi)
    assert pi.sum() == pytest.approx(1)
    assert stationary(np.zeros(3)).tolist() == [0, 0, 0]


def test_greedy_is_one_to_one_in_order_of_confidence_with_ties_by_index():
    pairs = np.array([[0, 0], [0, 1], [1, 1], [1, 0], [2, 2]])
    assert greedy(pairs, np.array([0.5, 0.9, 0.4, 0.4, 0.4]), none).tolist() == [1, 3, 4]


def test_greedy_takes_the_first_ones_first_and_leaves_out_conflicts():
    pairs = np.array([[0, 0], [1, 1], [2, 2]])
    conflict = np.array([[0, 1, 0], [1, 0, 0], [0, 0, 0]], bool)
    confidence = np.array([0.9, 0.5, 0.1])
    assert greedy(pairs, confidence, lambda a, others: conflict[a, others]).tolist() == [0, 2]
    assert greedy(pairs, confidence, lambda a, others: conflict[a, others], first=np.array([1])).tolist() == [1, 2]
    assert greedy(pairs, np.array([0.9, 0.5, 0]), lambda a, others: conflict[a, others]).tolist() == [0]


def test_k_best_with_ties_to_the_smaller_row():
    pairs = np.array([[0, 0], [0, 1], [0, 2], [1, 0], [1, 2]])
    distance = np.array([2.0, 1.0, 1.0, 5.0, 4.0])
    assert k_best(pairs, distance, 1, side=0).tolist() == [False, True, False, False, True]
    assert k_best(pairs, distance, 1, side=1).tolist() == [True, True, True, False, False]


def test_isometry_by_hand():
    assert isometry([1, 2, 0, 3, UNREACHABLE], [2, 2, 1, 0, 1]) == pytest.approx([0.5, 1, 0, 0, 0])


def test_affinity_table_of_eq_3_3():
    table = affinity_table(4, 3, 0.5)
    assert table[2, 2] == 1
    assert table[3, 2] == pytest.approx((2 / 3 - 0.5) / 0.5)
    assert table[4, 1] == 0
    assert table[0].max() == table[:, 0].max() == 0


@given(st.integers(0, 10**6), st.floats(0, 0.95))
@settings(max_examples=20, deadline=None)
def test_row_sums_equal_those_of_the_matrix(seed, c_0):
    rng = np.random.default_rng(seed)
    d_source, d_target = (np.where(np.eye(n), 0, rng.integers(1, 6, (n, n))).astype(np.uint8) for n in (7, 5))
    d_source[0, 1] = d_source[1, 0] = UNREACHABLE
    d_source, d_target = np.minimum(d_source, d_source.T), np.minimum(d_target, d_target.T)
    pairs = np.array([(i, j) for i in range(7) for j in range(5) if rng.random() < 0.4]).reshape(-1, 2)
    similarity = rng.random(len(pairs))
    reach = (3, 4)
    matrix = np.diag(similarity)
    for a, (i, j) in enumerate(pairs):
        for b, (x, y) in enumerate(pairs):
            p, q = int(d_source[i, x]), int(d_target[j, y])
            if a != b and 1 <= p <= reach[0] and 1 <= q <= reach[1]:
                m = min(p / q, q / p)
                matrix[a, b] = (m - c_0) / (1 - c_0) if m >= c_0 else 0
    found = affinity_degrees(pairs, similarity, d_source, d_target, affinity_table(*reach, c_0))
    assert found == pytest.approx(matrix.sum(axis=1))


def test_votes_by_hand():
    # head < head+body < all on both sides; a fourth match nests on one side only
    inside_source = np.array([[0, 1, 1, 0], [0, 0, 1, 0], [0, 0, 0, 0], [0, 0, 1, 0]], bool)
    inside_target = np.array([[0, 1, 1, 1], [0, 0, 1, 0], [0, 0, 0, 0], [0, 0, 1, 0]], bool)
    accepted, votes = vote(inside_source, inside_target, np.array([0.1, 0.2, 0.9, 0.8]))
    assert votes.tolist() == [2, 1, 0, 1]
    assert accepted.tolist() == [0, 1, 2]  # the fourth conflicts with the first


def test_nesting_is_strict():
    members = np.array([[1, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 1]], bool)
    assert np.argwhere(nesting(members)).tolist() == [[0, 1], [2, 1]]


def test_both_directions_of_nesting_are_tested():
    inside_source = np.array([[0, 0], [1, 0]], bool)  # the second lies in the first, on the source side only
    inside_target = np.zeros((2, 2), bool)
    votes, conflict = containment(inside_source, inside_target)
    assert votes.tolist() == [0, 0]
    assert conflict[0, 1]
    assert conflict[1, 0]
    assert vote(inside_source, inside_target, np.array([0.3, 0.6]))[0].tolist() == [1]


def test_ties_of_votes_go_to_confidence_then_index():
    nothing = np.zeros((3, 3), bool)
    assert vote(nothing, nothing, np.array([0.2, 0.9, 0.2]))[0].tolist() == [1, 0, 2]


def random_pack(n, rng):
    """As `pack` makes it: the second is the first transposed, and distances are symmetric."""
    overlap, distance = rng.random((2, n, n))
    return np.stack([overlap, overlap.T, distance + distance.T], axis=-1).astype(np.float32)


def test_overlap_scores_equal_the_plain_loops():
    rng = np.random.default_rng(4)
    source, target = random_pack(6, rng), random_pack(5, rng)
    pairs = np.array([(i, j) for i in range(6) for j in range(5)])
    g = rng.random(len(pairs))
    found = overlap_scores(pairs, g, source, target, 0.3)
    wanted = np.zeros(len(pairs))
    for a in range(len(pairs)):
        for b in range(len(pairs)):
            if a != b:
                r, ratio = overlap_agreement(source, target, pairs[a], pairs[b])
                wanted[a] += g[a] * g[b] * max(r * ratio - 0.3, 0) / 0.7
    assert found == pytest.approx(wanted, rel=1e-4)


def test_overlap_agreement_by_hand():
    source = np.zeros((2, 2, 3), np.float32)
    target = np.zeros((2, 2, 3), np.float32)
    source[0, 1], target[0, 1] = (1.0, 0.5, 2.0), (0.75, 0.5, 1.0)
    r, ratio = overlap_agreement(source, target, np.array([0, 0]), np.array([1, 1]))
    assert r == pytest.approx(0.75)
    assert ratio == pytest.approx(0.5, abs=1e-5)
    same, whole = overlap_agreement(source, source, np.array([0, 0]), np.array([0, 0]))
    assert same == whole == 1  # two distances of zero agree
