"""Scores of solutions: hand-made placements with known values."""

from dataclasses import replace

import numpy as np
import pytest

from engine.puzzles.cutting import cut
from engine.puzzles.parameters import PuzzleParameters
from engine.puzzles.pieces import Piece, Puzzle, Truth, rectangle
from engine.puzzles.scoring import contacts, right_joins, right_places, score, true_partners
from engine.puzzles.solution import UNPLACED, Joins, PuzzleSolution, no_joins


def puzzle_of(colours, *, frame=None, turned=False, pictures=1) -> Puzzle:
    """Squares of 4 px; a colour may be an array (4, 4)."""
    pieces = []
    for k, colour in enumerate(colours):
        image = np.zeros((4, 4, 3), dtype=np.uint8)
        image[..., 0] = colour
        pieces.append(Piece(rectangle(4, 4), image, np.ones((4, 4), dtype=bool), str(k)))
    return Puzzle(tuple(pieces), frame, turned, pictures)


def truth_of(cells, turns=None, picture=None) -> Truth:
    n = len(cells)
    picture = np.zeros(n) if picture is None else np.array(picture)
    return Truth(4 * np.array(cells), np.zeros(n) if turns is None else turns, picture, [(8, 8)] * (int(max(picture)) + 1))


def solved(puzzle: Puzzle, cells, turns=None, picture=None, joins=None) -> PuzzleSolution:
    n = puzzle.count
    return PuzzleSolution(
        "p", np.zeros(n) if picture is None else picture, 4 * np.array(cells), np.zeros(n) if turns is None else turns,
        [(8, 8)], joins or no_joins(), "mst", "mgc", PuzzleParameters())  # fmt: skip


SQUARE = [(0, 0), (1, 0), (0, 1), (1, 1)]


def test_the_truth_is_perfect():
    puzzle = puzzle_of([1, 2, 3, 4], frame=(8, 8))
    found = score(puzzle, truth_of(SQUARE), solved(puzzle, SQUARE))
    assert (found.direct, found.neighbour, found.largest_component, found.perfect) == (1, 1, 1, True)
    assert (found.direct_tie_aware, found.neighbour_tie_aware) == (1, 1)


def test_two_pieces_swapped():
    puzzle = puzzle_of([1, 2, 3, 4], frame=(8, 8))
    found = score(puzzle, truth_of(SQUARE), solved(puzzle, [(1, 0), (0, 0), (0, 1), (1, 1)]))
    assert (found.direct, found.neighbour, found.largest_component, found.perfect) == (0.5, 0.25, 0.5, False)


def test_identical_pieces_count_as_equal_only_in_the_tie_aware_scores():
    puzzle = puzzle_of([7, 7, 3, 4], frame=(8, 8))
    found = score(puzzle, truth_of(SQUARE), solved(puzzle, [(1, 0), (0, 0), (0, 1), (1, 1)]))
    assert (found.direct, found.neighbour, found.perfect) == (0.5, 0.25, False)
    assert (found.direct_tie_aware, found.neighbour_tie_aware, found.perfect_tie_aware) == (1, 1, True)


def test_a_shift_counts_against_a_known_frame_only():
    cells = [(0, 0), (1, 0), (2, 0)]
    moved = [(1, 0), (2, 0), (3, 0)]
    for frame, direct in (((16, 4), 0.0), (None, 1.0)):
        puzzle = puzzle_of([1, 2, 3], frame=frame)
        found = score(puzzle, truth_of(cells), solved(puzzle, moved))
        assert (found.direct, found.neighbour) == (direct, 1.0)


def test_a_picture_may_be_turned_as_a_whole_where_pieces_are():
    grey = np.arange(16).reshape(4, 4)
    puzzle = puzzle_of([grey, grey + 20, grey + 40, grey + 60], frame=(8, 8), turned=True)
    quarter = [(1, 0), (1, 1), (0, 0), (0, 1)]  # SQUARE after one clockwise quarter turn
    found = score(puzzle, truth_of(SQUARE), solved(puzzle, quarter, turns=np.ones(4)))
    assert (found.direct, found.neighbour) == (1, 1)
    assert score(puzzle, truth_of(SQUARE), solved(puzzle, quarter)).neighbour == 0  # moved but not turned


WIDE = [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)]


