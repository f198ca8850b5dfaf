"""What time and scanners do to pieces: eroded borders, compression, noise, gain. For measuring, never for solving."""

import io
from collections.abc import Callable

import numpy as np

from ..errors import BadInput
from .dissection import SMALLEST
from .pieces import Piece, Puzzle, Truth, rectangle

Wearing = Callable[[np.ndarray, np.random.Generator], np.ndarray]


def eroded(px: int) -> Wearing:
    """Pixels lost from every side of a square piece."""
    return lambda raster, rng: raster[px:-px, px:-px]


def compressed(quality: int) -> Wearing:
    """JPEG, each piece by itself."""

    def wear(raster: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        from PIL import Image

        store = io.BytesIO()
        Image.fromarray(raster).save(store, "JPEG", quality=quality)
        return np.asarray(Image.open(store).convert("RGB"))

    return wear


def noisy(sigma: float) -> Wearing:
    """Independent Gaussian noise on every value."""
    return lambda raster, rng: _bytes(raster + rng.normal(0, sigma, raster.shape))


def uneven(share: float) -> Wearing:
    """A gain of its own for every piece, uniform in 1 ± share."""
    return lambda raster, rng: _bytes(raster * rng.uniform(1 - share, 1 + share))


def _bytes(values: np.ndarray) -> np.ndarray:
    return np.clip(np.round(values), 0, 255).astype(np.uint8)


ERODED = {"eroded 1": 1, "eroded 2": 2, "eroded 3": 3}  # pixels lost from every side
WEAR: dict[str, Wearing] = {
    **{kind: eroded(px) for kind, px in ERODED.items()}, "jpeg 90": compressed(90),
    "noise 3": noisy(3.0), "gain 5": uneven(0.05),
}  # fmt: skip


def check_wear(puzzle: Puzzle, kind: str) -> None:
    """Raise `BadInput` where `kind` leaves too little of the pieces of a square puzzle to compare."""
    px = puzzle.pieces[0].image.shape[0]
    lost = 2 * ERODED.get(kind, 0)
    if px - lost < SMALLEST:
        raise BadInput(f"The wear '{kind}' takes {lost} of the {px} pixels across a piece and must leave at least {SMALLEST}; "
                       f"cut pieces of {SMALLEST + lost} pixels or more.")  # fmt: skip


def worn(puzzle: Puzzle, truth: Truth, kind: str, seed: int) -> tuple[Puzzle, Truth]:
    """A square puzzle whose pieces have suffered `kind` (a key of `WEAR`); the same seed gives the same pieces.

    Eroded pieces are smaller; frame and true places shrink with them. Raises `BadInput` where too little is left.
    """
    check_wear(puzzle, kind)
    rng = np.random.default_rng(seed)
    rasters = [WEAR[kind](piece.image, rng) for piece in puzzle.pieces]
    pieces = tuple(
        Piece(rectangle(r.shape[1], r.shape[0]), r, np.ones(r.shape[:2], dtype=bool), p.name)
        for p, r in zip(puzzle.pieces, rasters, strict=True)
    )
    before, after = puzzle.pieces[0].image.shape[0], rasters[0].shape[0]
    frame = None if puzzle.frame is None else (puzzle.frame[0] // before * after, puzzle.frame[1] // before * after)
    moved = Truth(truth.position // before * after, truth.turns, truth.picture, truth.sizes // before * after)
    return Puzzle(pieces, frame, puzzle.turned, puzzle.pictures, puzzle.name, puzzle.notes), moved
