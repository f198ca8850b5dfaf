"""Small puzzles for tests of the window: a smooth picture of many colours, cut, and its true solution."""

import numpy as np

from engine.puzzles.cutting import cut
from engine.puzzles.parameters import PuzzleParameters
from engine.puzzles.pieces import Piece, Puzzle, Truth, rectangle
from engine.puzzles.solution import Joins, PuzzleSolution

PX = 16


def picture(columns=6, rows=4, px=PX, seed=3):
    """A picture (h, w, 3) uint8 without two places alike: soft blobs of colour and a little grain."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[: rows * px, : columns * px] / px
    image = np.zeros((rows * px, columns * px, 3))
    for _ in range(24):
        at, wide = rng.uniform((0, 0), (columns, rows)), rng.uniform(0.3, 1.4)
        image += rng.uniform(-120, 120, 3) * np.exp(-(((x - at[0]) ** 2 + (y - at[1]) ** 2) / wide**2))[..., None]
    return np.clip(image + 128 + rng.normal(0, 2, image.shape), 0, 255).astype(np.uint8)


def cut_small(columns=6, rows=4, px=PX, seed=0, **how):
    """A shuffled puzzle of `columns` × `rows` squares and its truth."""
    return cut(picture(columns, rows, px), piece_size=px, seed=seed, name="small", **how)


def flat(colour, w=4, h=4, name=""):
    """A rectangular piece of one colour."""
    return Piece(rectangle(w, h), np.full((h, w, 3), colour, np.uint8), np.ones((h, w), bool), name)


def two_by_two(px=4):
    """Four square pieces of one colour each, in reading order, and where they belong."""
    colours = ([200, 0, 0], [0, 200, 0], [0, 0, 200], [200, 200, 0])
    puzzle = Puzzle(tuple(flat(c, px, px, f"piece {k}") for k, c in enumerate(colours)), frame=(2 * px, 2 * px))
    position = np.array([[0, 0], [px, 0], [0, px], [px, px]])
    return puzzle, Truth(position, np.zeros(4), np.zeros(4), np.array([[2 * px, 2 * px]]))


def true_solution(puzzle: Puzzle, truth: Truth, confidence=None) -> PuzzleSolution:
    """All squares at their true place, with their joins: to the right, then downwards, by piece."""
    px = puzzle.pieces[0].image.shape[0]
    at = {tuple(p): k for k, p in enumerate(truth.position.tolist())}
    rows = []
    for (x, y), k in at.items():
        for side, step in ((1, (px, 0)), (2, (0, px))):
            other = at.get((x + step[0], y + step[1]))
            if other is not None:
                turns = [int(truth.turns[i]) for i in (k, other)]
                u, v = step
                for _ in range(turns[0]):  # back to how piece k was read
                    u, v = v, -u
                rows.append((k, (side - turns[0]) % 4, other, (side + 2 - turns[1]) % 4, u, v))
    table = np.array(sorted(rows), dtype=np.int64).reshape(-1, 6)
    sure = np.linspace(0.1, 1.0, len(table)) if confidence is None else np.asarray(confidence)
    turn = (truth.turns[table[:, 2]] - truth.turns[table[:, 0]]) % 4
    joins = Joins(table[:, :4], table[:, 4:], turn, sure)
    return PuzzleSolution(puzzle.name, truth.picture, truth.position, truth.turns, truth.sizes, joins, "true", "none",
                          PuzzleParameters())  # fmt: skip
