"""Candidate matches between two sets of rows: which of them are proposed."""

import numpy as np


def k_best(pairs: np.ndarray, distance: np.ndarray, k: int, *, side: int) -> np.ndarray:
    """Which of the pairs (c, 2) are among the k nearest of their row on `side` (0 source, 1 target), (c,) bool.

    Ties go to the smaller row of the other side, so the answer does not depend on the order of the pairs.
    """
    order = np.lexsort((pairs[:, 1 - side], distance, pairs[:, side]))
    rows = pairs[order, side]
    starts = np.searchsorted(rows, rows, side="left")
    kept = np.zeros(len(pairs), dtype=bool)
    kept[order] = np.arange(len(pairs)) - starts < k
    return kept
