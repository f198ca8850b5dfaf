"""How two joined pieces stand in the least rectangle that holds both."""

import numpy as np
import pytest
from puzzle_world import PX, cut_up, joins_of, touching

from engine.puzzles.identity import join_frame, size_of
from engine.puzzles.pieces import Piece, Puzzle
from engine.puzzles.solution import Joins


def oblong(w: int, h: int) -> Piece:
    return Piece(np.array([(0, 0), (w, 0), (w, h), (0, h)], float), np.zeros((h, w, 3), np.uint8), np.ones((h, w), bool))


@pytest.mark.parametrize(
    ("turns", "size", "corners"),
    [
        (0, (5, 3), ((0, 1), (3, 0))),
        (1, (3, 5), ((0, 0), (0, 3))),
        (2, (5, 3), ((2, 0), (0, 0))),
        (3, (3, 5), ((1, 2), (0, 0))),
    ],
)
def test_an_oblong_and_its_taller_neighbour_by_hand(turns, size, corners):
    """A piece of 3 × 2 pixels and at its right one of 2 × 3, a pixel higher; turned together clockwise."""
    puzzle = Puzzle((oblong(3, 2), oblong(2, 3)), name="two")
    frame = join_frame(puzzle, Joins([[0, 1, 1, 3]], [(3, -1)], [0], [1.0]), 0, turns)
    assert frame == (size, (turns, turns), corners)


def test_four_turns_are_none_and_both_pieces_fill_their_frame():
    puzzle, truth = cut_up(seed=3, turned=True)
    joins = joins_of(truth, touching(truth))
    for row, (a, b) in enumerate(joins.sides[:, ::2].tolist()):
        assert join_frame(puzzle, joins, row, 4) == join_frame(puzzle, joins, row, 0)
        frame = join_frame(puzzle, joins, row, row)
        assert sorted(frame.size) == [PX, 2 * PX]
        ends = [np.add(corner, size_of(puzzle.pieces[i], t)) for i, t, corner in zip((a, b), frame.turns, frame.corners, strict=True)]
        assert np.min(frame.corners, axis=0).tolist() == [0, 0]
        assert np.max(ends, axis=0).tolist() == list(frame.size)
