"""Puzzles of equal squares: candidates and their probabilities (slow), then blocks, completion and judge (fast)."""

import time

import numpy as np

from ..errors import BadInput
from ..progress import Progress, onwards, share, silent
from . import assembly
from .blocks import Blocks, grow_blocks
from .candidates import Candidates, shortlist
from .completing import Layout, complete
from .dissection import SMALLEST
from .evidence import evidence
from .gridreading import confidence_of, read_solution, rows_of, touching_sides
from .gridwishes import GridJob, PreparedGrid, with_wishes
from .learned import learned_probability, single_probability
from .measures import Strips, side_strips
from .parameters import PuzzleParameters
from .pieces import Puzzle
from .solution import UNPLACED, PuzzleSolution, Wishes

LEAST = 0.4  # probability below which no method joins blocks before contacts are summed
SURE_ENOUGH = 0.5  # the default tries other ways where joins of the first are less likely than this
LEAST_JOINED = 0.75  # share of sides surely joined below which borders may be worn
KEPT = (0.0, 2.0, 0.5, 4.0)  # log odds of the joins that are kept when a picture is taken apart
MOST_REBUILT = 10  # times
HOPEFUL = 0.5  # share of sides surely joined above which all that may help is tried
MOST_FOR_LP = 4000  # pieces up to which the default tries the linear programme too


def prepare_grid(puzzle: Puzzle, parameters: PuzzleParameters, *, progress: Progress = silent) -> PreparedGrid:
    """Compare all sides, list the likely partners of each and say how probable each join is."""
    began = time.perf_counter()
    if (puzzle.square or 0) < SMALLEST:
        raise BadInput(
            f"The pieces of {puzzle.name} are {puzzle.square} pixels wide, too small to compare; give pieces of at least {SMALLEST}."
        )
    rasters = puzzle.rasters()
    strips = side_strips(rasters)
    worn = parameters.wear == "worn"
    notes: tuple[str, ...] = ()
    found, value, probability = _measured(puzzle, rasters, strips, parameters, worn, share(progress, 0.0, 0.6))
    doubtful = parameters.wear == "auto" and parameters.measure == "learned"
    if doubtful and surely_joined(probability, found) < LEAST_JOINED:
        again = _measured(puzzle, rasters, strips, parameters, True, share(progress, 0.6, 0.95))
        if surely_joined(again[2], again[0]) > surely_joined(probability, found):
            found, value, probability = again
            notes = ("The borders of the pieces seem to have suffered; they are compared as worn ones.",)
    gathered = evidence(strips, found, probability)
    progress(1.0, "joins measured")
    seconds = {"joins": time.perf_counter() - began}
    return PreparedGrid(puzzle, strips, found, value, probability, gathered, parameters, seconds, notes)


def surely_joined(probability: np.ndarray, candidates: Candidates) -> float:
    """The share of sides that have a partner with a probability above 0.9."""
    return len(np.unique(candidates.pairs[probability > 0.9])) / max(len(candidates.start) - 1, 1)


def _measured(
    puzzle: Puzzle, rasters: np.ndarray, strips: Strips, parameters: PuzzleParameters, worn: bool, progress: Progress
) -> tuple[Candidates, np.ndarray, np.ndarray]:
    """Candidates, the measure's value (odds against by the borders alone, for the learned one) and the probability."""
    found = shortlist(strips, turned=puzzle.turned, by_mgc=parameters.listed, by_ssd=parameters.listed_by_colour,
                      worn=worn, progress=share(progress, 0.0, 0.5))  # fmt: skip
    if parameters.measure != "learned":
        return found, *single_probability(parameters.measure, found, strips)
    first, last = learned_probability(
        found, rasters, turned=puzzle.turned, worn=worn, progress=share(progress, 0.5, 1.0))  # fmt: skip
    return found, (1 - first) / (first + 1e-6), last


