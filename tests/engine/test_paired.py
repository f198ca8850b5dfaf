"""Paired tests on differences counted by hand."""

from itertools import product

import numpy as np
import pytest
from scipy.stats import wilcoxon

from engine.evaluation.paired import holm, mcnemar, paired_test


def test_counts_and_difference_leave_out_what_is_unknown():
    nan = float("nan")
    found = paired_test([0.5, 0.5, 0.5, nan, 0.1], [0.6, 0.4, 0.5, 0.9, nan])
    assert (found.pairs, found.better, found.worse, found.equal) == (3, 1, 1, 1)
    assert found.difference == pytest.approx(0)
    assert (found.permutation, found.wilcoxon) == (None, None)


def test_the_permutation_p_is_that_of_all_swaps_counted_one_by_one():
    x, y = np.array([0.2, 0.5, 0.1, 0.9, 0.4, 0.3, 0.8]), np.array([0.9, 0.6, 0.4, 0.7, 0.8, 0.7, 0.9])
    d = y - x
    means = np.array([np.mean(d * signs) for signs in product((1, -1), repeat=len(d))])
    by_hand = np.mean(np.abs(means) >= abs(d.mean()) - 1e-12)
    found = paired_test(x, y)
    assert found.permutation == pytest.approx(by_hand)
    assert found.wilcoxon == pytest.approx(wilcoxon(d).pvalue)


def test_six_pairs_of_one_sign_are_the_fewest_that_are_told():
    x = np.arange(6) / 10
    assert paired_test(x, x + 0.1 * np.arange(1, 7)).permutation == pytest.approx(2 / 2**6)
    assert paired_test(x[:5], x[:5] + 0.1).permutation is None


def test_equal_methods_differ_by_nothing():
    x = np.linspace(0, 1, 9)
    assert paired_test(x, x)[4:] == (0, 1, 1)


def test_turning_the_methods_round_keeps_p_and_turns_the_sign():
    rng = np.random.default_rng(1)
    x, y = rng.random(20), rng.random(20) + 0.2
    one, other = paired_test(x, y), paired_test(y, x)
    assert (one.better, one.worse) == (other.worse, other.better)
    assert one.difference == -other.difference
    assert one.wilcoxon == other.wilcoxon
    assert one.permutation == pytest.approx(other.permutation, abs=0.02)


def test_differences_that_are_equal_but_for_the_last_digit_tie():
    """1 - 2/3 and 1/3 - 0 differ in the last of their digits; their ranks and signs must not hang on it."""
    x, y = [0.0] * 4 + [1.0] * 3 + [0.1 + 0.2], [1 / 3] * 4 + [2 / 3] * 3 + [0.3]
    assert 1 / 3 != 1 - 2 / 3
    found = paired_test(x, y)
    assert (found.better, found.worse, found.equal) == (4, 3, 1)
    assert found.wilcoxon == paired_test([0] * 8, [1] * 4 + [-1] * 3 + [0]).wilcoxon


def test_holm_by_hand():
    assert holm([0.01, 0.04, None, 0.03]) == pytest.approx((0.03, 0.06, None, 0.06))
    assert holm([0.9, 0.8]) == (1, 1)
    assert holm([]) == ()


def test_mcnemar_by_hand():
    """Of 6 discordant cases all for one: 2 / 2^6; 5 to 1: 2 (1 + 6) / 2^6; without any nothing differs."""
    assert mcnemar(0, 6) == mcnemar(6, 0) == pytest.approx(2 / 64)
    assert mcnemar(5, 1) == pytest.approx(2 * 7 / 64)
    assert mcnemar(0, 0) == mcnemar(3, 3) == 1.0
