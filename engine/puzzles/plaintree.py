"""The plain baseline of the thesis: a spanning tree on Gallagher's ratio with overlap check, then cells filled greedily.

Nothing here looks at loops, contacts or a judge (Gallagher 2012): what a way of confirming joins adds can then be seen.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from .blocks import Rules, grow_blocks, single_pieces
from .measures import Strips, dissimilarity

WORST = 5.0  # of a ratio in the mean that judges an assembly


class Ratios(NamedTuple):
    """Gallagher's ratio N of every two of n unturned square pieces, below 1 iff best buddies, inf on the diagonal.

    `right` (n, n): the second piece lies to the right of the first; `down` (n, n): below it. `pairs` (2 n (n - 1), 2)
    int64 are all pairs of sides 4 i + side and `ratio` their N.
    """

    right: np.ndarray
    down: np.ndarray
    pairs: np.ndarray
    ratio: np.ndarray


def ratios_of(measure: str, strips: Strips) -> Ratios:
    """All ratios by one measure (a key of `measures.CODES`, or "mgc-pt"); EMD compares halves."""
    n = len(strips.outer) // 4
    first = 4 * np.arange(n)
    right, down = (
        gallagher(dissimilarity(measure, strips, first + a, first + b, parts=2)) for a, b in ((1, 3), (2, 0))
    )
    i, j = np.nonzero(~np.eye(n, dtype=bool))
    pairs = np.concatenate([np.column_stack([4 * i + a, 4 * j + b]) for a, b in ((1, 3), (2, 0))])
    return Ratios(right, down, pairs, np.concatenate([right[i, j], down[i, j]]))


def gallagher(d: np.ndarray) -> np.ndarray:
    """N (n, n) of dissimilarities (n, n): D over the least other one of its row and column; the diagonal is left out."""
    d = d + np.where(np.eye(len(d), dtype=bool), np.inf, 0)
    epsilon = 1e-3 * float(np.median(d[np.isfinite(d)])) + 1e-12
    other = np.minimum(_least_other(d), _least_other(d.T).T)
    return (d + epsilon) / (other + epsilon)


def _least_other(d: np.ndarray) -> np.ndarray:
    """The least value of each row but the entry itself, (n, n)."""
    if d.shape[1] < 3:
        return np.full(d.shape, float(np.median(d[np.isfinite(d)])))
    two = np.partition(d, 1, axis=1)[:, :2]
    own = np.arange(d.shape[1])[None] == d.argmin(axis=1)[:, None]
    return np.where(own, two[:, 1:], two[:, :1])


def plain_tree(ratios: Ratios, frame: tuple[int, int] | None, first: np.ndarray) -> np.ndarray:
    """Cells (n, 2) int64, (column, row) from (0, 0): a tree on N, the joins `first` (rows of the pairs) before all others.

    Pieces that the largest block could not take are put one by one into the empty cell with most neighbours where
    their mean ratio is least. `frame` (columns, rows) bounds everything; None is no bound.
    """
    n = len(ratios.right)
    order = np.argsort(ratios.ratio, kind="stable")
    if len(first):
        early = np.zeros(len(order), dtype=bool)
        early[first] = True
        order = np.concatenate([order[early[order]], order[~early[order]]])  # as if their D were multiplied by 1e-6
    blocks, _ = grow_blocks(ratios.pairs, order, single_pieces(n), Rules(frame))
    main = np.bincount(blocks.block, minlength=n).argmax()
    placed = blocks.block == main
    cells = np.column_stack([blocks.x, blocks.y])
    cells[~placed] = 0
    cells[placed] -= cells[placed].min(axis=0)
    columns, rows = frame or (n, n)
    _fill(cells, placed.copy(), ratios.right, ratios.down, columns, rows)
    return cells - cells.min(axis=0)


@njit(cache=True, nogil=True)
def _fill(cells, placed, right, down, columns, rows):  # type: ignore[no-untyped-def]
    n = len(cells)
    while not placed.all():
        low_x, high_x, low_y, high_y = n, -n, n, -n
        for i in range(n):
            if placed[i]:
                low_x, high_x = min(low_x, cells[i, 0]), max(high_x, cells[i, 0])
                low_y, high_y = min(low_y, cells[i, 1]), max(high_y, cells[i, 1])
        x0, x1 = max(low_x - 1, high_x - columns + 1), min(high_x + 1, low_x + columns - 1)
        y0, y1 = max(low_y - 1, high_y - rows + 1), min(high_y + 1, low_y + rows - 1)
        grid = np.full((y1 - y0 + 3, x1 - x0 + 3), -1)
        for i in range(n):
            if placed[i]:
                grid[cells[i, 1] - y0 + 1, cells[i, 0] - x0 + 1] = i
        most, least, where_x, where_y, who = 0, np.inf, 0, 0, -1
        for r in range(1, y1 - y0 + 2):
            for c in range(1, x1 - x0 + 2):
                west, east, north, south = grid[r, c - 1], grid[r, c + 1], grid[r - 1, c], grid[r + 1, c]
                count = (west >= 0) + (east >= 0) + (north >= 0) + (south >= 0)
                if grid[r, c] >= 0 or count < max(most, 1):
                    continue
                for i in range(n):
                    if placed[i]:
                        continue
                    total = 0.0
                    if west >= 0:
                        total += right[west, i]
                    if east >= 0:
                        total += right[i, east]
                    if north >= 0:
                        total += down[north, i]
                    if south >= 0:
                        total += down[i, south]
                    if count > most or total / count < least:
                        most, least, where_x, where_y, who = count, total / count, c + x0 - 1, r + y0 - 1, i
        if who < 0:
            return
        cells[who, 0], cells[who, 1], placed[who] = where_x, where_y, True


def judged(ratios: Ratios, cells: np.ndarray) -> float:
    """The mean of min(N, `WORST`) over the touching pairs of an assembly, smaller is better; it sees no truth."""
    values = []
    for table, step in ((ratios.right, (1, 0)), (ratios.down, (0, 1))):
        a, b = _steps(cells, step)
        values.append(np.minimum(table[a, b], WORST))
    every = np.concatenate(values)
    return float(every.mean()) if len(every) else WORST


def _steps(cells: np.ndarray, step: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Pieces a and b with the cell of b one step from that of a."""
    grid = np.full(cells.max(axis=0) + 2, -1)
    grid[cells[:, 0], cells[:, 1]] = np.arange(len(cells))
    b = grid[cells[:, 0] + step[0], cells[:, 1] + step[1]]
    return np.flatnonzero(b >= 0), b[b >= 0]


def direct_and_neighbour(cells: np.ndarray, true: np.ndarray, *, shifted: bool) -> tuple[float, float]:
    """The shares of pieces at their true cells and of true neighbours kept; `shifted` allows one shift of the whole."""
    off = true - cells
    if shifted:
        rows, counts = np.unique(off, axis=0, return_counts=True)
        off = off - rows[counts.argmax()]
    kept = total = 0
    for step in ((1, 0), (0, 1)):
        a, b = _steps(true, step)
        kept += int((cells[b] - cells[a] == step).all(axis=1).sum())
        total += len(a)
    return float((off == 0).all(axis=1).mean()), kept / max(total, 1)
