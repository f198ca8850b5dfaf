"""Where every piece of a puzzle stands on the canvas: the assembled pictures and, beside them, the tray."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from engine.puzzles.pieces import Puzzle
from engine.puzzles.solution import UNPLACED, PuzzleSolution


class Box(NamedTuple):
    """An upright rectangle in pixels of the pieces."""

    x: float
    y: float
    w: float
    h: float

    def united(self, other: "Box") -> "Box":
        """The smallest box around both."""
        x, y = min(self.x, other.x), min(self.y, other.y)
        return Box(x, y, max(self.x + self.w, other.x + other.w) - x, max(self.y + self.h, other.y + other.h) - y)

    def holds(self, x: float, y: float) -> bool:
        """Whether a point lies inside."""
        return self.x <= x < self.x + self.w and self.y <= y < self.y + self.h


class Outlines(NamedTuple):
    """The polygons of all n pieces as they were read: `corners` (v, 2), those of piece i from `first[i]` to `first[i+1]`.

    `owner` (v,) says whose a corner is, `size` (n, 2) are the widths and heights of the rasters.
    """

    corners: np.ndarray
    first: np.ndarray
    owner: np.ndarray
    size: np.ndarray


@lru_cache(maxsize=4)
def outlines(puzzle: Puzzle) -> Outlines:
    """The polygons of a puzzle in one array."""
    counts = [len(piece.polygon) for piece in puzzle.pieces]
    first = np.concatenate([[0], np.cumsum(counts)])
    size = np.array([piece.mask.shape[::-1] for piece in puzzle.pieces])
    return Outlines(np.concatenate([p.polygon for p in puzzle.pieces]), first, np.repeat(np.arange(puzzle.count), counts), size)


def turned_sizes(size: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Widths and heights (n, 2) after clockwise quarter turns (n,)."""
    return np.where((turns % 2 == 1)[:, None], size[:, ::-1], size)


def turned_corners(shape: Outlines, turns: np.ndarray) -> np.ndarray:
    """All corners (v, 2) in the rasters turned clockwise by quarter turns (n,)."""
    x, y = shape.corners.T
    w, h = shape.size[shape.owner].T
    k = turns[shape.owner] % 4
    return np.column_stack([np.choose(k, [x, h - y, w - x, y]), np.choose(k, [y, x, h - y, w - x])])


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """The canvas: `position` (n, 2) int64 the top-left pixel of each piece's turned raster, `turns` (n,) int64.

    `placed` (n,) bool says which pieces stand in a picture; the others lie in the `tray`. `pictures` are the areas of
    the pictures, `box` holds everything.
    """

    puzzle: Puzzle
    position: np.ndarray
    turns: np.ndarray
    placed: np.ndarray
    pictures: tuple[Box, ...]
    tray: Box | None
    box: Box

    @property
    def size(self) -> np.ndarray:
        """Widths and heights (n, 2) of the turned rasters."""
        return turned_sizes(outlines(self.puzzle).size, self.turns)

    def corners(self) -> np.ndarray:
        """The corners of all pieces on the canvas, (v, 2) float64."""
        shape = outlines(self.puzzle)
        return turned_corners(shape, self.turns) + self.position[shape.owner]

    def polygon(self, piece: int) -> np.ndarray:
        """The corners of one piece on the canvas, (k, 2)."""
        shape = outlines(self.puzzle)
        return self.corners()[shape.first[piece] : shape.first[piece + 1]]


