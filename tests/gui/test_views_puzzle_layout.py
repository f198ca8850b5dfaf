"""Where pieces lie on the canvas: pictures, tray, turned corners."""

from dataclasses import replace

import numpy as np
import pytest
from jigsaw import cut_small, flat, true_solution, two_by_two

from engine.puzzles.pieces import Piece, Puzzle
from engine.puzzles.solution import UNPLACED
from engine.puzzles.turning import turned_polygon
from gui.views.puzzle_layout import Box, arrange, growing, outlines, shelves, turned_corners, turned_sizes


def boxes(layout):
    return np.column_stack([layout.position, layout.position + layout.size])


def overlap(a, b):
    return (np.minimum(a[2:], b[2:]) > np.maximum(a[:2], b[:2])).all()


def test_without_a_solution_all_pieces_lie_in_the_tray_apart():
    puzzle, _ = cut_small()
    layout = arrange(puzzle, None)
    assert not layout.placed.any()
    assert layout.pictures == (Box(0, 0, 96, 64),)  # the known frame, empty
    all_ = boxes(layout)
    assert not any(overlap(all_[i], all_[j]) for i in range(24) for j in range(i))
    tray = layout.tray
    assert (all_[:, :2] >= (tray.x, tray.y)).all()
    assert (all_[:, 2:] <= (tray.x + tray.w, tray.y + tray.h)).all()
    assert not overlap(np.array([tray.x, tray.y, tray.x + tray.w, tray.y + tray.h]), np.array([0, 0, 96, 64]))


def test_a_solution_is_shown_as_it_is_and_the_rest_in_the_tray():
    puzzle, truth = cut_small()
    solution = true_solution(puzzle, truth)
    layout = arrange(puzzle, solution)
    assert layout.tray is None
    assert (layout.position == truth.position).all()
    some = solution.picture.copy()
    some[[3, 7]] = UNPLACED
    layout = arrange(puzzle, replace(solution, picture=some))
    assert np.flatnonzero(~layout.placed).tolist() == [3, 7]
    kept = layout.placed
    assert (layout.position[kept] == truth.position[kept]).all()
    assert all(layout.tray.holds(*layout.position[k]) for k in (3, 7))


@pytest.mark.parametrize(("aspect", "beside"), [(3.0, True), (0.4, False)])
def test_the_tray_goes_where_all_can_be_shown_larger(aspect, beside):
    puzzle, _ = cut_small()
    layout = arrange(puzzle, None, aspect)
    assert (layout.tray.x > 96) == beside
    assert (layout.tray.y > 64) != beside


def test_several_pictures_stand_side_by_side():
    puzzle, truth = two_by_two()
    solution = replace(true_solution(puzzle, truth), picture=np.array([0, 0, 1, 1]), sizes=np.array([[8, 4], [8, 8]]))
    layout = arrange(puzzle, solution)
    first, second = layout.pictures
    assert second.x >= first.x + first.w
    assert layout.position[2].tolist() == [second.x, 4]


def test_shelves_keep_the_order_and_break_at_the_width():
    position, box = shelves(np.array([[4, 4], [4, 8], [4, 4]]), width=16, gap=2)
    assert position.tolist() == [[2, 2], [8, 2], [2, 12]]
    assert box == Box(0, 0, 14, 18)


def test_corners_turn_as_the_engine_turns_them():
    outline = np.array([[2, 0], [6, 3], [0, 3]], float)
    piece = Piece(outline, np.zeros((3, 6, 3), np.uint8), np.ones((3, 6), bool))
    puzzle = Puzzle((piece, flat([0, 0, 0], 5, 2)))
    for turns in range(4):
        found = turned_corners(outlines(puzzle), np.array([turns, (turns + 1) % 4]))
        assert (found[:3] == turned_polygon(outline, (6, 3), turns)).all()
        assert (found[3:] == turned_polygon(puzzle.pieces[1].polygon, (5, 2), turns + 1)).all()
        sizes = turned_sizes(outlines(puzzle).size, np.array([turns, turns]))
        assert sizes.tolist() == [[3, 6] if turns % 2 else [6, 3], [2, 5] if turns % 2 else [5, 2]]


def test_growing_takes_each_piece_from_one_layout_or_the_other():
    puzzle, truth = cut_small()
    solution = true_solution(puzzle, truth)
    full, goal = arrange(puzzle, solution, 1.5, solution.placed), arrange(puzzle, solution)
    assert not full.placed.any()
    shown = np.zeros(24, bool)
    shown[[1, 5]] = True
    between = growing(full, goal, shown)
    assert (between.position[shown] == truth.position[shown]).all()
    assert (between.position[~shown] == full.position[~shown]).all()
    assert between.placed.tolist() == shown.tolist()
