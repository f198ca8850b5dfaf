"""Identity of pieces and joins by content, so that one vote serves every method, order and turn of the pieces.

A piece as it stands is known by its pixels and mask; the piece itself by the least of its four turns; a join by its two
pieces as they stand and where they stand to each other, whichever is named first and however both are turned together.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..store import digest
from .pieces import Piece, Puzzle
from .solution import Joins
from .turning import turned_raster

Offset = tuple[int, int]
Size = tuple[int, int]


class JoinFrame(NamedTuple):
    """Two joined pieces in the least rectangle that holds both: its width and height in pixels, and of the pieces a and b
    the clockwise quarter turns (0 to 3) and the top-left pixel of the turned raster in it."""

    size: Size
    turns: tuple[int, int]
    corners: tuple[Offset, Offset]


@lru_cache(maxsize=4)
def standing_ids(puzzle: Puzzle) -> tuple[tuple[str, ...], ...]:
    """For each piece, its four hashes after 0, 1, 2, 3 clockwise quarter turns; equal pieces have equal hashes."""
    return tuple(tuple(_standing(piece, turns) for turns in range(4)) for piece in puzzle.pieces)


def _standing(piece: Piece, turns: int) -> str:
    """Hash of the size, the mask and the pixels inside it after clockwise quarter turns."""
    mask = turned_raster(piece.mask, turns)
    inside = turned_raster(piece.image, turns)[mask]
    return digest(b"piece", np.array(mask.shape, "<i8").tobytes(), np.packbits(mask).tobytes(), inside.tobytes())


def piece_ids(puzzle: Puzzle) -> tuple[str, ...]:
    """One hash a piece, the same however it was turned when it was read."""
    return tuple(map(min, standing_ids(puzzle)))


def puzzle_id(puzzle: Puzzle) -> str:
    """Hash of all pieces, the same in any order and turn."""
    return digest(b"puzzle", *(piece.encode() for piece in sorted(piece_ids(puzzle))))


def reading_id(puzzle: Puzzle) -> str:
    """Hash of all pieces in the order and turn in which they were read: what piece numbers and joins refer to."""
    return digest(b"reading", *(turns[0].encode() for turns in standing_ids(puzzle)))


def join_ids(puzzle: Puzzle, joins: Joins) -> tuple[str, ...]:
    """One hash a join (j,): of what the two pieces look like when they are put together."""
    return tuple(_join_id(puzzle, joins, row) for row in range(len(joins)))


def _join_id(puzzle: Puzzle, joins: Joins, row: int) -> str:
    seen = []
    for a, b, (x, y) in join_views(puzzle, joins, row):
        seen += [(a, b, x, y), (b, a, -x, -y)]
    first, second, x, y = min(seen)
    return digest(b"match", b"puzzle", first.encode(), second.encode(), f"{x} {y}".encode())


def join_views(puzzle: Puzzle, joins: Joins, row: int) -> list[tuple[str, str, Offset]]:
    """A join as it looks after 0, 1, 2, 3 clockwise quarter turns: a and b as they stand, and where b's raster begins."""
    ids, (a, b) = standing_ids(puzzle), joins.sides[row, ::2].tolist()
    turn, offset = int(joins.turn[row]), (int(joins.offset[row, 0]), int(joins.offset[row, 1]))
    sizes = size_of(puzzle.pieces[a], 0), size_of(puzzle.pieces[b], turn)
    found = []
    for turns in range(4):
        found.append((ids[a][turns], ids[b][(turn + turns) % 4], offset))
        offset, sizes = turned_offset(offset, *sizes), (sizes[0][::-1], sizes[1][::-1])
    return found


def size_of(piece: Piece, turns: int) -> Size:
    """Width and height of a piece's raster after quarter turns."""
    h, w = piece.mask.shape
    return (h, w) if turns % 2 else (w, h)


def turned_offset(offset: Offset, a: Size, b: Size) -> Offset:
    """Where b's raster begins, seen from a's, after both were turned clockwise together; sizes are those before."""
    return a[1] - b[1] - offset[1], offset[0]


def join_frame(puzzle: Puzzle, joins: Joins, row: int, turns: int) -> JoinFrame:
    """How the two pieces of a join stand after both were turned by so many clockwise quarter turns from where a was read."""
    a, b = joins.sides[row, ::2].tolist()
    turn, (x, y) = int(joins.turn[row]), joins.offset[row].tolist()
    one, two = size_of(puzzle.pieces[a], 0), size_of(puzzle.pieces[b], turn)
    for _ in range(turns % 4):
        (x, y), one, two = turned_offset((x, y), one, two), one[::-1], two[::-1]
    left, top = min(0, x), min(0, y)
    size = max(one[0], x + two[0]) - left, max(one[1], y + two[1]) - top
    return JoinFrame(size, (turns % 4, (turn + turns) % 4), ((-left, -top), (x - left, y - top)))
