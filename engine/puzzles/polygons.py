"""Puzzles of polygons: candidate joins and their odds (slow), then clusters, hypotheses and the rest (fast).

Sides that run against each other are brought together corner to corner, and all samples of the contact are compared
(thesis, chapter 5: sub-edges). Pieces are then placed by whole pixels beside each other, without overlap, so that all
the contacts that arise speak for it.
"""

import time
from dataclasses import dataclass, field

import numpy as np

from ..progress import Progress, share, silent
from .alignments import Alignments, alignments, contest_features, with_slid
from .clusters import Layout, Trials
from .contacts import LEARNED, Ground, all_odds, ground_of
from .hypotheses import Rules, filled, largest, reconsidered
from .identity import size_of
from .measures import CODES, IN_LAB, to_lab
from .parameters import PuzzleParameters
from .pieces import Piece, Puzzle
from .placedjoins import joins_of_layout, likely_partners
from .polygonmodels import Model, model_of
from .polygonwishes import start_layout
from .solution import UNPLACED, Joins, PuzzleSolution, Wishes
from .subedges import Sides, sides_of

PROMISING = -6.0  # log odds of a candidate that clusters are merged by
LEAST = 0.0  # summed log odds of a merge before the last pieces are filled in
NO_WISHES = Wishes()


@dataclass(frozen=True, slots=True, eq=False)
class PreparedPolygons:
    """What the fast part needs: the sides, their pixels for compiled loops, the candidates and their log odds (c,)."""

    puzzle: Puzzle
    sides: Sides
    ground: Ground
    candidates: Alignments
    odds: np.ndarray
    model: Model
    measure: str
    seconds: dict[str, float] = field(default_factory=dict)


def prepare_polygons(puzzle: Puzzle, parameters: PuzzleParameters, *, progress: Progress = silent) -> PreparedPolygons:
    """Sample all sides, list the candidate joins and say how likely each is."""
    began = time.perf_counter()
    progress(0.0, "sampling sides")
    model = model_of(parameters.measure)
    sides, ground = ground_for(puzzle, parameters.measure, model.form)
    progress(0.2, "comparing sides")
    found, _, logit = judged_candidates(ground, sides, model, turned=puzzle.turned)
    progress(1.0, f"{len(logit)} candidate joins")
    seconds = {"joins": time.perf_counter() - began}
    return PreparedPolygons(puzzle, sides, ground, found, logit, model, parameters.measure, seconds)


def ground_for(puzzle: Puzzle, measure: str, form: np.ndarray) -> tuple[Sides, Ground]:
    """The sides of a puzzle and all that compiled loops need, in the colours of a measure."""
    sides = sides_of(puzzle.pieces)
    colours = (to_lab(sides.outer), to_lab(sides.inner)) if measure in IN_LAB else (sides.outer, sides.inner)
    slack = 0.0 if all(is_exact(piece) for piece in puzzle.pieces) else 1.0
    code = LEARNED if measure == "learned" else CODES[measure]
    return sides, ground_of(puzzle.pieces, sides, *colours, slack=slack, code=code, form=form)


def judged_candidates(
    ground: Ground, sides: Sides, model: Model, *, turned: bool
) -> tuple[Alignments, np.ndarray, np.ndarray]:
    """All candidates, what their log odds are made of (c, 7), and their log odds (c,)."""
    found = alignments(ground, sides.piece, features=len(model.form) - 1, turned=turned)
    found, odds, edge = with_slid(ground, found, all_odds(model.form, found.feature))
    seen = contest_features(found, odds, edge, len(sides))
    return found, seen, seen @ model.contest


def is_exact(piece: Piece) -> bool:
    """Whether a polygon lies on whole pixels and holds as many as its area, but for those that its slopes cut."""
    x, y = piece.polygon.T
    area = abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()) / 2
    across = np.abs(piece.polygon - np.roll(piece.polygon, -1, axis=0)).min(axis=1).sum()
    whole = bool((piece.polygon == np.round(piece.polygon)).all())
    return whole and abs(area - piece.mask.sum()) <= across / 2 + 0.01


