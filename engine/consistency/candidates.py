"""Candidate matches between two sets of rows: which of them are proposed."""

import numpy as np


def k_best(pairs: np.ndarray, distance: np.ndarray, k: int, *, side: int) -> np.ndarray:
    """Which of the pairs (c, 2) are among the k nearest of their row on `side` (0 source, 1 target), (c,) bool.

    The pairs must be sorted and distinct; ties then go to the smaller row of the other side.
    """
    if not len(pairs):
        return np.zeros(0, dtype=bool)
    nearest = np.argsort(distance, kind="stable")
    row = pairs[nearest, side].astype(np.uint16 if pairs[:, side].max() < 2**16 else np.int64)
    order = nearest[np.argsort(row, kind="stable")]  # a radix sort
    rows = pairs[order, side]
    starts = np.searchsorted(rows, np.arange(rows[-1] + 1))[rows]
    kept = np.zeros(len(pairs), dtype=bool)
    kept[order] = np.arange(len(pairs)) - starts < k
    return kept
