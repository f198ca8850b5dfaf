"""Candidate joins of polygons: two sides that run against each other and share a corner, at one end or at both."""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from .contacts import FEATURES, Ground, features_of, shared_pixels, side_odds, touching

FIRST, LAST = 1, 2  # the shared corner: start of the first side and end of the second; the other way; 3 is both
NOBODY = -3.0  # log odds of having no partner at all, in the contest at an end of a side
FLOOR, CEILING = -20.0, 20.0
TRIED, RIM = 8, 3  # candidates of a corner that are moved about; pixels that masks on a slope may share
ROUNDED, CLEARLY = 0.8, 2.0  # pixels that corners may miss each other by; log odds that a move must bring
HOPEFUL, SLIDE, NOWHERE, SHARP = -3.0, 8, -50.0, 6.0  # which candidates are slid, how far, and what is made of it


class Alignments(NamedTuple):
    """c candidate joins: `side` (c, 2) int64, piece of the first < piece of the second; `turn` (c,) int64 quarter
    turns of the second piece; `offset` (c, 2) int64 of its turned raster from the first's, in pixels; `corner` (c,)
    int64 which corners are shared; `samples` (c, 3) int64 their contact; `feature` (c, k) float64 what is seen;
    `slid` (c,) int64 by how many pixels the corners miss each other along the side, `origin` (c,) int64 the row of the
    candidate that was slid, itself where none was."""

    side: np.ndarray
    turn: np.ndarray
    offset: np.ndarray
    corner: np.ndarray
    samples: np.ndarray
    feature: np.ndarray
    slid: np.ndarray
    origin: np.ndarray


def alignments(ground: Ground, piece: np.ndarray, *, features: int, turned: bool) -> Alignments:
    """All candidate joins of the sides of different pieces (s,), seen by `features` numbers; with `turned` also by
    quarter turns."""
    count = _list(ground, piece, turned, *_room(0))
    side, turn, offset, corner, samples = _room(count)
    _list(ground, piece, turned, side, turn, offset, corner, samples)
    feature = np.zeros((count, features))
    _see(ground, side, samples, feature)
    return Alignments(side, turn, offset, corner, samples, feature, np.zeros(count, dtype=np.int64), np.arange(count))


def _room(c: int) -> list[np.ndarray]:
    return [np.zeros(shape, dtype=np.int64) for shape in ((c, 2), (c,), (c, 2), (c,), (c, 3))]


@njit(cache=True, nogil=True)
def _list(g, piece, turned, side, turn, offset, corner, samples):  # type: ignore[no-untyped-def]
    """Count the candidate joins, and write them down if there is room."""
    count, s, room = 0, len(piece), len(side) > 0
    for e in range(s):
        for f in range(g.first[piece[e] + 1], s):
            for t in range(4 if turned else 1):
                x0, y0 = round(g.start[e, 0, 0] - g.end[f, t, 0]), round(g.start[e, 0, 1] - g.end[f, t, 1])
                x1, y1 = round(g.end[e, 0, 0] - g.start[f, t, 0]), round(g.end[e, 0, 1] - g.start[f, t, 1])
                both = max(abs(x0 - x1), abs(y0 - y1)) <= g.slack
                for way in range(1 if both else 2):
                    x, y = (x0, y0) if way == 0 else (x1, y1)
                    n, i, j = touching(g, e, 0, f, t, x, y)
                    if n == 0:
                        break  # they do not run against each other
                    if room:
                        side[count, 0], side[count, 1], turn[count] = e, f, t
                        offset[count, 0], offset[count, 1] = x, y
                        corner[count] = FIRST + LAST if both else LAST if way else FIRST
                        samples[count, 0], samples[count, 1], samples[count, 2] = n, i, j
                    count += 1
    return count


@njit(cache=True, nogil=True, parallel=True)
def _see(g, side, samples, feature):  # type: ignore[no-untyped-def]
    for k in prange(len(side)):
        features_of(g, side[k, 0], samples[k, 1], side[k, 1], samples[k, 2], samples[k, 0], feature[k])


def contest(a: Alignments, odds: np.ndarray, sides: int) -> np.ndarray:
    """How each candidate stands against all others at the corners that it shares, (c, 2): for its first and second side.

    At an end of a side at most one candidate is right: the value is its log odds minus the log of the summed odds of
    the others and of no partner at all, the lesser of the two ends where it shares both. A candidate and those slid
    from it are rivals elsewhere (`with_slid`), not here.
    """
    strength = np.full(a.origin.max(initial=-1) + 1, -np.inf)
    np.maximum.at(strength, a.origin, odds)
    kept = np.flatnonzero(a.slid == 0)
    against = np.full((len(odds), 2), FLOOR)
    for column in (0, 1):
        for shared in (FIRST, LAST):
            rows = kept[(a.corner[kept] & shared) > 0]
            side, value = a.side[rows, column], strength[a.origin[rows]]
            most = np.full(sides, -np.inf)
            np.maximum.at(most, side, value)
            power = np.exp(value - most[side])
            others = np.maximum(np.bincount(side, power, sides)[side] - power, 1e-12)
            against[rows, column] = np.maximum(against[rows, column], np.logaddexp(most[side] + np.log(others), NOBODY))
    first = np.empty(len(strength), dtype=np.int64)
    first[a.origin[kept]] = kept
    return np.clip(odds[:, None] - against[first[a.origin]], FLOOR, CEILING)


