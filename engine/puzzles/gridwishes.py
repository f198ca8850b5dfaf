"""What people decided, worked into a prepared puzzle of equal squares before it is assembled."""

from dataclasses import dataclass, field, replace

import numpy as np

from ..errors import BadInput
from .blocks import STEP_X, STEP_Y, Blocks, Rules, grow_blocks, single_pieces
from .candidates import Candidates, candidates_of, exclusive
from .evidence import LIMIT, NEVER, Evidence
from .measures import Strips
from .parameters import PuzzleParameters
from .pieces import SIDE_NAMES, Puzzle
from .solution import Joins, Wishes
from .wishcheck import check_wishes

TAKEN = -9.0  # log odds of a join of a side that is locked to another


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


@dataclass(frozen=True, slots=True, eq=False)
class GridJob:
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


def with_wishes(prepared: PreparedGrid, parameters: PuzzleParameters, wishes: Wishes) -> GridJob:
    puzzle, n = prepared.puzzle, prepared.puzzle.count
    px = puzzle.square or 1
    frame = (
        None
        if puzzle.frame is None or parameters.frame == "unknown"
        else (puzzle.frame[0] // px, puzzle.frame[1] // px)
    )
    if frame is not None and frame[0] * frame[1] < n and puzzle.pictures == 1:
        frame = None
    locked, forbidden = (side_rows(joins, prepared.puzzle) for joins in (wishes.locked, wishes.forbidden))
    whole = Wishes(
        joins_of(locked, np.ones(len(locked)), px), joins_of(forbidden, np.zeros(len(forbidden)), px), wishes.pinned
    )
    check_wishes(puzzle if frame is not None else replace(puzzle, frame=None), whole)
    found, value, probability = prepared.candidates, prepared.value, prepared.probability
    e = prepared.evidence
    if len(locked) or len(forbidden):
        found, value, probability, e = _revised(prepared, locked, forbidden)
    pins = np.array([pin.piece for pin in wishes.pinned], dtype=np.int64)
    start, groups = _start_blocks(n, locked, forbidden, wishes, px, frame, puzzle.turned)
    rules = Rules(frame, puzzle.turned, forbidden, pins if frame is not None else pins[:0])
    first = wishes.pinned[0] if wishes.pinned else None
    pin = None if first is None else (first.piece, first.x // px, first.y // px, first.quarter_turns)
    return GridJob(puzzle, found, value, probability, e, rules, start, groups, pin, prepared.strips)


def side_rows(joins: Joins, puzzle: Puzzle) -> np.ndarray:
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
    logit = np.concatenate([prepared.evidence.logit, extra + TAKEN])[where]
    taken = np.isin(pairs, locked).any(axis=1)
    probability[taken], logit[taken] = 0.0, TAKEN
    key = pairs @ np.array([sides, 1])
    sure = np.isin(key, locked @ np.array([sides, 1]))
    never = np.isin(key, forbidden @ np.array([sides, 1]))
    probability[sure], logit[sure], value[sure] = 1.0, LIMIT, 0.0
    probability[never], logit[never] = 0.0, NEVER
    found = candidates_of(pairs, sides)
    probability = np.where(sure, 1.0, exclusive(probability, found))
    e = prepared.evidence
    return (
        found,
        value,
        probability,
        e._replace(start=found.start, partner=found.partner, row=found.index, logit=logit),
    )


def _start_blocks(
    n: int,
    locked: np.ndarray,
    forbidden: np.ndarray,
    wishes: Wishes,
    px: int,
    frame: tuple[int, int] | None,
    turned: bool,
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
        start = Blocks(block, x, y, turns)
    pinned = np.array([pin.piece for pin in pins if frame is not None], dtype=np.int64)
    rules = Rules(frame, turned, forbidden, pinned)
    blocks, taken = grow_blocks(locked, np.arange(len(locked)), start, rules)
    _refuse_made(blocks, forbidden)
    if not taken.all():
        a, b = locked[np.flatnonzero(~taken)[0]].tolist()
        raise BadInput(
            f"The locked join of piece {a // 4} ({SIDE_NAMES[a % 4]}) and piece {b // 4} ({SIDE_NAMES[b % 4]}) contradicts "
            "other locked or forbidden joins or pinned pieces; unlock one of them.")  # fmt: skip
    counts = np.bincount(blocks.block, minlength=n)
    groups = np.where(counts[blocks.block] > 1, blocks.block, -1)
    groups[[pin.piece for pin in pins]] = blocks.block[[pin.piece for pin in pins]]
    return blocks, groups


def _refuse_made(blocks: Blocks, forbidden: np.ndarray) -> None:
    """Raise `BadInput` where pins and locked joins by themselves bring a forbidden pair of sides together."""
    for a, b in forbidden.tolist():
        i, j = a // 4, b // 4
        d = (a % 4 + blocks.turns[i]) % 4
        beside = blocks.x[j] - blocks.x[i] == STEP_X[d] and blocks.y[j] - blocks.y[i] == STEP_Y[d]
        if blocks.block[i] == blocks.block[j] and beside and (b % 4 + blocks.turns[j]) % 4 == (d + 2) % 4:
            raise BadInput(
                f"Piece {i} ({SIDE_NAMES[a % 4]}) and piece {j} ({SIDE_NAMES[b % 4]}) are forbidden to touch, but pins or locked "
                "joins bring them together; take one of these back.")  # fmt: skip


def joins_of(sides: np.ndarray, confidence: np.ndarray, px: int, confirmed_by: tuple[str, ...] = ()) -> Joins:
    """Joins of square pieces of `px` pixels from side rows (j, 2)."""
    a, s, b, t = sides[:, 0] // 4, sides[:, 0] % 4, sides[:, 1] // 4, sides[:, 1] % 4
    step = np.column_stack([STEP_X, STEP_Y])
    return Joins(np.column_stack([a, s, b, t]), px * step[s], (s + 2 - t) % 4, confidence, confirmed_by)
