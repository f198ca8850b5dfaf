"""Halves of sides: the sub-edges of chapters 4 and 5 of the thesis on square pieces.

Side r has the half 2 r, from its first corner as it is read clockwise, and 2 r + 1, which ends at its second corner.
Where side a meets side b, the first half of a lies against the second of b, and the second of a against the first.
"""

import numpy as np

from .measures import Strips, dissimilarity_of_pairs


def half_strips(strips: Strips, length: int | None = None) -> Strips:
    """The strips of the 2 s halves of s sides, `length` pixels each (half the side, rounded down, if None)."""
    whole = strips.outer.shape[1]
    size = max(1, whole // 2) if length is None else min(length, whole)
    first, second = strips.part(0, size), strips.part(whole - size, whole)
    outer, inner = (
        np.stack([getattr(first, name), getattr(second, name)], axis=1).reshape(-1, size, 3)
        for name in ("outer", "inner")
    )
    return Strips(outer, inner, strips.gap)


def meeting_halves(rows: np.ndarray) -> np.ndarray:
    """Which halves lie against each other where the sides of `rows` (c, 2) meet: (c, 2, 2) int64, [:, k] the k-th pair."""
    a, b = np.asarray(rows, dtype=np.int64).reshape(-1, 2).T
    return np.stack([np.stack([2 * a, 2 * b + 1], axis=1), np.stack([2 * a + 1, 2 * b], axis=1)], axis=1)


def half_dissimilarity(measure: str, strips: Strips, rows: np.ndarray, *, length: int | None = None) -> np.ndarray:
    """How unlike the two pairs of halves of candidate joins are, (c, 2) float64.

    `measure` is a key of `measures.CODES` or "mgc-pt"; `rows` (c, 2) are sides, `length` as in `half_strips`.
    """
    pairs = meeting_halves(rows).reshape(-1, 2)
    return dissimilarity_of_pairs(measure, half_strips(strips, length), pairs).reshape(-1, 2)


def as_halves(dissimilarity: np.ndarray) -> np.ndarray:
    """(c, 2) float64 from (c, 2), or from the (c,) of whole sides, both halves then being as unlike as the whole."""
    d = np.asarray(dissimilarity, dtype=np.float64)
    return np.repeat(d[:, None], 2, axis=1) if d.ndim == 1 else d


def least_of_halves(rows: np.ndarray, halves: np.ndarray) -> np.ndarray:
    """The least dissimilarity of each half of each side among the candidates, (2 s,); inf where it has none.

    The sides s are those up to the largest in `rows`.
    """
    meeting = meeting_halves(rows)
    least = np.full(2 * (int(rows.max()) + 1 if len(rows) else 0), np.inf)
    for end in (0, 1):
        np.minimum.at(least, meeting[:, :, end], halves)
    return least


def smallest_unit(halves: np.ndarray) -> float:
    """ε: a thousandth of the median dissimilarity, so that ratios of nothing to nothing are 1."""
    return 1e-3 * float(np.median(halves)) + 1e-12 if len(halves) else 1.0
