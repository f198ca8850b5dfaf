"""Puzzles of equal squares: candidates and their probabilities (slow), then blocks, completion and judge (fast)."""

import time
from dataclasses import dataclass, field

import numpy as np

from ..errors import BadInput
from ..progress import Progress, share, silent
from . import assembly
from .blocks import Blocks, Rules, grow_blocks, single_pieces
from .candidates import Candidates, candidates_of, exclusive, shortlist
from .completing import Layout, complete, lying_as
from .evidence import NEVER, Evidence, evidence
from .learned import learned_probability, single_probability
from .measures import Strips, side_strips
from .parameters import PuzzleParameters
from .pieces import SIDE_NAMES, Puzzle
from .solution import UNPLACED, Joins, PuzzleSolution, Wishes

LEAST = 0.4  # probability below which no method joins blocks before contacts are summed
SURE_ENOUGH = 0.5  # the default tries other ways where joins of the first are less likely than this
LEAST_JOINED = 0.6  # share of sides surely joined below which borders may be worn
MOST_FOR_LP = 4000  # pieces up to which the default tries the linear programme too


@dataclass(frozen=True, slots=True, eq=False)
class PreparedGrid:
    """What the fast part needs of a square puzzle: strips, candidates, the measure's value and the probability (c,)."""

    puzzle: Puzzle
    strips: Strips
    candidates: Candidates
    value: np.ndarray
    probability: np.ndarray
    evidence: Evidence
    parameters: PuzzleParameters
    seconds: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def prepare_grid(puzzle: Puzzle, parameters: PuzzleParameters, *, progress: Progress = silent) -> PreparedGrid:
    """Compare all sides, list the likely partners of each and say how probable each join is."""
    began = time.perf_counter()
    rasters = puzzle.rasters()
    strips = side_strips(rasters)
    worn, notes = parameters.wear == "worn", ()
    found, value, probability = _measured(puzzle, rasters, strips, parameters, worn, share(progress, 0.0, 0.6))
    if (
        parameters.wear == "auto"
        and parameters.measure == "learned"
        and surely_joined(probability, found) < LEAST_JOINED
    ):
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
    puzzle, n = prepared.puzzle, prepared.puzzle.count
    job = _with_wishes(prepared, parameters, wishes)
    seconds = dict(prepared.seconds)
    layouts: dict[str, Layout] = {}
    confirmed: dict[str, np.ndarray] = {}
    for number, method in enumerate(_methods(parameters.method, n)):
        step = share(progress, number / 3, (number + 1) / 3)
        step(0.0, f"assembling: {method}")
        if _settled(job, layouts):
            break
        order = _order(method, job, parameters, layouts, confirmed, step)
        blocks = (assembly.grown_greedily(job.probability, job.candidates, job.start, job.rules, LEAST)
                  if order is None else grow_blocks(job.candidates.pairs, order, job.start, job.rules)[0])  # fmt: skip
        layouts[method] = complete(
            blocks, job.candidates, job.evidence, job.rules, groups=job.groups, pin=job.pin, pictures=puzzle.pictures,
            turned=puzzle.turned, missing=parameters.missing)  # fmt: skip
    best = max(layouts, key=lambda name: layouts[name].worth - 10.0 * (layouts[name].picture == UNPLACED).sum())
    seconds["assembly"] = time.perf_counter() - began
    progress(1.0, "assembled")
    return _solution(job, best, layouts, confirmed, parameters, wishes, seconds, prepared.notes)


def _methods(method: str, n: int) -> tuple[str, ...]:
    if method != "auto":
        return (method,)
    return ("mst", "loops", "lp") if n <= MOST_FOR_LP else ("mst", "loops")


@dataclass(frozen=True, slots=True, eq=False)
class _Job:
    """A prepared puzzle with the wishes worked in."""

    puzzle: Puzzle
    candidates: Candidates
    value: np.ndarray
    probability: np.ndarray
    evidence: Evidence
    rules: Rules
    start: Blocks
    groups: np.ndarray
    pin: tuple[int, int, int, int] | None
    strips: Strips


