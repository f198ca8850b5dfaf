"""The likeliest partners of the sides of a piece, as the solver sees them."""

from dataclasses import replace

import numpy as np

from engine.puzzles.solution import Joins, PuzzleSolution

from .edits import one
from .state import PuzzleState


def partners_of_side(state: PuzzleState, piece: int, side: int) -> Joins | None:
    """The likely partners of one side, best first; None before anything was compared, or where there are none.

    The partner that the picture has there bears the confidence of the placed join, which its neighbours speak for too.
    """
    if state.prepared is None or state.puzzle is None or getattr(state.prepared, "puzzle", None) is not state.puzzle:
        return None
    from engine.puzzles.solving import candidate_joins

    found = candidate_joins(state.prepared, piece, side)
    return with_placed(found, state.solution) if len(found) else None


def with_placed(found: Joins, solution: PuzzleSolution | None) -> Joins:
    """The same joins; those that hold in the solution with the confidence that they have in it."""
    if solution is None:
        return found
    said = {}
    for row, sure in zip(solution.joins.sides.tolist(), solution.joins.confidence.tolist(), strict=True):
        said[tuple(row)] = said[(*row[2:], *row[:2])] = sure
    sure = [said.get(tuple(row), own) for row, own in zip(found.sides.tolist(), found.confidence.tolist(), strict=True)]
    return replace(found, confidence=np.array(sure))


def best_of_sides(state: PuzzleState, piece: int) -> list[Joins]:
    """The best partner of each side of a piece that has one (rows of joins), the most certain side first."""
    sides = range(len(state.puzzle.pieces[piece].polygon))
    found = [one(joins, 0) for joins in (partners_of_side(state, piece, side) for side in sides) if joins is not None]
    return sorted(found, key=lambda join: -float(join.confidence[0]))


def next_best(state: PuzzleState, piece: int) -> Joins | None:
    """The best partner of the piece's most certain side, or of the side after the one that is looked at."""
    found = best_of_sides(state, piece)
    if not found:
        return None
    here = -1
    if state.preview is not None and state.preview.sides[0, 0] == piece:
        side = int(state.preview.sides[0, 1])
        here = next((k for k, join in enumerate(found) if join.sides[0, 1] == side), -1)
    return found[(here + 1) % len(found)]


def side_confidence(state: PuzzleState, piece: int) -> np.ndarray:
    """How sure the best partner of each side is, (sides,) in [0, 1]; 0 where there is none."""
    sure = np.zeros(len(state.puzzle.pieces[piece].polygon))
    for join in best_of_sides(state, piece):
        sure[int(join.sides[0, 1])] = join.confidence[0]
    return sure
