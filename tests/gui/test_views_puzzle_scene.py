"""What the puzzle canvas draws and hits, as plain arrays."""

from dataclasses import replace

import numpy as np
import pytest
from jigsaw import cut_small, flat, true_solution, two_by_two

from engine.puzzles.pieces import Puzzle
from engine.puzzles.solution import Joins
from gui.palette import DARK, LIGHT
from gui.views.puzzle_layout import Box, arrange
from gui.views.puzzle_scene import (
    BINS,
    View,
    bin_colours,
    bins,
    by_doubt,
    fitted,
    growth_order,
    hit_join,
    hit_piece,
    in_view,
    join_key,
    join_keys,
    kept,
    meetings,
    next_in,
    seams,
    shown_joins,
    widths,
)
from gui.views.puzzle_snap import snapped


@pytest.fixture
def square():
    puzzle, truth = two_by_two()
    solution = true_solution(puzzle, truth)
    return puzzle, solution, arrange(puzzle, solution)


def test_a_view_goes_there_and_back_and_zooms_about_a_point():
    view = View(2.5, 10, -4)
    assert view.to_canvas(*view.to_screen(np.array([3.0, 7.0]))) == pytest.approx((3, 7))
    closer = view.zoomed(2, 30, 40)
    assert closer.scale == 5
    assert closer.to_canvas(30, 40) == pytest.approx(view.to_canvas(30, 40))
    assert View(60.0).zoomed(100, 0, 0).scale == 64


def test_a_fitted_view_shows_the_whole_box_centred():
    view = fitted(Box(10, 20, 100, 50), 400, 400, 50)
    assert view.scale == 3
    assert view.to_screen(np.array([60, 45])).tolist() == [200, 200]


def test_a_view_is_shifted_until_a_box_that_fits_is_seen_and_a_large_one_fills_it():
    small, large = Box(0, 0, 10, 10), Box(0, 0, 100, 100)
    assert kept(View(10, 395, -80), small, 400, 400, 20) == View(10, 280, 20)
    assert kept(View(10, 150, 120), small, 400, 400, 20) == View(10, 150, 120)
    assert kept(View(10, 300, -900), large, 400, 400, 20) == View(10, 20, -620)


def test_the_name_of_a_join_is_the_same_from_both_sides():
    assert join_key((5, 1, 2, 3)) == join_key((2, 3, 5, 1)) == (2, 3, 5, 1)


def test_seams_are_the_common_borders(square):
    _, solution, layout = square
    found = {key: np.sort(segment, axis=0).tolist() for key, segment in
             zip(join_keys(solution.joins), seams(layout, solution.joins), strict=True)}  # fmt: skip
    assert found == {
        (0, 1, 1, 3): [[4, 0], [4, 4]], (0, 2, 2, 0): [[0, 4], [4, 4]],
        (1, 2, 3, 0): [[4, 4], [8, 4]], (2, 1, 3, 3): [[4, 4], [4, 8]],
    }  # fmt: skip


def test_a_long_side_meets_a_short_one_where_they_face_each_other_halfway_across_the_gap():
    long, short = np.array([[[0, 0], [10, 0]]], float), np.array([[[7, -2], [3, -2]]], float)
    assert meetings(long, short)[0].tolist() == [[3, -1], [7, -1]]
    apart = np.array([[[30, 0], [20, 0]]], float)
    assert meetings(long, apart)[0].tolist() == long[0].tolist()


def test_seams_of_turned_pieces_lie_where_the_pieces_touch():
    puzzle, truth = cut_small(turned=True, seed=5)
    solution = true_solution(puzzle, truth)
    found = seams(arrange(puzzle, solution), solution.joins)
    for (a, _, b, _), segment in zip(solution.joins.sides.tolist(), found, strict=True):
        middle = (truth.position[a] + truth.position[b] + 16) / 2
        assert segment.mean(axis=0).tolist() == middle.tolist()


def test_the_slider_hides_the_certain_joins_but_not_those_of_the_chosen_piece_or_held_ones(square):
    joins = replace(square[1].joins, confidence=np.array([0.2, 0.95, 0.99, 1.0]))
    none = np.zeros(4, bool)
    assert shown_joins(joins, 0.95, -1, none).tolist() == [True, False, False, False]
    assert shown_joins(joins, 1.0, -1, none).all()
    assert shown_joins(joins, 0.0, 3, none).tolist() == [(3 in row) for row in joins.sides[:, [0, 2]].tolist()]
    assert shown_joins(joins, 0.0, -1, np.array([False, False, True, False])).tolist() == [False, False, True, False]


def test_the_next_worst_join_goes_round(square):
    joins = replace(square[1].joins, confidence=np.array([0.5, 0.2, 0.9, 0.2]))
    order = by_doubt(joins, np.array([False, False, True, False]))
    assert order.tolist() == [1, 3, 0]
    assert [next_in(order, row, 1) for row in (-1, 1, 3, 0)] == [1, 3, 0, 1]
    assert [next_in(order, row, -1) for row in (-1, 1)] == [0, 0]
    assert next_in(order[:0], 0, 1) == -1


