"""What the puzzle canvas draws and what a pointer hits, as plain arrays: views, joins, colours, order of doubt."""

import heapq
from collections.abc import Iterable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from engine.puzzles.solution import Joins

from ..palette import Theme, rgb
from .puzzle_layout import Box, Layout, outlines

Key = tuple[int, int, int, int]
"""Piece, side, piece, side of a join; the smaller piece first"""
BINS = 8
CLOSEST, FARTHEST = 64.0, 0.01  # screen pixels for one pixel of a piece


class View(NamedTuple):
    """How the canvas is seen: screen = scale · canvas + (x, y)."""

    scale: float = 1.0
    x: float = 0.0
    y: float = 0.0

    def to_screen(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 2) of the canvas on the screen."""
        return np.asarray(points) * self.scale + (self.x, self.y)

    def to_canvas(self, x: float, y: float) -> tuple[float, float]:
        """The point of the canvas below a point of the screen."""
        return (x - self.x) / self.scale, (y - self.y) / self.scale

    def zoomed(self, factor: float, x: float, y: float) -> "View":
        """Closer by a factor, the point below (x, y) staying there."""
        scale = float(np.clip(self.scale * factor, FARTHEST, CLOSEST))
        factor = scale / self.scale
        return View(scale, x + (self.x - x) * factor, y + (self.y - y) * factor)

    def moved(self, dx: float, dy: float) -> "View":
        """Shifted on the screen."""
        return View(self.scale, self.x + dx, self.y + dy)


def fitted(box: Box, width: float, height: float, margin: float = 24.0) -> View:
    """The view that shows a box as large as fits, centred."""
    scale = min((width - 2 * margin) / max(box.w, 1), (height - 2 * margin) / max(box.h, 1))
    scale = float(np.clip(scale, FARTHEST, CLOSEST))
    return View(scale, width / 2 - scale * (box.x + box.w / 2), height / 2 - scale * (box.y + box.h / 2))


def kept(view: View, box: Box, width: float, height: float, margin: float = 32.0) -> View:
    """The same view shifted so that a box that fits is seen whole, and no more paper than a margin beside one that does not."""
    shift = []
    for start, long, room in ((view.scale * box.x + view.x, box.w * view.scale, width),
                              (view.scale * box.y + view.y, box.h * view.scale, height)):  # fmt: skip
        if long + 2 * margin <= room:
            low, high = margin, room - margin - long
        else:
            low, high = room - margin - long, margin
        shift.append(float(np.clip(start, low, high)) - start)
    return view.moved(*shift)


def join_key(sides: Iterable[int]) -> Key:
    """The name of a join, the same from both of its sides."""
    a, side_a, b, side_b = (int(k) for k in sides)
    return (a, side_a, b, side_b) if a <= b else (b, side_b, a, side_a)


@lru_cache(maxsize=8)
def join_rows(joins: Joins) -> dict[Key, int]:
    """The row of each join by its name; not to be changed."""
    return {join_key(row): k for k, row in enumerate(joins.sides.tolist())}


def join_keys(joins: Joins) -> list[Key]:
    """The names of all joins, in their order."""
    return list(join_rows(joins))


def edges(layout: Layout, corners: np.ndarray, piece: np.ndarray, side: np.ndarray) -> np.ndarray:
    """The sides (j, 2, 2) of pieces on the canvas, from their first to their second corner; `corners` are the layout's."""
    first = outlines(layout.puzzle).first
    count = first[piece + 1] - first[piece]
    return np.stack([corners[first[piece] + side % count], corners[first[piece] + (side + 1) % count]], axis=1)


@lru_cache(maxsize=4)
def seams(layout: Layout, joins: Joins) -> np.ndarray:
    """Where the two sides of each join meet on the canvas: segments (j, 2, 2) float64."""
    corners = layout.corners()
    return meetings(*(edges(layout, corners, joins.sides[:, k], joins.sides[:, k + 1]) for k in (0, 2)))