def refined(ground: Ground, a: Alignments, odds: np.ndarray) -> Alignments:
    """Candidates of traced outlines, each moved by a pixel at most to where it fits best.

    The corners of traced outlines are off by up to a pixel, which is enough to hide a true join. The strongest at each
    corner are moved about: along level and upright sides, and in all directions on slopes, where the masks must touch
    without overlap. Candidates that end in the same place become one.
    """
    rows = _strongest(a, odds, TRIED)
    offset = a.offset.copy()
    _refine(ground, a.side, a.turn, a.offset, a.corner, rows, offset)
    samples, feature = a.samples.copy(), a.feature.copy()
    changed = np.flatnonzero((offset != a.offset).any(axis=1))
    new = np.zeros((len(changed), 3), dtype=np.int64)
    _touch(ground, a.side[changed], a.turn[changed], offset[changed], new)
    seen = np.zeros((len(changed), feature.shape[1]))
    _see(ground, a.side[changed], new, seen)
    samples[changed], feature[changed] = new, seen
    _, first, place = np.unique(
        np.column_stack([a.side, a.turn, offset]), axis=0, return_index=True, return_inverse=True
    )
    corner = np.zeros(len(first), dtype=np.int64)
    np.bitwise_or.at(corner, place.ravel(), a.corner)
    return Alignments(
        a.side[first], a.turn[first], offset[first], corner, samples[first], feature[first], a.slid[first],
        np.arange(len(first)),
    )  # fmt: skip


def _strongest(a: Alignments, odds: np.ndarray, most: int) -> np.ndarray:
    """The rows that are among the `most` strongest of some corner of some side."""
    order = np.argsort(-odds, kind="stable")
    chosen = np.zeros(len(odds), dtype=bool)
    for column in (0, 1):
        for shared in (FIRST, LAST):
            rows = order[(a.corner[order] & shared) > 0]
            rows = rows[np.argsort(a.side[rows, column], kind="stable")]
            side = a.side[rows, column]
            first = np.searchsorted(side, side, side="left")
            chosen[rows[np.arange(len(rows)) - first < most]] = True
    return np.flatnonzero(chosen)


@njit(cache=True, nogil=True, parallel=True)
def _refine(g, side, turn, offset, corner, rows, result):  # type: ignore[no-untyped-def]
    for q in prange(len(rows)):
        k = rows[q]
        e, f, t = side[k, 0], side[k, 1], turn[k]
        if corner[k] & FIRST:
            dx, dy = g.start[e, 0] - g.end[f, t]
        else:
            dx, dy = g.end[e, 0] - g.start[f, t]
        x, y = _best_nearby(g, e, f, t, offset[k, 0], offset[k, 1], dx, dy)
        result[k, 0], result[k, 1] = x, y


@njit(cache=True, nogil=True)
def _best_nearby(g, e, f, turn, x, y, dx, dy):  # type: ignore[no-untyped-def]
    """The offset near (dx, dy), where the corners meet, at which side f fits side e clearly better than at (x, y)."""
    a = np.searchsorted(g.first, e, side="right") - 1
    b = np.searchsorted(g.first, f, side="right") - 1
    ax, ay = g.end[e, 0] - g.start[e, 0]
    slope = min(abs(ax), abs(ay)) > 1e-6
    ix, iy = np.int64(-np.sign(ay)), np.int64(np.sign(ax))  # towards the inside of a
    z, best, at_x, at_y = np.empty(FEATURES), NOWHERE, x, y
    for u in range(-1, 2):
        for v in range(-1, 2):
            moved = abs(x + u - dx) > ROUNDED or abs(y + v - dy) > ROUNDED
            n, i, j = touching(g, e, 0, f, turn, x + u, y + v)
            if n == 0 or (moved and (u or v)):
                continue
            if slope and (
                shared_pixels(g, a, 0, b, turn, x + u, y + v, RIM) > RIM
                or shared_pixels(g, a, 0, b, turn, x + u + ix, y + v + iy, RIM) <= RIM
            ):
                continue
            value = side_odds(g, e, i, f, j, n, z) - (CLEARLY if u or v else 0.0)
            if value > best:
                best, at_x, at_y = value, x + u, y + v
    return at_x, at_y


