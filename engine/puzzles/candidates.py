"""Candidate joins of square sides as rows of arrays, and what can be said of each: its features."""

from dataclasses import dataclass

import numpy as np
from numba import njit, prange

from ..progress import Progress, share
from .measures import Strips, across, dissimilarity_of_pairs, side_strips, smoothed
from .shortlist import mgc_forms, nearest, pairs_of, ssd_forms


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """The c candidate joins between the s sides of a square puzzle.

    `pairs` (c, 2) int64 are side rows 4 i + side, the smaller first, sorted; the candidates of side r are the rows
    `index[start[r]:start[r + 1]]` of `pairs`, their other sides `partner[start[r]:start[r + 1]]`.
    """

    pairs: np.ndarray
    start: np.ndarray
    partner: np.ndarray
    index: np.ndarray

    @property
    def count(self) -> int:
        """The number of candidates c."""
        return len(self.pairs)


def candidates_of(pairs: np.ndarray, sides: int) -> Candidates:
    """Index the pairs (c, 2) by side, for `sides` = s sides."""
    both = np.concatenate([pairs, pairs[:, ::-1]])
    order = np.argsort(both[:, 0], kind="stable")
    start = np.searchsorted(both[order, 0], np.arange(sides + 1))
    return Candidates(pairs, start, both[order, 1], order % max(len(pairs), 1))


def shortlist(strips: Strips, *, turned: bool, by_mgc: int, by_ssd: int, worn: bool, progress: Progress) -> Candidates:
    """The candidates of n square pieces: the nearest of each side by MGC and by SSD in L*a*b*; where borders are `worn`
    three times as many, and colours are smoothed."""
    n = len(strips.outer) // 4
    colours = smoothed(strips.lab(), 5) if worn else strips.lab()
    more = 3 if worn else 1
    halves = share(progress, 0.0, 0.6), share(progress, 0.6, 1.0)
    lists = [
        nearest(mgc_forms(strips), n, more * by_mgc, turned=turned, progress=halves[0]),
        nearest(ssd_forms(colours), n, more * by_ssd, turned=turned, progress=halves[1]),
    ]
    return candidates_of(pairs_of(lists), 4 * n)


@njit(cache=True, nogil=True, parallel=True)
def rivals(values, pairs, start, partner, index, result):  # type: ignore[no-untyped-def]
    """For each candidate and each of its ends, the least value of the other candidates of that side, (c, 2); inf if none."""
    for side in prange(len(start) - 1):
        best, second, who = np.inf, np.inf, -1
        for k in range(start[side], start[side + 1]):
            value = values[index[k]]
            if value < best:
                best, second, who = value, best, index[k]
            elif value < second:
                second = value
        for k in range(start[side], start[side + 1]):
            a = index[k]
            result[a, 0 if pairs[a, 0] == side else 1] = second if a == who else best


def rival_values(values: np.ndarray, candidates: Candidates) -> np.ndarray:
    """The least value among the other candidates at either end, (c, 2) float64; inf where there is no other."""
    result = np.full((candidates.count, 2), np.inf)
    rivals(values, candidates.pairs, candidates.start, candidates.partner, candidates.index, result)
    return result


def gallagher_ratio(values: np.ndarray, candidates: Candidates) -> np.ndarray:
    """N (c,) = D / (the second best of either side), Gallagher 2012: below 1 iff best buddies.

    ε = 1e-3 of the median keeps ties of flat pieces at 1.
    """
    epsilon = 1e-3 * float(np.median(values)) + 1e-9 if len(values) else 1.0
    return (values + epsilon) / (rival_values(values, candidates).min(axis=1) + epsilon)


Looks = list[tuple[str, Strips, bool]]  # a measure, the strips that it looks at, and whether its value counts too


def looks_of(rasters: np.ndarray, worn: bool) -> Looks:
    """What the features of candidates look at: the borders; where they are `worn` also what lies further apart and
    deeper, and what smoothing leaves."""
    strips = side_strips(rasters)
    looks = [("mgc-root", strips, True), ("pt", strips, True), ("lpq", strips, False), ("ssd-lab", strips, False),
             ("emd-lab", strips, True)]  # fmt: skip
    if worn:
        deep = side_strips(rasters, rows=2)
        looks += [("mgc-root", across(strips, 3.0), True), ("mgc-root", across(strips, 6.0), False),
                  ("ssd-lab", smoothed(strips, 5), True), ("mgc-root", deep, True), ("pt", smoothed(deep, 3), False),
                  ("emd-lab", deep, False)]  # fmt: skip
    return looks


