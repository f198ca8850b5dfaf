"""Diffusion pruning of candidate joins by their halves (thesis, chapter 5).

A candidate join has four correspondences of halves: its two pairs of halves, each looked up from either side. They
support each other where all are good and alike (Eq 5.4). The stationary distribution of the walk on that affinity
ranks them, and a join is certain where all four are among the first (Algorithm 2: two-way cycle consistency).
"""

from typing import NamedTuple

import numpy as np

from ..consistency.diffusion import stationary
from ..progress import Progress, silent
from .halves import least_of_halves, meeting_halves, smallest_unit

LARGEST_RATIO = 10.0  # of the similarities of a join's two halves (Algorithm 2: val <= 10)
STEEPNESS, EVEN = 9.5, 1.2  # of the chance that a kept join is right by its distinctness, for MGC and for EMD alike


class Pruned(NamedTuple):
    """`kept` (c,) bool; `confidence` (c,) in [0, 1], support times the chance that a join so distinct is right;
    `round` (c,) int64: which iteration kept it, -1 if none."""

    kept: np.ndarray
    confidence: np.ndarray
    round: np.ndarray


def prune(
    rows: np.ndarray,
    halves: np.ndarray,
    *,
    knn: int,
    t_1: float,
    t_2: float,
    t_3: float,
    iterations: int,
    progress: Progress = silent,
) -> Pruned:
    """Which candidate joins are certain.

    Parameters
    ----------
    rows
        (c, 2) int64 sides, each pair once.
    halves
        (c, 2) dissimilarity of their halves (`half_dissimilarity`).
    knn
        How many nearest partners of each half are looked at.
    t_1, t_2, t_3
        Least similarity of a half to count (Eq 5.3), least agreement of two correspondences (Eq 5.4), and the share of
        the correspondences that is looked at, the most confident first.
    iterations
        At most so many rounds; each leaves out the sides that those before have joined. Ends where nothing is new.
    """
    c = len(rows)
    kept, support, rounds = np.zeros(c, dtype=bool), np.zeros(c), np.full(c, -1, dtype=np.int64)
    distinct = distinctness(rows, halves)
    left = np.arange(c)
    for step in range(iterations):
        progress(step / iterations, "pruning joins")
        sure, now = _once(rows[left], halves[left], distinct[left], knn=knn, t_1=t_1, t_2=t_2, t_3=t_3)
        support[left] = np.maximum(support[left], now)
        chosen = left[sure]
        if not len(chosen):
            break
        kept[chosen], rounds[chosen] = True, step
        left = left[~np.isin(rows[left], rows[chosen]).any(axis=1)]
    progress(1.0, "pruning joins")
    return Pruned(kept, support / (1 + np.exp(np.minimum(STEEPNESS * (distinct - EVEN), 50))), rounds)


def distinctness(rows: np.ndarray, halves: np.ndarray) -> np.ndarray:
    """How a join compares with its rivals, (c,) > 0: the mean over its four correspondences of D over the least other D
    of the half that looks, as Gallagher's ratio does for whole sides. Below 1 it is better than its rivals."""
    looking, d, epsilon = _looking(rows), np.tile(halves, 2), smallest_unit(halves)
    least = least_of_halves(rows, halves)
    best = _rank(looking.ravel(), d.ravel()).reshape(d.shape) == 0
    second = np.full(len(least), np.inf)
    np.minimum.at(second, looking, np.where(best, np.inf, d))
    other = np.where(best, second[looking], least[looking])
    return ((d + epsilon) / (np.minimum(other, 1e6 * (d + epsilon)) + epsilon)).mean(axis=1)


def _looking(rows: np.ndarray) -> np.ndarray:
    """The halves that look for partners, (c, 4): the first side's first and second pair, then the second side's."""
    return meeting_halves(rows).transpose(0, 2, 1).reshape(-1, 4)


def correspondences(rows: np.ndarray, halves: np.ndarray, *, knn: int, t_1: float) -> tuple[np.ndarray, np.ndarray]:
    """The four correspondences of each candidate: sim (c, 4) >= 1 of Eq 5.3, and which are candidates (c, 4) bool.

    In order: first halves, second halves, looked up from the first side; the same from the second. sim is the
    dissimilarity over the least one of the half that looks; a correspondence is one if it is among the `knn` nearest
    of that half and 1 / sim >= t_1.
    """
    looking = _looking(rows)
    least, epsilon = least_of_halves(rows, halves), smallest_unit(halves)
    d = np.tile(halves, 2)
    sim = (d + epsilon) / (least[looking] + epsilon)
    return sim, (_rank(looking.ravel(), d.ravel()).reshape(d.shape) < knn) & (sim * t_1 <= 1)


def _rank(group: np.ndarray, value: np.ndarray) -> np.ndarray:
    """The place of each value within its group, 0 the least; ties by index."""
    order = np.lexsort((np.arange(len(value)), value, group))
    ordered = group[order]
    rank = np.empty(len(value), dtype=np.int64)
    rank[order] = np.arange(len(value)) - np.searchsorted(ordered, ordered)
    return rank


def affinity(sim: np.ndarray, valid: np.ndarray, *, t_2: float) -> np.ndarray:
    """The blocks of M, (c, 4, 4): m of Eq 5.4 between the correspondences of one pair of sides, its diagonal 1."""
    a, b = sim[:, :, None], sim[:, None]
    m = np.minimum(a / b, b / a) / np.minimum(a, b)
    m = np.where((m >= t_2) & valid[:, :, None] & valid[:, None], m, 0.0)
    m[:, np.arange(4), np.arange(4)] = valid
    return m


def _once(
    rows: np.ndarray,
    halves: np.ndarray,
    distinct: np.ndarray,
    *,
    knn: int,
    t_1: float,
    t_2: float,
    t_3: float,
) -> tuple[np.ndarray, np.ndarray]:
    """One round: which candidates are accepted (c,) bool, and their support (c,) in [0, 1]: the mean of their block of M.

    Equal π are ordered by similarity, then by how distinct the join is, then by index.
    """
    if not len(rows):
        return np.zeros(0, dtype=bool), np.zeros(0)
    sim, valid = correspondences(rows, halves, knn=knn, t_1=t_1)
    degree = affinity(sim, valid, t_2=t_2).sum(axis=2)
    pi = stationary(degree.ravel())
    order = np.lexsort((np.arange(pi.size), np.repeat(distinct, 4), sim.ravel(), -pi))[: valid.sum()]
    first = np.zeros(pi.size, dtype=bool)
    first[order[: int(np.ceil(t_3 * len(order)))]] = True
    alike = sim[:, :2].max(axis=1) <= LARGEST_RATIO * sim[:, :2].min(axis=1)
    accepted = first.reshape(valid.shape).all(axis=1) & alike  # Algorithm 2: all four, whose corners are then neighbours
    support = degree.mean(axis=1) / 4
    return accepted & _best_of_both_sides(rows, np.where(accepted, support - distinct, -np.inf)), support


def _best_of_both_sides(rows: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Which rows (c, 2) have the largest value of all that share one of their sides, ties by index, (c,) bool."""
    order = np.tile(np.lexsort((np.arange(len(value)), -value)), 2)
    rank = np.empty(len(value), dtype=np.int64)
    rank[order[: len(value)]] = np.arange(len(value))
    best = np.full(int(rows.max()) + 1, len(value), dtype=np.int64)
    for end in (0, 1):
        np.minimum.at(best, rows[:, end], rank)
    return (best[rows] == rank[:, None]).all(axis=1)