def _with_wishes(prepared: PreparedGrid, parameters: PuzzleParameters, wishes: Wishes) -> _Job:
    puzzle, n = prepared.puzzle, prepared.puzzle.count
    px = puzzle.square or 1
    frame = (
        None
        if puzzle.frame is None or parameters.frame == "unknown"
        else (puzzle.frame[0] // px, puzzle.frame[1] // px)
    )
    if frame is not None and frame[0] * frame[1] < n and puzzle.pictures == 1:
        frame = None
    locked, forbidden = (_side_rows(joins, prepared.puzzle) for joins in (wishes.locked, wishes.forbidden))
    found, value, probability = prepared.candidates, prepared.value, prepared.probability
    e = prepared.evidence
    if len(locked) or len(forbidden):
        found, value, probability, e = _revised(prepared, locked, forbidden)
    pins = np.array([pin.piece for pin in wishes.pinned], dtype=np.int64)
    start, groups = _start_blocks(n, locked, forbidden, wishes, px, frame)
    either_way = puzzle.turned and not len(pins)
    rules = Rules(frame, either_way, forbidden, pins if frame is not None else pins[:0])
    first = wishes.pinned[0] if wishes.pinned else None
    pin = None if first is None else (first.piece, first.x // px, first.y // px, first.quarter_turns)
    return _Job(puzzle, found, value, probability, e, rules, start, groups, pin, prepared.strips)


def _side_rows(joins: Joins, puzzle: Puzzle) -> np.ndarray:
    """Pairs of side rows (j, 2), the smaller first; raises `BadInput` for sides that there are not."""
    for a, side_a, b, side_b in joins.sides.tolist():
        for piece, side in ((a, side_a), (b, side_b)):
            if not (0 <= piece < puzzle.count and 0 <= side < 4):
                raise BadInput(
                    f"There is no side {side} of piece {piece}; pieces run from 0 to {puzzle.count - 1}, sides from 0 to 3."
                )
        if not puzzle.turned and (side_a + 2) % 4 != side_b:
            raise BadInput(
                f"The {SIDE_NAMES[side_a]} of piece {a} cannot lie at the {SIDE_NAMES[side_b]} of piece {b}: the pieces of this "
                "puzzle are not turned.")  # fmt: skip
    rows = 4 * joins.sides[:, [0, 2]] + joins.sides[:, [1, 3]]
    return np.sort(rows, axis=1).reshape(-1, 2)


def _revised(
    prepared: PreparedGrid, locked: np.ndarray, forbidden: np.ndarray
) -> tuple[Candidates, np.ndarray, np.ndarray, Evidence]:
    """Candidates with what people decided: locked joins are certain and their sides taken, forbidden ones impossible."""
    old = prepared.candidates
    sides = len(old.start) - 1
    said = np.concatenate([locked, forbidden])
    pairs, where = np.unique(np.concatenate([old.pairs, said]) @ np.array([sides, 1]), return_index=True)
    pairs = np.stack(np.divmod(pairs, sides), axis=1)
    extra = np.zeros(len(said))
    value = np.concatenate([prepared.value, extra + np.max(prepared.value, initial=1.0)])[where]
    probability = np.concatenate([prepared.probability, extra])[where]
    logit = np.concatenate([prepared.evidence.logit, extra - 9.0])[where]
    taken = np.isin(pairs, locked).any(axis=1)
    probability[taken], logit[taken] = 0.0, -9.0
    key = pairs @ np.array([sides, 1])
    sure = np.isin(key, locked @ np.array([sides, 1]))
    never = np.isin(key, forbidden @ np.array([sides, 1]))
    probability[sure], logit[sure], value[sure] = 1.0, 12.0, 0.0
    probability[never], logit[never] = 0.0, NEVER
    found = candidates_of(pairs, sides)
    probability = np.where(sure, 1.0, exclusive(probability, found))
    e = prepared.evidence
    return (
        found,
        value,
        probability,
        e._replace(start=found.start, partner=found.partner, index=found.index, logit=logit),
    )


def _start_blocks(
    n: int, locked: np.ndarray, forbidden: np.ndarray, wishes: Wishes, px: int, frame: tuple[int, int] | None
) -> tuple[Blocks, np.ndarray]:
    """Blocks that the locked joins and pins make, and the group of each locked piece (-1: none).

    Raises `BadInput` where the wishes contradict each other.
    """
    start = single_pieces(n)
    pins = wishes.pinned
    if pins:
        block, x, y, turns = (a.copy() for a in start)
        for pin in pins:
            if not 0 <= pin.piece < n:
                raise BadInput(f"There is no piece {pin.piece} to pin; pieces run from 0 to {n - 1}.")
            if frame is not None and not (0 <= pin.x // px < frame[0] and 0 <= pin.y // px < frame[1]):
                raise BadInput(
                    f"Piece {pin.piece} is pinned outside the picture; pin it within {frame[0]} × {frame[1]} pieces."
                )
            block[pin.piece] = pins[0].piece
            x[pin.piece], y[pin.piece], turns[pin.piece] = pin.x // px, pin.y // px, pin.quarter_turns % 4
        cells = {(pin.x // px, pin.y // px) for pin in pins}
        if len(cells) < len({pin.piece for pin in pins}):
            raise BadInput("Two pinned pieces share a place; unpin one of them.")
        start = Blocks(block, x, y, turns)
    blocks, taken = grow_blocks(locked, np.arange(len(locked)), start, Rules(forbidden=forbidden))
    if not taken.all():
        a, b = locked[np.flatnonzero(~taken)[0]].tolist()
        raise BadInput(
            f"The locked join of piece {a // 4} ({SIDE_NAMES[a % 4]}) and piece {b // 4} ({SIDE_NAMES[b % 4]}) contradicts "
            "other locked or forbidden joins or pinned pieces; unlock one of them.")  # fmt: skip
    counts = np.bincount(blocks.block, minlength=n)
    groups = np.where(counts[blocks.block] > 1, blocks.block, -1)
    groups[[pin.piece for pin in pins]] = blocks.block[[pin.piece for pin in pins]]
    return blocks, groups


def _order(
    method: str, job: _Job, parameters: PuzzleParameters, layouts: dict[str, Layout], confirmed: dict[str, np.ndarray],
    progress: Progress,
) -> np.ndarray | None:  # fmt: skip
    """Rows of the candidates in the order in which a method joins them; None for greedy growth."""
    p, found = job.probability, job.candidates
    if method == "greedy":
        return None
    if method == "loops":
        return assembly.loops_first(p, found, LEAST)
    if method == "lp":
        first = next(iter(layouts.values()), None) or complete(
            grow_blocks(found.pairs, assembly.by_probability(p, LEAST), job.start, job.rules)[0], found, job.evidence,
            job.rules, groups=job.groups, pin=job.pin, pictures=job.puzzle.pictures, turned=job.puzzle.turned, missing=parameters.missing)  # fmt: skip
        return assembly.by_linear_programme(p, found, first.turns, rounds=12, least=0.05, progress=progress)
    if method in ("matchlift", "diffusion"):
        from .confirmation import confirmed_joins

        kept = confirmed_joins(method, job.puzzle, job.strips, job.candidates, parameters, progress=progress).kept
        confirmed[method] = kept
        order = np.lexsort((-p, ~kept))
        return order[(p[order] >= LEAST) | kept[order]]
    return assembly.by_probability(p, LEAST)


def _settled(job: _Job, layouts: dict[str, Layout]) -> bool:
    """Whether nothing is left to improve: two ways came to the same, or every piece is placed and every join likely."""
    if len(layouts) < 1:
        return False
    first, *others = layouts.values()
    if others and any(abs(first.worth - other.worth) < 1e-6 for other in others):
        return True
    if (first.picture == UNPLACED).any():
        return False
    return bool((_confidence(job, _touching(first)) >= SURE_ENOUGH).all())


def _touching(layout: Layout) -> np.ndarray:
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


def _confidence(job: _Job, sides: np.ndarray) -> np.ndarray:
    """The calibrated probability (j,) of joins between side rows (j, 2); 0 where the pair was not even listed."""
    s = len(job.candidates.start) - 1
    keys = job.candidates.pairs @ np.array([s, 1])
    wanted = sides @ np.array([s, 1])
    place = np.minimum(np.searchsorted(keys, wanted), max(len(keys) - 1, 0))
    if not len(keys):
        return np.zeros(len(sides))
    return np.where(keys[place] == wanted, job.probability[place], 0.0)


def _solution(
    job: _Job, best: str, layouts: dict[str, Layout], confirmed: dict[str, np.ndarray], parameters: PuzzleParameters,
    wishes: Wishes, seconds: dict[str, float], notes: tuple[str, ...],
) -> PuzzleSolution:  # fmt: skip
    puzzle, px = job.puzzle, job.puzzle.square or 1
    layout = layouts[best] if job.pin or puzzle.pictures > 1 else lying_as(layouts[best], job.rules.frame)
    sides = _touching(layout)
    joins = joins_of(sides, _confidence(job, sides), px, _confirmations(job, sides, layout, confirmed, wishes))
    position = np.column_stack([layout.x, layout.y]) * px
    position[layout.picture == UNPLACED] = 0
    sizes = [_size(layout, k, job, px) for k in range(max(int(layout.picture.max()) + 1, 1))]
    why = {int(i): "no place where its sides fit was left" for i in np.flatnonzero(layout.picture == UNPLACED)}
    return PuzzleSolution(
        puzzle.name, layout.picture, position, np.where(layout.picture == UNPLACED, 0, layout.turns), np.array(sizes),
        joins, best, parameters.measure, parameters, seconds, {name: found.worth for name, found in layouts.items()}, why,
        notes)  # fmt: skip


def _size(layout: Layout, k: int, job: _Job, px: int) -> tuple[int, int]:
    on = layout.picture == k
    w, h = (int(c[on].max(initial=0)) + 1 for c in (layout.x, layout.y))
    frame = job.rules.frame
    if frame is not None and job.puzzle.pictures == 1:
        w, h = frame if w <= frame[0] and h <= frame[1] else frame[::-1]
    return w * px, h * px


def _confirmations(
    job: _Job, sides: np.ndarray, layout: Layout, confirmed: dict[str, np.ndarray], wishes: Wishes
) -> tuple[str, ...]:
    """What confirmed each join: a person, a method of the thesis, or a closed loop of four likely joins."""
    sure = exclusive_choice(job.probability, job.candidates)
    looped = assembly.closed_loops(sure, job.candidates) > 0
    said = {tuple(row): "person" for row in _side_rows(wishes.locked, job.puzzle).tolist()}
    by = {"loops": looped, **confirmed}
    rows = {tuple(row): a for a, row in enumerate(job.candidates.pairs.tolist())} if len(sides) < 20_000 else None
    if rows is None:
        s = len(job.candidates.start) - 1
        keys = job.candidates.pairs @ np.array([s, 1])
        place = np.minimum(np.searchsorted(keys, sides @ np.array([s, 1])), len(keys) - 1)
        found = np.where(keys[place] == sides @ np.array([s, 1]), place, -1).tolist()
    else:
        found = [rows.get(tuple(row), -1) for row in sides.tolist()]
    return tuple(
        said.get(tuple(row)) or next((name for name in reversed(by) if a >= 0 and by[name][a]), "")
        for row, a in zip(sides.tolist(), found, strict=True)
    )


def exclusive_choice(probability: np.ndarray, candidates: Candidates) -> np.ndarray:
    """Best buddies that are more likely right than not, (c,) bool: at most one for each side."""
    return assembly.best_buddies(probability, candidates) & (probability > 0.5)


def joins_of(sides: np.ndarray, confidence: np.ndarray, px: int, confirmed_by: tuple[str, ...] = ()) -> Joins:
    """Joins of square pieces from side rows (j, 2)."""
    a, s, b, t = sides[:, 0] // 4, sides[:, 0] % 4, sides[:, 1] // 4, sides[:, 1] % 4
    step = np.array([(0, -1), (1, 0), (0, 1), (-1, 0)])
    return Joins(np.column_stack([a, s, b, t]), px * step[s], (s + 2 - t) % 4, confidence, confirmed_by)


def candidate_joins_of_square(prepared: PreparedGrid, piece: int, side: int) -> Joins:
    """The likely partners of one side, likeliest first."""
    found, r = prepared.candidates, 4 * piece + side
    rows = found.index[found.start[r] : found.start[r + 1]]
    other = found.partner[found.start[r] : found.start[r + 1]]
    order = np.argsort(-prepared.probability[rows], kind="stable")
    sides = np.stack([np.full(len(order), r), other[order]], axis=1)
    return joins_of(sides, prepared.probability[rows][order], prepared.puzzle.square or 1)
