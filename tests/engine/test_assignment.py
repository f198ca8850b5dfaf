"""Assignments against brute force over all partial one-to-one choices."""

from itertools import combinations

import numpy as np
import pytest

from engine.consistency.assignment import assign


def brute_force(pairs, cost, most):
    """The least Σ (cost - most) over all one-to-one sets of pairs."""
    best = 0.0
    for size in range(1, len(pairs) + 1):
        for rows in combinations(range(len(pairs)), size):
            one_to_one = all(len(set(pairs[list(rows), side])) == size for side in (0, 1))
            if one_to_one:
                best = min(best, sum(cost[k] - most for k in rows))
    return best


def test_the_whole_counts_more_than_the_best_pair():
    pairs = np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
    assert assign(pairs, np.array([1.0, 2, 2, 9]), 10.0).tolist() == [1, 2]
    assert assign(pairs, np.array([1.0, 2, 2, 2.5]), 10.0).tolist() == [0, 3]


def test_bad_pairs_stay_out_even_where_both_are_free():
    pairs = np.array([[0, 0], [1, 1]])
    assert assign(pairs, np.array([1.0, 3.0]), 3.0).tolist() == [0]
    assert assign(pairs, np.array([1.0, 3.0]), 3.1).tolist() == [0, 1]
    assert assign(pairs, np.array([4.0, 5.0]), 3.0).tolist() == []


def test_a_bad_pair_is_not_chosen_to_make_room():
    """Clipped at 3, 0-1 and 1-0 together win 2; 0-0 alone wins 2.5."""
    pairs = np.array([[0, 0], [0, 1], [1, 0]])
    assert assign(pairs, np.array([0.5, 2.0, 2.0]), 3.0).tolist() == [0]
    assert assign(pairs, np.array([1.5, 2.0, 2.0]), 3.0).tolist() == [1, 2]


@pytest.mark.parametrize("seed", range(8))
def test_no_other_choice_is_better(seed):
    rng = np.random.default_rng(seed)
    pairs = np.argwhere(rng.random((4, 3)) < 0.7)
    cost = rng.random(len(pairs)) * 2
    rows = assign(pairs, cost, 1.2)
    assert len(set(pairs[rows, 0])) == len(set(pairs[rows, 1])) == len(rows)
    assert (cost[rows] - 1.2).sum() == pytest.approx(brute_force(pairs, cost, 1.2))
    assert (np.diff(cost[rows]) >= 0).all()


def test_swapping_the_sides_changes_nothing():
    pairs, cost = np.indices((5, 4)).reshape(2, -1).T, np.random.default_rng(1).random(20)
    order = np.lexsort((pairs[:, 0], pairs[:, 1]))
    back = order[assign(pairs[order][:, ::-1], cost[order], 0.8)]
    assert back.tolist() == assign(pairs, cost, 0.8).tolist()


def test_nothing_gives_nothing():
    assert assign(np.zeros((0, 2), dtype=np.int64), np.zeros(0), 1.0).tolist() == []
