"""Ways to build blocks of square pieces from candidates: each returns the order in which joins are tried.

All see the same candidates, probabilities and rules, so that a judge can compare what comes out.
"""

import heapq

import numpy as np
from numba import njit

from ..progress import Progress
from .blocks import STEP_X, STEP_Y, Blocks, Rules, grow_blocks
from .candidates import Candidates, rival_values


def by_probability(probability: np.ndarray, least: float) -> np.ndarray:
    """Rows of the candidates with at least this probability, likeliest first, ties by index: Kruskal's order."""
    order = np.argsort(-probability, kind="stable")
    return order[probability[order] >= least]


def best_buddies(probability: np.ndarray, candidates: Candidates) -> np.ndarray:
    """Which candidates are likelier than every rival at both ends, (c,) bool."""
    return probability > -rival_values(-probability, candidates).min(axis=1)


def loops_first(probability: np.ndarray, candidates: Candidates, least: float) -> np.ndarray:
    """Rows in the order of Son et al. (2014): first the best buddies that close 2 × 2 loops of best buddies, those in
    two loops before those in one, then the others, each by probability."""
    closed = closed_loops(best_buddies(probability, candidates), candidates)
    order = np.lexsort((-probability, -closed))
    return order[probability[order] >= least]


def closed_loops(chosen: np.ndarray, candidates: Candidates) -> np.ndarray:
    """In how many 2 × 2 loops of `chosen` candidates (c,) bool each chosen one lies, (c,) int64 in 0..2.

    Each side must have at most one chosen candidate.
    """
    partner = np.full(len(candidates.start) - 1, -1, dtype=np.int64)
    a, b = candidates.pairs[chosen].T
    partner[a], partner[b] = b, a
    counts = np.zeros(candidates.count, dtype=np.int64)
    for first, second in ((a, b), (b, a)):  # the loop around the corner at the clockwise end of `first`
        up = partner[first // 4 * 4 + (first + 1) % 4]
        down = partner[second // 4 * 4 + (second + 3) % 4]
        there = (up >= 0) & (down >= 0)
        closing = partner[up // 4 * 4 + (up + 1) % 4] == down // 4 * 4 + (down + 3) % 4
        counts[chosen] += there & closing
    return counts


def grown_greedily(
    probability: np.ndarray, candidates: Candidates, start: Blocks, rules: Rules, least: float
) -> Blocks:
    """One block grown from the surest join by the likeliest candidate at its border (Prim's order, as Paikin & Tal).

    When nothing at the border is at least `least` likely, a new block is started from what is left.
    """
    order = _prims_order(probability, candidates.pairs, candidates.start, candidates.index, least)
    return grow_blocks(candidates.pairs, order, start, rules)[0]


def _prims_order(
    probability: np.ndarray, pairs: np.ndarray, start: np.ndarray, index: np.ndarray, least: float
) -> np.ndarray:
    """Rows in the order in which a growing set of pieces meets them, likeliest first."""
    seeds = by_probability(probability, least).tolist()
    reached = np.zeros((len(start) - 1) // 4, dtype=bool)
    queued = probability < least
    order: list[int] = []
    heap: list[tuple[float, int]] = []
    for seed in seeds:
        if reached[pairs[seed, 0] // 4]:
            continue
        heapq.heappush(heap, (-probability[seed], seed))
        while heap:
            _, a = heapq.heappop(heap)
            order.append(a)
            for piece in (pairs[a] // 4).tolist():
                if reached[piece]:
                    continue
                reached[piece] = True
                for row in index[start[4 * piece] : start[4 * piece + 4]].tolist():
                    if not queued[row]:
                        queued[row] = True
                        heapq.heappush(heap, (-probability[row], row))
    return np.array(order, dtype=np.int64)


@njit(cache=True, nogil=True)
def _steps(pairs, turns, step_x, step_y):  # type: ignore[no-untyped-def]
    for a in range(len(pairs)):
        d = (pairs[a, 0] % 4 + turns[pairs[a, 0] // 4]) % 4
        step_x[a], step_y[a] = STEP_X[d], STEP_Y[d]


def by_linear_programme(
    probability: np.ndarray, candidates: Candidates, turns: np.ndarray, *, rounds: int, least: float, progress: Progress
) -> np.ndarray:
    """Rows that a weighted L1 fit of all positions agrees with, by probability, then the others by probability.

    Yu, Russell & Agapito, "Solving jigsaw puzzles with linear programming" (BMVC 2016): every side takes its likeliest
    candidate, positions minimise Σ w |x_i − x_j − δ| on either axis, candidates off by more than half a cell are
    rejected, their sides take the next, until nothing changes. `turns` (n,) are the quarter turns of the pieces, as a
    first solution has them: only candidates that agree with them take part.
    """
    pairs = candidates.pairs
    facing = (pairs % 4 + turns[pairs // 4]) % 4
    open_ = (probability >= least) & ((facing[:, 0] + 2) % 4 == facing[:, 1])
    step_x, step_y = np.zeros(len(pairs)), np.zeros(len(pairs))
    _steps(pairs, turns, step_x, step_y)
    agreed = np.zeros(len(pairs), dtype=bool)
    for number in range(rounds):
        active = np.flatnonzero(_likeliest(probability * open_, candidates) & open_)
        if not len(active):
            break
        weight = probability[active] / (1.0 + 1e-6 - probability[active])
        weight = np.minimum(weight, 1e4)
        off = np.zeros(len(active))
        for step in (step_x, step_y):
            place = _fit_positions(pairs[active] // 4, step[active], weight, len(turns))
            off = np.maximum(off, np.abs(place[pairs[active, 1] // 4] - place[pairs[active, 0] // 4] - step[active]))
        agreed[:] = False
        agreed[active[off < 0.5]] = True
        progress((number + 1) / rounds, "fitting positions")
        if (off < 0.5).all():
            break
        open_[active[off >= 0.5]] = False
    order = np.lexsort((-probability, ~agreed))
    return order[(probability[order] >= least)]


def _likeliest(probability: np.ndarray, candidates: Candidates) -> np.ndarray:
    """Which candidates are the likeliest of at least one of their sides, (c,) bool."""
    return (probability > 0) & (probability[:, None] >= -rival_values(-probability, candidates)).any(axis=1)


def _fit_positions(ends: np.ndarray, step: np.ndarray, weight: np.ndarray, n: int) -> np.ndarray:
    """x (n,) that minimises Σ weight |x_j − x_i − step| over the rows (i, j) of `ends`, by HiGHS."""
    from scipy.optimize import linprog
    from scipy.sparse import coo_matrix, hstack, identity

    c = len(ends)
    row = np.arange(c)
    difference = coo_matrix(
        (np.concatenate([np.ones(c), -np.ones(c)]), (np.concatenate([row, row]), np.concatenate([ends[:, 1], ends[:, 0]]))),
        shape=(c, n))  # fmt: skip
    slack = identity(c)
    equal = hstack([difference, -slack, slack]).tocsr()
    cost = np.concatenate([np.zeros(n), weight, weight])
    bounds = [(None, None)] * n + [(0, None)] * (2 * c)
    solved = linprog(cost, A_eq=equal, b_eq=step, bounds=bounds, method="highs")
    return solved.x[:n]