@pytest.mark.parametrize("turn", [0, 1, 2, 3])
def test_a_turned_picture_lies_in_its_frame_where_that_is_known(turn):
    """A picture of 3 × 2 squares turned as a whole with its frame is right; one column off in it, or round it, is not."""
    grey = np.arange(16).reshape(4, 4)
    colours = [grey + 20 * k for k in range(6)]
    x, y = np.array(WIDE).T
    places = [(x, y), (1 - y, x), (2 - x, 1 - y), (y, 2 - x)][turn]
    truth = replace(truth_of(WIDE), sizes=np.array([(12, 8)]))
    sizes = np.array([(12, 8) if turn % 2 == 0 else (8, 12)])
    along = np.array((1, 0) if turn % 2 == 0 else (0, 1))
    cells, long = np.column_stack(places), int(np.max(places)) + 1
    round_it = np.where(along, (cells + 1) % long, cells)
    for frame, off, round_about in (((12, 8), 0.0, 0.0), (None, 1.0, 4 / 6)):
        puzzle = puzzle_of(colours, frame=frame, turned=True)
        found = [replace(solved(puzzle, where, turns=np.full(6, turn)), sizes=sizes) for where in (cells, cells + along, round_it)]
        scores = [score(puzzle, truth, solution) for solution in found]
        assert [s.direct for s in scores] == pytest.approx([1.0, off, round_about])
        assert scores[0].perfect
        assert scores[1].neighbour == 1
        assert scores[1].direct_tie_aware == off
        assert right_places(puzzle, truth, found[1]).mean() == off


def test_a_picture_that_outgrew_its_frame_still_has_right_places():
    """One piece hangs out of the frame, so that the picture is larger than it; the others are where they belong."""
    grey = np.arange(16).reshape(4, 4)
    puzzle = puzzle_of([grey, grey + 20, grey + 40, grey + 60], frame=(8, 8), turned=True)
    out = replace(solved(puzzle, [*SQUARE[:3], (2, 1)]), sizes=np.array([(12, 8)]))
    assert score(puzzle, truth_of(SQUARE), out).direct == 0.75


def test_unplaced_pieces_are_wrong():
    puzzle = puzzle_of([1, 2, 3, 4], frame=(8, 8))
    found = score(puzzle, truth_of(SQUARE), solved(puzzle, SQUARE, picture=np.array([0, 0, 0, UNPLACED])))
    assert (found.direct, found.neighbour, found.largest_component) == (0.75, 0.5, 0.75)


def test_two_pictures_may_come_in_either_order():
    puzzle = puzzle_of([1, 2, 3, 4], pictures=2)
    cells = [(0, 0), (1, 0), (0, 0), (1, 0)]
    found = score(puzzle, truth_of(cells, picture=[0, 0, 1, 1]), solved(puzzle, cells, picture=np.array([1, 1, 0, 0])))
    assert found.direct == found.neighbour == 1
    mixed = score(puzzle, truth_of(cells, picture=[0, 0, 1, 1]), solved(puzzle, cells, picture=np.array([0, 1, 1, 0])))
    assert mixed.neighbour == 0


def test_right_joins_and_places():
    puzzle = puzzle_of([1, 2, 3, 4], frame=(8, 8))
    joins = Joins([[0, 1, 1, 3], [0, 2, 3, 0]], [[4, 0], [0, 4]], [0, 0], [0.9, 0.1])
    solution = solved(puzzle, [(0, 0), (1, 0), (1, 1), (0, 1)], joins=joins)
    assert right_joins(puzzle, truth_of(SQUARE), solution).tolist() == [True, False]
    assert right_places(puzzle, truth_of(SQUARE), solution).tolist() == [True, True, False, False]


def test_contacts_of_polygons_are_shared_borders():
    mask = np.tri(4, dtype=bool)
    image = np.zeros((4, 4, 3), dtype=np.uint8)
    lower = Piece([[0, 0], [4, 4], [0, 4]], image, mask)
    upper = Piece([[0, 0], [4, 0], [4, 4]], image, ~mask)
    square = Piece(rectangle(4, 4), image, np.ones((4, 4), dtype=bool))
    puzzle = Puzzle((lower, upper, square))
    found = contacts(puzzle, np.zeros(3), np.array([(0, 0), (0, 0), (4, 0)]), np.zeros(3, dtype=int))
    assert {tuple(sorted(pair)) for pair in found.tolist()} == {(0, 1), (1, 2)}


@pytest.mark.parametrize("turned", [False, True])
def test_true_partners_are_mutual_and_lie_where_the_truth_says(turned):
    picture = np.random.default_rng(0).integers(0, 256, (24, 40, 3)).astype(np.uint8)
    puzzle, truth = cut(picture, piece_size=8, turned=turned, seed=5)
    partners = true_partners(truth, 8)
    joined = np.flatnonzero(partners >= 0)
    assert len(joined) == 2 * (4 * 3 + 5 * 2)
    assert (partners[partners[joined]] == joined).all()
    a, s, b, t = joined // 4, joined % 4, partners[joined] // 4, partners[joined] % 4
    facing = (s + truth.turns[a]) % 4
    step = np.array([(0, -8), (8, 0), (0, 8), (-8, 0)])[facing]
    assert (truth.position[b] - truth.position[a] == step).all()
    assert ((t + truth.turns[b]) % 4 == (facing + 2) % 4).all()
    assert puzzle.count == 15
