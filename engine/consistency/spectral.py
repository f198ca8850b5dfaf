"""Spectral matching: the principal eigenvector of the affinity says how sure each candidate is.

After Leordeanu & Hebert (2005); the adaptive rounds, one-to-many, after Kleiman, van Kaick, Sorkine-Hornung & Cohen-Or
(2015), "SHED: Shape Edit Distance for fine-grained shape similarity".
"""

import numpy as np
from numba import njit

_STEPS, _TOLERANCE, _DIGITS = 2000, 1e-9, 7


def principal(affinity: np.ndarray, start: np.ndarray | None = None) -> np.ndarray:
    """The principal eigenvector of a symmetric affinity (c, c) >= 0, (c,) >= 0, its largest entry 1.

    By power iteration from equal weights (or from `start`, mixed with equal weights), so that where several are
    principal each gets its share. Rounded to seven digits, so that candidates alike by symmetry are exactly equal.
    All zero where there is no affinity at all.
    """
    x = np.ones(len(affinity)) if start is None else 0.5 + start
    return np.round(_power(np.ascontiguousarray(affinity), x, _STEPS, _TOLERANCE), _DIGITS)


@njit(cache=True, nogil=True)
def _power(affinity, x, steps, tolerance):  # type: ignore[no-untyped-def]
    """Power iteration, shifted a little so that two halves that point at each other do not swing.

    Plain loops: no number of threads can change the sums.
    """
    count = len(x)
    shift = 0.0
    for i in range(count):
        shift = max(shift, 0.02 * affinity[i].sum())
    for _ in range(steps):
        y = np.zeros(count)
        for j in range(count):
            if x[j] > 0:
                for i in range(count):
                    y[i] += affinity[j, i] * x[j]
        if not y.any():
            return y
        y += shift * x
        y /= y.max()
        change = np.abs(y - x).max()
        x = y
        if change < tolerance:
            break
    return x


def adaptive_rounds(
    pairs: np.ndarray, affinity: np.ndarray, fixed: np.ndarray, free: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """Accept the surest candidate, make it certain, forget what speaks against it, and look again; one-to-many.

    A candidate (i, j) is accepted if i or j has no match yet. Then all affinity between the candidates of i and those
    of j is forgotten, and the accepted support themselves and each other by 1. Where nothing that is left has to do with
    the accepted, it is looked at by itself. Ends when nothing is free, or no candidate has affinity. Last, matches whose
    ends both have others are taken back, the latest first.

    Parameters
    ----------
    pairs, affinity
        (c, 2) int64 and (c, c) float64, symmetric, >= 0.
    fixed
        Rows that are accepted before all others, whatever they are, and never taken back.
    free
        Which source and which target rows are still to be matched, (n,) and (m,) bool.

    Returns
    -------
    Accepted rows, in the order of acceptance.
    """
    affinity, open_ends = affinity.copy(), (free[0].copy(), free[1].copy())
    left = np.ones(len(pairs), dtype=bool)
    accepted: list[int] = []

    def accept(row: int) -> None:
        i, j = pairs[row]
        accepted.append(row)
        open_ends[0][i] = open_ends[1][j] = left[row] = False
        of_i, of_j = np.flatnonzero(pairs[:, 0] == i), np.flatnonzero(pairs[:, 1] == j)
        affinity[np.ix_(of_i, of_j)] = affinity[np.ix_(of_j, of_i)] = 0.0
        affinity[np.ix_(accepted, accepted)] = 1.0

    for row in fixed.tolist():
        accept(row)
    x: np.ndarray | None = None
    while True:
        left &= open_ends[0][pairs[:, 0]] | open_ends[1][pairs[:, 1]]
        if not left.any():
            break
        x = principal(affinity, x)
        apart = not x[left].any()  # nothing that is left has to do with what is certain
        best = int(np.argmax(np.where(left, principal(affinity * np.outer(left, left)) if apart else x, -1.0)))
        if apart and not affinity[best].any():
            break
        accept(best)
    return _without_many_to_many(pairs, np.array(accepted, dtype=np.int64), len(fixed))


def _without_many_to_many(pairs: np.ndarray, accepted: np.ndarray, sure: int) -> np.ndarray:
    """The accepted rows without those whose ends both have other matches; the first `sure` always stay.

    Where one of those is many-to-many, the latest of the others at its ends go.
    """
    kept = accepted.tolist()

    def many(row: int) -> bool:
        return bool(((pairs[kept] == pairs[row]).sum(axis=0) > 1).all())

    for row in accepted[sure:][::-1].tolist():
        beside = [other for other in kept[:sure] if (pairs[other] == pairs[row]).any()]
        if any(map(many, [row, *beside])):
            kept.remove(row)
    return np.array(kept, dtype=np.int64)
