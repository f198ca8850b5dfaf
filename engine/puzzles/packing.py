"""The last pieces of a picture of known size, packed without a gap.

Where pieces are all alike (a white sky), borders say nothing, but shapes do: nothing may be left open. The topmost,
then leftmost open pixel belongs to a piece whose own topmost, leftmost pixel lies there; the pieces are tried in the
order of what their contacts say, and taken back where they lead nowhere.
"""

from collections.abc import Iterator

import numpy as np
from numba import njit

from .clusters import Layout, extent, near, parted, support
from .contacts import FEATURES, Ground, _belongs
from .hypotheses import room_around

BUDGET, SHARE = 120_000, 2_500  # places looked at altogether, and from one side at first


def packed(
    ground: Ground, start: Layout, layout: Layout, core: int, forbidden: np.ndarray, size: tuple[int, int], *,
    fixed: bool, turned: bool, base: float, most: int,
) -> Layout | None:  # fmt: skip
    """A layout that fills the picture of (w, h) pixels around the cluster named `core`, or None if none is found.

    The cluster is tried in the corners of the room that it has; where it is `fixed` it stays where it is. The rest is
    packed from each of the four sides, beginning with the one that the cluster is nearest to: there its outline leaves
    the least choice. At most `most` places of pieces are looked at from each side.
    """
    inside = layout.cluster == core
    left = np.flatnonzero(~inside)
    if len(np.unique(start.cluster[left])) < len(left):
        return None  # what people have locked is not taken apart
    for moved, w, h in _shifted(ground, layout, inside, size, fixed, turned):
        middle = (moved.place[inside].mean(axis=0) + ground.size[inside].mean(axis=0) / 2) / (w, h) - 0.5
        nearness = np.array([middle[1], middle[0], -middle[1], -middle[0]])  # what comes to the top after 0..3 turns
        for sweep in np.argsort(nearness, kind="stable"):
            result = rotated_layout(ground, moved, int(sweep), (w, h))
            room = (h, w) if sweep % 2 else (w, h)
            ways = np.arange(4) if turned else np.array([sweep])
            if _pack(ground, result, inside.copy(), left, forbidden, *room, ways, base, most):
                result.cluster[:] = core
                return rotated_layout(ground, result, -int(sweep), room)
    return None


def _shifted(
    ground: Ground, layout: Layout, inside: np.ndarray, size: tuple[int, int], fixed: bool, turned: bool
) -> Iterator[tuple[Layout, int, int]]:
    """Layouts with the cluster in each corner of the room that it has, and the sizes of the picture."""
    extents = np.where((layout.turns % 2 == 1)[:, None], ground.size[:, ::-1], ground.size)
    low, high = layout.place[inside].min(axis=0), (layout.place + extents)[inside].max(axis=0)
    for w, h in sorted({size, size[::-1]} if turned and not fixed else {size}, reverse=size[0] > size[1]):
        if (high - low > (w, h)).any():
            continue
        for x, y in [(0, 0)] if fixed else room_around(ground, layout, inside, (w, h)):
            result = layout.copy()
            result.place[inside] += (x, y)
            yield result, w, h


def rotated_layout(ground: Ground, layout: Layout, turns: int, size: tuple[int, int]) -> Layout:
    """A layout in a picture of (w, h) pixels after clockwise quarter turns of the whole."""
    place, now = layout.place, layout.turns
    for _ in range(turns % 4):
        height = np.where(now % 2 == 1, ground.size[:, 0], ground.size[:, 1])
        place, now = np.column_stack([size[1] - place[:, 1] - height, place[:, 0]]), (now + 1) % 4
        size = size[::-1]
    return Layout(layout.cluster.copy(), np.ascontiguousarray(place), now)


@njit(cache=True, nogil=True)
def _paint(g, canvas, i, turns, x, y, value):  # type: ignore[no-untyped-def]
    w, h = extent(g, i, turns)
    for v in range(h):
        for u in range(w):
            if _belongs(g, i, turns, u, v):
                canvas[y + v, x + u] = value


@njit(cache=True, nogil=True)
def _open(g, canvas, i, turns, x, y):  # type: ignore[no-untyped-def]
    """Whether piece i may lie at (x, y): within the picture, on open pixels alone."""
    w, h = extent(g, i, turns)
    if x < 0 or y < 0 or x + w > canvas.shape[1] or y + h > canvas.shape[0]:
        return False
    for v in range(h):
        for u in range(w):
            if canvas[y + v, x + u] and _belongs(g, i, turns, u, v):
                return False
    return True


