"""Spectral matching on affinities drawn by hand, beside brute force and dense eigenvectors."""

from itertools import permutations, product

import numpy as np
import pytest

from engine.consistency.diffusion import greedy
from engine.consistency.spectral import adaptive_rounds, principal

NONE = np.zeros(0, dtype=np.int64)


def everything(n, m):
    return np.array(list(product(range(n), range(m))))


def all_free(n, m):
    return np.ones(n, dtype=bool), np.ones(m, dtype=bool)


def rounds(pairs, affinity, fixed=NONE, free=None):
    free = free or all_free(*(pairs.max(axis=0) + 1))
    return [tuple(pairs[row].tolist()) for row in adaptive_rounds(pairs, affinity, np.asarray(fixed), free)]


def test_the_principal_eigenvector_by_hand():
    """[[2, 1], [1, 2]] has (1, 1); [[3, 2], [2, 0]] has (2, 1), with 4·2 = 3·2 + 2·1."""
    assert principal(np.array([[2.0, 1], [1, 2]])) == pytest.approx([1, 1])
    assert principal(np.array([[3.0, 2], [2, 0]])) == pytest.approx([1, 0.5])
    assert principal(np.zeros((3, 3))).tolist() == [0, 0, 0]


def test_it_is_that_of_a_dense_solver():
    for seed in range(5):
        m = np.random.default_rng(seed).random((30, 30)) ** 4
        m = m + m.T
        vector = np.abs(np.linalg.eigh(m)[1][:, -1])
        assert principal(m) == pytest.approx(vector / vector.max(), abs=1e-6)


def test_two_halves_that_point_at_each_other_do_not_swing():
    assert principal(np.array([[0.0, 1], [1, 0]])) == pytest.approx([1, 1])
    assert principal(np.array([[0.0, 1, 1], [1, 0, 0], [1, 0, 0]])) == pytest.approx([1, 0.5**0.5, 0.5**0.5], abs=1e-6)


def test_what_is_alike_by_symmetry_is_exactly_equal():
    ring = np.roll(np.eye(7), 1, axis=1)
    assert len(set(principal(ring + ring.T + np.eye(7)).tolist())) == 1
    rng = np.random.default_rng(5)
    m, swap = rng.random((12, 12)), rng.permutation(12)
    swap = np.argsort(swap)[(swap[np.arange(12)] + 6) % 12]  # an involution: every one has a mirror image
    m = m + m.T
    x = principal(m + m[np.ix_(swap, swap)])
    assert np.array_equal(x, x[swap])
    two = np.kron(np.eye(2), np.array([[1.0, 2], [2, 1]]))  # two islands, both principal: each gets its share
    assert principal(two).tolist() == [1, 1, 1, 1]


def test_renumbering_renumbers_the_vector():
    m = np.random.default_rng(3).random((12, 12))
    m, order = m + m.T, np.random.default_rng(4).permutation(12)
    assert principal(m)[order] == pytest.approx(principal(m[np.ix_(order, order)]), abs=1e-8)


def test_spectral_matching_of_points_finds_the_best_assignment():
    """On a line at 0, 1, 3, 7 and the same shuffled, one-to-one: the assignment that brute force finds."""
    line, order = np.array([0.0, 1, 3, 7]), [2, 0, 3, 1]
    other = line[order]
    pairs = everything(4, 4)
    a, b = pairs.T
    gap = np.abs(np.abs(line[a][:, None] - line[a]) - np.abs(other[b][:, None] - other[b]))
    m = np.maximum(1 - gap**2, 0) * (a[:, None] != a) * (b[:, None] != b)
    best = max(permutations(range(4)), key=lambda p: m[np.ix_(k := [4 * i + p[i] for i in range(4)], k)].sum())
    found = greedy(pairs, principal(m), lambda a, others: np.zeros(len(others), dtype=bool))
    assert {tuple(p) for p in pairs[found].tolist()} == set(enumerate(best)) == {(v, k) for k, v in enumerate(order)}


