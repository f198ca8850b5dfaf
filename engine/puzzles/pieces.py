"""Pieces and puzzles. The true placement is a type of its own, which no solver takes."""

from dataclasses import dataclass, field

import numpy as np

from ..arrays import frozen_array
from ..errors import BadInput

TOP, RIGHT, BOTTOM, LEFT = 0, 1, 2, 3  # the sides of a square piece, clockwise
SIDE_NAMES = ("top", "right", "bottom", "left")


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """One piece: a polygon and the pixels inside it.

    `polygon` (v, 2) float64 are the corners (x, y) in pixels of its own raster, y down, clockwise as seen, the first
    being the topmost and then leftmost; side k runs from corner k to corner k+1. `image` (h, w, 3) uint8 is RGB,
    `mask` (h, w) bool says which of its pixels belong to the piece.
    """

    polygon: np.ndarray
    image: np.ndarray
    mask: np.ndarray
    name: str = ""

    def __post_init__(self) -> None:
        h, w = np.shape(self.image)[:2]
        object.__setattr__(self, "polygon", frozen_array(self.polygon, np.float64, (None, 2), "The polygon of a piece"))
        object.__setattr__(self, "image", frozen_array(self.image, np.uint8, (h, w, 3), "The image of a piece"))
        object.__setattr__(self, "mask", frozen_array(self.mask, bool, (h, w), "The mask of a piece"))
        if not self.mask.any():
            raise BadInput(f"The piece {self.name or '?'} has no pixels; give pieces of at least one pixel.")

    @property
    def is_square(self) -> bool:
        """Whether it is an upright square that fills its raster."""
        h, w = self.mask.shape
        return h == w and len(self.polygon) == 4 and bool(self.mask.all())


def rectangle(w: float, h: float) -> np.ndarray:
    """The polygon of an upright rectangle, (4, 2): its sides are top, right, bottom, left."""
    return np.array([[0, 0], [w, 0], [w, h], [0, h]], dtype=np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class Puzzle:
    """The n pieces of one puzzle, in an order that says nothing.

    `frame` is the known size (width, height) in pixels of the picture, or None; `turned` says that pieces may have to
    be turned by quarter turns; `pictures` is how many pictures are mixed.
    """

    pieces: tuple[Piece, ...]
    frame: tuple[int, int] | None = None
    turned: bool = False
    pictures: int = 1
    name: str = "puzzle"
    notes: tuple[str, ...] = field(default=())

    def __post_init__(self) -> None:
        if len(self.pieces) < 2:
            raise BadInput(f"The puzzle {self.name} has {len(self.pieces)} piece(s); it takes at least 2.")

    @property
    def count(self) -> int:
        """The number of pieces n."""
        return len(self.pieces)

    @property
    def square(self) -> int | None:
        """The side in pixels if all pieces are equal squares, else None."""
        px = self.pieces[0].image.shape[0]
        return px if all(p.is_square and p.image.shape[0] == px for p in self.pieces) else None

    def rasters(self) -> np.ndarray:
        """The pixels of all pieces of a square puzzle, (n, px, px, 3) uint8."""
        return np.stack([piece.image for piece in self.pieces])


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """Where the n pieces belong: kept apart from the puzzle.

    `position` (n, 2) int64 is the top-left pixel (x, y) of each piece's raster in its picture after `turns` (n,) int64
    clockwise quarter turns; `picture` (n,) int64 which picture it belongs to; `sizes` (pictures, 2) their (w, h).
    """

    position: np.ndarray
    turns: np.ndarray
    picture: np.ndarray
    sizes: np.ndarray

    def __post_init__(self) -> None:
        n = len(self.position)
        for name, shape in (("position", (n, 2)), ("turns", (n,)), ("picture", (n,)), ("sizes", (None, 2))):
            checked = frozen_array(getattr(self, name), np.int64, shape, f"The {name} of a true placement")
            object.__setattr__(self, name, checked)
