"""Clusters of placed polygons that are merged, the best supported join first, without overlap.

A join between two clusters puts one beside the other, and all contacts that arise then speak for or against it: joins
that agree with other joins, around a corner or across a T, gain; those that make strangers touch lose. Kruskal's order
on single joins, with an overlap check (Gallagher 2012), is the case in which nothing but the join itself counts.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from .contacts import overlapping, side_odds, touching

GOOD, BAD = 5.0, -6.0  # the most that one contact counts for or against a join, in log odds


class Trials(NamedTuple):
    """c possible joins: `side` (c, 2) int64 the two sides, `turn` (c,) int64, `offset` (c, 2) int64 of the second
    piece against the first, `odds` (c,) float64 their log odds, all competition counted."""

    side: np.ndarray
    turn: np.ndarray
    offset: np.ndarray
    odds: np.ndarray


class Layout(NamedTuple):
    """Where n pieces stand: `cluster` (n,) int64 named by one of its pieces, `place` (n, 2) int64 the top-left pixels
    of the turned rasters within the cluster, `turns` (n,) int64."""

    cluster: np.ndarray
    place: np.ndarray
    turns: np.ndarray

    def copy(self) -> "Layout":
        """A layout that may be changed on its own."""
        return Layout(self.cluster.copy(), self.place.copy(), self.turns.copy())


def apart(n: int) -> Layout:
    """Every piece a cluster of its own."""
    return Layout(np.arange(n), np.zeros((n, 2), dtype=np.int64), np.zeros(n, dtype=np.int64))


@njit(cache=True, nogil=True)
def rotated(x, y, w, h, turns):  # type: ignore[no-untyped-def]
    """The top-left corner of the box (x, y, w, h) after clockwise quarter turns around (0, 0)."""
    for _ in range(turns % 4):
        x, y, w, h = -y - h, x, h, w
    return x, y


@njit(cache=True, nogil=True)
def extent(g, i, turns):  # type: ignore[no-untyped-def]
    """(w, h) of the turned raster of piece i."""
    return g.size[i, turns % 2], g.size[i, 1 - turns % 2]


@njit(cache=True, nogil=True)
def movement(g, layout, a, b, turn, dx, dy):  # type: ignore[no-untyped-def]
    """The (quarter turns, x, y) that bring the cluster of b beside a: first turned around (0, 0), then moved.

    The top-left of b, turned by `turn`, lies at (dx, dy) from that of a while a stands as it was read.
    """
    ta = layout.turns[a]
    turns = (ta + turn - layout.turns[b]) % 4
    wb, hb = extent(g, b, turn)
    x, y = rotated(dx, dy, wb, hb, ta)
    x0, y0 = rotated(0, 0, g.size[a, 0], g.size[a, 1], ta)
    w, h = extent(g, b, layout.turns[b])
    x1, y1 = rotated(layout.place[b, 0], layout.place[b, 1], w, h, turns)
    return turns, layout.place[a, 0] + x - x0 - x1, layout.place[a, 1] + y - y0 - y1


@njit(cache=True, nogil=True)
def moved(g, layout, i, turns, mx, my):  # type: ignore[no-untyped-def]
    """(quarter turns, x, y) of piece i after a movement of its cluster."""
    w, h = extent(g, i, layout.turns[i])
    x, y = rotated(layout.place[i, 0], layout.place[i, 1], w, h, turns)
    return (layout.turns[i] + turns) % 4, x + mx, y + my


@njit(cache=True, nogil=True)
def near(g, a, ta, b, tb, dx, dy):  # type: ignore[no-untyped-def]
    """Whether the rasters of two pieces touch or overlap."""
    wa, ha = extent(g, a, ta)
    wb, hb = extent(g, b, tb)
    r = 1 + g.slack
    return dx <= wa + r and dy <= ha + r and -dx <= wb + r and -dy <= hb + r


@njit(cache=True, nogil=True)
def support(g, a, ta, b, tb, dx, dy, skip_a, skip_b, base, z):  # type: ignore[no-untyped-def]
    """(log odds, length) of all contacts of two placed pieces but that of the sides skip_a and skip_b."""
    total, length = 0.0, 0
    for e in range(g.first[a], g.first[a + 1]):
        for f in range(g.first[b], g.first[b + 1]):
            if e == skip_a and f == skip_b:
                continue
            n, i, j = touching(g, e, ta, f, tb, dx, dy)
            if n > 0:
                total += min(max(side_odds(g, e, i, f, j, n, z) - base, BAD), GOOD)
                length += n
    return total, length


@njit(cache=True, nogil=True)
def parted(g, forbidden, a, ta, b, tb, dx, dy):  # type: ignore[no-untyped-def]
    """Whether two placed pieces stand in a forbidden relation: rows (p, q, turn, dx, dy) in the frame of p as read."""
    for k in range(len(forbidden)):
        p, q, turn, x, y = forbidden[k]
        if p == a and q == b and _stands(g, a, ta, b, tb, dx, dy, turn, x, y):
            return True
        if p == b and q == a and _stands(g, b, tb, a, ta, -dx, -dy, turn, x, y):
            return True
    return False


@njit(cache=True, nogil=True)
def _stands(g, a, ta, b, tb, dx, dy, turn, x, y):  # type: ignore[no-untyped-def]
    if (tb - ta) % 4 != turn:
        return False
    wa, ha = extent(g, a, ta)
    wb, hb = extent(g, b, tb)
    x0, y0 = rotated(0, 0, wa, ha, -ta)
    x1, y1 = rotated(dx, dy, wb, hb, -ta)
    return abs(x1 - x0 - x) <= 1 and abs(y1 - y0 - y) <= 1


@njit(cache=True, nogil=True)
def side_by_side(g, layout, members, others, turns, mx, my, sa, sb, forbidden, base, z):  # type: ignore[no-untyped-def]
    """(possible, log odds) of `others` moved beside `members`: no overlap, nothing forbidden; the contacts' sum.

    The contact of the sides sa and sb is left out: it is counted elsewhere, with its competition.
    """
    total = 0.0
    for look in range(2):  # first whether it is possible, then what it is worth
        for q in range(len(others)):
            b = others[q]
            tb, bx, by = moved(g, layout, b, turns, mx, my)
            for p in range(len(members)):
                a = members[p]
                ta, dx, dy = layout.turns[a], bx - layout.place[a, 0], by - layout.place[a, 1]
                if not near(g, a, ta, b, tb, dx, dy):
                    continue
                if look:
                    total += support(g, a, ta, b, tb, dx, dy, sa, sb, base, z)[0]
                elif overlapping(g, a, ta, b, tb, dx, dy) or parted(g, forbidden, a, ta, b, tb, dx, dy):
                    return False, 0.0
    return True, total


@njit(cache=True, nogil=True)
def bounds(g, layout, members, start, stop, turns, mx, my):  # type: ignore[no-untyped-def]
    """The box (left, top, right, bottom) around pieces after a movement."""
    left, top, right, bottom = 1 << 40, 1 << 40, -(1 << 40), -(1 << 40)
    for p in range(start, stop):
        t, x, y = moved(g, layout, members[p], turns, mx, my)
        w, h = extent(g, members[p], t)
        left, top, right, bottom = min(left, x), min(top, y), max(right, x + w), max(bottom, y + h)
    return left, top, right, bottom


@njit(cache=True, nogil=True)
def merge(g, layout, trials, forbidden, fixed, main, width, height, either_way, least, base):  # type: ignore[no-untyped-def]
    """Merge clusters in place, the highest sum of log odds first, while it is at least `least`; the merged trials.

    `fixed` is a piece whose cluster may not move and stays within (0, 0)..(width, height), or -1; no other cluster
    outgrows width × height (0: unknown), `either_way` also height × width. Where `main` (n,) bool names clusters, only
    merges of one of them with another cluster are made.
    """
    main, only = main.copy(), main.any()
    room = int(2 * g.slack)  # what rough outlines may add up to
    n, c = len(layout.cluster), len(trials.side)
    member = np.argsort(layout.cluster, kind="mergesort")  # the pieces of a cluster in a row
    start, stop = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64)
    for p in range(n):
        name = layout.cluster[member[p]]
        if p == 0 or layout.cluster[member[p - 1]] != name:
            start[name] = p
        stop[name] = p + 1
    lists = [member[start[k] : stop[k]].copy() for k in range(n)]
    home = layout.cluster[fixed] if fixed >= 0 else -1
    piece = np.empty((c, 2), dtype=np.int64)
    for k in range(c):
        for q in range(2):
            piece[k, q] = np.searchsorted(g.first, trials.side[k, q], side="right") - 1
    score, alive = trials.odds.copy(), np.ones(c, dtype=np.bool_)
    z = np.empty(16)
    for k in range(c):
        a, b = layout.cluster[piece[k, 0]], layout.cluster[piece[k, 1]]
        alive[k] = a != b
        if alive[k]:
            alive[k], more = _judged(g, layout, trials, piece, k, lists[a], lists[b], forbidden, base, z)
            score[k] += more
    chosen: list[int] = []
    while True:
        best = -1
        for k in range(c):
            if alive[k] and score[k] >= least and (best < 0 or score[k] > score[best]):
                if only and main[layout.cluster[piece[k, 0]]] == main[layout.cluster[piece[k, 1]]]:
                    continue
                best = k
        if best < 0:
            return chosen
        a, b = piece[best, 0], piece[best, 1]
        A, B = layout.cluster[a], layout.cluster[b]
        turns, mx, my = movement(g, layout, a, b, trials.turn[best], trials.offset[best, 0], trials.offset[best, 1])
        l0, t0, r0, b0 = bounds(g, layout, lists[A], 0, len(lists[A]), 0, 0, 0)
        l1, t1, r1, b1 = bounds(g, layout, lists[B], 0, len(lists[B]), turns, mx, my)
        w, h = max(r0, r1) - min(l0, l1), max(b0, b1) - min(t0, t1)
        alive[best] = False
        if width > 0 and not (
            (w <= width + room and h <= height + room) or (either_way and w <= height + room and h <= width + room)
        ):
            continue
        back = home != A and (home == B or len(lists[B]) > len(lists[A]))  # A is moved instead
        if back:
            turns, mx, my = _inverse(turns, mx, my)
            A, B = B, A
        if home == A:
            l1, t1, r1, b1 = bounds(g, layout, lists[B], 0, len(lists[B]), turns, mx, my)
            if min(l1, t1) < -room or (width > 0 and (r1 > width + room or b1 > height + room)):
                continue
        chosen.append(best)
        main[A] = main[A] or main[B]
        old, new = lists[A], lists[B]
        for i in new:
            t, x, y = moved(g, layout, i, turns, mx, my)
            layout.turns[i], layout.place[i, 0], layout.place[i, 1] = t, x, y
        for i in new:
            layout.cluster[i] = A
        lists[A] = np.concatenate((old, new))
        lists[B] = new[:0]
        was_new = np.zeros(n, dtype=np.bool_)
        was_new[new] = True
        for k in range(c):
            if not alive[k]:
                continue
            p, q = piece[k, 0], piece[k, 1]
            cp, cq = layout.cluster[p], layout.cluster[q]
            if cp != A and cq != A:
                continue
            if cp == cq:
                alive[k] = False
                continue
            if cp == A:
                added = old if was_new[p] else new
                alive[k], more = _judged(g, layout, trials, piece, k, added, lists[cq], forbidden, base, z)
            else:
                added = old if was_new[q] else new
                alive[k], more = _judged(g, layout, trials, piece, k, lists[cp], added, forbidden, base, z)
            score[k] += more


@njit(cache=True, nogil=True)
def held(g, layout, trials, kept):  # type: ignore[no-untyped-def]
    """Which trials a layout keeps, written into `kept` (c,) bool: both pieces stand to each other as they say."""
    for k in range(len(kept)):
        a = np.searchsorted(g.first, trials.side[k, 0], side="right") - 1
        b = np.searchsorted(g.first, trials.side[k, 1], side="right") - 1
        kept[k] = False
        if layout.cluster[a] == layout.cluster[b]:
            turns, x, y = movement(g, layout, a, b, trials.turn[k], trials.offset[k, 0], trials.offset[k, 1])
            kept[k] = turns == 0 and abs(x) <= g.slack and abs(y) <= g.slack


@njit(cache=True, nogil=True)
def _inverse(turns, mx, my):  # type: ignore[no-untyped-def]
    """The movement that undoes another."""
    x, y = rotated(-mx, -my, 0, 0, -turns)
    return (-turns) % 4, x, y


@njit(cache=True, nogil=True)
def _judged(g, layout, trials, piece, k, members, others, forbidden, base, z):  # type: ignore[no-untyped-def]
    """(possible, log odds) of the contacts that trial k makes between some pieces of its two clusters."""
    a, b = piece[k, 0], piece[k, 1]
    turns, mx, my = movement(g, layout, a, b, trials.turn[k], trials.offset[k, 0], trials.offset[k, 1])
    return side_by_side(
        g, layout, members, others, turns, mx, my, trials.side[k, 0], trials.side[k, 1], forbidden, base, z
    )  # fmt: skip


@njit(cache=True, nogil=True)
def contact_total(g, layout, base):  # type: ignore[no-untyped-def]
    """(sum of log odds, pixels) of all contacts of pieces of the same clusters."""
    total, length = 0.0, 0
    z = np.empty(16)
    order = np.argsort(layout.cluster, kind="mergesort")
    for p in range(len(order)):
        for q in range(p + 1, len(order)):
            a, b = order[p], order[q]
            if layout.cluster[a] != layout.cluster[b]:
                break
            dx, dy = layout.place[b, 0] - layout.place[a, 0], layout.place[b, 1] - layout.place[a, 1]
            if near(g, a, layout.turns[a], b, layout.turns[b], dx, dy):
                value, n = support(g, a, layout.turns[a], b, layout.turns[b], dx, dy, -1, -1, base, z)
                total += value
                length += n
    return total, length
