"""Whether wishes can be honoured at all: each contradiction is one sentence, before anything is solved."""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from ..errors import BadInput
from .identity import Offset, Size, size_of, turned_offset
from .pieces import Puzzle
from .solution import Joins, Wishes
from .turning import turned_raster

SLACK = 2  # pixels by which outlines of polygons may be off
GRAZE = 1  # pixels by which a polygon may be off a forbidden join and still make it, as the solver counts
STEPS = ((0, -1), (1, 0), (0, 1), (-1, 0))  # from a square to its neighbour at each side
State = tuple[int, int, int]  # x, y of a turned raster, and its quarter turns


def check_wishes(puzzle: Puzzle, wishes: Wishes) -> None:
    """Raise `BadInput` in one sentence for the first wish that cannot be, or contradicts another.

    With pins a known frame lies as it is given; without it, nothing may reach further than the pieces side by side.
    """
    for joins, word in ((wishes.locked, "locked"), (wishes.forbidden, "forbidden")):
        _check_ends(puzzle, joins, word)
    _check_sides(puzzle, wishes)
    _check_pins(puzzle, wishes)
    for chain, pinned in chains(puzzle, wishes):
        _check_places(puzzle, chain, pinned)
        _check_forbidden(puzzle, wishes, chain, pinned)


def relation(puzzle: Puzzle, joins: Joins, row: int) -> tuple[Offset, int]:
    """Where a join puts b while a stands as it was read: its offset in pixels and quarter turns; sides say it of squares."""
    if puzzle.square is None:
        return (int(joins.offset[row, 0]), int(joins.offset[row, 1])), int(joins.turn[row]) % 4
    _, side_a, _, side_b = joins.sides[row].tolist()
    x, y = STEPS[side_a]
    return (puzzle.square * x, puzzle.square * y), (side_a + 2 - side_b) % 4


def _check_ends(puzzle: Puzzle, joins: Joins, word: str) -> None:
    for row, (a, side_a, b, side_b) in enumerate(joins.sides.tolist()):
        for piece, side in ((a, side_a), (b, side_b)):
            if not 0 <= piece < puzzle.count:
                raise BadInput(f"A {word} join names piece {piece}; pieces are numbered 0 to {puzzle.count - 1}.")
            if not 0 <= side < len(puzzle.pieces[piece].polygon):
                last = len(puzzle.pieces[piece].polygon) - 1
                raise BadInput(f"A {word} join names side {side} of piece {piece}, which has the sides 0 to {last}.")
        if a == b:
            raise BadInput(f"A {word} join joins piece {a} to itself; remove it.")
        if word == "locked" and not puzzle.turned and relation(puzzle, joins, row)[1]:
            raise BadInput(f"The locked join of pieces {a} and {b} turns a piece, but pieces are not turned here; use --rotate.")


def _key(joins: Joins, k: int) -> tuple[tuple[int, int], tuple[int, int]]:
    a, side_a, b, side_b = joins.sides[k].tolist()
    first, second = sorted(((a, side_a), (b, side_b)))
    return first, second


def _check_sides(puzzle: Puzzle, wishes: Wishes) -> None:
    """A side of a square has one partner; nothing is both locked and forbidden."""
    refused = {_key(wishes.forbidden, k): k for k in range(len(wishes.forbidden))}
    partner: dict[tuple[int, int], tuple[int, int]] = {}
    for k in range(len(wishes.locked)):
        key = _key(wishes.locked, k)
        (a, side_a), (b, side_b) = key
        if key in refused and _alike(puzzle, wishes.locked, k, wishes.forbidden, refused[key]):
            raise BadInput(f"The join of piece {a} side {side_a} and piece {b} side {side_b} is locked and forbidden; choose one.")
        for end, other in (key, key[::-1]) if puzzle.square is not None else ():
            if partner.setdefault(end, other) != other:
                first = partner[end]
                raise BadInput(f"Side {end[1]} of piece {end[0]} is locked to piece {first[0]} and to piece {other[0]}; unlock one.")


def _alike(puzzle: Puzzle, one: Joins, i: int, other: Joins, j: int) -> bool:
    """Whether two joins of the same two sides put the pieces in the same place."""
    if puzzle.square is not None or tuple(one.sides[i]) != tuple(other.sides[j]):
        return True
    return bool(np.abs(one.offset[i] - other.offset[j]).max() <= SLACK)


