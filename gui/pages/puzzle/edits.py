"""What a hand may do to a puzzle, as functions from wishes and solutions to new ones."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from engine.puzzles.parameters import PuzzleParameters
from engine.puzzles.pieces import Puzzle
from engine.puzzles.solution import UNPLACED, Joins, Pin, PuzzleSolution, Wishes, no_joins

from ...views.puzzle_layout import outlines, turned_sizes
from ...views.puzzle_scene import Key, join_keys, join_rows

NO_WISHES = Wishes()
BY_HAND = "by hand"


def chosen(joins: Joins, rows: np.ndarray) -> Joins:
    """Some rows of joins."""
    names = tuple(joins.confirmed_by[k] for k in np.arange(len(joins))[rows])
    return Joins(joins.sides[rows], joins.offset[rows], joins.turn[rows], joins.confidence[rows], names)


def one(joins: Joins, row: int) -> Joins:
    """One row of joins, as joins."""
    return chosen(joins, np.array([row]))


def together(first: Joins, second: Joins) -> Joins:
    """The rows of both."""
    return Joins(
        np.concatenate([first.sides, second.sides]), np.concatenate([first.offset, second.offset]),
        np.concatenate([first.turn, second.turn]), np.concatenate([first.confidence, second.confidence]),
        first.confirmed_by + second.confirmed_by,
    )  # fmt: skip


def without(joins: Joins, keys: Iterable[Key]) -> Joins:
    """The rows whose sides are not named."""
    names = set(keys)
    return chosen(joins, np.array([key not in names for key in join_keys(joins)], bool)) if len(joins) else joins


def held(joins: Joins) -> Joins:
    """The same joins as a person's: certain."""
    return replace(joins, confidence=np.ones(len(joins)), confirmed_by=("person",) * len(joins))


def lock(wishes: Wishes, join: Joins, *, single: bool) -> Wishes:
    """Hold a join (one row), or let it go if it is held.

    Where a side has a `single` partner, what else the two sides were said to join is taken back.
    """
    (key,) = join_keys(join)
    if key in join_keys(wishes.locked):
        return replace(wishes, locked=without(wishes.locked, [key]))
    rivals = [k for k in join_keys(wishes.locked) if single and _shares_side(k, key)]
    locked = together(without(wishes.locked, rivals), held(join))
    return replace(wishes, locked=locked, forbidden=without(wishes.forbidden, [key]))


def forbid(wishes: Wishes, joins: Joins) -> Wishes:
    """Reject joins: they may not come back, and are held no more."""
    keys = join_keys(joins)
    return replace(wishes, locked=without(wishes.locked, keys),
                   forbidden=together(without(wishes.forbidden, keys), replace(joins, confirmed_by=("person",) * len(joins))))  # fmt: skip


def pin(wishes: Wishes, pins: Iterable[Pin]) -> Wishes:
    """Hold pieces where they are said to stand; earlier pins of the same pieces are replaced."""
    new = {p.piece: p for p in pins}
    kept = tuple(p for p in wishes.pinned if p.piece not in new)
    return replace(wishes, pinned=(*kept, *new.values()))


def unpin(wishes: Wishes, pieces: Iterable[int]) -> Wishes:
    """Let pieces go."""
    gone = set(pieces)
    return replace(wishes, pinned=tuple(p for p in wishes.pinned if p.piece not in gone))


def upright(wishes: Wishes) -> Wishes:
    """The wishes that turn no piece."""
    locked, forbidden = (chosen(joins, joins.turn % 4 == 0) for joins in (wishes.locked, wishes.forbidden))
    return Wishes(locked, forbidden, tuple(p for p in wishes.pinned if p.quarter_turns % 4 == 0))


def released(wishes: Wishes, key: Key) -> Wishes:
    """Neither hold nor reject a join any more."""
    return replace(wishes, locked=without(wishes.locked, [key]), forbidden=without(wishes.forbidden, [key]))


def group(piece: int, locked: Joins) -> frozenset[int]:
    """The pieces that hang on a piece by held joins, itself among them."""
    found, edge = {piece}, [piece]
    pairs = locked.sides[:, [0, 2]]
    while edge:
        here = edge.pop()
        beside = {*pairs[pairs[:, 0] == here, 1].tolist(), *pairs[pairs[:, 1] == here, 0].tolist()} - found
        found |= beside
        edge += beside
    return frozenset(found)


def empty_solution(puzzle: Puzzle, parameters: PuzzleParameters) -> PuzzleSolution:
    """All pieces unplaced: where building by hand begins."""
    n = puzzle.count
    sizes = [puzzle.frame] if puzzle.frame is not None else [(0, 0)]
    return PuzzleSolution(
        puzzle.name, np.full(n, UNPLACED), np.zeros((n, 2)), np.zeros(n), np.array(sizes), no_joins(), BY_HAND,
        parameters.measure, parameters,
    )  # fmt: skip


