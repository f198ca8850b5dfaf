"""Is one method better than another on the same pairs? Tests of the differences, pair by pair."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import frozen_array

LEAST_PAIRS = 6  # below, even a difference that always has one sign cannot reach a two-sided p of .05 by Wilcoxon's test
RESAMPLES = 9999


class PairedTest(NamedTuple):
    """Differences second - first over the pairs where both are known, and two p-values, None below 6 pairs."""

    pairs: int
    better: int
    worse: int
    equal: int
    difference: float
    permutation: float | None
    wilcoxon: float | None


def paired_test(first: object, second: object) -> PairedTest:
    """Compare two methods by one figure a pair, (n,) each; NaN where a method has none.

    `permutation` swaps the two figures within pairs and asks how often the mean difference is as large (exact up to 13
    pairs, else 9,999 seeded draws); `wilcoxon` is the signed-rank test. Both are two-sided.
    """
    x = frozen_array(first, np.float64, (None,), "The figures of the first method")
    y = frozen_array(second, np.float64, x.shape, "The figures of the second method")
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    d = np.round(y - x, 12)  # 1 - 2/3 and 1/3 - 0 are the same difference
    tested = len(d) >= LEAST_PAIRS
    return PairedTest(
        len(d), int((d > 0).sum()), int((d < 0).sum()), int((d == 0).sum()), float(d.mean()) if len(d) else float("nan"),
        _permutation(x, y) if tested else None, _wilcoxon(d) if tested else None)  # fmt: skip


def holm(values: Sequence[float | None]) -> tuple[float | None, ...]:
    """p-values adjusted for their number (Holm, Scand. J. Statist. 6, 1979); those that are None stay None."""
    known = sorted((p, number) for number, p in enumerate(values) if p is not None)
    adjusted: list[float | None] = [None] * len(values)
    largest = 0.0
    for rank, (p, number) in enumerate(known):
        largest = max(largest, min(1.0, (len(known) - rank) * p))
        adjusted[number] = largest
    return tuple(adjusted)


def mcnemar(first: int, second: int) -> float:
    """McNemar's exact two-sided p of so many discordant cases for the one and the other (Psychometrika 12, 1947)."""
    from scipy.stats import binomtest

    return float(binomtest(first, first + second, 0.5).pvalue) if first + second else 1.0


def _permutation(x: np.ndarray, y: np.ndarray) -> float:
    from scipy.stats import permutation_test

    if (x == y).all():
        return 1.0

    def statistic(a: np.ndarray, b: np.ndarray, axis: int = -1) -> np.ndarray:
        return np.mean(b - a, axis=axis)

    found = permutation_test((x, y), statistic, permutation_type="samples", vectorized=True, n_resamples=RESAMPLES, batch=1000,
                             rng=np.random.default_rng(0))  # fmt: skip
    return float(found.pvalue)


def _wilcoxon(d: np.ndarray) -> float:
    from scipy.stats import wilcoxon

    return float(wilcoxon(d).pvalue) if d.any() else 1.0
