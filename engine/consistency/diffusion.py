"""Diffusion pruning: confidence from the stationary distribution, then greedy acceptance.

After Tam, Martin, Rosin & Lai (2014), as the thesis simplifies it (section 3.4.2).
"""

from collections.abc import Callable

import numpy as np
from numba import njit


def stationary(degree: np.ndarray) -> np.ndarray:
    """π (Eq 3.4): the stationary distribution of the random walk on a symmetric affinity, from its row sums (c,).

    No matrix and no eigenvector is needed: π(a) = d(a) / Σ d(b). All zero where there is no affinity at all.
    """
    total = degree.sum()
    return degree / total if total > 0 else np.zeros_like(degree)


def greedy(
    pairs: np.ndarray,
    confidence: np.ndarray,
    conflicts: Callable[[int, np.ndarray], np.ndarray],
    *,
    first: np.ndarray | None = None,
    fixed: np.ndarray | None = None,
) -> np.ndarray:
    """Accept candidates one-to-one in descending confidence, ties by index; rejects what an accepted one excludes.

    Candidates with a confidence of 0 are never accepted, unless they are among `first`.

    Parameters
    ----------
    pairs, confidence
        (c, 2) int64 and (c,) float64.
    conflicts
        `conflicts(a, others)` bool: which of the candidates `others` (rows) cannot stand beside the accepted row a.
    first
        Candidates (rows) that come before all others, in this order; they too must not conflict.
    fixed
        Candidates (rows) that are accepted whatever they exclude, even each other; all others must fit them.

    Returns
    -------
    Rows of the accepted candidates, in the order of acceptance.
    """
    left = np.argsort(-confidence, kind="stable")
    left = left[confidence[left] > 0]
    if first is not None and len(first):
        left = np.concatenate([first, left[~np.isin(left, first)]])
    accepted: list[int] = [] if fixed is None else np.asarray(fixed).tolist()
    for a in accepted:
        left = _beside(a, left, pairs, conflicts)
    while len(left):
        a = int(left[0])
        accepted.append(a)
        left = _beside(a, left, pairs, conflicts)
    return np.array(accepted, dtype=np.int64)


def _beside(
    a: int, left: np.ndarray, pairs: np.ndarray, conflicts: Callable[[int, np.ndarray], np.ndarray]
) -> np.ndarray:
    """The rows of `left` that can stand beside the accepted row a."""
    left = _one_to_one(pairs, a, left)
    return left[~conflicts(a, left)]


@njit(cache=True, nogil=True)
def _one_to_one(pairs, a, left):  # type: ignore[no-untyped-def]
    """Those of the rows `left` that share no end with the row a."""
    found, count = np.empty_like(left), 0
    for row in left:
        if pairs[row, 0] != pairs[a, 0] and pairs[row, 1] != pairs[a, 1]:
            found[count] = row
            count += 1
    return found[:count]
