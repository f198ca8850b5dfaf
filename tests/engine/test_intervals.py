"""Intervals of shares in clusters: hand values, another implementation, coverage."""

import numpy as np
import pytest

from engine.errors import BadInput, BadParameter
from engine.evaluation.intervals import (
    Interval,
    clopper_pearson,
    cluster_robust,
    clustered_interval,
    ratio_interval,
    weighted_interval,
    wilson,
)


def test_wilson_of_a_hand_value() -> None:
    low, high, _ = wilson(8, 10)
    assert (low, high) == pytest.approx((0.4902, 0.9433), abs=1e-4)
    assert wilson(0, 10).low == 0
    assert wilson(10, 10).high == 1


def test_clopper_pearson_of_a_hand_value() -> None:
    """All of n right: the lower bound is (alpha/2)^(1/n); as many clusters as trials lower nothing."""
    assert clopper_pearson(10, 10, 10)[:2] == pytest.approx((0.025 ** (1 / 10), 1.0))
    assert clopper_pearson(0, 10, 10)[:2] == pytest.approx((0.0, 1 - 0.025 ** (1 / 10)))


def test_fewer_clusters_give_a_wider_interval_at_full_score() -> None:
    lows = [clustered_interval([60 // g] * g, [60 // g] * g).low for g in (2, 3, 6, 20, 60)]
    assert lows == sorted(lows)
    assert lows[0] < 0.2 < lows[-1]


def test_cluster_robust_equals_statsmodels_where_pairs_are_equally_large() -> None:
    sm = pytest.importorskip("statsmodels.api")
    k, n = np.array([3, 10, 0, 7, 5]), np.full(5, 11)
    fit = sm.GLM(np.column_stack([k, n - k]), np.ones((5, 1)), family=sm.families.Binomial()).fit(
        cov_type="cluster", cov_kwds={"groups": np.arange(5)}, use_t=True
    )
    expected = 1 / (1 + np.exp(-fit.conf_int()[0]))
    assert cluster_robust(k, n)[:2] == pytest.approx(tuple(expected), abs=1e-9)


def test_cluster_robust_of_unequal_pairs_is_the_jackknife_with_fewer_degrees() -> None:
    """Two pairs of 1 and 3 matches, of which 1 and 1 are right: p = 2/4, without one 1/3, without the other 1; the
    effective number of pairs is 16 / 10, so t has the least of degrees, 1."""
    low, high, _ = cluster_robust(np.array([1, 1]), np.array([1, 3]))
    error = np.sqrt(1 / 2 * ((1 / 3 - 1 / 2) ** 2 + (1 - 1 / 2) ** 2)) / (1 / 2 * 1 / 2)
    reach = 12.7062 * error
    assert (low, high) == pytest.approx((1 / (1 + np.exp(reach)), 1 / (1 + np.exp(-reach))), rel=1e-4)
    even, uneven = (cluster_robust(np.array(k), np.array(n)) for k, n in (([8, 4, 9, 5], [10] * 4), ([8, 4, 9, 5], [10, 5, 10, 15])))
    assert uneven.high - uneven.low > even.high - even.low


def test_the_way_is_named() -> None:
    assert clustered_interval([], []) is None
    assert clustered_interval([0, 0], [0, 0]) is None
    assert clustered_interval([3, 0], [4, 0]) == Interval(*wilson(3, 4)[:2], "Wilson, one pair only")
    assert clustered_interval([2, 4], [4, 8]) == Interval(*wilson(6, 12)[:2], "Wilson, equal pairs")
    assert clustered_interval([4, 8], [4, 8]).method == "Clopper-Pearson, adjusted n"
    assert clustered_interval([3, 8], [4, 8]).method == "cluster-robust GLM, t"


def test_right_and_wrong_exchanged_mirror_the_interval() -> None:
    k, n = np.array([3, 10, 0, 7]), np.array([4, 11, 3, 9])
    there, back = clustered_interval(k, n), clustered_interval(n - k, n)
    assert (there.low, there.high) == pytest.approx((1 - back.high, 1 - back.low))
    assert clustered_interval(k[::-1], n[::-1])[:2] == pytest.approx(there[:2])


def test_counts_that_cannot_be_are_refused() -> None:
    with pytest.raises(BadParameter):
        clustered_interval([5], [4])
    with pytest.raises(BadParameter):
        clustered_interval([-1], [4])
    with pytest.raises(BadInput):
        clustered_interval([1, 2], [4])
    with pytest.raises(BadParameter):
        clustered_interval([1, 2], [4, 4], confidence=95)


@pytest.mark.parametrize("clusters", [5, 15, 60])
def test_coverage_where_pairs_differ_in_difficulty(clusters: int) -> None:
    """Shares drawn per pair (beta, mean .8, intraclass correlation .2): 95 % intervals hold the mean as promised."""
    rng = np.random.default_rng(clusters)
    held = 0
    for _ in range(1500):
        n = rng.integers(3, 15, clusters)
        low, high, _ = clustered_interval(rng.binomial(n, rng.beta(3.2, 0.8, clusters)), n)
        held += low <= 0.8 <= high
    assert 0.92 < held / 1500 < 0.995


def test_the_interval_of_amounts_is_that_of_counts_on_any_scale() -> None:
    k, n = np.array([3, 10, 0, 7, 5]), np.array([4, 11, 3, 9, 5])
    assert ratio_interval(k, n)[:2] == pytest.approx(cluster_robust(k, n)[:2])
    assert ratio_interval(k * 0.01, n * 0.01)[:2] == pytest.approx(ratio_interval(k, n)[:2])
    assert ratio_interval([*k, 0.0], [*n, 0.0]) == ratio_interval(k, n)


NONE, ONE, ZERO, EQUAL, FULL = ([], []), ([1.0], [2.0]), ([0.0, 0.0], [1.0, 2.0]), ([1.0, 2.0], [2.0, 4.0]), ([1.0], [1.0])


@pytest.mark.parametrize(("k", "n"), [NONE, ONE, ZERO, EQUAL, FULL])
def test_amounts_that_tell_nothing_of_the_spread_have_no_interval(k, n) -> None:
    assert ratio_interval(k, n) is None


def test_more_than_the_whole_is_refused() -> None:
    with pytest.raises(BadParameter, match="more than its whole"):
        ratio_interval([3.0, 1.0], [2.0, 2.0])


def test_the_interval_of_amounts_holds_the_truth_nearly_as_often_as_it_says() -> None:
    rng, hits = np.random.default_rng(5), 0
    for _ in range(400):
        n = rng.uniform(0.5, 2, 20)
        found = ratio_interval(n * rng.beta(6, 2, 20), n)
        hits += found.low <= 0.75 <= found.high
    assert 0.9 < hits / 400 < 0.99


def test_weights_on_any_scale_give_the_same_interval() -> None:
    k, n, q = np.array([3.0, 10.0, 0.5, 7.0]), np.array([4.0, 11.0, 3.0, 9.0]), np.array([6.0, 20.0, 4.0, 15.0])
    found = weighted_interval(k, n, q)
    assert found.method == "cluster-robust GLM, t, weighted"
    assert found[:2] == pytest.approx(cluster_robust(k, n)[:2])
    assert weighted_interval(k * 7, n * 7, q * 49)[:2] == pytest.approx(found[:2])


def test_weighted_shares_that_tell_nothing_of_the_spread_take_the_effective_number() -> None:
    """Two trials of weight 1 and 3 count as (1 + 3)² / (1 + 9) = 1.6 trials."""
    one = weighted_interval([2.0], [4.0], [10.0])
    assert one[:2] == pytest.approx(wilson(0.8, 1.6)[:2])
    assert one.method == "Wilson, one pair only, weighted"
    full = weighted_interval([4.0, 4.0], [4.0, 4.0], [10.0, 10.0])
    assert full[:2] == pytest.approx(clopper_pearson(3.2, 3.2, 2)[:2])
    assert full.method == "Clopper-Pearson, adjusted n, weighted"
    assert weighted_interval([2.0, 4.0], [4.0, 8.0], [10.0, 20.0])[:2] == pytest.approx(wilson(2.4, 4.8)[:2])
    assert weighted_interval([], [], []) is None
    assert weighted_interval([0.0], [0.0], [0.0]) is None
