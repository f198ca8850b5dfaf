"""Puzzles made of pictures: cut, always shuffled, mixed with others, pieces lost."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from ..arrays import frozen_array
from ..errors import BadInput
from .dissection import SMALLEST, Dissection, merged, pieces_per_cell, rectangles, squares, triangles
from .pieces import Piece, Puzzle, Truth
from .turning import from_the_top, turned_polygon, turned_raster

Kind = Literal["squares", "merged", "rectangles", "triangles"]
KINDS: tuple[Kind, ...] = ("squares", "merged", "rectangles", "triangles")
USUAL_SIZE, USUAL_COUNT = 28, 50  # pixels of a square; how many rectangles


def cut(
    image: np.ndarray, *, kind: Kind = "squares", pieces: int | None = None, piece_size: int | None = None,
    turned: bool = False, seed: int = 0, name: str = "",
) -> tuple[Puzzle, Truth]:  # fmt: skip
    """Cut a picture (h, w, 3) uint8 into a shuffled puzzle and its truth.

    Grids ("squares", "merged", "triangles") take the size of a square in pixels or the wanted number of pieces, which
    they meet as nearly as equal squares can; the picture is cropped around its centre to whole squares. "rectangles"
    takes the number of pieces and uses the whole picture. `turned` turns every piece by random quarter turns. The same
    seed gives the same pieces. Raises `BadInput` where a picture has too few pixels for what is asked.
    """
    image = frozen_array(image, np.uint8, (None, None, 3), "The picture to be cut")
    rng = np.random.default_rng(seed)
    image, divided = _dissected(image, kind, pieces, piece_size, rng)
    count = len(divided.polygons)
    order = rng.permutation(count)
    turns = rng.integers(0, 4, count) if turned else np.zeros(count, dtype=np.int64)
    corners = np.array([np.floor(p.min(axis=0)) for p in divided.polygons], dtype=np.int64)
    made = tuple(
        _piece(image, divided, k, int(turn), f"piece {i}")
        for i, (k, turn) in enumerate(zip(order, turns, strict=True), 1)
    )
    frame = (image.shape[1], image.shape[0])
    puzzle = Puzzle(made, frame=frame, turned=turned, name=name or "puzzle")
    return puzzle, Truth(corners[order], turns, np.zeros(count), np.array([frame]))


def _piece(image: np.ndarray, divided: Dissection, k: int, turns: int, name: str) -> Piece:
    """Polygon k as a piece that `turns` clockwise quarter turns put upright."""
    polygon = divided.polygons[k]
    low, high = polygon.min(axis=0).astype(int), polygon.max(axis=0).astype(int)
    mask = divided.labels[low[1] : high[1], low[0] : high[0]] == k
    inside = np.where(mask[..., None], image[low[1] : high[1], low[0] : high[0]], 0)
    w, h = high - low
    outline = from_the_top(turned_polygon(polygon - low, (int(w), int(h)), -turns))
    return Piece(outline, turned_raster(inside, -turns), turned_raster(mask, -turns), name)


def _dissected(
    image: np.ndarray, kind: Kind, pieces: int | None, piece_size: int | None, rng: np.random.Generator
) -> tuple[np.ndarray, Dissection]:
    """The picture, cropped where it must be, and its division."""
    h, w = image.shape[:2]
    if kind not in KINDS:
        raise BadInput(f"A picture cannot be cut into '{kind}'; the ways are {', '.join(KINDS)}.")
    if pieces is not None and piece_size is not None:
        raise BadInput("Give the number of pieces or the size of a piece, not both.")
    if pieces is not None and pieces < 2:
        raise BadInput(f"A puzzle of {pieces} piece(s) is none; ask for at least 2.")
    if kind == "rectangles":
        if piece_size is not None:
            raise BadInput("Rectangles of arbitrary size have no piece size; give the number of pieces.")
        return image, rectangles(w, h, pieces or USUAL_COUNT, rng)
    px = piece_size if piece_size is not None else _square_for(w, h, pieces, kind) if pieces else USUAL_SIZE
    _check_size(px, w, h, pieces)
    columns, rows = w // px, h // px
    left, top = (w - columns * px) // 2, (h - rows * px) // 2
    cropped = image[top : top + rows * px, left : left + columns * px]
    if kind == "squares":
        return cropped, squares(columns, rows, px)
    return cropped, (merged if kind == "merged" else triangles)(columns, rows, px, rng)


def _square_for(w: int, h: int, pieces: int, kind: Kind) -> int:
    """The square, in pixels, whose grid gives nearly `pieces` pieces; the larger one if two are as near."""
    sizes = np.arange(1, max(w, h) + 1)
    counts = np.round((w // sizes) * (h // sizes) * pieces_per_cell(kind))
    return int(sizes[len(sizes) - 1 - np.abs(counts - pieces)[::-1].argmin()])


def _check_size(px: int, w: int, h: int, pieces: int | None) -> None:
    if pieces is not None and px < SMALLEST:
        raise BadInput(
            f"A picture of {w} × {h} pixels is too small for {pieces} pieces whose sides are at least {SMALLEST} "
            f"pixels; ask for at most {(w // SMALLEST) * (h // SMALLEST)}."
        )
    if px < SMALLEST:
        raise BadInput(f"A piece of {px} × {px} pixels is too small to compare; give at least {SMALLEST} pixels.")
    if (w // px) * (h // px) < 2:
        raise BadInput(
            f"A picture of {w} × {h} pixels gives {(w // px) * (h // px)} square(s) of {px} pixels; it takes at least 2, "
            "so give a smaller piece size."
        )


def mix(parts: Sequence[tuple[Puzzle, Truth]], seed: int) -> tuple[Puzzle, Truth]:
    """The pieces of several puzzles in one heap, shuffled; its frame is unknown, its pictures are counted."""
    if len(parts) < 2:
        raise BadInput("Mixing takes at least two puzzles.")
    pieces = [piece for puzzle, _ in parts for piece in puzzle.pieces]
    truths = [truth for _, truth in parts]
    first = np.cumsum([0, *(len(truth.sizes) for truth in truths)])
    picture = np.concatenate([truth.picture + start for truth, start in zip(truths, first, strict=False)])
    truth = Truth(
        np.concatenate([t.position for t in truths]), np.concatenate([t.turns for t in truths]), picture,
        np.concatenate([t.sizes for t in truths]),
    )  # fmt: skip
    whole = Puzzle(
        tuple(pieces), turned=any(puzzle.turned for puzzle, _ in parts), pictures=int(first[-1]),
        name=" and ".join(puzzle.name for puzzle, _ in parts),
    )  # fmt: skip
    return _chosen(whole, truth, np.random.default_rng(seed).permutation(len(pieces)))


def drop(puzzle: Puzzle, truth: Truth, missing: float, seed: int) -> tuple[Puzzle, Truth]:
    """Lose a share `missing` in [0, 1) of the pieces, chosen at random; the frame and the truth of the rest stay."""
    kept = puzzle.count - round(missing * puzzle.count)
    if not 0 <= missing < 1 or kept < 2:
        raise BadInput(f"Losing {missing:.0%} of {puzzle.count} pieces leaves no puzzle; lose fewer.")
    return _chosen(puzzle, truth, np.random.default_rng(seed).permutation(puzzle.count)[:kept])


def _chosen(puzzle: Puzzle, truth: Truth, order: np.ndarray) -> tuple[Puzzle, Truth]:
    """Some pieces in a new order, named by it."""
    pieces = tuple(replace(puzzle.pieces[k], name=f"piece {i}") for i, k in enumerate(order, 1))
    chosen = Truth(truth.position[order], truth.turns[order], truth.picture[order], truth.sizes)
    return replace(puzzle, pieces=pieces), chosen
