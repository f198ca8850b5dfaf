"""What hands do to wishes and solutions, without any widget."""

from dataclasses import replace

import numpy as np
import pytest
from jigsaw import PX, cut_small, flat, true_solution, two_by_two

from engine.puzzles.parameters import PuzzleParameters
from engine.puzzles.pieces import Puzzle
from engine.puzzles.solution import UNPLACED, Joins, Pin, no_joins
from gui.pages.puzzle.contacts import alike, beside, contacts, turned_round
from gui.pages.puzzle.edits import (
    NO_WISHES,
    empty_solution,
    forbid,
    group,
    joins_of_piece,
    lock,
    one,
    overlapping,
    pin,
    placed_by_hand,
    row_of,
    rows_of,
    shifted,
    taken_out,
    together,
    unpin,
    without,
)
from gui.pages.puzzle.overlay import ghost
from gui.pages.puzzle.solving import moved_pieces
from gui.pages.puzzle.state import ASSEMBLE, NOTHING, PREPARE, PuzzleState, by_worst, counts_text, needed, percent
from gui.session import Session
from gui.views.puzzle_layout import arrange
from gui.views.puzzle_scene import join_keys


@pytest.fixture
def square():
    puzzle, truth = two_by_two()
    return puzzle, true_solution(puzzle, truth, [0.9, 0.3, 1.0, 0.5])


KEYS = [(0, 1, 1, 3), (0, 2, 2, 0), (1, 2, 3, 0), (2, 1, 3, 3)]


def join(a, side_a, b, side_b):
    return Joins(np.array([[a, side_a, b, side_b]]), np.zeros((1, 2)), np.zeros(1), np.array([0.4]))


def test_locking_holds_a_join_as_certain_and_again_lets_it_go(square):
    joins = square[1].joins
    held = lock(NO_WISHES, one(joins, 1), single=True)
    assert join_keys(held.locked) == [KEYS[1]]
    assert held.locked.confidence.tolist() == [1.0]
    assert held.locked.confirmed_by == ("person",)
    assert held.locked.offset.tolist() == [[0, 4]]
    assert len(lock(held, one(joins, 1), single=True).locked) == 0


def test_locking_takes_back_what_its_sides_were_locked_to_and_its_own_rejection():
    wishes = lock(lock(NO_WISHES, join(0, 1, 1, 3), single=True), join(4, 1, 5, 3), single=True)
    wishes = forbid(wishes, join(3, 3, 0, 1))
    uneven = lock(wishes, join(0, 1, 3, 3), single=False)
    assert len(uneven.locked) == 3  # a long side may have several partners
    wishes = lock(wishes, join(0, 1, 3, 3), single=True)
    assert join_keys(wishes.locked) == [(4, 1, 5, 3), (0, 1, 3, 3)]
    assert not len(wishes.forbidden)


def test_rejecting_ends_a_lock_and_is_kept_once(square):
    joins = square[1].joins
    wishes = forbid(lock(NO_WISHES, one(joins, 2), single=True), one(joins, 2))
    wishes = forbid(wishes, joins_of_piece(joins, 3))
    assert not len(wishes.locked)
    assert sorted(join_keys(wishes.forbidden)) == [KEYS[2], KEYS[3]]


def test_pins_replace_earlier_ones_of_the_same_piece():
    wishes = pin(pin(NO_WISHES, [Pin(0, 1, 2), Pin(1, 5, 5)]), [Pin(0, 7, 7, 1)])
    assert set(wishes.pinned) == {Pin(1, 5, 5), Pin(0, 7, 7, 1)}
    assert unpin(wishes, [1]).pinned == (Pin(0, 7, 7, 1),)


def test_what_hangs_together_by_locks_is_one_group():
    locked = together(together(join(0, 1, 1, 3), join(2, 1, 1, 2)), join(5, 0, 6, 0))
    assert group(0, locked) == {0, 1, 2}
    assert group(6, locked) == {5, 6}
    assert group(9, locked) == {9}