def _check_pins(puzzle: Puzzle, wishes: Wishes) -> None:
    seen: dict[int, State] = {}
    for pin in wishes.pinned:
        if not 0 <= pin.piece < puzzle.count:
            raise BadInput(f"A pin names piece {pin.piece}; pieces are numbered 0 to {puzzle.count - 1}.")
        if pin.quarter_turns % 4 and not puzzle.turned:
            raise BadInput(f"The pin of piece {pin.piece} turns it, but pieces are not turned here; use --rotate.")
        place = (pin.x, pin.y, pin.quarter_turns % 4)
        if seen.setdefault(pin.piece, place) != place:
            raise BadInput(f"Piece {pin.piece} is pinned to two places; keep one.")
        if puzzle.square is not None and (pin.x % puzzle.square or pin.y % puzzle.square):
            raise BadInput(f"Piece {pin.piece} is pinned to ({pin.x}, {pin.y}); squares lie at multiples of {puzzle.square} pixels.")


def chains(puzzle: Puzzle, wishes: Wishes) -> list[tuple[dict[int, State], bool]]:
    """Where the pieces of each locked chain stand to each other, and whether that is in the picture; pins are one chain.

    Raises `BadInput` where a chain does not close or two pins contradict what is locked between them.
    """
    beside: dict[int, list[tuple[int, Offset, int, str]]] = defaultdict(list)
    for row, (a, _, b, _) in enumerate(wishes.locked.sides.tolist()):
        (dx, dy), turn = relation(puzzle, wishes.locked, row)
        words = f"of pieces {a} and {b}"
        beside[a].append((b, (dx, dy), turn, words))
        back, sizes = (-dx, -dy), (size_of(puzzle.pieces[b], turn), size_of(puzzle.pieces[a], 0))
        for _ in range((4 - turn) % 4):  # the same two pieces, turned together until b stands as it was read
            back, sizes = turned_offset(back, *sizes), (sizes[0][::-1], sizes[1][::-1])
        beside[b].append((a, back, (4 - turn) % 4, words))
    pinned = {pin.piece: (pin.x, pin.y, pin.quarter_turns % 4) for pin in wishes.pinned}
    result, left = [], set(beside) - set(pinned)
    if pinned:
        result.append((_followed(puzzle, pinned, beside), True))
        left -= set(result[0][0])
    while left:
        first = min(left)
        chain = _followed(puzzle, {first: (0, 0, 0)}, beside)
        result.append((chain, False))
        left -= set(chain)
    return result


def _followed(
    puzzle: Puzzle, start: dict[int, State], beside: dict[int, list[tuple[int, Offset, int, str]]]
) -> dict[int, State]:
    places, queue = dict(start), list(start)
    while queue:
        here = queue.pop()
        x, y, turns = places[here]
        for there, offset, turn, words in beside[here]:
            step = _turned(offset, size_of(puzzle.pieces[here], 0), size_of(puzzle.pieces[there], turn), turns)
            place = (x + step[0], y + step[1], (turns + turn) % 4)
            if there not in places:
                places[there] = place
                queue.append(there)
            elif places[there][2] != place[2] or max(abs(places[there][k] - place[k]) for k in (0, 1)) > _slack(puzzle):
                what = "the pins" if there in start and len(start) > 1 else "the other locked joins"
                raise BadInput(f"The locked join {words} contradicts {what}; unlock one of them.")
    return places


def _turned(offset: Offset, a: Size, b: Size, turns: int) -> Offset:
    for _ in range(turns):
        offset, a, b = turned_offset(offset, a, b), a[::-1], b[::-1]
    return offset


def _slack(puzzle: Puzzle) -> int:
    return 0 if puzzle.square is not None else SLACK


