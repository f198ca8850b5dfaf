"""How well any two sides fit, in log odds: calibrated for candidates, by the plain measure for all others."""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from .candidates import Candidates, rival_values
from .measures import Strips, dissimilarity_of_pairs, gradient_statistics, mgc

LIMIT = 12.0  # largest log odds, either way
NEVER = -1e6  # log odds of a forbidden pair
CROWD = 8  # candidates as good as the best that make a side's list a matter of chance
UNLISTED = -5.0  # log odds of a pair that is as alike as the best candidate but was not listed


class Evidence(NamedTuple):
    """What assembling asks of two sides, as plain arrays for compiled loops.

    `start`, `partner`, `row` are `start`, `partner`, `index` of the candidates and `logit` (c,) float64 their log odds; `outer`
    (s, L, 3), `mean` (s, 3), `inverse` (s, 3, 3) are what MGC needs, and `best` (s,) the least MGC of each side.
    """

    start: np.ndarray
    partner: np.ndarray
    row: np.ndarray
    logit: np.ndarray
    outer: np.ndarray
    mean: np.ndarray
    inverse: np.ndarray
    best: np.ndarray


def kinds_of(e: Evidence) -> np.ndarray:
    """A number (n,) int64 for each piece: equal for pieces whose borders and gradients are the same."""
    n = len(e.outer) // 4
    sides = np.concatenate([e.outer.reshape(n, -1), e.mean.reshape(n, -1), e.inverse.reshape(n, -1)], axis=1)
    seen: dict[bytes, int] = {}
    return np.array([seen.setdefault(row.tobytes(), len(seen)) for row in sides], dtype=np.int64)


def log_odds(probability: np.ndarray) -> np.ndarray:
    """log p / (1 − p), within ±`LIMIT`."""
    p = np.clip(probability, 1e-9, 1 - 1e-9)
    return np.clip(np.log(p / (1 - p)), -LIMIT, LIMIT)


def evidence(strips: Strips, candidates: Candidates, probability: np.ndarray) -> Evidence:
    """Gather the evidence of a square puzzle."""
    value = dissimilarity_of_pairs("mgc-root", strips, candidates.pairs)
    least = np.minimum(value[:, None], rival_values(value, candidates))
    best = np.full(len(strips.outer), np.inf)
    for end in (0, 1):
        np.minimum.at(best, candidates.pairs[:, end], least[:, end])
    best[~np.isfinite(best)] = np.median(value) if len(value) else 1.0
    floor = 1e-3 * strips.outer.shape[1]
    mean, inverse = gradient_statistics(strips)
    logit = _evened(log_odds(probability), value + floor, best + floor, candidates)
    return Evidence(
        candidates.start, candidates.partner, candidates.index, logit, strips.outer, mean, inverse, best + floor)  # fmt: skip


def _evened(logit: np.ndarray, value: np.ndarray, best: np.ndarray, candidates: Candidates) -> np.ndarray:
    """Log odds (c,) without what chance listed: where a side has more equals than its list can hold, the listed ones are
    no likelier than those that were not listed."""
    ratio = value / best[candidates.pairs].min(axis=1)
    alike = ratio < 1.05
    sides = len(candidates.start) - 1
    ties = np.bincount(candidates.pairs[alike].ravel(), minlength=sides)
    crowded = (ties >= CROWD)[candidates.pairs].any(axis=1) & (logit < 0)
    plain = np.maximum(UNLISTED - 2.0 * np.log(np.maximum(ratio, 1.0)), -LIMIT)
    return np.where(crowded, plain, logit)


@njit(cache=True, nogil=True)
def fit(e, r, c):  # type: ignore[no-untyped-def]
    """Log odds that the sides r and c belong together."""
    for k in range(e.start[r], e.start[r + 1]):
        if e.partner[k] == c:
            return e.logit[e.row[k]]
    value = mgc(e.outer[r], e.mean[r], e.inverse[r], e.outer[c], e.mean[c], e.inverse[c], 1.0, True)
    ratio = (value + 1e-3 * e.outer.shape[1]) / min(e.best[r], e.best[c])
    return max(UNLISTED - 2.0 * np.log(max(ratio, 1.0)), -LIMIT)


@njit(cache=True, nogil=True, parallel=True)
def fits(e, sides, result):  # type: ignore[no-untyped-def]
    """Log odds (j,) of the pairs of side rows (j, 2)."""
    for a in prange(len(sides)):
        result[a] = fit(e, sides[a, 0], sides[a, 1])
