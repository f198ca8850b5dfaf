"""A file of wishes (schema concord.wishes/1): joins locked or forbidden and pieces pinned, as people write it."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import BadInput
from ..store import write_atomically
from .pieces import Puzzle
from .solution import Joins, Pin, Wishes
from .solutionfile import compact, joins_to_json, read_json, whole_number
from .turning import turned_polygon

SCHEMA = "concord.wishes/1"


def write_wishes(path: Path | str, wishes: Wishes) -> None:
    """Write wishes so that `read_wishes` gives them back for the same puzzle; raises `BadInput`."""
    pins = [pin._asdict() for pin in wishes.pinned]
    content = {"schema": SCHEMA, "locked": joins_to_json(wishes.locked), "forbidden": joins_to_json(wishes.forbidden),
               "pinned": pins}  # fmt: skip
    write_atomically(path, compact(content))


def read_wishes(path: Path | str, puzzle: Puzzle) -> Wishes:
    """Wishes from a file, checked against a puzzle: unknown pieces, sides and contradictions raise `BadInput`.

    A piece is its number or its name. A join takes `a`, `side_a`, `b`, `side_b` (numbers, or top, right, bottom, left);
    `dx`, `dy` may say where b lies, else the two sides meet corner to corner; the quarter turns follow from the sides.
    """
    from .wishcheck import check_wishes

    path = Path(path)
    content = read_json(path, SCHEMA, "file of wishes")
    names = _numbers_of_names(puzzle)
    locked, forbidden = (_joins(path, content, key, puzzle, names) for key in ("locked", "forbidden"))
    pins = []
    for k, entry in enumerate(_entries(path, content, "pinned")):
        where = f"The pin {k + 1} in {path}"
        piece = _piece(entry.get("piece"), puzzle, names, where)
        x, y, turns = (_number(entry.get(key, 0 if key == "quarter_turns" else None), where) for key in ("x", "y", "quarter_turns"))
        pins.append(Pin(piece, x, y, turns % 4))
    wishes = Wishes(locked, forbidden, tuple(pins))
    check_wishes(puzzle, wishes)
    return wishes


def _entries(path: Path, content: Mapping[str, Any], key: str) -> Sequence[Mapping[str, Any]]:
    entries = content.get(key, [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise BadInput(f"'{key}' in {path} must be a list of objects; see the README for an example.")
    return entries


def _numbers_of_names(puzzle: Puzzle) -> dict[str, int]:
    """Numbers of pieces by their names, without those that several share."""
    found: dict[str, int] = {}
    for i, piece in enumerate(puzzle.pieces):
        found[piece.name] = -1 if piece.name in found else i
    return found


def _piece(value: Any, puzzle: Puzzle, names: Mapping[str, int], where: str) -> int:
    if isinstance(value, str) and names.get(value, -1) >= 0:
        return names[value]
    if isinstance(value, int) and not isinstance(value, bool) and 0 <= value < puzzle.count:
        return value
    raise BadInput(
        f"{where} names the piece {value!r}, which there is not; pieces are numbered 0 to {puzzle.count - 1}."
    )


def _side(value: Any, piece: int, puzzle: Puzzle, where: str) -> int:
    from .pieces import SIDE_NAMES

    count = len(puzzle.pieces[piece].polygon)
    if value in SIDE_NAMES and puzzle.pieces[piece].mask.all():
        return SIDE_NAMES.index(value)
    if isinstance(value, int) and not isinstance(value, bool) and 0 <= value < count:
        return value
    raise BadInput(f"{where} names the side {value!r} of piece {piece}, which has the sides 0 to {count - 1}.")


def _number(value: Any, where: str) -> int:
    try:
        return whole_number(value)
    except (ValueError, OverflowError):
        raise BadInput(f"{where} needs whole numbers of pixels and quarter turns, not {value!r}.") from None


def _joins(path: Path, content: Mapping[str, Any], key: str, puzzle: Puzzle, names: Mapping[str, int]) -> Joins:
    sides, offsets, turns = [], [], []
    for k, entry in enumerate(_entries(path, content, key)):
        where = f"The {key} join {k + 1} in {path}"
        a, b = (_piece(entry.get(end), puzzle, names, where) for end in ("a", "b"))
        side_a, side_b = _side(entry.get("side_a"), a, puzzle, where), _side(entry.get("side_b"), b, puzzle, where)
        turn, offset = meeting(puzzle, a, side_a, b, side_b, where)
        if puzzle.square is None and ("dx" in entry or "dy" in entry):
            offset = (_number(entry.get("dx"), where), _number(entry.get("dy"), where))
        sides.append((a, side_a, b, side_b))
        offsets.append(offset)
        turns.append(turn)
    return Joins(np.array(sides).reshape(-1, 4), np.array(offsets).reshape(-1, 2), np.array(turns), np.ones(len(sides)))


def meeting(puzzle: Puzzle, a: int, side_a: int, b: int, side_b: int, where: str = "The join") -> tuple[int, tuple[int, int]]:
    """The quarter turns of b and the offset of its raster if two sides meet, the first corner of a's at the last of b's."""
    one, other = puzzle.pieces[a], puzzle.pieces[b]
    along = np.roll(one.polygon, -1, axis=0)[side_a] - one.polygon[side_a]
    h, w = other.mask.shape
    for turn in range(4):
        polygon = turned_polygon(other.polygon, (w, h), turn)
        back = polygon[side_b] - np.roll(polygon, -1, axis=0)[side_b]
        cosine = float(along @ back) / max(float(np.hypot(*along) * np.hypot(*back)), 1e-9)
        if cosine > 0.98:
            offset = one.polygon[side_a] - polygon[(side_b + 1) % len(polygon)]
            return turn, (round(float(offset[0])), round(float(offset[1])))
    raise BadInput(f"{where} puts side {side_a} of piece {a} against side {side_b} of piece {b}, which are not parallel.")