def test_joins_are_found_by_name_from_either_side(square):
    joins = square[1].joins
    assert [row_of(joins, key) for key in KEYS] == [0, 1, 2, 3]
    assert row_of(joins, (0, 0, 1, 0)) == row_of(joins, None) == -1
    assert rows_of(joins, [KEYS[3], KEYS[0]]).tolist() == [True, False, False, True]
    assert join_keys(without(joins, KEYS[1:3])) == [KEYS[0], KEYS[3]]


def test_a_piece_put_on_another_sends_that_to_the_tray_and_ends_the_joins_of_both(square):
    puzzle, solution = square
    after = placed_by_hand(puzzle, solution, [Pin(0, 4, 4)])
    assert after.picture.tolist() == [0, 0, 0, UNPLACED]
    assert after.position[0].tolist() == [4, 4]
    assert len(after.joins) == 0
    assert "another piece" in after.why_unplaced[3]
    beside = placed_by_hand(puzzle, solution, [Pin(0, -4, 0)])
    assert beside.placed.all()
    assert join_keys(beside.joins) == KEYS[2:]


def test_building_by_hand_begins_with_nothing_placed(square):
    puzzle, _ = square
    start = empty_solution(puzzle, PuzzleParameters())
    assert not start.placed.any()
    after = placed_by_hand(puzzle, start, [Pin(2, 4, 0, 3)])
    assert after.placed.tolist() == [False, False, True, False]
    assert after.turns[2] == 3


def test_a_piece_taken_out_leaves_the_others_joined(square):
    after = taken_out(square[1], [1])
    assert after.placed.tolist() == [True, False, True, True]
    assert join_keys(after.joins) == [KEYS[1], KEYS[3]]


def test_only_pixels_count_for_overlaps_and_slivers_do_not():
    mask = np.tri(8, dtype=bool)  # the lower left half
    lower = replace(flat([9, 9, 9], 8, 8), mask=mask)
    upper = replace(flat([5, 5, 5], 8, 8), mask=~mask)
    puzzle = Puzzle((lower, upper, flat([1, 1, 1], 8, 8)))
    where, turns = np.zeros(3, int), np.zeros(3, int)
    at = np.array([[0, 0], [0, 0], [7, 0]])
    assert overlapping(puzzle, where, at, turns, np.array([0])).tolist() == []  # a sliver of one pixel is let pass
    at[2] = 5, 0
    assert overlapping(puzzle, where, at, turns, np.array([0, 1])).tolist() == [2]
    assert overlapping(puzzle, np.array([0, 0, 1]), at, turns, np.array([0, 1])).tolist() == []  # in another picture


def test_sides_that_touch_are_joins_as_the_solver_writes_them():
    puzzle, truth = cut_small(turned=True, seed=4)
    solution = true_solution(puzzle, truth)
    piece = int(np.flatnonzero((truth.position == (PX, PX)).all(axis=1))[0])
    found = contacts(puzzle, solution, frozenset({piece}))
    assert len(found) == 4
    for row, key in enumerate(join_keys(found)):
        there = row_of(solution.joins, key)
        assert there >= 0
        if found.sides[row, 0] == solution.joins.sides[there, 0]:
            assert found.offset[row].tolist() == solution.joins.offset[there].tolist()
            assert found.turn[row] == solution.joins.turn[there]
    pair = frozenset({piece, int(found.sides[0, 2])})
    assert all(len({a, b} & pair) == 1 for a, _, b, _ in contacts(puzzle, solution, pair).sides.tolist())