@njit(cache=True, nogil=True)
def _fits_row(g, left, used, run, chosen, width, ways):  # type: ignore[no-untyped-def]
    """Whether widths of unused pieces can sum to what is left of a run of open pixels beside the chosen piece."""
    reached = np.zeros(run + 1, dtype=np.bool_)
    if width > run:
        return False
    reached[width] = True
    for k in range(len(left)):
        if used[k] or k == chosen:
            continue
        for sum_ in range(run, width - 1, -1):
            if reached[sum_]:
                for t in ways[:2]:
                    wide = g.size[left[k], t % 2]
                    if sum_ + wide <= run:
                        reached[sum_ + wide] = True
    return reached[run]


@njit(cache=True, nogil=True)
def _worth(g, layout, inside, i, turns, x, y, forbidden, base, z):  # type: ignore[no-untyped-def]
    """What the contacts of piece i at (x, y) say, or minus infinity where one is forbidden."""
    total = 0.0
    for b in range(len(inside)):
        dx, dy = layout.place[b, 0] - x, layout.place[b, 1] - y
        if not inside[b] or not near(g, i, turns, b, layout.turns[b], dx, dy):
            continue
        if parted(g, forbidden, i, turns, b, layout.turns[b], dx, dy):
            return -np.inf
        total += support(g, i, turns, b, layout.turns[b], dx, dy, -1, -1, base, z)[0]
    return total


@njit(cache=True, nogil=True)
def _pack(g, layout, inside, left, forbidden, width, height, ways, base, most):  # type: ignore[no-untyped-def]
    """Fill the picture with the pieces `left`, in place, each in one of the turns `ways`; whether that succeeded."""
    canvas = np.zeros((height, width), dtype=np.uint8)
    whole = True
    for i in range(len(inside)):
        if inside[i]:
            if not _open(g, canvas, i, layout.turns[i], layout.place[i, 0], layout.place[i, 1]):
                return False
            _paint(g, canvas, i, layout.turns[i], layout.place[i, 0], layout.place[i, 1], 1)
        else:
            whole = whole and g.full[i]
    n = len(left)
    used, z = np.zeros(n, dtype=np.bool_), np.empty(FEATURES)
    state = np.zeros((n, n * len(ways), 4))  # of each depth: worth, index, turns, x; best last
    count, taken = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64)
    tops = np.zeros(n, dtype=np.int64)
    depth, looked, fresh = 0, 0, True
    while depth < n:
        if fresh:
            top = tops[depth - 1] if depth else 0
            x = y = -1
            for v in range(top, height):
                for u in range(width):
                    if not canvas[v, u]:
                        x, y = u, v
                        break
                if y >= 0:
                    break
            tops[depth], count[depth] = y, 0
            run = 0
            while y >= 0 and x + run < width and not canvas[y, x + run]:
                run += 1
            for k in range(n):
                if used[k] or y < 0:
                    continue
                for t in ways:
                    looked += 1
                    wide, _ = extent(g, left[k], t)
                    first = 0
                    while not _belongs(g, left[k], t, first, 0):
                        first += 1
                    if whole and not _fits_row(g, left, used, run, k, wide, ways):
                        continue
                    if not _open(g, canvas, left[k], t, x - first, y):
                        continue
                    worth = _worth(g, layout, inside, left[k], t, x - first, y, forbidden, base, z)
                    if worth > -np.inf:
                        slot = state[depth, count[depth]]
                        slot[0], slot[1], slot[2], slot[3] = worth, k, t, x - first
                        count[depth] += 1
            order = np.argsort(state[depth, : count[depth], 0], kind="mergesort")
            state[depth, : count[depth]] = state[depth, : count[depth]][order]
        if count[depth] == 0 or looked >= most:
            if depth == 0 or looked >= most:
                return False
            depth -= 1
            k = taken[depth]
            i = left[k]
            _paint(g, canvas, i, layout.turns[i], layout.place[i, 0], layout.place[i, 1], 0)
            used[k], inside[i], fresh = False, False, False
            continue
        count[depth] -= 1
        slot = state[depth, count[depth]]
        k, t, x = int(slot[1]), int(slot[2]), int(slot[3])
        i = left[k]
        layout.turns[i], layout.place[i, 0], layout.place[i, 1] = t, x, tops[depth]
        _paint(g, canvas, i, t, x, tops[depth], 1)
        used[k], inside[i], taken[depth] = True, True, k
        depth, fresh = depth + 1, True
    return True