def test_rounds_match_every_part_one_to_many():
    """Parts 0, 1 against 0, 1, 2: 0-0 is surest, then 1-1 beside it; 2 is left over, and goes to its better partner."""
    pairs = everything(2, 3)
    affinity = np.diag([0.9, 0.1, 0.2, 0.1, 0.8, 0.3])
    affinity[0, 4] = affinity[4, 0] = 0.3
    assert rounds(pairs, affinity) == [(0, 0), (1, 1), (1, 2)]


def test_an_accepted_match_forgets_what_speaks_against_it():
    """0-2 and 1-0 support each other most of all; but beside 0-0, both cannot be: only 1-1 has its support."""
    pairs = np.array([[0, 0], [0, 2], [1, 0], [1, 1], [2, 1]])
    affinity = np.diag([0.9, 0.05, 0.05, 0.05, 0.05])
    for a, b, value in ((0, 3, 0.2), (1, 2, 3.0), (2, 4, 0.25), (1, 4, 0.25)):
        affinity[a, b] = affinity[b, a] = value
    assert rounds(pairs, affinity, fixed=[0])[:2] == [(0, 0), (1, 1)]
    assert rounds(pairs, affinity)[0] == (0, 2)


def test_the_accepted_support_each_other_in_full():
    """0-0 and 1-1 hardly know each other; once both are certain, 2-2 has more from them than 2-3 from 0-0 alone."""
    pairs = np.array([[0, 0], [1, 1], [2, 2], [2, 3]])
    affinity = np.diag([0.9, 0.8, 0.1, 0.1])
    for a, b, value in ((0, 1, 0.01), (0, 2, 0.15), (1, 2, 0.15), (0, 3, 0.2)):
        affinity[a, b] = affinity[b, a] = value
    assert rounds(pairs, affinity, fixed=[0, 1])[2] == (2, 2)


def test_fixed_ones_come_first_and_stay():
    pairs = everything(2, 2)
    affinity = np.diag([0.9, 0.1, 0.1, 0.9])
    assert rounds(pairs, affinity) == [(0, 0), (1, 1)]
    assert rounds(pairs, affinity, fixed=[1]) == [(0, 1), (0, 0)]  # 1-1, too, would make 0-1 many-to-many
    assert set(rounds(pairs, affinity, fixed=[1, 2])) == {(0, 1), (1, 0)}
    assert len(rounds(pairs, affinity, fixed=[0, 1, 2, 3])) == 4


def test_what_is_not_free_is_left_alone():
    pairs = everything(2, 2)
    affinity = np.diag([0.9, 0.1, 0.1, 0.8])
    free = np.array([False, True]), np.array([False, True])
    assert rounds(pairs, affinity, free=free) == [(1, 1)]
    assert rounds(pairs, affinity, free=(np.zeros(2, dtype=bool), np.zeros(2, dtype=bool))) == []


def test_there_are_no_many_to_many_matches_and_nothing_is_left():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        n, m = rng.integers(2, 6, 2)
        affinity = 0.3 * rng.random((n * m, n * m))
        found = rounds(everything(n, m), (affinity + affinity.T) / 2 + np.diag(rng.random(n * m)))
        sources, targets = [i for i, _ in found], [j for _, j in found]
        assert set(sources) == set(range(n))
        assert set(targets) == set(range(m))
        assert not [p for p in found if sources.count(p[0]) > 1 and targets.count(p[1]) > 1]
        assert len(set(found)) == len(found)


def test_from_the_other_side_the_same_rounds():
    rng = np.random.default_rng(8)
    affinity = 0.3 * rng.random((12, 12))
    affinity = (affinity + affinity.T) / 2 + np.diag(rng.random(12))
    back = np.arange(12).reshape(3, 4).T.ravel()
    other = rounds(everything(4, 3), affinity[np.ix_(back, back)])
    assert {(j, i) for i, j in other} == set(rounds(everything(3, 4), affinity))
