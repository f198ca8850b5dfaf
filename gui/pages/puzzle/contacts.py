"""Which sides touch in a picture that a hand has put together, as joins."""

import numpy as np

from engine.puzzles.identity import size_of, turned_offset
from engine.puzzles.pieces import Puzzle
from engine.puzzles.solution import Joins, PuzzleSolution
from engine.puzzles.turning import turned_polygon

from ...views.puzzle_layout import outlines, turned_corners

NEAR = 3.0  # pixels between two sides that touch: eroded borders and careful hands leave some


def contacts(puzzle: Puzzle, solution: PuzzleSolution, pieces: frozenset[int]) -> Joins:
    """The joins of touching sides between some placed pieces and the others: sides that face each other, at most
    `NEAR` pixels apart along half of the shorter one."""
    shape, where = outlines(puzzle), solution.picture
    corners = turned_corners(shape, solution.turns) + solution.position[shape.owner]
    follower = np.arange(len(corners)) + 1
    follower[shape.first[1:] - 1] = shape.first[:-1]
    sides = np.stack([corners, corners[follower]], axis=1)
    rows: list[tuple[int, int, int, int]] = []
    for a in sorted(pieces):
        free = (where[shape.owner] == where[a]) & ~np.isin(shape.owner, list(pieces))
        for k in range(shape.first[a], shape.first[a + 1]):
            near = np.flatnonzero(free & (np.abs(sides.mean(axis=1) - sides[k].mean(axis=0)).max(axis=1) < 2 * _reach(sides, k)))
            rows += [(a, k - int(shape.first[a]), int(shape.owner[m]), m - int(shape.first[shape.owner[m]]))
                     for m in near[_facing(sides[k], sides[near])].tolist()]  # fmt: skip
    return _standing_joins(puzzle, solution, np.array(rows, np.int64).reshape(-1, 4))


def turned_round(puzzle: Puzzle, joins: Joins, row: int) -> Joins:
    """One join (a row of joins) said from its other piece."""
    a, side_a, b, side_b = joins.sides[row].tolist()
    turn, (x, y) = int(joins.turn[row]), joins.offset[row].tolist()
    at, one, two = (-x, -y), size_of(puzzle.pieces[b], turn), size_of(puzzle.pieces[a], 0)
    for _ in range(-turn % 4):  # on, until piece b stands as it was read
        at, one, two = turned_offset(at, one, two), one[::-1], two[::-1]
    return Joins(np.array([[b, side_b, a, side_a]]), np.array([at]), np.array([-turn % 4]), joins.confidence[[row]],
                 (joins.confirmed_by[row],))  # fmt: skip


def beside(puzzle: Puzzle, joins: Joins, row: int, turns: int) -> np.ndarray:
    """The outline (k, 2) of a join's piece b, seen from the top-left pixel of a, which stands after quarter `turns`."""
    a, _, b, _ = joins.sides[row].tolist()
    turn, at = int(joins.turn[row]), tuple(joins.offset[row].tolist())
    one, two = size_of(puzzle.pieces[a], 0), size_of(puzzle.pieces[b], turn)
    for _ in range(turns % 4):
        at, one, two = turned_offset(at, one, two), one[::-1], two[::-1]
    return turned_polygon(puzzle.pieces[b].polygon, size_of(puzzle.pieces[b], 0), (turn + turns) % 4) + np.array(at)


def alike(puzzle: Puzzle, first: Joins, row: int, second: Joins, k: int) -> bool:
    """Whether two joins put the same sides together in the same place, whichever piece is named first."""
    if first.sides[row].tolist() != second.sides[k].tolist():
        first, row = turned_round(puzzle, first, row), 0
    same = first.sides[row].tolist() == second.sides[k].tolist() and first.turn[row] % 4 == second.turn[k] % 4
    return bool(same and (first.offset[row] == second.offset[k]).all())


def _reach(sides: np.ndarray, k: int) -> float:
    """A distance of middles beyond which no side can touch side k."""
    longest = np.hypot(*(sides[:, 1] - sides[:, 0]).T).max()
    return float(longest + np.hypot(*(sides[k, 1] - sides[k, 0])))


def _facing(side: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Which sides (m, 2, 2) run against one side (2, 2) close by, (m,) bool."""
    along = side[1] - side[0]
    length = max(float(np.hypot(*along)), 1e-9)
    unit = along / length
    relative = others - side[0]
    t, apart = relative @ unit, np.abs(relative @ np.array([-unit[1], unit[0]])).max(axis=1)
    run = t[:, 0] - t[:, 1]  # positive where the other runs the opposite way
    common = np.minimum(t.max(axis=1), length) - np.maximum(t.min(axis=1), 0)
    return (apart <= NEAR) & (run > 0) & (common >= 0.5 * np.minimum(length, np.abs(run)))


def _standing_joins(puzzle: Puzzle, solution: PuzzleSolution, rows: np.ndarray) -> Joins:
    """Sides (j, 4) as joins with the places that the pieces have now."""
    a, b = rows[:, 0], rows[:, 2]
    turn = (solution.turns[b] - solution.turns[a]) % 4
    offset = []
    for i, j in zip(a.tolist(), b.tolist(), strict=True):
        u, v = (solution.position[j] - solution.position[i]).tolist()
        at = (u, v)
        one_size, other = (size_of(puzzle.pieces[k], int(solution.turns[k])) for k in (i, j))
        for _ in range(-int(solution.turns[i]) % 4):  # on, until piece a stands as it was read
            at, one_size, other = turned_offset(at, one_size, other), one_size[::-1], other[::-1]
        offset.append(at)
    return Joins(rows, np.array(offset, np.int64).reshape(-1, 2), turn, np.ones(len(rows)))
