"""What solving a puzzle gives back, and what a person may ask of it."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..arrays import frozen_array
from .parameters import PuzzleParameters

UNPLACED = -1  # the picture of a piece that was not placed


@dataclass(frozen=True, slots=True, eq=False)
class Joins:
    """The j joins between sides of pieces, rows of arrays.

    `sides` (j, 4) int64: piece a, its side, piece b, its side. `turn` (j,) int64: clockwise quarter turns of b while a
    stands as it was read; `offset` (j, 2) int64: the top-left pixel of b's turned raster minus that of a's raster,
    in pixels, a standing as it was read. `confidence` (j,) float64 in [0, 1]: the calibrated probability that the join is right.
    `confirmed_by` (j,): what confirmed it ("loops", "diffusion", "matchlift", "person"), or "".
    """

    sides: np.ndarray
    offset: np.ndarray
    turn: np.ndarray
    confidence: np.ndarray
    confirmed_by: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        j = len(self.sides)
        for name, dtype, shape in (
            ("sides", np.int64, (j, 4)), ("offset", np.int64, (j, 2)), ("turn", np.int64, (j,)),
            ("confidence", np.float64, (j,)),
        ):  # fmt: skip
            object.__setattr__(self, name, frozen_array(getattr(self, name), dtype, shape, f"The {name} of joins"))
        if not self.confirmed_by:
            object.__setattr__(self, "confirmed_by", ("",) * j)

    def __len__(self) -> int:
        return len(self.sides)


def no_joins() -> Joins:
    """An empty list of joins."""
    return Joins(np.zeros((0, 4)), np.zeros((0, 2)), np.zeros(0), np.zeros(0))


class Pin(NamedTuple):
    """A piece that must stand at (x, y), its raster's top-left pixel, after clockwise quarter turns."""

    piece: int
    x: int
    y: int
    quarter_turns: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Wishes:
    """What people have decided, honoured exactly: joins that must hold, joins that must not, pieces that stay put."""

    locked: Joins = field(default_factory=no_joins)
    forbidden: Joins = field(default_factory=no_joins)
    pinned: tuple[Pin, ...] = ()

    def __bool__(self) -> bool:
        return bool(len(self.locked) or len(self.forbidden) or self.pinned)


@dataclass(frozen=True, slots=True, eq=False)
class PuzzleSolution:
    """Where the n pieces were placed and how sure their joins are.

    `picture` (n,) int64 is the picture that a piece was placed in, `UNPLACED` where it was not; `position` (n, 2)
    int64 the top-left pixel of its turned raster in that picture (zeros where unplaced); `turns` (n,) int64 its
    clockwise quarter turns. `joins` are those of touching sides in the assembly, a < b. `sizes` (pictures, 2) are the
    widths and heights of the assembled pictures. `why_unplaced` says in a few words why, by piece.
    """

    puzzle: str
    picture: np.ndarray
    position: np.ndarray
    turns: np.ndarray
    sizes: np.ndarray
    joins: Joins
    method: str
    measure: str
    parameters: PuzzleParameters
    seconds: dict[str, float] = field(default_factory=dict)
    judge: dict[str, float] = field(default_factory=dict)  # what the judge, which sees no truth, gave each assembler
    why_unplaced: dict[int, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.picture)
        for name, shape in (("picture", (n,)), ("position", (n, 2)), ("turns", (n,)), ("sizes", (None, 2))):
            checked = frozen_array(getattr(self, name), np.int64, shape, f"The {name} of a solution")
            object.__setattr__(self, name, checked)

    @property
    def placed(self) -> np.ndarray:
        """Which pieces were placed, (n,) bool."""
        return self.picture != UNPLACED
