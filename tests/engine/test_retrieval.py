"""Retrieval by hand, its chance by counting all orders, and its laws."""

from itertools import combinations

import numpy as np
import pytest

from engine.errors import BadInput
from engine.evaluation.retrieval import TOP, joined, retrieval


def test_figures_of_one_query_by_hand():
    """True ones at ranks 2 and 3 of four: precision 1/2 and 2/3; of the four pairs of true and false, two are right."""
    found = retrieval([[0.1, 0.3, 0.2, 0.9]], [[False, True, True, False]], [5])
    assert found.figures[0] == pytest.approx([0, 1, (1 / 2 + 2 / 3) / 2, 0.5])
    assert found.size.tolist() == [5]


def test_a_true_partner_beyond_the_seventh_is_not_among_them():
    distance = np.arange(9.0)[None]
    for rank in range(9):
        figures = retrieval(distance, np.arange(9)[None] == rank, [1]).figures[0]
        assert figures == pytest.approx([float(rank == 0), float(rank < TOP), 1 / (rank + 1), 1 - rank / 8])


def test_equal_distances_count_against_the_query_but_as_half_in_auc():
    found = retrieval(np.zeros((1, 4)), [[True, False, False, False]], [1])
    assert found.figures[0] == pytest.approx([0, 1, 1 / 4, 0.5])


@pytest.mark.parametrize(("m", "t"), [(5, 1), (9, 2), (10, 6), (3, 2)])
def test_chance_is_the_mean_over_all_orders(m, t):
    figures = []
    for places in combinations(range(m), t):
        truth = np.isin(np.arange(m), places)[None]
        figures.append(retrieval(np.arange(float(m))[None], truth, [1]).figures[0])
    assert retrieval(np.zeros((1, m)), np.arange(m)[None] < t, [1]).chance[0] == pytest.approx(np.mean(figures, axis=0))


def test_queries_with_nothing_to_find_or_nothing_else_are_left_out():
    truth = np.array([[False, False], [True, True], [True, False]])
    found = retrieval(np.ones((3, 2)), truth, [1, 2, 3])
    assert found.size.tolist() == [3]
    assert retrieval(np.ones((2, 2)), np.zeros((2, 2)), [1, 1]).figures.shape == (0, 4)


def test_only_the_order_of_distances_matters_not_that_of_candidates():
    rng = np.random.default_rng(1)
    distance, truth = rng.random((6, 20)), rng.random((6, 20)) < 0.3
    found = retrieval(distance, truth, np.arange(6)).figures
    mixed = rng.permutation(20)
    assert retrieval(distance[:, mixed] ** 3 + 1, truth[:, mixed], np.arange(6)).figures == pytest.approx(found)
    assert retrieval(truth * -1.0, truth, np.arange(6)).figures == pytest.approx(np.ones((6, 4)))


def test_several_pairs_are_joined_query_by_query():
    a = retrieval([[0.0, 1.0]], [[True, False]], [1])
    b = retrieval([[0.0, 1.0]], [[False, True]], [4])
    both = joined([a, b])
    assert both.size.tolist() == [1, 4]
    assert both.figures[:, 0].tolist() == [1, 0]
    assert joined([]).figures.shape == (0, 4)


def test_truth_of_another_shape_is_refused():
    with pytest.raises(BadInput, match="truth"):
        retrieval(np.ones((2, 3)), np.ones((2, 2)), [1, 1])