def arrange(
    puzzle: Puzzle, solution: PuzzleSolution | None, aspect: float = 1.5, waiting: np.ndarray | None = None
) -> Layout:
    """Lay a puzzle out for a view whose width is `aspect` times its height.

    Pictures stand side by side from (0, 0); the tray goes to the right of them or below, wherever all can be shown
    larger. With a known frame its area is there even while it is empty. Placed pieces that are `waiting` (n,) bool
    still lie in the tray.
    """
    n = puzzle.count
    picture = np.full(n, UNPLACED) if solution is None else solution.picture
    picture = picture if waiting is None else np.where(waiting, UNPLACED, picture)
    turns = np.zeros(n, np.int64) if solution is None else np.where(picture == UNPLACED, 0, solution.turns)
    size, gap = turned_sizes(outlines(puzzle).size, turns), tray_gap(puzzle)
    areas = _pictures(puzzle, solution, size, 2 * gap)
    placed = picture != UNPLACED
    position = np.zeros((n, 2), np.int64)
    for k, area in enumerate(areas):
        inside = picture == k
        if solution is not None and inside.any():
            position[inside] = solution.position[inside] + (int(area.x), int(area.y))
    rows = np.flatnonzero(~placed)
    tray = None
    if len(rows):
        position[rows], tray = _tray(size[rows], areas, gap, aspect)
    boxes = [*areas, *([tray] if tray is not None else [])]
    whole = boxes[0]
    for box in boxes[1:]:
        whole = whole.united(box)
    return Layout(puzzle, position, turns, placed, areas, tray, whole)


def growing(full: Layout, grown: Layout, shown: np.ndarray) -> Layout:
    """Between two layouts: the pieces `shown` (n,) bool stand as in `grown`, the others still as in `full`."""
    position = np.where(shown[:, None], grown.position, full.position)
    turns = np.where(shown, grown.turns, full.turns)
    return replace(full, position=position, turns=turns, placed=shown & grown.placed)


def tray_gap(puzzle: Puzzle) -> int:
    """Pixels between pieces in the tray."""
    return max(2, round(0.22 * float(np.median(outlines(puzzle).size))))


def _pictures(puzzle: Puzzle, solution: PuzzleSolution | None, size: np.ndarray, gap: int) -> tuple[Box, ...]:
    """The areas of the pictures, side by side; none where nothing is placed and no frame is known."""
    if solution is None or not solution.placed.any():
        return () if puzzle.frame is None else (Box(0, 0, *puzzle.frame),)
    areas: list[Box] = []
    x = 0.0
    for k in range(int(solution.picture.max()) + 1):
        inside = solution.picture == k
        reach = (solution.position[inside] + size[inside]).max(axis=0) if inside.any() else np.ones(2)
        known = solution.sizes[k] if k < len(solution.sizes) else reach
        w, h = np.maximum(reach, known)
        areas.append(Box(x, 0, float(w), float(h)))
        x += float(w) + gap
    return tuple(areas)


def _tray(size: np.ndarray, areas: Sequence[Box], gap: int, aspect: float) -> tuple[np.ndarray, Box]:
    """Positions (m, 2) of the pieces in the tray and its area."""
    room = float(((size + gap).prod(axis=1)).sum())
    widest = int(size[:, 0].max()) + 2 * gap
    if not areas:
        position, box = shelves(size, max(widest, round((room * aspect) ** 0.5)), gap)
        return position, box
    whole = areas[0]
    for area in areas[1:]:
        whole = whole.united(area)
    away = max(2 * gap, round(0.045 * max(whole.w, whole.h)))  # room for the tray's name
    choices = []
    for beside in (True, False):
        width = max(widest, round(room / whole.h) if beside else round(whole.w))
        position, box = shelves(size, width, gap)
        at = (whole.x + whole.w + away, whole.y) if beside else (whole.x, whole.y + whole.h + away)
        moved = Box(box.x + at[0], box.y + at[1], box.w, box.h)
        both = whole.united(moved)
        choices.append((min(aspect / both.w, 1 / both.h), position + np.array(at, np.int64), moved))
    _, position, box = max(choices, key=lambda choice: choice[0])
    return position, box


def shelves(size: np.ndarray, width: int, gap: int) -> tuple[np.ndarray, Box]:
    """Put boxes (m, 2) one after the other on shelves of a width; their positions (m, 2) int64 and the area from 0, 0."""
    position = np.zeros((len(size), 2), np.int64)
    x, y, tall, reach = gap, gap, 0, 0
    for k, (w, h) in enumerate(size.tolist()):
        if x > gap and x + w + gap > width:
            x, y, tall = gap, y + tall + gap, 0
        position[k] = x, y
        x, tall, reach = x + w + gap, max(tall, h), max(reach, x + w + gap)
    return position, Box(0, 0, float(reach), float(y + tall + gap))
