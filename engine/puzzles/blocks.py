"""Blocks of square pieces that hang together on a grid: joined one candidate at a time, never overlapping.

A block is a set of pieces with cells (x, y) and quarter turns in a frame of its own. Two blocks are merged by a join
of two of their sides; the smaller one is turned and moved, after a look whether a cell is taken or the block would
outgrow the frame (Gallagher 2012).
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numba import njit

_SHIFT, _HALF = 1 << 20, 1 << 19
STEP_X = np.array([0, 1, 0, -1])
STEP_Y = np.array([-1, 0, 1, 0])


class Blocks(NamedTuple):
    """`block` (n,) int64: the block of each piece, named by one of its pieces; `x`, `y`, `turns` (n,) int64 within it."""

    block: np.ndarray
    x: np.ndarray
    y: np.ndarray
    turns: np.ndarray


def single_pieces(n: int) -> Blocks:
    """Every piece a block of its own."""
    zero = np.zeros(n, dtype=np.int64)
    return Blocks(np.arange(n), zero, zero, zero)


@dataclass(frozen=True, slots=True, eq=False)
class Rules:
    """What blocks must keep to.

    `frame` (columns, rows) that no block may outgrow, lying or standing where `either_way`; `forbidden` (f, 2) int64
    pairs of sides that must not touch; `anchored`: pieces whose block has its place in the frame already, so that it
    must stay within columns 0..w-1 and rows 0..h-1 of its own cells; `apart`: pieces of blocks that must not be merged
    with each other (several pictures).
    """

    frame: tuple[int, int] | None = None
    either_way: bool = False
    forbidden: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    anchored: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    apart: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))


def grow_blocks(
    pairs: np.ndarray, order: np.ndarray, start: Blocks, rules: Rules, *, once: bool = False
) -> tuple[Blocks, np.ndarray]:
    """Join blocks by candidates `pairs` (c, 2) of sides 4 i + side in the given `order` of rows, as in Kruskal's tree.

    A candidate is taken if its pieces lie in different blocks that may be merged by the rules without an overlap, or in
    one block where it holds already. With `once` no block of `start` is moved twice. Returns the blocks and which rows
    of `pairs` were taken, (c,) bool.
    """
    block, x, y, turns = (np.array(a, dtype=np.int64) for a in start)
    width, height = rules.frame if rules.frame is not None else (0, 0)
    taken = np.zeros(len(pairs), dtype=bool)
    anchored, main = np.zeros(len(block), dtype=bool), np.zeros(len(block), dtype=bool)
    if rules.frame is not None:
        anchored[block[rules.anchored]] = True
    main[block[rules.apart]] = True
    _grow(np.ascontiguousarray(pairs), np.asarray(order, dtype=np.int64), block, x, y, turns, width, height,
          rules.either_way, once, np.ascontiguousarray(rules.forbidden), anchored, main, taken)  # fmt: skip
    return Blocks(block, x, y, turns), taken


@njit(cache=True, nogil=True)
def slot_of(keys, key):  # type: ignore[no-untyped-def]
    """Where the key is, or belongs, in a table with open addressing; free slots hold -1."""
    mask = len(keys) - 1
    place = (key * 0x9E3779B1 ^ (key >> 21)) & mask
    while keys[place] != -1 and keys[place] != key:
        place = (place + 1) & mask
    return place


@njit(cache=True, nogil=True)
def cell_key(block, x, y):  # type: ignore[no-untyped-def]
    """One number for a cell of a block."""
    return (block * _SHIFT + (x + _HALF)) * _SHIFT + y + _HALF


@njit(cache=True, nogil=True)
def turn_cell(x, y, k):  # type: ignore[no-untyped-def]
    """A cell after k clockwise quarter turns about the origin, y down."""
    if k == 0:
        return x, y
    if k == 1:
        return -y, x
    if k == 2:
        return -x, -y
    return y, -x


@njit(cache=True, nogil=True)
def _chains(block, x, y):  # type: ignore[no-untyped-def]
    """Size, bounding box, next member and last member of each block; a chain starts at the piece that names it."""
    n = len(block)
    size = np.zeros(n, dtype=np.int64)
    box = np.empty((n, 4), dtype=np.int64)
    after, last = np.full(n, -1), np.arange(n)
    for i in range(n):
        b = block[i]
        if size[b] == 0:
            box[b, 0], box[b, 1], box[b, 2], box[b, 3] = x[i], y[i], x[i], y[i]
        _widen(box, b, x[i], y[i], x[i], y[i])
        size[b] += 1
        if i != b:
            if last[b] == b:
                last[b] = i
            after[i], after[b] = after[b], i
    return size, box, after, last


@njit(cache=True, nogil=True)
def _widen(box, b, x0, y0, x1, y1):  # type: ignore[no-untyped-def]
    box[b, 0], box[b, 1] = min(box[b, 0], x0), min(box[b, 1], y0)
    box[b, 2], box[b, 3] = max(box[b, 2], x1), max(box[b, 3], y1)


@njit(cache=True, nogil=True)
def _moved_box(box, q, k, dx, dy):  # type: ignore[no-untyped-def]
    ax, ay = turn_cell(box[q, 0], box[q, 1], k)
    bx, by = turn_cell(box[q, 2], box[q, 3], k)
    return min(ax, bx) + dx, min(ay, by) + dy, max(ax, bx) + dx, max(ay, by) + dy


@njit(cache=True, nogil=True)
def _grow(pairs, order, block, x, y, turns, width, height, either_way, once, forbidden, anchored, main, taken):  # type: ignore[no-untyped-def]
    n = len(block)
    capacity = 16
    while capacity < 4 * n * (2 + int(np.log2(n + 2))):
        capacity *= 2
    keys = np.full(capacity, -1, dtype=np.int64)
    size, box, after, last = _chains(block, x, y)
    for i in range(n):
        key = cell_key(block[i], x[i], y[i])
        keys[slot_of(keys, key)] = key
        if anchored[block[i]]:
            _widen(box, block[i], 0, 0, width - 1, height - 1)
    origin, moved = block.copy(), np.zeros(n, dtype=np.bool_)
    for a in order:
        i, s, j, t = pairs[a, 0] // 4, pairs[a, 0] % 4, pairs[a, 1] // 4, pairs[a, 1] % 4
        p, q = block[i], block[j]
        if anchored[q] or (size[p] < size[q] and not anchored[p]):  # what has its place in the frame is not moved
            i, s, j, t = j, t, i, s
            p, q = q, p
        d = (s + turns[i]) % 4
        goal_x, goal_y, goal_turns = x[i] + STEP_X[d], y[i] + STEP_Y[d], (d + 2 - t) % 4
        if p == q:
            taken[a] = x[j] == goal_x and y[j] == goal_y and turns[j] == goal_turns
            continue
        if (main[p] and main[q]) or (once and (moved[origin[i]] or moved[origin[j]])):
            continue
        k = (goal_turns - turns[j]) % 4
        jx, jy = turn_cell(x[j], y[j], k)
        dx, dy = goal_x - jx, goal_y - jy
        if not _fits(box, p, q, k, dx, dy, width, height, either_way and not anchored[p]):
            continue
        if _overlaps(keys, p, q, k, dx, dy, x, y, after):
            continue
        if _touches(forbidden, block, x, y, turns, p, q, k, dx, dy):
            continue
        taken[a] = True
        moved[origin[j]] = True
        main[p], anchored[p] = main[p] or main[q], anchored[p] or anchored[q]
        x0, y0, x1, y1 = _moved_box(box, q, k, dx, dy)
        _widen(box, p, x0, y0, x1, y1)
        m = q
        while m >= 0:
            mx, my = turn_cell(x[m], y[m], k)
            x[m], y[m], turns[m], block[m] = mx + dx, my + dy, (turns[m] + k) % 4, p
            key = cell_key(p, x[m], y[m])
            keys[slot_of(keys, key)] = key
            m = after[m]
        after[last[p]] = q
        last[p] = last[q]
        size[p] += size[q]


@njit(cache=True, nogil=True)
def _fits(box, p, q, k, dx, dy, width, height, either_way):  # type: ignore[no-untyped-def]
    if width == 0:
        return True
    x0, y0, x1, y1 = _moved_box(box, q, k, dx, dy)
    w = max(box[p, 2], x1) - min(box[p, 0], x0) + 1
    h = max(box[p, 3], y1) - min(box[p, 1], y0) + 1
    return (w <= width and h <= height) or (either_way and w <= height and h <= width)


@njit(cache=True, nogil=True)
def _overlaps(keys, p, q, k, dx, dy, x, y, after):  # type: ignore[no-untyped-def]
    m = q
    while m >= 0:
        mx, my = turn_cell(x[m], y[m], k)
        key = cell_key(p, mx + dx, my + dy)
        if keys[slot_of(keys, key)] == key:
            return True
        m = after[m]
    return False


@njit(cache=True, nogil=True)
def _touches(forbidden, block, x, y, turns, p, q, k, dx, dy):  # type: ignore[no-untyped-def]
    """Whether merging would bring a forbidden pair of sides together."""
    for f in range(len(forbidden)):
        i, s, j, t = forbidden[f, 0] // 4, forbidden[f, 0] % 4, forbidden[f, 1] // 4, forbidden[f, 1] % 4
        if block[i] == q and block[j] == p:
            i, s, j, t = j, t, i, s
        if block[i] == p and block[j] == q:
            d = (s + turns[i]) % 4
            jx, jy = turn_cell(x[j], y[j], k)
            beside = x[i] + STEP_X[d] == jx + dx and y[i] + STEP_Y[d] == jy + dy
            if beside and (turns[j] + k + t) % 4 == (d + 2) % 4:
                return True
    return False