def border_features(candidates: Candidates, looks: Looks, turned: bool, progress: Progress) -> np.ndarray:
    """What the borders say of each candidate, (c, f) float32: for each look the log ratio to the best rival at the
    worse and at the better end, and some plain values on a log scale; then the contrast of both borders, the size of
    the sides and whether pieces are `turned`."""
    columns = []
    strips = looks[0][1]
    length = strips.outer.shape[1]
    for number, (measure, seen, plain) in enumerate(looks):
        values = dissimilarity_of_pairs(measure, seen, candidates.pairs, parts=2)
        epsilon = 1e-4 * float(np.median(values)) + 1e-9 if len(values) else 1.0
        ratio = np.log(((values[:, None] + epsilon) / (rival_values(values, candidates) + epsilon)).clip(0.01, 60))
        columns += [ratio.max(axis=1), ratio.min(axis=1)]
        if plain:
            columns.append(np.log(values / length + 0.005))
        progress((number + 1) / len(looks), "measuring joins")
    contrast = np.log(strips.outer.std(axis=1).mean(axis=1) + 0.3)
    ends = contrast[candidates.pairs]
    columns += [ends.max(axis=1), ends.min(axis=1)]
    columns += [np.full(candidates.count, np.log(length / 28)), np.full(candidates.count, float(turned))]
    return np.stack(columns, axis=1).astype(np.float32)


@njit(cache=True, nogil=True)
def _chance(probability, start, partner, index, r, c):  # type: ignore[no-untyped-def]
    for k in range(start[r], start[r + 1]):
        if partner[k] == c:
            return probability[index[k]]
    return 0.0


@njit(cache=True, nogil=True, parallel=True)
def _support(probability, pairs, start, partner, index, order, most, result):  # type: ignore[no-untyped-def]
    for a in prange(len(pairs)):
        for corner in range(2):
            r, c = (pairs[a, 0], pairs[a, 1]) if corner == 0 else (pairs[a, 1], pairs[a, 0])
            i, s, j, t = r // 4, r % 4, c // 4, c % 4
            beside, below = 4 * i + (s + 1) % 4, 4 * j + (t + 3) % 4
            total = 0.0
            for x in range(start[beside], min(start[beside + 1], start[beside] + most)):
                u = partner[order[x]]
                p = probability[index[order[x]]]
                if p < 1e-3:
                    break
                for y in range(start[below], min(start[below + 1], start[below] + most)):
                    w = partner[order[y]]
                    q = probability[index[order[y]]]
                    if p * q < 1e-4:
                        break
                    if u // 4 == w // 4 or u // 4 == j or w // 4 == i:
                        continue
                    closing = _chance(
                        probability, start, partner, index, u // 4 * 4 + (u + 1) % 4, w // 4 * 4 + (w + 3) % 4
                    )
                    total += p * q * closing
            result[a, corner] = total


def exclusive(probability: np.ndarray, candidates: Candidates) -> np.ndarray:
    """Probabilities (c,) scaled down so that those of no side sum to more than 1: a side has at most one partner."""
    sides = len(candidates.start) - 1
    total = np.bincount(candidates.pairs.ravel(), np.repeat(probability, 2), sides)
    return probability / np.maximum(1.0, np.maximum(total[candidates.pairs[:, 0]], total[candidates.pairs[:, 1]]))


def loop_support(probability: np.ndarray, candidates: Candidates, most: int) -> np.ndarray:
    """How strongly 2 × 2 loops of four pieces support each candidate at its two corners, (c, 2) float64 >= 0.

    A loop counts the product of the probabilities of its other three joins; the `most` likeliest candidates of a side
    are tried. The sum over loops may pass 1 where rivals share pieces.
    """
    likeliest = np.lexsort((-probability[candidates.index], _owner(candidates)))
    result = np.zeros((candidates.count, 2))
    _support(
        probability, candidates.pairs, candidates.start, candidates.partner, candidates.index, likeliest, most, result
    )
    return result


def _owner(candidates: Candidates) -> np.ndarray:
    return np.repeat(np.arange(len(candidates.start) - 1), np.diff(candidates.start))


def context_features(probability: np.ndarray, candidates: Candidates, most: int) -> np.ndarray:
    """What the neighbourhood says of each candidate, (c, 9) float32: its own log odds, those of the best rivals, loop
    support at both corners, and the loop support of the best supported rivals."""
    logit = np.log(probability.clip(1e-6, 1 - 1e-6) / (1 - probability).clip(1e-6, 1 - 1e-6))
    rival = -rival_values(-logit, candidates).clip(-14, 14)
    support = loop_support(exclusive(probability, candidates), candidates, most)
    strength = np.log(support + 1e-4)
    total = strength.sum(axis=1)
    rival_strength = (-rival_values(-total, candidates)).clip(-20, 20)
    both = logit + total
    rival_both = (-rival_values(-both, candidates)).clip(-30, 30)
    return np.stack(
        [logit, rival.max(axis=1), rival.min(axis=1), strength.max(axis=1), strength.min(axis=1),
         rival_strength.max(axis=1), rival_strength.min(axis=1), both - rival_both.max(axis=1),
         both - rival_both.min(axis=1)], axis=1).astype(np.float32)  # fmt: skip
