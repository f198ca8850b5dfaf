"""Candidate matches between two sets of rows: which of them are proposed."""

import numpy as np
from numba import njit


def k_best(pairs: np.ndarray, distance: np.ndarray, k: int, *, side: int) -> np.ndarray:
    """Which of the pairs (c, 2) are among the k nearest of their row on `side` (0 source, 1 target), (c,) bool.

    The pairs must be sorted and distinct; ties then go to the smaller row of the other side.
    """
    if not len(pairs):
        return np.zeros(0, dtype=bool)
    return _nearest(np.ascontiguousarray(pairs[:, side]), np.asarray(distance, dtype=np.float64), int(k))


def keep_nearest(kept: np.ndarray, distance: np.ndarray, pool: int) -> None:
    """Mark in `kept` (n, m) the `pool` nearest of each row and of each column."""
    for axis in (0, 1):
        most = min(pool, distance.shape[axis])
        rows = np.argpartition(distance, most - 1, axis=axis)
        np.put_along_axis(kept, rows[:most] if axis == 0 else rows[:, :most], True, axis=axis)


@njit(cache=True, nogil=True)
def _nearest(row, distance, k):  # type: ignore[no-untyped-def]
    """Which entries are among the k smallest of their row, the earlier one first where equal."""
    best, count = np.empty((row.max() + 1, k), dtype=np.int64), np.zeros(row.max() + 1, dtype=np.int64)
    for a in range(len(row)):
        mine, place = best[row[a]], count[row[a]]
        if place == k and not distance[a] < distance[mine[k - 1]]:
            continue
        count[row[a]] = min(place + 1, k)
        place = min(place, k - 1)
        while place and distance[a] < distance[mine[place - 1]]:
            mine[place] = mine[place - 1]
            place -= 1
        mine[place] = a
    kept = np.zeros(len(row), dtype=np.bool_)
    for i in range(len(count)):
        for place in range(count[i]):
            kept[best[i, place]] = True
    return kept
