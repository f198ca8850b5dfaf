"""Confirmed joins: the common form of all that decides which candidate joins between square sides are certain."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import frozen_array
from ..consistency.apart import matchlift_apart
from ..consistency.matchlift import matchlift
from ..errors import BadInput, BadParameter
from ..progress import Progress, silent
from .candidates import Candidates
from .corners import (
    corner_matrix,
    corner_similarity,
    join_confidence,
    meeting_corners,
    universe_of,
    unlike_corners,
)
from .halves import as_halves, half_dissimilarity
from .measures import Strips
from .parameters import PuzzleParameters
from .pieces import Puzzle
from .pruning import prune

PLAIN = "mgc-root"  # compares halves where the measure is the learned one, which compares whole sides only
LARGEST = 60  # corners that are lifted together where a puzzle is too large to be lifted at once


@dataclass(frozen=True, slots=True, eq=False)
class Confirmed:
    """Of c candidates: which are confirmed, `kept` (c,) bool, and how sure each is, `confidence` (c,) in [0, 1]."""

    kept: np.ndarray
    confidence: np.ndarray

    def __post_init__(self) -> None:
        c = len(self.kept)
        object.__setattr__(self, "kept", frozen_array(self.kept, bool, (c,), "What is confirmed"))
        object.__setattr__(self, "confidence", frozen_array(self.confidence, np.float64, (c,), "The confidence"))


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
            universe=_universe(puzzle, parameters), turned=puzzle.turned, progress=progress)  # fmt: skip
    raise BadParameter(f"The method '{method}' does not confirm joins; choose matchlift or diffusion.")


def _universe(puzzle: Puzzle, parameters: PuzzleParameters) -> int | None:
    """The points of the grid where the size of the picture is known, and all of it is there."""
    px = puzzle.square
    if puzzle.frame is None or px is None or parameters.frame == "unknown" or puzzle.pictures > 1:
        return None
    columns, rows = puzzle.frame[0] // px, puzzle.frame[1] // px
    return universe_of(columns, rows) if columns * rows == puzzle.count else None


def confirm_matchlift(
    rows: np.ndarray,
    dissimilarity: np.ndarray,
    *,
    count: int,
    t_1: float,
    t_2: float,
    sparsity: float,
    penalty: float,
    tolerance: float,
    max_steps: int,
    at_once: int,
    universe: int | None = None,
    turned: bool = False,
    progress: Progress = silent,
) -> Confirmed:
    """Confirm joins whose corners MatchLift finds consistent around every cycle (thesis, chapter 4).

    Parameters
    ----------
    rows
        (c, 2) int64 sides 4 i + side of the candidates, the two in any order, each pair once; right-left and bottom-top
        unless `turned`.
    dissimilarity
        (c, 2) of their halves (`half_dissimilarity`), or (c,) of the whole sides.
    count, universe
        n pieces, and the points of the grid where the frame is known (`universe_of`), else None: no bound.
    t_1, t_2
        The least similarity that is an input (Eq 4.5), and the least lifted match of **both** halves that confirms.
    at_once
        The largest number of pieces that are lifted all together, with the bound on the universe.
    sparsity, penalty, tolerance, max_steps
        Those of `engine.consistency.matchlift`.

    Notes
    -----
    The decomposition costs O(n³) a step. Puzzles of more than `at_once` pieces are therefore lifted without a bound on
    the universe, which falls apart into components of at most `LARGEST` corners. What is lost is small: few corners have
    inputs enough to feel that bound.
    """
    rows, halves = _candidates(rows, dissimilarity, count)
    similarity = corner_similarity(rows, halves)
    unlike = unlike_corners(count, turned=turned)
    how: dict[str, Any] = {"sparsity": sparsity, "penalty": penalty, "tolerance": tolerance, "max_steps": max_steps}
    if count <= at_once:
        found = matchlift(
            corner_matrix(rows, similarity, count, t_1=t_1), unlike[0], universe=universe,
            impossible=None if turned else unlike[1][:, None] == unlike[1], progress=progress, **how)  # fmt: skip
        lifted = join_confidence(rows, found.matches)
    else:
        corners, given = meeting_corners(rows), similarity >= t_1
        lifted = matchlift_apart(
            corners[given], similarity[given], unlike, corners.reshape(-1, 2), largest=LARGEST, progress=progress, **how
        ).reshape(-1, 2)  # fmt: skip
    confidence = lifted.min(axis=1)
    return Confirmed(confidence >= t_2, confidence)


def confirm_diffusion(
    rows: np.ndarray,
    dissimilarity: np.ndarray,
    *,
    count: int,
    knn: int,
    t_1: float,
    t_2: float,
    t_3: float,
    iterations: int,
    least: float,
    progress: Progress = silent,
) -> Confirmed:
    """Confirm joins by diffusion pruning of their halves (thesis, chapter 5), in O(c log c).

    `rows` and `dissimilarity` are as in `confirm_matchlift`, the rest as in `pruning.prune`. The confidence is how much
    a join's four correspondences support each other times the chance that a join so distinct from its rivals is right;
    what pruning keeps with less than `least` is not confirmed, for in its last rounds it joins sides of the frame.
    """
    rows, halves = _candidates(rows, dissimilarity, count)
    found = prune(rows, halves, knn=knn, t_1=t_1, t_2=t_2, t_3=t_3, iterations=iterations, progress=progress)
    return Confirmed(found.kept & (found.confidence >= least), found.confidence)


def _candidates(rows: np.ndarray, dissimilarity: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Checked candidates with the dissimilarity of both halves."""
    rows = frozen_array(rows, np.int64, (None, 2), "The candidate joins")
    halves = frozen_array(as_halves(dissimilarity), np.float64, (len(rows), 2), "The dissimilarity of the candidates")
    if len(rows) and not (rows.min() >= 0 and rows.max() < 4 * count):
        raise BadInput(f"The sides of the candidate joins must be rows 0 to {4 * count - 1} of {count} pieces.")
    if (rows[:, 0] // 4 == rows[:, 1] // 4).any():
        raise BadInput("A candidate joins a piece to itself; leave such pairs out.")
    if not (np.isfinite(halves).all() and (halves >= 0).all()):
        raise BadInput("The dissimilarity of the candidates must be finite and not negative.")
    return rows, halves
