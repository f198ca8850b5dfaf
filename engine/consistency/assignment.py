"""The best one-to-one assignment of candidates, where bad pairs stay unmatched (Kuhn 1955)."""

import numpy as np


def assign(pairs: np.ndarray, cost: np.ndarray, most: float) -> np.ndarray:
    """Rows of the one-to-one choice of pairs with the least Σ (cost - most); those that cost `most` or more stay out.

    Parameters
    ----------
    pairs, cost
        (c, 2) int64, distinct, and (c,) float64; a pair that is not listed cannot be chosen.
    most
        What leaving one pair out costs.

    Returns
    -------
    Rows, by ascending cost, ties by index.
    """
    from scipy.optimize import linear_sum_assignment

    if not len(pairs):
        return np.zeros(0, dtype=np.int64)
    sides = [np.unique(pairs[:, side], return_inverse=True) for side in (0, 1)]
    shape = tuple(len(values) for values, _ in sides)
    at = tuple(where.ravel() for _, where in sides)
    gain, row = np.zeros(shape), np.full(shape, -1)
    gain[at], row[at] = np.minimum(cost - most, 0.0), np.arange(len(pairs))
    chosen = linear_sum_assignment(gain)
    rows = np.sort(row[chosen][gain[chosen] < 0])
    return rows[np.argsort(cost[rows], kind="stable")]
