"""From a layout of equal squares to a solution: positions, joins with their confidence, and what confirmed them."""

import numpy as np

from . import assembly
from .candidates import Candidates
from .completing import Layout, lying_as
from .evidence import Evidence, fits
from .gridwishes import GridJob, PreparedGrid, joins_of, side_rows
from .learned import placed_probability
from .parameters import PuzzleParameters
from .solution import UNPLACED, Joins, PuzzleSolution, Wishes


def touching_sides(layout: Layout) -> np.ndarray:
    """Touching pairs of pieces as side rows (j, 2), the smaller first, sorted."""
    on = np.flatnonzero(layout.picture != UNPLACED)
    x, y, k = layout.x[on], layout.y[on], layout.picture[on]
    x, y = x - x.min(initial=0), y - y.min(initial=0)
    grid = np.full(
        (int(k.max(initial=0)) + 1, int(y.max(initial=0)) + 2, int(x.max(initial=0)) + 2), -1, dtype=np.int64
    )
    grid[k, y, x] = on
    rows = []
    for first, second, d in ((grid[:, :, :-1], grid[:, :, 1:], 1), (grid[:, :-1], grid[:, 1:], 2)):
        there = (first >= 0) & (second >= 0)
        a, b = first[there], second[there]
        rows.append(np.stack([4 * a + (d - layout.turns[a]) % 4, 4 * b + (d + 2 - layout.turns[b]) % 4], axis=1))
    sides = np.concatenate(rows)
    sides = np.where((sides[:, :1] > sides[:, 1:]), sides[:, ::-1], sides)
    return sides[np.lexsort((sides[:, 1], sides[:, 0]))]


def rows_of(candidates: Candidates, sides: np.ndarray) -> np.ndarray:
    """Which candidate joins each pair of side rows (j, 2), the smaller first: (j,) int64, -1 for none."""
    if not candidates.count:
        return np.full(len(sides), -1)
    by = np.array([len(candidates.start) - 1, 1])
    keys, wanted = candidates.pairs @ by, sides @ by
    place = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    return np.where(keys[place] == wanted, place, -1)


def confidence_of(job: GridJob, sides: np.ndarray) -> np.ndarray:
    """The calibrated probability (j,) of joins between side rows (j, 2); 0 where the pair was not even listed."""
    rows = rows_of(job.candidates, sides)
    return np.where(rows >= 0, np.append(job.probability, 0.0)[rows], 0.0)


def placed_confidence(job: GridJob, sides: np.ndarray) -> np.ndarray:
    """The calibrated probability (j,) of the joins of an assembled picture, by side rows (j, 2)."""
    return placed_probability(*contact_odds(job.evidence, sides))


def contact_odds(e: Evidence, sides: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Log odds (j,) of touching side rows (j, 2), and the mean (j, 2) of the other contacts of their two pieces."""
    own = np.empty(len(sides))
    fits(e, np.ascontiguousarray(sides), own)
    pieces = sides // 4
    n = len(e.start) // 4
    total = np.bincount(pieces.ravel(), np.repeat(own, 2), n)
    count = np.bincount(pieces.ravel(), minlength=n)
    return own, (total[pieces] - own[:, None]) / np.maximum(count[pieces] - 1, 1)


def read_solution(
    job: GridJob, best: str, layouts: dict[str, Layout], confirmed: dict[str, np.ndarray], parameters: PuzzleParameters,
    wishes: Wishes, seconds: dict[str, float], notes: tuple[str, ...],
) -> PuzzleSolution:  # fmt: skip
    """The solution that the layout of the method `best` is; `layouts` are those of all methods tried."""
    puzzle, px = job.puzzle, job.puzzle.square or 1
    layout = layouts[best] if job.pin or puzzle.pictures > 1 else lying_as(layouts[best], job.rules.frame)
    out = layout.picture == UNPLACED
    position = np.where(out[:, None], 0, np.column_stack([layout.x, layout.y]))
    beyond = np.minimum(position.min(axis=0), 0)
    if beyond.any():
        notes = (*notes, f"The picture grew over its left or top border: all pieces, pinned ones too, moved by {-beyond[0] * px}, "
                 f"{-beyond[1] * px} pixels.")  # fmt: skip
        position = np.where(out[:, None], 0, position - beyond)
    sides = touching_sides(layout)
    joins = joins_of(sides, placed_confidence(job, sides), px, _confirmations(job, sides, confirmed, wishes))
    count = max(int(layout.picture.max()) + 1, 1)
    sizes = [px * _size(position[layout.picture == k], job) for k in range(count)]
    why = {int(i): "no place where its sides fit was left" for i in np.flatnonzero(out)}
    worths = {name: found.worth for name, found in layouts.items()}
    return PuzzleSolution(
        puzzle.name, layout.picture, px * position, np.where(out, 0, layout.turns), np.array(sizes), joins, best,
        parameters.measure, parameters, seconds, worths, why, notes)  # fmt: skip


def _size(cells: np.ndarray, job: GridJob) -> np.ndarray:
    """Columns and rows of a picture: those of its frame where that is known."""
    size = cells.max(axis=0, initial=0) + 1
    frame = job.rules.frame
    if frame is None or job.puzzle.pictures > 1:
        return size
    return np.array(frame if (size <= frame).all() else frame[::-1])


def _confirmations(
    job: GridJob, sides: np.ndarray, confirmed: dict[str, np.ndarray], wishes: Wishes
) -> tuple[str, ...]:  # fmt: skip
    """What confirmed each join: a person, a method of the thesis, or a closed loop of four likely joins."""
    sure = exclusive_choice(job.probability, job.candidates)
    by = {"loops": assembly.closed_loops(sure, job.candidates) > 0, **confirmed}
    rows = rows_of(job.candidates, sides)
    words = np.full(len(sides), "", dtype=object)
    for name, kept in by.items():
        words[np.append(kept, False)[rows]] = name
    locked = rows_of(job.candidates, side_rows(wishes.locked, job.puzzle))
    words[(rows >= 0) & np.isin(rows, locked)] = "person"
    return tuple(words.tolist())


def exclusive_choice(probability: np.ndarray, candidates: Candidates) -> np.ndarray:
    """Best buddies that are more likely right than not, (c,) bool: at most one for each side."""
    return assembly.best_buddies(probability, candidates) & (probability > 0.5)


def candidate_joins_of_square(prepared: PreparedGrid, piece: int, side: int) -> Joins:
    """The likely partners of one side, likeliest first."""
    found, r = prepared.candidates, 4 * piece + side
    rows = found.index[found.start[r] : found.start[r + 1]]
    other = found.partner[found.start[r] : found.start[r + 1]]
    order = np.argsort(-prepared.probability[rows], kind="stable")
    sides = np.stack([np.full(len(order), r), other[order]], axis=1)
    return joins_of(sides, prepared.probability[rows][order], prepared.puzzle.square or 1)