def assemble_polygons(
    prepared: PreparedPolygons, parameters: PuzzleParameters, *, wishes: Wishes = NO_WISHES, progress: Progress = silent
) -> PuzzleSolution:
    """Place the pieces; wishes are honoured exactly. Raises `BadInput` where they contradict each other."""
    began = time.perf_counter()
    puzzle = prepared.puzzle
    start, fixed, forbidden = start_layout(puzzle, wishes)
    rules = _rules(prepared, parameters, fixed, forbidden)
    everything = Trials(prepared.candidates.side, prepared.candidates.turn, prepared.candidates.offset, prepared.odds)
    trials = Trials(*(column[prepared.odds > PROMISING] for column in everything))
    best = reconsidered(
        prepared.ground, start, trials, rules, least=LEAST, tries=_tries(parameters), progress=share(progress, 0.0, 0.8)
    )
    progress(0.8, "filling in")
    layout = filled(prepared.ground, start, best.layout, everything, rules, puzzle.pictures)
    picture, position, turns, sizes = _pictures(puzzle, layout, rules)
    placed = Layout(np.where(picture == UNPLACED, -1 - np.arange(puzzle.count), picture), position, turns)
    joins = joins_of_layout(
        prepared.ground, placed, prepared.candidates, prepared.odds, prepared.model.base, prepared.model.placed,
        wishes.locked,
    )  # fmt: skip
    progress(1.0, "assembled")
    return PuzzleSolution(
        puzzle=puzzle.name, picture=picture, position=position, turns=turns, sizes=sizes, joins=joins,
        method=parameters.method, measure=prepared.measure, parameters=parameters,
        seconds=dict(prepared.seconds) | {"assembly": time.perf_counter() - began}, judge={"contacts": best.total},
        why_unplaced={int(i): "there is no room for it beside any other" for i in np.flatnonzero(picture == UNPLACED)},
    )  # fmt: skip


def _tries(parameters: PuzzleParameters) -> int:
    return 0 if parameters.method == "mst" else parameters.hypotheses


def _rules(prepared: PreparedPolygons, parameters: PuzzleParameters, fixed: int, forbidden: np.ndarray) -> Rules:
    puzzle = prepared.puzzle
    known = puzzle.frame is not None and parameters.frame == "known" and puzzle.pictures == 1
    width, height = puzzle.frame if known and puzzle.frame is not None else (0, 0)
    return Rules(forbidden, fixed, width, height, puzzle.turned and fixed < 0, prepared.model.base)


def _pictures(puzzle: Puzzle, layout: Layout, rules: Rules) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The largest clusters as pictures: picture (n,), position (n, 2), turns (n,), sizes (pictures, 2)."""
    n = puzzle.count
    picture, position, turns = np.full(n, UNPLACED), np.zeros((n, 2), dtype=np.int64), np.zeros(n, dtype=np.int64)
    sizes = []
    for number, name in enumerate(largest(layout, puzzle.pictures, rules.fixed)):
        on = np.flatnonzero(layout.cluster == name)
        picture[on], turns[on] = number, layout.turns[on]
        extents = np.array([size_of(puzzle.pieces[i], int(t)) for i, t in zip(on, turns[on], strict=True)])
        place = layout.place[on]
        if not (number == 0 and rules.fixed >= 0):
            place = place - place.min(axis=0)
        high = (place + extents).max(axis=0)
        if rules.either_way and rules.width and (high > (rules.width, rules.height)).any():  # it lies on its side
            place = np.column_stack([high[1] - place[:, 1] - extents[:, 1], place[:, 0]])
            turns[on], high = (turns[on] + 1) % 4, high[::-1]
        position[on] = place
        sizes.append((rules.width, rules.height) if rules.width else tuple(high))
    return picture, position, turns, np.array(sizes)


def candidate_joins_of_polygon(prepared: PreparedPolygons, piece: int, side: int) -> Joins:
    """The likely partners of one side of a piece, likeliest first."""
    return likely_partners(prepared.puzzle, prepared.ground, prepared.candidates, prepared.odds, piece, side)