@pytest.mark.parametrize("theme", [LIGHT, DARK])
def test_doubtful_joins_are_thicker_and_of_another_lightness_than_certain_ones(theme):
    colours = bin_colours(theme).astype(float) @ [0.2126, 0.7152, 0.0722]
    thick = widths(32)
    assert len(colours) == len(thick) == BINS
    assert thick[0] > thick[-1] == 1
    assert (np.diff(thick) <= 0).all()
    assert colours[0] - colours[-1] > (30 if theme is LIGHT else 10)
    assert bins(np.array([0.0, 0.5, 0.9, 1.0])).tolist() == [0, 2, 6, 7]
    assert (widths(4) == 1).all()


def test_the_nearest_segment_within_reach_is_hit():
    segments = np.array([[[0, 0], [10, 0]], [[0, 4], [10, 4]]], float)
    assert hit_join(segments, 5, 1, 3) == 0
    assert hit_join(segments, 5, 3.5, 3) == 1
    assert hit_join(segments, 14, 0, 3) == -1  # beyond the end
    assert hit_join(segments[:0], 0, 0, 3) == -1


def test_the_piece_below_a_point_is_the_one_drawn_last_and_only_where_it_has_pixels():
    mask = np.ones((4, 4), bool)
    mask[:2, :2] = False
    puzzle, truth = two_by_two()
    holed = replace(puzzle.pieces[3], mask=mask)
    puzzle = Puzzle((*puzzle.pieces[:3], holed), frame=(8, 8))
    solution = replace(true_solution(puzzle, truth), position=np.array([[0, 0], [4, 0], [0, 4], [2, 2]]))
    layout = arrange(puzzle, solution)
    assert hit_piece(layout, 2.5, 2.5) == 0  # the hole of piece 3
    assert hit_piece(layout, 3.5, 4.5) == 3
    assert hit_piece(layout, 40, 2) == -1
    turned = arrange(puzzle, replace(solution, turns=np.array([0, 0, 0, 2])))
    assert hit_piece(turned, 2.5, 2.5) == 3  # the hole has turned away
    assert hit_piece(turned, 5.5, 5.5) == -1


def test_segments_outside_the_window_are_left_out():
    segments = np.array([[[-50, 5], [-20, 5]], [[-5, 5], [5, 5]], [[90, 200], [110, 90]]], float)
    assert in_view(segments, 100, 100).tolist() == [False, True, True]
    assert in_view(segments + np.array([0, 300]), 100, 100).tolist() == [False, False, False]


def test_a_picture_grows_along_its_most_certain_joins():
    joins = Joins(np.array([[0, 1, 1, 3], [1, 1, 2, 3], [0, 2, 3, 0], [4, 1, 5, 3]]), np.zeros((4, 2)), np.zeros(4),
                  np.array([0.9, 0.5, 0.7, 0.8]))  # fmt: skip
    placed = np.array([True] * 6 + [False, True])
    order = growth_order(joins, placed).tolist()
    assert order == [0, 1, 3, 2, 4, 5, 7]
    nothing = Joins(np.zeros((0, 4)), np.zeros((0, 2)), np.zeros(0), np.zeros(0))
    assert growth_order(nothing, np.array([True, False, True])).tolist() == [0, 2]


def test_a_carried_piece_snaps_to_the_nearest_corner_within_reach_and_not_to_its_company(square):
    puzzle, solution, _ = square
    uneven = Puzzle((*puzzle.pieces[:3], flat([9, 9, 9], 4, 5)))  # squares alone take cells instead
    spread = replace(solution, position=np.array([[0, 0], [20, 0], [0, 20], [30, 30]]), sizes=np.array([[40, 40]]))
    layout = arrange(uneven, spread)
    assert snapped(layout, frozenset({1}), 1, 4.8, 0.6, 1.5) == (4, 0, True)
    assert snapped(layout, frozenset({1}), 1, 4.8, 2.6, 1.5) == (5, 3, False)
    assert snapped(layout, frozenset({0, 1}), 1, 4.2, 1.6, 1.0) == (4, 2, False)
    assert snapped(layout, frozenset({1}), 1, 35.5, 35.4, 1.0) == (36, 36, True)  # the corner of the picture


def test_equal_squares_take_the_cells_of_the_picture(square):
    _, _, layout = square
    assert snapped(layout, frozenset({1}), 1, 2.1, 1.9, 0.1) == (4, 0, True)
    assert snapped(layout, frozenset({1}), 1, 6.5, 0, 0.1) == (6, 0, False)  # its middle is outside


def test_uneven_pieces_snap_by_any_of_their_corners():
    puzzle = Puzzle((flat([1, 1, 1], 6, 4), flat([2, 2, 2], 3, 3)))
    solution = replace(true_solution(*two_by_two()), picture=np.array([0, 0]), position=np.array([[0, 0], [50, 50]]),
                       turns=np.zeros(2), sizes=np.array([[60, 60]]))  # fmt: skip
    layout = arrange(puzzle, solution)
    assert snapped(layout, frozenset({1}), 1, 6.4, 0.7, 1.0)[:2] == (6, 1)  # its lower corner meets the lower corner
