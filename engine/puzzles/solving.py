"""Solving a puzzle: `prepare` is slow and asks nothing of anybody, `assemble` is fast and honours wishes."""

from typing import TYPE_CHECKING

from ..errors import BadInput
from ..progress import Progress, share, silent
from .gridreading import candidate_joins_of_square
from .gridsolving import assemble_grid, prepare_grid
from .gridwishes import PreparedGrid
from .parameters import PuzzleParameters
from .pieces import Puzzle
from .solution import Joins, PuzzleSolution, Wishes

if TYPE_CHECKING:
    from .polygons import PreparedPolygons

NO_WISHES = Wishes()


def prepare(
    puzzle: Puzzle, parameters: PuzzleParameters, *, progress: Progress = silent
) -> "PreparedGrid | PreparedPolygons":
    """Compare all sides of all pieces: what takes seconds and does not depend on wishes or `live` parameters."""
    if puzzle.square is not None:
        return prepare_grid(puzzle, parameters, progress=progress)
    from .polygons import prepare_polygons

    return prepare_polygons(puzzle, parameters, progress=progress)


def assemble(
    prepared: "PreparedGrid | PreparedPolygons", parameters: PuzzleParameters, *, wishes: Wishes = NO_WISHES,
    progress: Progress = silent,
) -> PuzzleSolution:  # fmt: skip
    """Assemble prepared pieces; locked and forbidden joins and pinned pieces are honoured exactly.

    Raises `BadInput` where the wishes contradict each other.
    """
    if isinstance(prepared, PreparedGrid):
        return assemble_grid(prepared, parameters, wishes=wishes, progress=progress)
    from .polygons import assemble_polygons

    return assemble_polygons(prepared, parameters, wishes=wishes, progress=progress)


def solve(
    puzzle: Puzzle, parameters: PuzzleParameters, *, wishes: Wishes = NO_WISHES, progress: Progress = silent
) -> PuzzleSolution:
    """Prepare and assemble."""
    prepared = prepare(puzzle, parameters, progress=share(progress, 0.0, 0.7))
    return assemble(prepared, parameters, wishes=wishes, progress=share(progress, 0.7, 1.0))


def candidate_joins(prepared: "PreparedGrid | PreparedPolygons", piece: int, side: int) -> Joins:
    """The likely partners of one side of a piece, likeliest first. Raises `BadInput` for a side that there is not."""
    pieces = prepared.puzzle.pieces
    if not (0 <= piece < len(pieces) and 0 <= side < len(pieces[piece].polygon)):
        raise BadInput(f"There is no side {side} of piece {piece}.")
    if isinstance(prepared, PreparedGrid):
        return candidate_joins_of_square(prepared, piece, side)
    from .polygons import candidate_joins_of_polygon

    return candidate_joins_of_polygon(prepared, piece, side)
