"""The last global shift: rows and columns at the border of a picture that belong to the opposite border."""

import numpy as np

from ..progress import Progress
from .evidence import Evidence
from .filling import EMPTY, cell_score, rearrange, total_worth

WEAK = 1.0  # mean log odds a contact below which the line between two rows is worth a try
DEEPEST = 3  # rows that are tried to be moved at once


def shift(
    grid: np.ndarray, turns: np.ndarray, loose: np.ndarray, groups: np.ndarray, turned: bool, e: Evidence,
    progress: Progress,
) -> None:  # fmt: skip
    """Move whole rows and columns of `grid` from one border to the opposite one while the sum of all log odds grows.

    Without it a picture may end one cell off as a whole: the neighbours right, no place right. The cells that a move
    brings to the border are rearranged along with the cells `loose` (m, 2) before it is judged. `groups` (n,) int64 names
    locked pieces, which are neither parted nor rearranged (-1: not locked). Changes `grid` and `turns`; the pieces of
    the grid must span their frame.
    """
    rows, columns = np.nonzero(grid != EMPTY)
    top, left, bottom, right = rows.min(), columns.min(), rows.max() + 1, columns.max() + 1
    view = grid[top:bottom, left:right]
    origin = np.array([top, left])
    best = total_worth(grid, turns, e)
    for axis in (0, 1):
        for depth in [d for k in range(1, DEEPEST + 1) for d in (k, -k)]:
            if abs(depth) >= view.shape[axis] or _strength(view, turns, axis, depth % view.shape[axis], e) >= WEAK:
                continue
            if _parts_a_group(view, groups, axis, depth):
                continue
            before, old_turns = view.copy(), turns.copy()
            view[:] = np.roll(view, -depth, axis=axis)
            moved = np.argwhere(_border(view.shape, axis, depth)) + origin
            cells = np.unique(np.concatenate([moved, loose]), axis=0)
            pieces = grid[cells[:, 0], cells[:, 1]]
            rearrange(grid, turns, cells[(pieces != EMPTY) & (groups[pieces] < 0)], turned, 12, 3, 0, e, progress)
            worth = total_worth(grid, turns, e)
            if worth > best + 1e-6:
                best = worth
            else:
                view[:], turns[:] = before, old_turns


def _strength(view: np.ndarray, turns: np.ndarray, axis: int, line: int, e: Evidence) -> float:
    """Mean log odds of the contacts across the line before row (axis 0) or column (axis 1) number `line`."""
    pair = np.take(view, [line - 1, line], axis=axis)
    scores = []
    for k in range(view.shape[1 - axis]):
        two = np.ascontiguousarray(np.take(pair, [k], axis=1 - axis))
        if (two != EMPTY).all():
            scores.append(cell_score(two, turns, 0, 0, two[0, 0], turns[two[0, 0]], e)[0])
    return float(np.mean(scores)) if scores else 0.0


def _parts_a_group(view: np.ndarray, groups: np.ndarray, axis: int, depth: int) -> bool:
    """Whether locked pieces of one group lie on both sides of the line at which the picture would be cut."""
    lines = np.split(view, [depth % view.shape[axis]], axis=axis)
    first, second = (np.unique(groups[part[part != EMPTY]]) for part in lines)
    return bool((np.intersect1d(first, second) >= 0).any())


def _border(shape: tuple[int, ...], axis: int, depth: int) -> np.ndarray:
    """The cells that a roll by -depth has brought to the other border."""
    mask = np.zeros(shape, dtype=bool)
    index = [slice(None), slice(None)]
    index[axis] = slice(-depth, None) if depth > 0 else slice(0, -depth)
    mask[tuple(index)] = True
    return mask