def placed_by_hand(puzzle: Puzzle, solution: PuzzleSolution, pins: Iterable[Pin], picture: int = 0) -> PuzzleSolution:
    """Put pieces somewhere at once, before solving again: their joins end, and what lay there goes to the tray."""
    pins = list(pins)
    moved = np.array([p.piece for p in pins])
    where, position, turns = solution.picture.copy(), solution.position.copy(), solution.turns.copy()
    where[moved] = picture
    position[moved] = [(p.x, p.y) for p in pins]
    turns[moved] = [p.quarter_turns for p in pins]
    covered = [k for k in overlapping(puzzle, where, position, turns, moved).tolist() if k not in set(moved.tolist())]
    where[covered] = UNPLACED
    ended = np.isin(solution.joins.sides[:, [0, 2]], [*moved.tolist(), *covered]).any(axis=1)
    return replace(solution, picture=where, position=position, turns=turns, joins=chosen(solution.joins, ~ended),
                   why_unplaced=dict.fromkeys(covered, "another piece was put there"))  # fmt: skip


def taken_out(solution: PuzzleSolution, pieces: Iterable[int]) -> PuzzleSolution:
    """Put pieces back into the tray, before solving again."""
    gone = sorted(pieces)
    where = solution.picture.copy()
    where[gone] = UNPLACED
    ended = np.isin(solution.joins.sides[:, [0, 2]], gone).any(axis=1)
    return replace(solution, picture=where, joins=chosen(solution.joins, ~ended))


def overlapping(puzzle: Puzzle, where: np.ndarray, position: np.ndarray, turns: np.ndarray, pieces: np.ndarray) -> np.ndarray:
    """The placed pieces that share more than a sliver with one of `pieces`, in rows (k,) int64.

    A sliver, up to an eighth of the smaller box's shorter side, is what eroded borders and careful hands leave.
    """
    size = turned_sizes(outlines(puzzle).size, turns)
    found: set[int] = set()
    for piece in pieces.tolist():
        low = np.maximum(position, position[piece])
        high = np.minimum(position + size, position[piece] + size[piece])
        sliver = np.maximum(1, np.minimum(size.min(axis=1), size[piece].min()) // 8)
        near = (where == where[piece]) & ((high - low).min(axis=1) > sliver)
        near[piece] = False
        for other in np.flatnonzero(near).tolist():
            if _common(puzzle, position, turns, piece, other) > 0.02 * min(puzzle.pieces[k].mask.sum() for k in (piece, other)):
                found.add(other)
    return np.array(sorted(found), np.int64)


def _common(puzzle: Puzzle, position: np.ndarray, turns: np.ndarray, a: int, b: int) -> int:
    """Number of pixels that two placed pieces share."""
    masks = [np.rot90(puzzle.pieces[k].mask, -int(turns[k])) for k in (a, b)]
    low = np.maximum(position[a], position[b])
    high = np.minimum(*(position[k] + mask.shape[::-1] for k, mask in zip((a, b), masks, strict=True)))
    parts = [mask[low[1] - position[k][1] : high[1] - position[k][1], low[0] - position[k][0] : high[0] - position[k][0]]
             for k, mask in zip((a, b), masks, strict=True)]  # fmt: skip
    return int((parts[0] & parts[1]).sum())


def _shares_side(one_key: Key, other: Key) -> bool:
    return bool({one_key[:2], one_key[2:]} & {other[:2], other[2:]})


def rows_of(joins: Joins, keys: Iterable[Key]) -> np.ndarray:
    """Which joins are named, (j,) bool."""
    named, rows = np.zeros(len(joins), bool), join_rows(joins)
    named[[rows[key] for key in keys if key in rows]] = True
    return named


def row_of(joins: Joins, key: Key | None) -> int:
    """The row of a join by its name, or -1."""
    return join_rows(joins).get(key, -1) if key else -1


def joins_of_piece(joins: Joins, piece: int) -> Joins:
    """The joins of one piece."""
    return chosen(joins, (joins.sides[:, [0, 2]] == piece).any(axis=1))


def shifted(puzzle: Puzzle, solution: PuzzleSolution, wishes: Wishes) -> tuple[PuzzleSolution, Wishes]:
    """The same with each picture moved so that its pieces begin at (0, 0), and the pins with them.

    Without a known frame only relative places count.
    """
    size = turned_sizes(outlines(puzzle).size, solution.turns)
    step, sizes = np.zeros((puzzle.count, 2), np.int64), solution.sizes.copy()
    for k in range(len(sizes)):
        inside = solution.picture == k
        if inside.any():
            step[inside] = solution.position[inside].min(axis=0)
            sizes[k] = (solution.position + size - step)[inside].max(axis=0)
    moved = replace(solution, position=solution.position - step, sizes=sizes)
    pins = tuple(_follows(p, moved) for p in wishes.pinned)
    wishes = wishes if pins == wishes.pinned else replace(wishes, pinned=pins)
    return (moved if step.any() or (sizes != solution.sizes).any() else solution), wishes


def _follows(held: Pin, solution: PuzzleSolution) -> Pin:
    """A pin where a solution has its piece."""
    if not solution.placed[held.piece]:
        return held
    x, y = solution.position[held.piece].tolist()
    return held._replace(x=x, y=y)