def with_slid(ground: Ground, a: Alignments, odds: np.ndarray) -> tuple[Alignments, np.ndarray, np.ndarray]:
    """Corners that nearly meet: the candidates, those found by sliding them a few pixels, and how sharply each fits.

    Corners of different cuts may lie a few pixels apart, and the join that makes them meet is then nearly right and
    quite wrong. Every hopeful candidate is slid along its side; one that fits better elsewhere is joined by a candidate
    at the best place. Returns all candidates, their log odds (c,), and by how much these exceed those of the best
    other place nearby (c,), 0 where nothing was slid.
    """
    rows = np.flatnonzero(odds > HOPEFUL)
    found = np.zeros((len(rows), 2 * SLIDE + 1))
    _slide(ground, a.side, a.turn, a.offset, rows, found)
    seen = found[:, SLIDE] > NOWHERE
    rows, found = rows[seen], found[seen]
    edge = np.zeros(len(odds))
    edge[rows] = odds[rows] - np.delete(found, SLIDE, axis=1).max(axis=1, initial=NOWHERE)
    better = np.flatnonzero(edge[rows] < 0)
    peak = found[better].argmax(axis=1)
    inside = (peak > 0) & (peak < 2 * SLIDE) & (found[better, peak] > HOPEFUL)
    better, peak = better[inside], peak[inside]
    new = _moved(ground, a, rows[better], peak - SLIDE)
    value = found[better, peak]
    around = found[better]
    around[np.arange(len(better)), peak] = NOWHERE
    everything = Alignments(*(np.concatenate(pair) for pair in zip(a, new, strict=True)))
    return (
        everything,
        np.concatenate([odds, value]),
        np.concatenate([edge, value - around.max(axis=1, initial=NOWHERE)]),
    )


def _moved(ground: Ground, a: Alignments, rows: np.ndarray, by: np.ndarray) -> Alignments:
    """Some candidates moved along their first side by whole pixels."""
    along = ground.end[a.side[rows, 0], 0] - ground.start[a.side[rows, 0], 0]
    offset = a.offset[rows] + by[:, None] * np.sign(along).astype(np.int64)
    samples, feature = np.zeros((len(rows), 3), dtype=np.int64), np.zeros((len(rows), a.feature.shape[1]))
    _touch(ground, a.side[rows], a.turn[rows], offset, samples)
    _see(ground, a.side[rows], samples, feature)
    return Alignments(a.side[rows], a.turn[rows], offset, a.corner[rows], samples, feature, by, a.origin[rows])


@njit(cache=True, nogil=True)
def _touch(g, side, turn, offset, samples):  # type: ignore[no-untyped-def]
    for k in range(len(side)):
        n, i, j = touching(g, side[k, 0], 0, side[k, 1], turn[k], offset[k, 0], offset[k, 1])
        samples[k, 0], samples[k, 1], samples[k, 2] = n, i, j


@njit(cache=True, nogil=True)
def _slide(g, side, turn, offset, rows, found):  # type: ignore[no-untyped-def]
    """Log odds (r, 2 SLIDE + 1) of some candidates moved along their sides; `NOWHERE` where they touch no more.

    Only level and upright sides are slid: pixels do not lie on whole steps of other slopes.
    """
    z = np.empty(FEATURES)
    for q in range(len(rows)):
        k = rows[q]
        e, f = side[k]
        dx, dy = g.end[e, 0] - g.start[e, 0]
        found[q] = NOWHERE
        if min(abs(dx), abs(dy)) > 1e-6:
            continue
        ux, uy = np.int64(np.sign(dx)), np.int64(np.sign(dy))
        for by in range(-SLIDE, SLIDE + 1):
            n, i, j = touching(g, e, 0, f, turn[k], offset[k, 0] + by * ux, offset[k, 1] + by * uy)
            if n > 0:
                found[q, by + SLIDE] = side_odds(g, e, i, f, j, n, z)


def contest_features(a: Alignments, odds: np.ndarray, edge: np.ndarray, sides: int) -> np.ndarray:
    """What a candidate's calibrated log odds are made of, (c, 7): 1, its own, both contests and the lesser of them,
    whether both corners meet, how sharply it fits (`edge`), and whether no corner meets."""
    standing = contest(a, odds, sides)
    both = (a.corner == FIRST + LAST) & (a.slid == 0)
    columns = (np.ones(len(odds)), np.clip(odds, FLOOR, CEILING), standing.sum(axis=1), standing.min(axis=1), both,
               np.clip(edge, -SHARP, SHARP), a.slid != 0)  # fmt: skip
    return np.stack(columns, axis=1).astype(np.float64)
