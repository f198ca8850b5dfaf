"""Completing a picture: blocks joined by the sum of their contacts, then single pieces in the cells that are left."""

import itertools

import numpy as np
from numba import njit, prange

from ..progress import Progress
from .blocks import STEP_X, STEP_Y, Blocks, Rules, cell_key, grow_blocks, slot_of, turn_cell
from .candidates import Candidates
from .evidence import NEVER, Evidence, fit

EMPTY = -1


def merge_by_contacts(
    blocks: Blocks, candidates: Candidates, e: Evidence, rules: Rules, *, least: float, hopeful: float,
    progress: Progress,
) -> Blocks:  # fmt: skip
    """Merge blocks round by round where the log odds of all the contacts that a placement makes sum to more than `least`.

    Each candidate with log odds above `hopeful` between two blocks implies a placement of one beside the other. The
    best are taken first; no block is moved twice in a round.
    """
    for number in itertools.count():
        progress(1.0 - 0.9**number, "joining blocks")
        names = blocks.block[candidates.pairs // 4]
        rows = np.flatnonzero((names[:, 0] != names[:, 1]) & (e.logit > hopeful))
        score = placement_scores(candidates.pairs[rows], blocks, e)
        rows, score = rows[score > least], score[score > least]
        order = rows[np.lexsort((rows, -score))]
        merged, taken = grow_blocks(candidates.pairs, order, blocks, rules, once=True)
        if not taken.any():
            return blocks
        blocks = merged
    return blocks


def placement_scores(pairs: np.ndarray, blocks: Blocks, e: Evidence) -> np.ndarray:
    """The sum of the log odds of all contacts that joining two blocks by each of `pairs` (c, 2) makes, (c,) float64.

    -inf where the blocks would overlap.
    """
    n = len(blocks.block)
    members = np.argsort(blocks.block, kind="stable")
    first = np.searchsorted(blocks.block[members], np.arange(n + 1))
    keys, values = _cell_table(blocks.block, blocks.x, blocks.y)
    score = np.empty(len(pairs))
    _placement_scores(pairs, blocks.block, blocks.x, blocks.y, blocks.turns, members, first, keys, values, e, score)
    return score


@njit(cache=True, nogil=True)
def _cell_table(block, x, y):  # type: ignore[no-untyped-def]
    capacity = 16
    while capacity < 4 * len(block):
        capacity *= 2
    keys, values = np.full(capacity, -1, dtype=np.int64), np.full(capacity, EMPTY, dtype=np.int64)
    for i in range(len(block)):
        key = cell_key(block[i], x[i], y[i])
        place = slot_of(keys, key)
        keys[place], values[place] = key, i
    return keys, values


@njit(cache=True, nogil=True, parallel=True)
def _placement_scores(pairs, block, x, y, turns, members, first, keys, values, e, score):  # type: ignore[no-untyped-def]
    for a in prange(len(pairs)):
        i, s, j, t = pairs[a, 0] // 4, pairs[a, 0] % 4, pairs[a, 1] // 4, pairs[a, 1] % 4
        p, q = block[i], block[j]
        if first[p + 1] - first[p] < first[q + 1] - first[q]:
            i, s, j, t = j, t, i, s
            p, q = q, p
        d = (s + turns[i]) % 4
        k = ((d + 2 - t) - turns[j]) % 4
        jx, jy = turn_cell(x[j], y[j], k)
        dx, dy = x[i] + STEP_X[d] - jx, y[i] + STEP_Y[d] - jy
        total = 0.0
        for place in range(first[q], first[q + 1]):
            m = members[place]
            mx, my = turn_cell(x[m], y[m], k)
            mx, my = mx + dx, my + dy
            if values[slot_of(keys, cell_key(p, mx, my))] != EMPTY:
                total = -np.inf
                break
            for w in range(4):
                other = values[slot_of(keys, cell_key(p, mx + STEP_X[w], my + STEP_Y[w]))]
                if other != EMPTY:
                    mine = 4 * m + (w - turns[m] - k) % 4
                    total += fit(e, mine, 4 * other + (w + 2 - turns[other]) % 4)
        score[a] = total


@njit(cache=True, nogil=True)
def cell_score(grid, turns, row, column, piece, turn, e):  # type: ignore[no-untyped-def]
    """The sum of the log odds of a piece's contacts in a cell of `grid`, and their number."""
    total, contacts = 0.0, 0
    for w in range(4):
        r, c = row + STEP_Y[w], column + STEP_X[w]
        if 0 <= r < grid.shape[0] and 0 <= c < grid.shape[1] and grid[r, c] != EMPTY:
            other = grid[r, c]
            total += fit(e, 4 * piece + (w - turn) % 4, 4 * other + (w + 2 - turns[other]) % 4)
            contacts += 1
    return total, contacts


@njit(cache=True, nogil=True)
def fill_cells(grid, turns, left, kind, width, height, turned, least, most, e):  # type: ignore[no-untyped-def]
    """Place up to `most` of the pieces `left` (m,), one at a time, into empty cells of `grid` that touch others.

    `kind` (m,) are their kinds, equal ones in a row: of pieces that look alike one is tried for all.

    The piece and the cell with the best mean log odds a contact come first, cells with more neighbours before others
    of the same worth; what is placed never outgrows `width` × `height` cells (0: no limit). Stops where no mean
    reaches `least`. Changes `grid` and `turns`; returns which of `left` were placed.
    """
    rows, columns = grid.shape
    placed = np.zeros(len(left), dtype=np.bool_)
    worth = np.full((rows, columns), -np.inf)
    choice = np.full((rows, columns), EMPTY)
    way = np.zeros((rows, columns), dtype=np.int64)
    box = np.array([rows, columns, -1, -1])
    stale = np.zeros((rows, columns), dtype=np.bool_)
    for r in range(rows):
        for c in range(columns):
            stale[r, c] = grid[r, c] == EMPTY
            if grid[r, c] != EMPTY:
                box[0], box[1], box[2], box[3] = min(box[0], r), min(box[1], c), max(box[2], r), max(box[3], c)
    for _ in range(min(len(left), most)):
        best, best_r, best_c = -np.inf, -1, -1
        for r in range(max(box[0] - 1, 0), min(box[2] + 2, rows)):
            for c in range(max(box[1] - 1, 0), min(box[3] + 2, columns)):
                if grid[r, c] != EMPTY:
                    continue
                if height and (max(box[2], r) - min(box[0], r) >= height or max(box[3], c) - min(box[1], c) >= width):
                    continue
                if stale[r, c] or (choice[r, c] != EMPTY and placed[choice[r, c]]):
                    worth[r, c], choice[r, c], way[r, c] = _best_for_cell(
                        grid, turns, r, c, left, kind, placed, turned, e
                    )
                    stale[r, c] = False
                if worth[r, c] > best:
                    best, best_r, best_c = worth[r, c], r, c
        if best_r < 0 or best < least:
            break
        k = choice[best_r, best_c]
        grid[best_r, best_c] = left[k]
        turns[left[k]] = way[best_r, best_c]
        placed[k] = True
        box[0], box[1] = min(box[0], best_r), min(box[1], best_c)
        box[2], box[3] = max(box[2], best_r), max(box[3], best_c)
        for w in range(4):
            r, c = best_r + STEP_Y[w], best_c + STEP_X[w]
            if 0 <= r < rows and 0 <= c < columns:
                stale[r, c] = grid[r, c] == EMPTY
    return placed


@njit(cache=True, nogil=True)
def _best_for_cell(grid, turns, r, c, left, kind, placed, turned, e):  # type: ignore[no-untyped-def]
    best, which, way, last = -np.inf, EMPTY, 0, -1
    for k in range(len(left)):
        if placed[k] or kind[k] == last:
            continue
        last = kind[k]
        for turn in range(4 if turned else 1):
            total, contacts = cell_score(grid, turns, r, c, left[k], turn, e)
            if contacts and total > NEVER / 2 and total / contacts + 0.5 * contacts > best:
                best, which, way = total / contacts + 0.5 * contacts, k, turn
    return best, which, way


@njit(cache=True, nogil=True)
def best_place(grid, turns, group, x, y, group_turns, movable, width, height, turned, e):  # type: ignore[no-untyped-def]
    """Where a group of pieces, with cells and turns of their own, fits the pieces on `grid` best, touching one at least.

    It may take the place of pieces that are `movable` (n,) bool, whose log odds are then lost.

    Returns the sum of log odds (-inf where there is no room), the row and column of the group's origin, and its turns.
    """
    rows, columns = grid.shape
    box = np.array([rows, columns, -1, -1])
    for r in range(rows):
        for c in range(columns):
            if grid[r, c] != EMPTY:
                box[0], box[1], box[2], box[3] = min(box[0], r), min(box[1], c), max(box[2], r), max(box[3], c)
    best, best_r, best_c, best_k = -np.inf, 0, 0, 0
    reach = len(group)
    for k in range(4 if turned else 1):
        for r in range(-reach, rows + reach):
            for c in range(-reach, columns + reach):
                total, touching = 0.0, 0
                low_r, low_c, high_r, high_c = box[0], box[1], box[2], box[3]
                for m in range(len(group)):
                    dx, dy = turn_cell(x[m], y[m], k)
                    row, column = r + dy, c + dx
                    if not (0 <= row < rows and 0 <= column < columns):
                        total = -np.inf
                        break
                    there = grid[row, column]
                    if there != EMPTY:
                        if not movable[there]:
                            total = -np.inf
                            break
                        total -= cell_score(grid, turns, row, column, there, turns[there], e)[0]
                    low_r, low_c, high_r, high_c = (
                        min(low_r, row),
                        min(low_c, column),
                        max(high_r, row),
                        max(high_c, column),
                    )
                    if height and (high_r - low_r >= height or high_c - low_c >= width):
                        total = -np.inf
                        break
                    worth, contacts = cell_score(grid, turns, row, column, group[m], (group_turns[m] + k) % 4, e)
                    total += worth
                    touching += contacts
                if touching and total > best and total > NEVER / 2:
                    best, best_r, best_c, best_k = total, r, c, k
    return best, best_r, best_c, best_k


def rearrange(
    grid: np.ndarray, turns: np.ndarray, loose: np.ndarray, turned: bool, rounds: int, patience: int, seed: int,
    e: Evidence, progress: Progress,
) -> None:  # fmt: skip
    """Move the pieces in the cells `loose` (m, 2) among these cells while the sum of all log odds grows.

    In each round cells are drawn of which no two touch, so that the best assignment of their pieces to them, all others
    staying where they are, is a linear assignment problem. Stops after `rounds`, or `patience` rounds without a gain.
    Changes `grid` and `turns`.
    """
    from scipy.optimize import linear_sum_assignment

    rng, idle = np.random.default_rng(seed), 0
    for number in range(rounds if len(loose) > 1 else 0):
        progress(number / rounds, "moving loose pieces")
        cells = loose[_apart(grid.shape, loose, rng)]
        pieces = grid[cells[:, 0], cells[:, 1]]
        worth, way = np.empty((len(cells), len(cells))), np.zeros((len(cells), len(cells)), dtype=np.int64)
        _worth_by_cell(grid, turns, cells, pieces, turned, e, worth, way)
        rows, columns = linear_sum_assignment(-worth)
        gain = worth[rows, columns].sum() - _worth_now(grid, turns, cells, e)
        idle = 0 if gain > 1e-6 else idle + 1
        if gain > 1e-6:
            grid[cells[rows, 0], cells[rows, 1]] = pieces[columns]
            turns[pieces[columns]] = way[rows, columns]
        elif idle >= patience:
            return


def _apart(shape: tuple[int, ...], cells: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A random choice of cells (m,) bool of which no two touch: those that drew more than all their neighbours."""
    lots = np.full((shape[0] + 2, shape[1] + 2), -1.0)
    r, c = cells.T + 1
    lots[r, c] = rng.random(len(cells))
    around = np.stack([lots[r + dr, c + dc] for dr, dc in ((0, 1), (1, 0), (0, -1), (-1, 0))])
    return lots[r, c] > around.max(axis=0)


def _worth_now(grid: np.ndarray, turns: np.ndarray, cells: np.ndarray, e: Evidence) -> float:
    return sum(cell_score(grid, turns, r, c, grid[r, c], turns[grid[r, c]], e)[0] for r, c in cells.tolist())


@njit(cache=True, nogil=True, parallel=True)
def _worth_by_cell(grid, turns, cells, pieces, turned, e, worth, way):  # type: ignore[no-untyped-def]
    for a in prange(len(cells)):
        for b in range(len(pieces)):
            best = -np.inf
            for k in range(4 if turned else 1):
                turn = k if turned else turns[pieces[b]]
                total = cell_score(grid, turns, cells[a, 0], cells[a, 1], pieces[b], turn, e)[0]
                if total > best:
                    best, way[a, b] = total, turn
            worth[a, b] = best


@njit(cache=True, nogil=True)
def total_worth(grid, turns, e):  # type: ignore[no-untyped-def]
    """The judge: the sum of the log odds of all contacts of a picture. It sees no truth."""
    total = 0.0
    for r in range(grid.shape[0]):
        for c in range(grid.shape[1]):
            piece = grid[r, c]
            if piece == EMPTY:
                continue
            for w in range(1, 3):
                r2, c2 = r + STEP_Y[w], c + STEP_X[w]
                if r2 < grid.shape[0] and c2 < grid.shape[1] and grid[r2, c2] != EMPTY:
                    other = grid[r2, c2]
                    total += fit(e, 4 * piece + (w - turns[piece]) % 4, 4 * other + (w + 2 - turns[other]) % 4)
    return total
