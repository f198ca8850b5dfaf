"""Where the tiles of a collection stand, and what is under a point: plain numbers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

CAPTION, GAP = 26, 12
SMALLEST, LARGEST = 150, 460


class Grid(NamedTuple):
    """Columns, the side of a square tile, and the height of everything, in logical pixels."""

    columns: int
    side: int
    left: int
    height: int


def grid_for(count: int, width: int, height: int) -> Grid:
    """The columns that make the tiles largest; where they would be smaller than can be read, the rest is scrolled to."""
    best = Grid(1, SMALLEST, GAP, 0)
    for columns in range(1, max(count, 1) + 1):
        rows = -(-count // columns)
        across = (width - GAP) // columns - GAP
        side = min(across, (height - GAP) // rows - GAP - CAPTION, LARGEST)
        if side < SMALLEST:
            side = min(across, SMALLEST)
            if side < SMALLEST and columns > 1:
                break
        if side >= best.side or columns == 1:
            left = max(GAP, (width - columns * (side + GAP) + GAP) // 2)
            best = Grid(columns, max(side, 1), left, rows * (side + CAPTION + GAP) + GAP)
    return best


def corner(grid: Grid, row: int) -> tuple[int, int]:
    """Upper left corner of a tile's picture, below its caption."""
    line, column = divmod(row, grid.columns)
    return grid.left + column * (grid.side + GAP), GAP + line * (grid.side + CAPTION + GAP) + CAPTION


def tile_at(grid: Grid, count: int, x: float, y: float) -> tuple[int, float, float] | None:
    """The tile under a point, and where in its picture in shares of its side (y < 0 in the caption); None beside all."""
    for row in range(count):
        left, top = corner(grid, row)
        if left <= x < left + grid.side and top - CAPTION <= y < top + grid.side:
            return row, (x - left) / grid.side, (y - top) / grid.side
    return None


def next_part(present: np.ndarray, now: int, by: int) -> int:
    """The part after (or before) one in the order of a list, around its ends; -1 for none before the first."""
    parts = [-1, *present.tolist()]
    return parts[(parts.index(now) + by) % len(parts)] if now in parts else -1