def assemble_grid(
    prepared: PreparedGrid, parameters: PuzzleParameters, *, wishes: Wishes, progress: Progress = silent
) -> PuzzleSolution:
    """Assemble a prepared puzzle; wishes are honoured exactly."""
    began = time.perf_counter()
    progress = onwards(progress)
    n = prepared.puzzle.count
    job = with_wishes(prepared, parameters, wishes)
    seconds = dict(prepared.seconds)
    layouts: dict[str, Layout] = {}
    confirmed: dict[str, np.ndarray] = {}
    hopeful = surely_joined(job.probability, job.candidates) >= HOPEFUL
    methods = _methods(parameters.method, n, hopeful)
    for number, method in enumerate(methods):
        step = share(progress, number / len(methods), (number + 1) / len(methods))
        step(0.0, f"assembling: {method}")
        if _settled(job, layouts):
            break
        order = _order(method, job, parameters, layouts, confirmed, share(step, 0.0, 0.4))
        blocks = (assembly.grown_greedily(job.probability, job.candidates, job.start, job.rules, LEAST)
                  if order is None else grow_blocks(job.candidates.pairs, order, job.start, job.rules)[0])  # fmt: skip
        layouts[method] = _completed(blocks, job, parameters, share(step, 0.4, 1.0))
    best = max(layouts, key=lambda name: _judged(layouts[name]))
    if parameters.method == "auto" and not _all_likely(job, layouts[best]):
        layouts[best] = _rebuilt(layouts[best], job, parameters, MOST_REBUILT if hopeful else len(KEPT), progress)
    seconds["assembly"] = time.perf_counter() - began
    progress(1.0, "assembled")
    return read_solution(job, best, layouts, confirmed, parameters, wishes, seconds, prepared.notes)


def _judged(layout: Layout) -> float:
    return layout.worth - 10.0 * float((layout.picture == UNPLACED).sum())


def _rebuilt(layout: Layout, job: GridJob, parameters: PuzzleParameters, most: int, progress: Progress) -> Layout:
    """The layout taken apart where its joins are weak and completed anew, as long as the judge finds it better.

    What was filled in or moved so far counts when blocks are merged again; in turns more and less is kept.
    """
    idle = 0
    for number in range(most):
        progress(1.0, "looking at weak joins again")
        rows = rows_of(job.candidates, touching_sides(layout))
        odds = job.evidence.logit[rows]
        kept = rows[(rows >= 0) & (odds >= KEPT[number % len(KEPT)])]
        order = kept[np.argsort(-job.evidence.logit[kept], kind="stable")]
        blocks = grow_blocks(job.candidates.pairs, order, job.start, job.rules)[0]
        again = _completed(blocks, job, parameters, lambda share, words: progress(1.0, words))
        if _judged(again) > _judged(layout) + 1e-6:
            layout, idle = again, 0
        else:
            idle += 1
        if idle == len(KEPT):
            break
    return layout


def _methods(method: str, n: int, hopeful: bool) -> tuple[str, ...]:
    """What is tried; the linear programme, which takes seconds where little is certain, only where it may help."""
    if method != "auto":
        return (method,)
    return ("mst", "loops", "lp") if n <= MOST_FOR_LP and hopeful else ("mst", "loops")


def _order(
    method: str, job: GridJob, parameters: PuzzleParameters, layouts: dict[str, Layout], confirmed: dict[str, np.ndarray],
    progress: Progress,
) -> np.ndarray | None:  # fmt: skip
    """Rows of the candidates in the order in which a method joins them; None for greedy growth."""
    p, found = job.probability, job.candidates
    if method == "greedy":
        return None
    if method == "loops":
        return assembly.loops_first(p, found, LEAST)
    if method == "lp":
        first = next(iter(layouts.values()), None)
        if first is None:
            tree = grow_blocks(found.pairs, assembly.by_probability(p, LEAST), job.start, job.rules)[0]
            first = _completed(tree, job, parameters, silent)
        return assembly.by_linear_programme(p, found, first.turns, rounds=12, least=0.05, progress=progress)
    if method in ("matchlift", "diffusion"):
        from .confirming import confirmed_joins

        kept = confirmed_joins(method, job.puzzle, job.strips, job.candidates, parameters, progress=progress).kept
        confirmed[method] = kept
        order = np.lexsort((-p, ~kept))
        return order[(p[order] >= LEAST) | kept[order]]
    return assembly.by_probability(p, LEAST)


def _completed(blocks: Blocks, job: GridJob, parameters: PuzzleParameters, progress: Progress) -> Layout:
    return complete(
        blocks, job.start, job.candidates, job.evidence, job.rules, groups=job.groups, pin=job.pin, pictures=job.puzzle.pictures,
        turned=job.puzzle.turned, missing=parameters.missing, progress=progress)  # fmt: skip


def _settled(job: GridJob, layouts: dict[str, Layout]) -> bool:
    """Whether nothing is left to improve: two ways came to the same, or every piece is placed and every join likely."""
    if len(layouts) < 1:
        return False
    first, *others = layouts.values()
    if others and any(abs(first.worth - other.worth) < 1e-6 for other in others):
        return True
    return _all_likely(job, first)


def _all_likely(job: GridJob, layout: Layout) -> bool:
    if (layout.picture == UNPLACED).any():
        return False
    return bool((confidence_of(job, touching_sides(layout)) >= SURE_ENOUGH).all())
