"""A small picture whose every join is known: 4 × 3 squares of 8 pixels, no two alike."""

import numpy as np

from engine.puzzles.cutting import cut
from engine.puzzles.parameters import PuzzleParameters
from engine.puzzles.pieces import Puzzle, Truth
from engine.puzzles.solution import Joins, PuzzleSolution

PX, COLUMNS, ROWS = 8, 4, 3


def picture(px: int = PX, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (ROWS * px, COLUMNS * px, 3), dtype=np.uint8)


def cut_up(seed: int = 0, turned: bool = False, px: int = PX, image: np.ndarray | None = None) -> tuple[Puzzle, Truth]:
    return cut(picture(px) if image is None else image, piece_size=px, seed=seed, turned=turned, name="noise")


def joins_of(truth: Truth, pairs: list[tuple[int, int]], px: int = PX, confidence: list[float] | None = None) -> Joins:
    """The joins of pairs of squares as the truth places them, seen from the first of each pair as it was read."""
    rows, offsets, turns = [], [], []
    for a, b in pairs:
        x, y = (truth.position[b] - truth.position[a]).tolist()
        side = {(0, -px): 0, (px, 0): 1, (0, px): 2, (-px, 0): 3}.get((x, y), 0)
        for _ in range(-int(truth.turns[a]) % 4):  # turn the picture until a stands as it was read
            x, y = -y, x
        rows.append((a, (side - truth.turns[a]) % 4, b, (side + 2 - truth.turns[b]) % 4))
        offsets.append((x, y))
        turns.append((truth.turns[b] - truth.turns[a]) % 4)
    sure = confidence or [0.9] * len(pairs)
    return Joins(np.array(rows).reshape(-1, 4), np.array(offsets).reshape(-1, 2), np.array(turns), np.array(sure))


def touching(truth: Truth, px: int = PX) -> list[tuple[int, int]]:
    """Pairs a < b of squares that share a side in the picture."""
    gaps = np.abs(truth.position[:, None] - truth.position[None]).sum(axis=2)
    return [(int(a), int(b)) for a, b in np.argwhere(gaps == px) if a < b]


def solved(
    puzzle: Puzzle, truth: Truth, joins: Joins | None = None, *, asked: str = "loops", **changes: object
) -> PuzzleSolution:
    """The true assembly as a solver would hand it back that was asked for a method, and chose "mst" if for any."""
    values = {
        "puzzle": puzzle.name, "picture": truth.picture, "position": truth.position, "turns": truth.turns,
        "sizes": truth.sizes, "joins": joins if joins is not None else joins_of(truth, touching(truth)),
        "method": "mst" if asked == "auto" else asked, "measure": "mgc", "parameters": PuzzleParameters(method=asked),
        "seconds": {"assembly": 0.5},
    }  # fmt: skip
    return PuzzleSolution(**(values | changes))