def test_a_join_said_from_its_other_piece_is_the_same_join():
    puzzle, truth = cut_small(turned=True, seed=4)
    uneven = Puzzle((flat([1, 1, 1], 8, 4), flat([2, 2, 2], 3, 5)))
    joins = Joins(np.array([[0, 2, 1, 3], [0, 2, 1, 3]]), np.array([[1, 4], [2, 4]]), np.array([1, 1]), np.ones(2))
    back = turned_round(uneven, joins, 0)
    assert (back.sides.tolist(), back.turn.tolist()) == ([[1, 3, 0, 2]], [3])
    assert back.offset.tolist() == [[-4, -2]]  # piece 0, four wide as it then stands, is at its left, two above its top
    assert alike(uneven, joins, 0, back, 0)
    assert not alike(uneven, joins, 1, back, 0)  # the same sides, elsewhere
    solution = true_solution(puzzle, truth)
    for row in range(len(solution.joins)):
        twice = turned_round(puzzle, turned_round(puzzle, solution.joins, row), 0)
        assert twice.offset[0].tolist() == solution.joins.offset[row].tolist()
        assert twice.turn[0] == solution.joins.turn[row]
        other = int(solution.joins.sides[row, 2])
        seen = contacts(puzzle, solution, frozenset({other}))
        assert sum(alike(puzzle, solution.joins, row, seen, k) for k in range(len(seen))) == 1


def test_a_tried_piece_is_outlined_where_its_join_puts_it():
    puzzle, truth = cut_small(turned=True, seed=6)
    solution = true_solution(puzzle, truth)
    for row, (a, _, b, _) in enumerate(solution.joins.sides.tolist()):
        there = truth.position[a] + beside(puzzle, solution.joins, row, int(truth.turns[a]))
        assert there.min(axis=0).tolist() == truth.position[b].tolist()
        assert there.max(axis=0).tolist() == (truth.position[b] + PX).tolist()
    layout = arrange(puzzle, replace(solution, picture=np.where(np.arange(24) == b, UNPLACED, 0)))
    state = PuzzleState(puzzle=puzzle, solution=solution, preview=one(solution.joins, row))
    assert (ghost(state, layout) == there).all()
    round_ = replace(state, preview=turned_round(puzzle, solution.joins, row))
    assert sorted(ghost(round_, layout).tolist()) == sorted(there.tolist())
    assert len(ghost(replace(state, preview=None), layout)) == 0


def test_sides_touch_across_a_small_gap_along_half_of_the_shorter_one():
    puzzle = Puzzle((flat([1, 1, 1], 8, 4), flat([2, 2, 2], 4, 4)))

    def touching(x, y):
        at = replace(true_solution(*two_by_two()), picture=np.zeros(2), position=np.array([[0, 0], [x, y]]), turns=np.zeros(2),
                     joins=no_joins())  # fmt: skip
        return join_keys(contacts(puzzle, at, frozenset({1})))

    assert touching(0, 4) == touching(6, 4) == touching(2, 6) == [(0, 2, 1, 0)]
    assert touching(7, 4) == []  # a quarter of the shorter side
    assert touching(0, 8) == []  # too far
    assert touching(8, 0) == [(0, 1, 1, 3)]
    assert touching(-4, 0) == [(0, 3, 1, 1)]


def test_without_a_frame_only_relative_places_count(square):
    puzzle, solution = square
    moved = replace(solution, position=solution.position - 4)
    again, wishes = shifted(puzzle, moved, pin(NO_WISHES, [Pin(1, 0, -4)]))
    assert (again.position == solution.position).all()
    assert wishes.pinned == (Pin(1, 4, 0),)
    assert again.sizes.tolist() == [[8, 8]]
    two = replace(solution, picture=np.array([0, 0, 1, 1]), sizes=np.array([[8, 4], [8, 8]]))
    again, wishes = shifted(puzzle, two, pin(NO_WISHES, [Pin(3, 4, 4), Pin(1, 4, 0)]))
    assert again.position.tolist() == [[0, 0], [4, 0], [0, 0], [4, 0]]
    assert again.sizes.tolist() == [[8, 4], [8, 4]]
    assert set(wishes.pinned) == {Pin(3, 4, 0), Pin(1, 4, 0)}
    assert shifted(puzzle, again, wishes) == (again, wishes)  # the same objects: nothing has to run again


def test_pieces_that_moved_are_found(square):
    _, solution = square
    other = replace(solution, turns=np.array([0, 1, 0, 0]), picture=np.array([0, 0, UNPLACED, 0]))
    assert moved_pieces(solution, other).tolist() == [1, 2]
    assert moved_pieces(None, other).tolist() == []
    all_ = replace(solution, position=solution.position + 4)
    assert moved_pieces(solution, all_).tolist() == []
    assert moved_pieces(solution, replace(all_, position=np.array([[4, 4], [8, 4], [4, 8], [9, 8]]))).tolist() == [3]


