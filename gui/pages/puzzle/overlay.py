"""What the canvas and the panel show of a state: marks over the pieces, words about a join."""

from collections.abc import Sequence

import numpy as np

from engine.puzzles.pieces import SIDE_NAMES, Puzzle
from engine.puzzles.solution import Joins

from ...views.puzzle_layout import Layout
from ...views.puzzle_painting import Overlay
from ...views.puzzle_scene import bins, edges, join_keys, seams, shown_joins
from ..shapes.arrange import share_text
from .contacts import beside, turned_round
from .edits import rows_of
from .judging import judged_rows
from .partners import side_confidence
from .state import PuzzleState, scores_text


def overlay_of(state: PuzzleState, layout: Layout) -> Overlay:
    """The joins and marks of a state over its layout."""
    pinned = tuple(p.piece for p in state.wishes.pinned if layout.placed[p.piece])
    sides = side_marks(state, layout) | {"ghost": ghost(state, layout)}
    if state.solution is None or not len(state.solution.joins):
        return Overlay(piece=state.piece, pinned=pinned, **sides)
    joins, row = state.solution.joins, state.row
    locked = rows_of(joins, join_keys(state.wishes.locked))
    always = locked.copy()
    if row >= 0:
        always[row] = True
    marks = state.marks if state.overlay else None
    none = np.zeros(0, np.int64)
    return Overlay(
        seams(layout, joins), bins(joins.confidence), shown_joins(joins, state.below, state.piece, always),
        judged_rows(state.items, state.verdicts), locked, row, state.piece, pinned,
        wrong_pieces=none if marks is None else np.flatnonzero(~marks.places & layout.placed),
        wrong_joins=none if marks is None else np.flatnonzero(~marks.joins),
        caption="" if marks is None else "Beside the truth:  " + scores_text(marks.scores), **sides,
    )  # fmt: skip


def ghost(state: PuzzleState, layout: Layout) -> np.ndarray:
    """The outline (k, 2) on the canvas of the piece that a tried join would put beside a placed one; (0, 2) for none."""
    nothing = np.zeros((0, 2))
    if state.preview is None:
        return nothing
    join = state.preview
    if not layout.placed[join.sides[0, 0]]:
        join = turned_round(state.puzzle, join, 0)
    a = int(join.sides[0, 0])
    if not layout.placed[a]:
        return nothing
    return layout.position[a] + beside(state.puzzle, join, 0, int(layout.turns[a]))


def side_marks(state: PuzzleState, layout: Layout) -> dict[str, np.ndarray]:
    """The sides of a chosen piece in the tray, in the colours of how sure their best partners are."""
    if state.piece < 0 or layout.placed[state.piece] or state.prepared is None:
        return {}
    sure = side_confidence(state, state.piece)
    rows = np.arange(len(sure))
    return {"sides": edges(layout, layout.corners(), np.full(len(rows), state.piece), rows), "side_bins": bins(sure)}


def side_text(puzzle: Puzzle, turns: Sequence[int], piece: int, side: int) -> str:
    """'piece 12, right': a side as it stands, by its direction where the piece is a rectangle."""
    name = puzzle.pieces[piece].name or f"piece {piece + 1}"
    polygon = puzzle.pieces[piece].polygon
    if len(polygon) == 4 and puzzle.pieces[piece].mask.all():
        return f"{name}, {SIDE_NAMES[(side + int(turns[piece])) % 4]}"
    return f"{name}, side {side + 1} of {len(polygon)}"


def join_text(puzzle: Puzzle, turns: Sequence[int], joins: Joins, row: int) -> str:
    """'piece 12, right – piece 57, left'."""
    a, side_a, b, side_b = joins.sides[row].tolist()
    standing = {a: int(turns[a]), b: int(turns[a]) + int(joins.turn[row])}
    return f"{side_text(puzzle, standing, a, side_a)} – {side_text(puzzle, standing, b, side_b)}"


def why_text(joins: Joins, row: int, locked: bool) -> str:
    """How sure a join is and what confirmed it, in words."""
    how = {"loops": "confirmed by the pieces around it",
           "diffusion": "confirmed by diffusion pruning", "matchlift": "confirmed by MatchLift",
           "person": "locked by a person"}  # fmt: skip
    if locked:
        return "locked: it stays whatever the solver thinks"
    by = joins.confirmed_by[row]
    sure = f"confidence {share_text(float(joins.confidence[row]))}"
    return f"{sure} · {how.get(by, f'confirmed by {by}')}" if by else sure


def tip_text(state: PuzzleState, row: int) -> str:
    """What hovering over a join says."""
    if state.solution is None or row >= len(state.solution.joins):
        return ""
    joins = state.solution.joins
    return f"{join_text(state.puzzle, state.solution.turns, joins, row)}\nconfidence {share_text(float(joins.confidence[row]))}"
