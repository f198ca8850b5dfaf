"""Confirming the candidates of a puzzle by the methods of the thesis, with the values of its parameters."""

import numpy as np

from ..errors import BadParameter
from ..progress import Progress, silent
from .candidates import Candidates
from .confirming import Confirmed, confirm_diffusion, confirm_matchlift
from .corners import universe_of
from .halves import half_dissimilarity
from .measures import Strips
from .parameters import PuzzleParameters
from .pieces import Puzzle

PLAIN = "mgc-root"  # compares halves where the measure is the learned one, which compares whole sides only


def confirmed_joins(
    method: str,
    puzzle: Puzzle,
    strips: Strips,
    candidates: Candidates,
    parameters: PuzzleParameters,
    *,
    progress: Progress = silent,
) -> Confirmed:
    """What "matchlift" or "diffusion" confirms of the c candidates of a puzzle of equal squares."""
    p, n = parameters, puzzle.count
    measure = PLAIN if p.measure == "learned" else p.measure
    length = max(1, round(p.half_length * strips.outer.shape[1]))
    if not candidates.count:
        return Confirmed(np.zeros(0), np.zeros(0))
    halves = half_dissimilarity(measure, strips, candidates.pairs, length=length)
    if method == "diffusion":
        return confirm_diffusion(
            candidates.pairs, halves, count=n, knn=p.prune_nearest, t_1=p.prune_similarity, t_2=p.prune_agreement,
            t_3=p.prune_share, iterations=p.prune_rounds, least=p.prune_confidence, progress=progress)  # fmt: skip
    if method == "matchlift":
        return confirm_matchlift(
            candidates.pairs, halves, count=n, t_1=p.lift_threshold, t_2=p.lift_accept, sparsity=p.lift_sparsity,
            penalty=p.lift_penalty, tolerance=p.lift_tolerance, max_steps=p.lift_steps, at_once=p.lift_whole,
            universe=universe_of(n, _grid(puzzle, parameters)), turned=puzzle.turned, progress=progress)  # fmt: skip
    raise BadParameter(f"The method '{method}' does not confirm joins; choose matchlift or diffusion.")


def _grid(puzzle: Puzzle, parameters: PuzzleParameters) -> tuple[int, int] | None:
    """(columns, rows) of the picture where they are known, and all of it is there."""
    px = puzzle.square
    if puzzle.frame is None or px is None or parameters.frame == "unknown" or puzzle.pictures > 1:
        return None
    grid = puzzle.frame[0] // px, puzzle.frame[1] // px
    return grid if grid[0] * grid[1] == puzzle.count else None
