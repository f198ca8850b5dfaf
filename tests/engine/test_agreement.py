"""The compiled loops of a re-run against plain ones, and what is fixed before anything else in the hall."""

import numba
import numpy as np
import pytest

from engine.consistency.candidates import k_best
from engine.consistency.diffusion import greedy
from engine.consistency.voting import vote
from engine.shapes.agreement import (
    affinity_table,
    affinity_total,
    hop_clashes,
    isometry,
    overlap_agreement,
    overlap_clashes,
    overlap_scores,
)
from engine.shapes.hops import UNREACHABLE, diameter


def pack(n, rng):
    overlap, distance = rng.random((2, n, n))
    return np.stack([overlap, overlap.T, distance + distance.T], axis=-1).astype(np.float32)


def hops(n, rng):
    distance = rng.integers(0, 9, (n, n)).astype(np.uint8)
    distance = np.maximum(distance, distance.T)
    distance[rng.random((n, n)) < 0.1] = UNREACHABLE
    return np.maximum(distance, distance.T)


def some_pairs(n, m, count, rng):
    chosen = np.sort(rng.choice(n * m, count, replace=False))
    return np.stack([chosen // m, chosen % m], axis=1)


@pytest.mark.parametrize("count", [1, 255, 256, 257, 700])
def test_scores_equal_the_whole_matrix_whatever_block_a_candidate_falls_into(count):
    rng = np.random.default_rng(count)
    source, target = pack(40, rng), pack(37, rng)
    pairs = some_pairs(40, 37, count, rng)
    g = rng.random(count)
    r, ratio = overlap_agreement(source, target, pairs[:, None], pairs[None])
    m = np.maximum(r * ratio - 0.2, 0) / 0.8
    np.fill_diagonal(m, 0)
    assert overlap_scores(pairs, g, source, target, 0.2) == pytest.approx(g * (m @ g), rel=1e-4, abs=1e-6)


def test_scores_follow_a_new_order_of_the_candidates_and_do_not_know_the_threads():
    rng = np.random.default_rng(1)
    source, target, pairs, g = pack(40, rng), pack(37, rng), some_pairs(40, 37, 900, rng), rng.random(900)
    plain, order = overlap_scores(pairs, g, source, target, 0.2), rng.permutation(900)
    assert overlap_scores(pairs[order], g[order], source, target, 0.2) == pytest.approx(plain[order], rel=1e-4)
    before = numba.get_num_threads()
    try:
        numba.set_num_threads(1)
        assert np.array_equal(overlap_scores(pairs, g, source, target, 0.2), plain)
    finally:
        numba.set_num_threads(before)


def test_clashes_equal_those_of_whole_arrays():
    rng = np.random.default_rng(2)
    pairs, others = some_pairs(20, 15, 120, rng), rng.permutation(120)[:70]
    source, target = pack(20, rng), pack(15, rng)
    r, ratio = overlap_agreement(source, target, pairs[7], pairs[others])
    found = overlap_clashes(*pairs[7], pairs, others, source, target, 0.5, 0.4)
    assert found.tolist() == ((r < 0.5) | (ratio < 0.4)).tolist()
    p, q = hops(20, rng), hops(15, rng)
    clash = rng.random((256, 256)) < 0.3
    wanted = clash[p[pairs[7, 0], pairs[others, 0]], q[pairs[7, 1], pairs[others, 1]]]
    assert hop_clashes(*pairs[7], pairs, others, p, q, clash).tolist() == wanted.tolist()


def test_the_total_of_affinities_equals_the_matrix():
    rng = np.random.default_rng(3)
    pairs, source, target = some_pairs(20, 15, 60, rng), hops(20, rng), hops(15, rng)
    p, q = source[np.ix_(pairs[:, 0], pairs[:, 0])].astype(int), target[np.ix_(pairs[:, 1], pairs[:, 1])].astype(int)
    m = isometry(p, q)
    wanted = np.where((m >= 0.5) & (p <= 5) & (q <= 4), (m - 0.5) / 0.5, 0)
    assert affinity_total(pairs, source, target, affinity_table(5, 4, 0.5)) == pytest.approx(wanted.sum())
    assert affinity_total(pairs[:0], source, target, affinity_table(5, 4, 0.5)) == 0


def test_the_diameter_leaves_out_what_cannot_be_reached():
    assert diameter(np.array([[0, 3, 255], [3, 0, 255], [255, 255, 0]], np.uint8)) == 3
    assert diameter(np.array([[0, 254], [254, 0]], np.uint8)) == 254
    assert diameter(np.full((2, 2), 255, np.uint8)) == 0
    assert diameter(np.zeros((0, 0), np.uint8)) == 0


@pytest.mark.parametrize("k", [1, 3, 50])
@pytest.mark.parametrize("side", [0, 1])
def test_the_k_best_are_those_of_a_sort(k, side):
    rng = np.random.default_rng(k)
    pairs = some_pairs(25, 30, 400, rng)
    distance = rng.integers(0, 6, 400).astype(float)  # many ties
    distance[::17] = np.inf
    wanted = np.zeros(400, bool)
    for row in np.unique(pairs[:, side]):
        mine = np.flatnonzero(pairs[:, side] == row)
        wanted[mine[np.argsort(distance[mine], kind="stable")[:k]]] = True
    assert k_best(pairs, distance, k, side=side).tolist() == wanted.tolist()


def test_what_is_fixed_comes_first_and_pushes_out_what_it_excludes():
    pairs = np.array([[0, 0], [1, 1], [2, 2], [3, 3], [3, 4]])
    conflict = np.zeros((5, 5), bool)
    conflict[1, 0] = conflict[0, 1] = conflict[1, 2] = conflict[2, 1] = True
    confidence = np.array([0.9, 0.0, 0.5, 0.4, 0.3])

    def clash(a, others):
        return conflict[a, others]

    assert greedy(pairs, confidence, clash).tolist() == [0, 2, 3]
    assert greedy(pairs, confidence, clash, fixed=np.array([1])).tolist() == [1, 3]
    assert greedy(pairs, confidence, clash, fixed=np.array([1, 2])).tolist() == [1, 2, 3]  # though they clash
    assert greedy(pairs, confidence, clash, first=np.array([4]), fixed=np.array([1])).tolist() == [1, 4]
    assert greedy(pairs, confidence, clash, fixed=np.zeros(0, int)).tolist() == [0, 2, 3]


def test_votes_do_not_drop_what_is_fixed():
    inside_source = np.array([[0, 1, 1], [0, 0, 0], [0, 0, 0]], bool)  # the first lies in both others, on this side only
    inside_target = np.zeros((3, 3), bool)
    confidence = np.array([0.1, 0.9, 0.8])
    assert vote(inside_source, inside_target, confidence)[0].tolist() == [1, 2]
    fixed = np.array([True, False, False])
    assert vote(inside_source, inside_target, confidence, fixed=fixed)[0].tolist() == [0]
    assert vote(inside_source, inside_target, confidence, fixed=np.array([True, True, False]))[0].tolist() == [1, 0]