def meetings(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The parts of sides a (j, 2, 2) that face sides b (j, 2, 2), halfway across the gap between them, (j, 2, 2).

    Whole sides a where they do not face each other.
    """
    along = a[:, 1] - a[:, 0]
    length = np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    unit = along / length
    normal = np.column_stack([-unit[:, 1], unit[:, 0]])
    t = np.einsum("jkd,jd->jk", b - a[:, :1], unit)
    low, high = np.maximum(t.min(axis=1), 0), np.minimum(t.max(axis=1), length[:, 0])
    apart = high - low < 1e-6
    low, high = np.where(apart, 0, low), np.where(apart, length[:, 0], high)
    across = np.where(apart, 0, np.einsum("jkd,jd->jk", b - a[:, :1], normal).mean(axis=1) / 2)
    start = a[:, 0] + across[:, None] * normal
    return np.stack([start + low[:, None] * unit, start + high[:, None] * unit], axis=1)


def shown_joins(joins: Joins, below: float, piece: int, always: np.ndarray) -> np.ndarray:
    """Which joins are drawn, (j,) bool: the doubtful ones, those of the chosen piece, and those `always` (j,) bool."""
    doubtful = np.ones(len(joins), bool) if below >= 1 else joins.confidence < below
    return doubtful | always | (joins.sides[:, [0, 2]] == piece).any(axis=1)


def by_doubt(joins: Joins, settled: np.ndarray) -> np.ndarray:
    """Rows of the joins, the least certain first; those `settled` (j,) bool are left out."""
    order = np.argsort(joins.confidence, kind="stable")
    return order[~settled[order]]


def next_in(order: np.ndarray, row: int, by: int) -> int:
    """The row after (or before) another in an order, around its ends; -1 in an empty order."""
    if not len(order):
        return -1
    here = np.flatnonzero(order == row)
    at = int(here[0]) + by if len(here) else (0 if by > 0 else len(order) - 1)
    return int(order[at % len(order)])


def bins(confidence: np.ndarray) -> np.ndarray:
    """Colour bin (j,) 0 (doubtful) .. BINS-1 (certain); fine where doubt begins, as most joins are nearly certain."""
    return np.minimum((np.clip(confidence, 0, 1) ** 2 * BINS).astype(np.int64), BINS - 1)


def bin_colours(theme: Theme) -> np.ndarray:
    """The colours (BINS, 3) uint8 from doubtful (glowing amber) to certain (calm green)."""
    return ramp(np.linspace(0, 1, BINS), theme)


def ramp(share: np.ndarray, theme: Theme) -> np.ndarray:
    """Colours (k, 3) uint8 for shares in [0, 1] of the way from doubtful to certain."""
    stops = np.array([rgb("#FFB000"), rgb("#E6CF6B"), rgb(theme.accent)], float)
    share = np.clip(share, 0, 1)
    return np.column_stack([np.interp(share, [0, 0.55, 1], stops[:, c]) for c in range(3)]).round().astype(np.uint8)


def widths(side: float) -> np.ndarray:
    """Line widths (BINS,) in screen pixels: doubtful joins thick, certain ones thin; less where a `side` is short."""
    return np.maximum(1, np.round(np.linspace(4, 1, BINS) * np.clip(side / 32, 0.3, 1))).astype(np.int64)


def hit_join(segments: np.ndarray, x: float, y: float, radius: float) -> int:
    """The segment (j, 2, 2) nearest to a point within a radius, or -1."""
    if not len(segments):
        return -1
    start, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    offset = np.array([x, y]) - start
    t = np.clip((offset * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-12), 0, 1)
    away = ((offset - t[:, None] * along) ** 2).sum(axis=1)
    best = int(away.argmin())
    return best if away[best] <= radius**2 else -1


def hit_piece(layout: Layout, x: float, y: float) -> int:
    """The piece whose pixels lie below a point of the canvas, the one drawn last if several do, or -1."""
    at = np.floor([x, y]).astype(np.int64) - layout.position
    over = np.flatnonzero(((at >= 0) & (at < layout.size)).all(axis=1))
    for piece in sorted(over.tolist(), key=lambda k: (not layout.placed[k], -k)):
        u, v = at[piece]
        if np.rot90(layout.puzzle.pieces[piece].mask, -int(layout.turns[piece]))[v, u]:
            return int(piece)
    return -1


def in_view(segments: np.ndarray, width: float, height: float, margin: float = 4.0) -> np.ndarray:
    """Which segments (j, 2, 2) may be seen in a window, (j,) bool, by their boxes."""
    low, high = segments.min(axis=1), segments.max(axis=1)
    return ((high >= -margin) & (low <= (width + margin, height + margin))).all(axis=1)


def growth_order(joins: Joins, placed: np.ndarray) -> np.ndarray:
    """The placed pieces in the order in which certain joins reach them, (p,) int64: how a picture grows.

    From the most certain join on, each piece follows along the most certain join to those already there; parts
    without any join to them begin anew. `placed` (n,) bool.
    """
    a, b, c = joins.sides[:, 0].tolist(), joins.sides[:, 2].tolist(), joins.confidence.tolist()
    beside: dict[int, list[tuple[float, int]]] = {}
    for i, j, sure in zip(a, b, c, strict=True):
        beside.setdefault(i, []).append((-sure, j))
        beside.setdefault(j, []).append((-sure, i))
    seen = ~placed
    best = np.argsort(-joins.confidence, kind="stable")
    starts = [*joins.sides[best, 0].tolist(), *np.flatnonzero(placed).tolist()]
    order: list[int] = []
    for start in starts:
        if seen[start]:
            continue
        heap = [(0.0, start)]
        while heap:
            _, piece = heapq.heappop(heap)
            if seen[piece]:
                continue
            seen[piece] = True
            order.append(piece)
            for step in beside.get(piece, ()):
                if not seen[step[1]]:
                    heapq.heappush(heap, step)
    return np.array(order, np.int64)