def _check_places(puzzle: Puzzle, chain: dict[int, State], pinned: bool) -> None:
    """Pieces of a chain must not overlap, must fit into a known frame, and lie near each other without one."""
    order = sorted(chain)
    boxes = np.array([(*chain[i][:2], *np.add(chain[i][:2], size_of(puzzle.pieces[i], chain[i][2]))) for i in order])
    for k, i in enumerate(order):
        near = np.all((boxes[:k, :2] < boxes[k, 2:]) & (boxes[:k, 2:] > boxes[k, :2]), axis=1)
        for j in np.flatnonzero(near):
            if _overlap(puzzle, (order[j], i), (chain[order[j]], chain[i])):
                said = "pinned" if pinned else "locked"
                raise BadInput(f"Pieces {order[j]} and {i} would overlap as they are {said}; unlock or unpin one of them.")
    frame = _frame(puzzle)
    if frame is None:
        _check_reach(puzzle, boxes, pinned)
    elif pinned:
        if (boxes[:, :2] < -_slack(puzzle)).any() or (boxes[:, 2:] > np.add(frame, _slack(puzzle))).any():
            raise BadInput(f"A piece is pinned or locked outside the picture of {frame[0]} × {frame[1]} pixels; unpin or unlock it.")
    else:
        _check_extent(puzzle, frame, boxes)


def _frame(puzzle: Puzzle) -> tuple[int, int] | None:
    """The known size of the one picture; None where it is unknown or too small for all squares, so that none can keep to it."""
    if puzzle.frame is None or puzzle.pictures > 1:
        return None
    px = puzzle.square
    if px is not None and (puzzle.frame[0] // px) * (puzzle.frame[1] // px) < puzzle.count:
        return None
    return puzzle.frame


def _check_extent(puzzle: Puzzle, frame: tuple[int, int], boxes: np.ndarray) -> None:
    (w, h), slack = frame, _slack(puzzle)
    extent = boxes[:, 2:].max(axis=0) - boxes[:, :2].min(axis=0)
    fits = bool(np.all(extent <= np.add((w, h), slack)) or (puzzle.turned and np.all(extent <= np.add((h, w), slack))))
    if not fits:
        raise BadInput(f"The locked pieces reach over {extent[0]} × {extent[1]} pixels, more than the picture of {w} × {h}; unlock some.")


def _check_reach(puzzle: Puzzle, boxes: np.ndarray, pinned: bool) -> None:
    """No picture without a frame is wider than all its pieces side by side; pins lie near its corner (0, 0), too."""
    reach = sum(max(piece.mask.shape) for piece in puzzle.pieces)
    starts = np.concatenate([boxes[:, :2], np.zeros((int(pinned), 2), dtype=boxes.dtype)])
    apart = int((starts.max(axis=0) - starts.min(axis=0)).max())
    if apart > reach:
        what = "Pieces are pinned" if pinned else "Locked pieces lie"
        raise BadInput(f"{what} {apart} pixels from each other or from the picture's corner, but all {puzzle.count} pieces side by "
                       f"side reach over {reach}; bring them nearer.")  # fmt: skip


def _check_forbidden(puzzle: Puzzle, wishes: Wishes, chain: dict[int, State], pinned: bool) -> None:
    """What pins and locked joins put side by side must not be forbidden."""
    slack = 0 if puzzle.square is not None else GRAZE
    for row, (a, side_a, b, side_b) in enumerate(wishes.forbidden.sides.tolist()):
        if a not in chain or b not in chain:
            continue
        offset, turn = relation(puzzle, wishes.forbidden, row)
        x, y, turns = chain[a]
        step = _turned(offset, size_of(puzzle.pieces[a], 0), size_of(puzzle.pieces[b], turn), turns)
        u, v, there = chain[b]
        if there == (turns + turn) % 4 and max(abs(x + step[0] - u), abs(y + step[1] - v)) <= slack:
            what = "pins and locked joins put" if pinned else "locked joins put"
            raise BadInput(f"The join of piece {a} side {side_a} and piece {b} side {side_b} is forbidden, but {what} the two there; "
                           "allow it, or unlock or unpin one of them.")  # fmt: skip


def _overlap(puzzle: Puzzle, pieces: Sequence[int], places: Sequence[State]) -> bool:
    """Whether the masks of two placed pieces share more than a rim of a few pixels."""
    if puzzle.square is not None:
        return True  # their boxes overlap
    (x, y, _), (u, v, _) = places
    first, second = (turned_raster(puzzle.pieces[i].mask, place[2]) for i, place in zip(pieces, places, strict=True))
    left, top = max(x, u), max(y, v)
    right, bottom = min(x + first.shape[1], u + second.shape[1]), min(y + first.shape[0], v + second.shape[0])
    shared = first[top - y : bottom - y, left - x : right - x] & second[top - v : bottom - v, left - u : right - u]
    return int(shared.sum()) > SLACK * max(*first.shape, *second.shape)
