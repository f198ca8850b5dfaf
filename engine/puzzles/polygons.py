"""Puzzles of polygons: candidate joins and their odds (slow), then clusters, hypotheses and the rest (fast).

Sides that run against each other are brought together corner to corner, and all samples of the contact are compared
(thesis, chapter 5: sub-edges). Pieces are then placed by whole pixels beside each other, without overlap, so that all
the contacts that arise speak for it.
"""

import time
from dataclasses import dataclass, field

import numpy as np

from ..progress import Progress, share, silent
from .alignments import Alignments, alignments, contest_features, refined, with_slid
from .clusters import Layout, Trials
from .contacts import LEARNED, Ground, all_odds, ground_of
from .hypotheses import Hypothesis, Rules, filled, largest, put_together, reconsidered, room_around
from .identity import size_of
from .measures import CODES, IN_LAB, to_lab
from .packing import BUDGET, SHARE, packed, rotated_layout
from .parameters import PuzzleParameters
from .pieces import Piece, Puzzle
from .placedjoins import joins_of_layout, likely_partners
from .polygonmodels import Model, model_of
from .polygonwishes import start_layout
from .solution import UNPLACED, Joins, PuzzleSolution, Wishes
from .subedges import Sides, sides_of

PROMISING = -6.0  # log odds of a candidate that clusters are merged by
SURER = (0.0, 3.0, 6.0)  # summed log odds of the merges that packing starts from
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
    if ground.slack > 0:
        found = refined(ground, found, all_odds(model.form, found.feature))
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
    layout = _without_gaps(prepared, start, trials, best, layout, rules)
    picture, position, turns, sizes = _pictures(prepared, layout, rules)
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


def _without_gaps(
    prepared: PreparedPolygons, start: Layout, trials: Trials, best: Hypothesis, layout: Layout, rules: Rules
) -> Layout:
    """Where pieces found no room though the picture is exactly as large as all together: packed, if that succeeds.

    What stays as it is are the joins of the best hypothesis, first all of them, then only the surer ones.
    """
    puzzle = prepared.puzzle
    area = sum(int(piece.mask.sum()) for piece in puzzle.pieces)
    if not rules.width or area != rules.width * rules.height or len(np.unique(layout.cluster)) == 1:
        return layout
    for most in (SHARE, BUDGET):
        for least in SURER:
            core = put_together(prepared.ground, start, trials._replace(odds=best.odds), rules, least).layout
            found = packed(
                prepared.ground, start, core, int(largest(core, 1, rules.fixed)[0]), rules.forbidden,
                (rules.width, rules.height), fixed=rules.fixed >= 0, turned=puzzle.turned, base=rules.base, most=most,
            )  # fmt: skip
            if found is not None:
                return found
    return layout


def _tries(parameters: PuzzleParameters) -> int:
    return 0 if parameters.method == "mst" else parameters.hypotheses


def _rules(prepared: PreparedPolygons, parameters: PuzzleParameters, fixed: int, forbidden: np.ndarray) -> Rules:
    puzzle = prepared.puzzle
    known = puzzle.frame is not None and parameters.frame == "known" and puzzle.pictures == 1
    width, height = puzzle.frame if known and puzzle.frame is not None else (0, 0)
    return Rules(forbidden, fixed, width, height, puzzle.turned and fixed < 0, prepared.model.base)


def _pictures(
    prepared: PreparedPolygons, layout: Layout, rules: Rules
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The largest clusters as pictures: picture (n,), position (n, 2), turns (n,), sizes (pictures, 2)."""
    puzzle, n = prepared.puzzle, prepared.puzzle.count
    picture, position, turns = np.full(n, UNPLACED), np.zeros((n, 2), dtype=np.int64), np.zeros(n, dtype=np.int64)
    sizes, frame = [], (rules.width, rules.height)
    for number, name in enumerate(largest(layout, puzzle.pictures, rules.fixed)):
        inside = layout.cluster == name
        on = np.flatnonzero(inside)
        here = layout
        if (
            rules.either_way
            and rules.width
            and (_extent(puzzle, layout, on) > np.add(frame, 2 * prepared.ground.slack)).any()
        ):
            here = rotated_layout(prepared.ground, layout, 1, frame[::-1])  # it lies on its side
        low, high = _corners(puzzle, here, on)
        if number == 0 and rules.fixed >= 0:
            shift = np.zeros(2, dtype=np.int64)
        elif rules.width and (high - low <= frame).all():
            shift = np.array(room_around(prepared.ground, here, inside, frame)[0])
        else:
            shift = -low
        picture[on], position[on], turns[on] = number, here.place[on] + shift, here.turns[on]
        sizes.append(tuple(np.maximum(frame, high + shift)))
    return picture, position, turns, np.array(sizes)


def _corners(puzzle: Puzzle, layout: Layout, on: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The top-left and bottom-right pixels (2,) around some pieces."""
    extents = np.array([size_of(puzzle.pieces[i], int(layout.turns[i])) for i in on])
    return layout.place[on].min(axis=0), (layout.place[on] + extents).max(axis=0)


def _extent(puzzle: Puzzle, layout: Layout, on: np.ndarray) -> np.ndarray:
    low, high = _corners(puzzle, layout, on)
    return high - low


def candidate_joins_of_polygon(prepared: PreparedPolygons, piece: int, side: int) -> Joins:
    """The likely partners of one side of a piece, likeliest first."""
    return likely_partners(prepared.puzzle, prepared.ground, prepared.candidates, prepared.odds, piece, side)