# --- the state


def solved(square):
    puzzle, solution = square
    return PuzzleState(puzzle=puzzle, solution=solution, parameters=solution.parameters, asked=True, prepared="ready",
                       prepared_with=solution.parameters, solved_with=NO_WISHES)  # fmt: skip


def test_what_has_to_run_follows_from_the_state(square):
    state = solved(square)
    assert needed(state) == NOTHING
    assert needed(PuzzleState()) == NOTHING
    assert needed(replace(state, wishes=pin(NO_WISHES, [Pin(0, 0, 0)]))) == ASSEMBLE
    assert needed(replace(state, solved_with=None)) == ASSEMBLE
    assert needed(replace(state, parameters=state.parameters.changed(method="mst"))) == ASSEMBLE
    assert needed(replace(state, parameters=state.parameters.changed(measure="ssd"))) == PREPARE
    assert needed(replace(state, prepared=None, solution=None)) == PREPARE
    assert needed(replace(state, asked=False, solution=None)) == NOTHING


def test_the_worst_joins_come_first_without_held_and_certain_ones(square):
    state = solved(square)
    assert by_worst(state) == [1, 3, 0]
    assert by_worst(replace(state, below=1.0)) == [1, 3, 0, 2]
    assert by_worst(replace(state, wishes=lock(NO_WISHES, one(square[1].joins, 1), single=True))) == [3, 0]


def test_undo_brings_wishes_and_solution_back_together_and_drops_what_is_no_more(square):
    puzzle, solution = square
    session = Session(solved(square))
    session.update(selected=KEYS[0], piece=3)
    wishes = forbid(NO_WISHES, one(solution.joins, 0))
    session.update(wishes=wishes, solution=taken_out(solution, [0]), solved_with=None)
    session.update(record=False, solved_with=wishes)
    session.undo()
    assert session.state.solution is solution
    assert session.state.solved_with is session.state.wishes is NO_WISHES
    assert session.state.selected == KEYS[0]
    session.redo()
    assert session.state.solved_with is session.state.wishes is wishes
    assert session.state.selected is None  # that join is gone
    assert session.state.piece == 3
    assert not {"answers", "verdicts", "volunteer", "dark", "below"} & set(PuzzleState.UNDOABLE)
    assert puzzle is session.state.puzzle


def test_the_status_line_counts(square):
    puzzle, solution = square
    assert "press Solve" in counts_text(PuzzleState(puzzle=puzzle))
    text = counts_text(replace(solved(square), wishes=pin(lock(NO_WISHES, one(solution.joins, 0), single=True), [Pin(0, 0, 0)])))
    assert text == "4 pieces · all placed · 3 of 4 joins below .95 · 1 locked · 1 pinned"
    judged = replace(solved(square), items=("a", "b", "c", "d"), verdicts={"a": "correct", "c": "tie", "of another": "wrong"})
    assert counts_text(judged) == "4 pieces · all placed · 3 of 4 joins below .95 · 2 of 4 judged"


def test_a_share_is_never_rounded_to_all():
    assert [percent(x) for x in (1.0, 0.9999, 0.958, 0.0)] == ["100 %", "99.9 %", "95.8 %", "0.0 %"]


def test_a_partner_that_is_placed_bears_the_confidence_of_its_join():
    """Either way round; the others keep the confidence of their borders."""
    from types import SimpleNamespace

    from gui.pages.puzzle.partners import with_placed

    def joins(rows, sure):
        return Joins(np.array(rows), np.zeros((len(rows), 2)), np.zeros(len(rows)), np.array(sure))

    found = joins([(5, 1, 2, 3), (5, 1, 7, 3)], [0.4, 0.1])
    placed = SimpleNamespace(joins=joins([(2, 3, 5, 1), (0, 1, 1, 3)], [0.98, 0.5]))
    assert with_placed(found, placed).confidence.tolist() == [0.98, 0.1]
    assert with_placed(found, None) is found
