"""Solving puzzles of squares: blocks by hand, laws of the whole solver, wishes honoured exactly."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from assets import example_picture
from engine.errors import BadInput, Cancelled
from engine.progress import silent
from engine.puzzles.assembly import by_linear_programme, closed_loops, loops_first
from engine.puzzles.blocks import Rules, grow_blocks, single_pieces
from engine.puzzles.candidates import candidates_of, exclusive, loop_support, rival_values
from engine.puzzles.cutting import cut, drop, mix
from engine.puzzles.evidence import evidence, kinds_of
from engine.puzzles.measures import side_strips
from engine.puzzles.parameters import PuzzleParameters
from engine.puzzles.pieces import Piece, Puzzle, rectangle
from engine.puzzles.scenery import landscape
from engine.puzzles.scoring import right_joins, score
from engine.puzzles.shifting import shift
from engine.puzzles.solution import Joins, Pin, Wishes
from engine.puzzles.solving import assemble, candidate_joins, prepare, solve
from engine.puzzles.wearing import worn

TOP, RIGHT, BOTTOM, LEFT = range(4)
FAST = PuzzleParameters(method="mst")


@pytest.fixture(scope="module")
def picture() -> np.ndarray:
    return np.asarray(Image.open(example_picture()).convert("RGB"))[100:380, 60:396]


def side(piece: int, which: int) -> int:
    return 4 * piece + which


def found_of(pairs, n):
    return candidates_of(np.sort(np.array(pairs), axis=1), 4 * n)


# --- blocks


def test_a_row_of_three_is_joined_and_an_overlap_refused():
    pairs = np.array([(side(0, RIGHT), side(1, LEFT)), (side(1, RIGHT), side(2, LEFT)), (side(0, RIGHT), side(2, LEFT))])
    blocks, taken = grow_blocks(pairs, np.arange(3), single_pieces(3), Rules())
    assert taken.tolist() == [True, True, False]
    assert (blocks.x - blocks.x[0]).tolist() == [0, 1, 2]
    assert blocks.y.tolist() == [blocks.y[0]] * 3


def test_blocks_that_would_overlap_stay_apart():
    """0-1 and 2-3 are rows; joining 2 below 0 is fine, then 3 cannot lie elsewhere than below 1."""
    pairs = np.array([(side(0, RIGHT), side(1, LEFT)), (side(2, RIGHT), side(3, LEFT)), (side(0, BOTTOM), side(2, TOP)),
                      (side(1, BOTTOM), side(3, TOP)), (side(1, RIGHT), side(3, LEFT))])  # fmt: skip
    _, taken = grow_blocks(pairs, np.arange(5), single_pieces(4), Rules())
    assert taken.tolist() == [True, True, True, True, False]


def test_no_block_outgrows_the_frame():
    pairs = np.array([(side(0, RIGHT), side(1, LEFT)), (side(1, RIGHT), side(2, LEFT))])
    assert grow_blocks(pairs, [0, 1], single_pieces(3), Rules(frame=(2, 5)))[1].tolist() == [True, False]
    assert grow_blocks(pairs, [0, 1], single_pieces(3), Rules(frame=(2, 5), either_way=True))[1].tolist() == [True, True]


def test_a_forbidden_touch_is_refused_even_where_another_join_makes_it():
    pairs = np.array([(side(0, RIGHT), side(1, LEFT)), (side(2, RIGHT), side(3, LEFT)), (side(0, BOTTOM), side(2, TOP))])
    forbidden = np.array([(side(1, BOTTOM), side(3, TOP))])
    assert grow_blocks(pairs, [0, 1, 2], single_pieces(4), Rules(forbidden=forbidden))[1].tolist() == [True, True, False]


def test_turned_pieces_are_turned_to_fit():
    """The top of 1 against the right of 0: 1 needs a quarter turn that brings its top to the left."""
    blocks, _ = grow_blocks(np.array([(side(0, RIGHT), side(1, TOP))]), [0], single_pieces(2), Rules())
    assert (blocks.turns[1] - blocks.turns[0]) % 4 == 3
    assert len(set(blocks.block.tolist())) == 1


# --- candidates


def test_rivals_are_the_best_of_the_others_at_each_end():
    found = found_of([(1, 7), (1, 11), (5, 11)], 3)
    value = np.array([3.0, 1.0, 2.0])
    assert rival_values(value, found).tolist() == [[1, np.inf], [3, 2], [np.inf, 1]]


def test_no_side_has_more_than_one_partner_on_the_whole():
    found = found_of([(1, 7), (1, 11), (5, 11)], 3)
    assert exclusive(np.array([0.9, 0.9, 0.1]), found) == pytest.approx([0.5, 0.5, 0.1])


SQUARE = [(side(0, RIGHT), side(1, LEFT)), (side(2, RIGHT), side(3, LEFT)), (side(0, BOTTOM), side(2, TOP)),
          (side(1, BOTTOM), side(3, TOP))]  # fmt: skip


def test_a_loop_of_four_supports_each_of_its_joins():
    pairs = np.array(sorted(tuple(sorted(p)) for p in SQUARE))
    found = candidates_of(pairs, 16)
    support = loop_support(np.array([0.9, 0.8, 0.7, 0.6]), found, 6)
    product = 0.9 * 0.8 * 0.7 * 0.6
    assert np.sort(support, axis=1) == pytest.approx(np.array([[0, product / p] for p in (0.9, 0.8, 0.7, 0.6)]))
    assert closed_loops(np.ones(4, dtype=bool), found).tolist() == [1, 1, 1, 1]
    assert closed_loops(np.array([True, True, True, False]), found).tolist() == [0, 0, 0, 0]


def test_loops_come_before_likelier_joins_outside_them():
    pairs = np.array(sorted([*(tuple(sorted(p)) for p in SQUARE), (side(3, RIGHT), side(4, LEFT))]))
    found = candidates_of(pairs, 20)
    lone = int(np.flatnonzero((pairs == (side(3, RIGHT), side(4, LEFT))).all(axis=1))[0])
    p = np.where(np.arange(5) == lone, 0.99, 0.8)
    assert loops_first(p, found, 0.1)[-1] == lone


def test_the_linear_programme_rejects_what_contradicts_the_others():
    """Three say that 3 lies right of 2 and below 1; one says that 3 lies right of 1."""
    pairs = np.array(sorted([*(tuple(sorted(p)) for p in SQUARE), (side(1, RIGHT), side(3, LEFT))]))
    found = candidates_of(pairs, 16)
    odd = int(np.flatnonzero((pairs == (side(1, RIGHT), side(3, LEFT))).all(axis=1))[0])
    p = np.full(5, 0.9)
    p[odd] = 0.85
    order = by_linear_programme(p, found, np.zeros(4, dtype=np.int64), rounds=5, least=0.1, progress=lambda *a: None)
    assert order[-1] == odd


# --- the whole solver


def scored(picture, parameters=FAST, wishes=Wishes(), **how):  # noqa: B008 - frozen
    puzzle, truth = cut(picture, piece_size=28, **how)
    solution = solve(puzzle, parameters, wishes=wishes)
    return puzzle, truth, solution, score(puzzle, truth, solution)


@pytest.mark.parametrize("method", ["auto", "mst", "greedy", "loops", "lp"])
def test_a_portrait_is_put_together(picture, method):
    _, _, solution, scores = scored(picture, PuzzleParameters(method=method), seed=1)
    assert scores.perfect
    assert solution.placed.all()
    assert len(solution.joins) == 12 * 9 + 11 * 10


@pytest.mark.parametrize("seed", range(3))
def test_a_portrait_of_turned_pieces(picture, seed):
    _, _, solution, scores = scored(picture, turned=True, seed=seed)
    assert scores.perfect
    assert solution.sizes.tolist() == [[336, 280]]
    assert (solution.position.max(axis=0) == (308, 252)).all()


def test_an_unknown_frame_is_found(picture):
    _, _, solution, scores = scored(picture, FAST.changed(frame="unknown"), seed=3)
    assert scores.perfect
    assert solution.sizes.tolist() == [[336, 280]]


@pytest.mark.parametrize("measure", ["mgc", "pt", "ssd-lab", "emd"])
def test_single_measures_do_most(picture, measure):
    assert scored(picture, FAST.changed(measure=measure), seed=4)[3].neighbour > 0.8


def test_the_order_of_the_pieces_does_not_matter(picture):
    solutions = [scored(picture, seed=seed)[2:] for seed in (5, 6)]
    assert solutions[0][1] == solutions[1][1]
    assert solutions[0][0].judge["mst"] == pytest.approx(solutions[1][0].judge["mst"], rel=1e-6)


def test_the_same_puzzle_gives_the_same_solution(picture):
    first, second = (scored(picture, seed=7)[2] for _ in range(2))
    assert (first.position == second.position).all()
    assert (first.joins.confidence == second.joins.confidence).all()


def test_missing_pieces_leave_holes(picture):
    puzzle, truth = drop(*cut(picture, piece_size=28, seed=8), missing=0.1, seed=8)
    solution = solve(puzzle, FAST)
    assert score(puzzle, truth, solution).direct > 0.97


def test_two_mixed_pictures_are_told_apart(picture):
    other = np.ascontiguousarray(255 - picture[::-1, :, ::-1])
    puzzle, truth = mix([cut(picture, piece_size=28, seed=1), cut(other, piece_size=28, seed=2)], seed=3)
    solution = solve(puzzle, FAST)
    assert len(solution.sizes) == 2
    assert score(puzzle, truth, solution).neighbour > 0.97


def test_two_pictures_that_look_alike_are_told_apart():
    """Their pieces would join; without a look at how many pictures there are, they become one."""
    parts = [cut(landscape(224, 168, seed=seed), piece_size=28, seed=seed) for seed in (1, 2)]
    puzzle, truth = mix(parts, seed=3)
    assert score(puzzle, truth, solve(puzzle, FAST)).perfect


def test_a_picture_that_ends_one_row_off_is_shifted():
    """Every row joins the next as well as can be, but the last joins the first even better: the line is at the border."""
    rows, columns = 5, 4
    cells = np.arange(rows * columns).reshape(rows, columns)
    sides = [(4 * cells[r, c] + RIGHT, 4 * cells[r, c + 1] + LEFT) for r in range(rows) for c in range(columns - 1)]
    sides += [(4 * cells[r, c] + BOTTOM, 4 * cells[r + 1, c] + TOP) for r in range(rows - 1) for c in range(columns)]
    found = found_of(sides, rows * columns)
    rasters = np.random.default_rng(0).integers(0, 256, (rows * columns, 6, 6, 3)).astype(np.uint8)
    e = evidence(side_strips(rasters), found, np.full(len(sides), 0.99))
    grid, turns = np.roll(cells, 1, axis=0), np.zeros(rows * columns, dtype=np.int64)
    shift(grid, turns, np.zeros((0, 2), dtype=np.int64), np.full(rows * columns, -1), False, e, silent)
    assert (grid == cells).all()
    locked = np.full(rows * columns, -1)
    grid = np.roll(cells, 1, axis=0)
    locked[grid[:2, 0]] = 0  # the wrong line is locked: it stays
    shift(grid, turns, np.zeros((0, 2), dtype=np.int64), locked, False, e, silent)
    assert (grid == np.roll(cells, 1, axis=0)).all()


def test_identical_pieces_make_a_picture():
    puzzle, truth = cut(np.full((28 * 3, 28 * 4, 3), 90, dtype=np.uint8), piece_size=28, seed=0)
    solution = solve(puzzle, PuzzleParameters())
    assert solution.placed.all()
    assert score(puzzle, truth, solution).direct_tie_aware == 1.0


def test_two_pieces_are_enough():
    puzzle, _ = cut(np.random.default_rng(0).integers(0, 256, (8, 16, 3)).astype(np.uint8), piece_size=8, seed=0)
    assert solve(puzzle, PuzzleParameters()).placed.all()


def test_the_smallest_pieces():
    puzzle, _ = cut(np.random.default_rng(0).integers(0, 256, (8, 16, 3)).astype(np.uint8), piece_size=4, seed=0)
    assert solve(puzzle, PuzzleParameters()).placed.all()


def test_confidence_tells_right_joins_from_wrong(picture):
    small = picture[::2, ::2]
    puzzle, truth = cut(np.ascontiguousarray(small), piece_size=10, seed=1)
    solution = solve(puzzle, FAST)
    right = right_joins(puzzle, truth, solution)
    sure = solution.joins.confidence > 0.9
    assert right[sure].mean() > 0.9


def test_work_can_be_cancelled(picture):
    def stop(share, words):
        raise Cancelled()

    puzzle, _ = cut(picture, piece_size=28, seed=1)
    with pytest.raises(Cancelled):
        solve(puzzle, FAST, progress=stop)


# --- wishes


def joins_of(rows) -> Joins:
    n = len(rows)
    return Joins(rows, np.zeros((n, 2)), np.zeros(n), np.ones(n))


def holds(solution, row) -> bool:
    a, s, b, t = row
    return any([a, s, b, t] == list(r) or [b, t, a, s] == list(r) for r in solution.joins.sides.tolist())


@pytest.fixture(scope="module")
def prepared(picture):
    puzzle, truth = cut(picture, piece_size=28, seed=11)
    return prepare(puzzle, FAST), truth


def test_a_locked_join_holds_even_if_it_is_wrong(prepared):
    ready, _ = prepared
    free = assemble(ready, FAST)
    a, s, b, _ = free.joins.sides[0].tolist()
    wrong = next(r for r in candidate_joins(ready, a, s).sides.tolist() if r[2] != b)
    solution = assemble(ready, FAST, wishes=Wishes(locked=joins_of([wrong])))
    assert holds(solution, wrong)
    assert solution.joins.confirmed_by[[tuple(sorted((r[0], r[2]))) for r in solution.joins.sides.tolist()].index(
        tuple(sorted((wrong[0], wrong[2]))))] == "person"  # fmt: skip


def test_forbidden_joins_never_hold(prepared):
    ready, _ = prepared
    free = assemble(ready, FAST)
    rows = free.joins.sides[::9].tolist()
    for method in ("mst", "greedy", "loops", "lp"):
        values = FAST.changed(method=method)
        solution = assemble(ready, values, wishes=Wishes(forbidden=joins_of(rows)))
        assert not any(holds(solution, row) for row in rows)


def test_a_pinned_piece_stays_where_it_was_put(prepared):
    ready, truth = prepared
    wrong = Pin(0, *((truth.position[0] + (28, 0)) % (336, 280)).tolist(), 0)
    solution = assemble(ready, FAST, wishes=Wishes(pinned=(wrong,)))
    assert solution.position[0].tolist() == [wrong.x, wrong.y]
    right = Pin(0, *truth.position[0].tolist(), 0)
    pinned = assemble(ready, FAST, wishes=Wishes(pinned=(right, Pin(5, *truth.position[5].tolist(), 0))))
    assert score(ready.puzzle, truth, pinned).perfect


def test_a_pin_turns_a_turned_puzzle(picture):
    puzzle, truth = cut(picture, piece_size=28, turned=True, seed=12)
    pin = Pin(3, *truth.position[3].tolist(), int(truth.turns[3]))
    solution = solve(puzzle, FAST, wishes=Wishes(pinned=(pin,)))
    assert (solution.position == truth.position).all()
    assert (solution.turns == truth.turns).all()


def test_a_pin_may_turn_a_picture_whose_size_is_guessed(picture):
    puzzle, _ = cut(picture[:112, :140], piece_size=28, turned=True, seed=2)  # four rows of five
    ready = prepare(replace(puzzle, frame=None), FAST)
    free = assemble(ready, FAST)
    for turn in range(4):
        solution = assemble(ready, FAST, wishes=Wishes(pinned=(Pin(3, 560, 560, turn),)))
        assert solution.position[3].tolist() == [560, 560]
        assert solution.turns[3] == turn
        upright = (turn - int(free.turns[3])) % 2 == 0
        reach = np.ptp(solution.position[solution.placed], axis=0) + 28
        assert tuple(reach) == tuple(free.sizes[0] if upright else free.sizes[0][::-1])


@pytest.mark.parametrize(
    "wishes",
    [
        Wishes(locked=joins_of([(0, RIGHT, 1, LEFT), (0, RIGHT, 2, LEFT)])),
        Wishes(locked=joins_of([(0, RIGHT, 1, LEFT)]), forbidden=joins_of([(0, RIGHT, 1, LEFT)])),
        Wishes(locked=joins_of([(0, RIGHT, 1, LEFT), (1, BOTTOM, 2, TOP), (2, LEFT, 3, RIGHT), (0, BOTTOM, 4, TOP)])),
        Wishes(pinned=(Pin(0, 0, 0), Pin(1, 0, 0))),
        Wishes(pinned=(Pin(0, 0, 0), Pin(1, 56, 0)), locked=joins_of([(0, RIGHT, 1, LEFT)])),
        Wishes(locked=joins_of([(0, RIGHT, 9999, LEFT)])),
        Wishes(pinned=(Pin(9999, 0, 0),)),
        Wishes(pinned=(Pin(0, 28 * 99, 0),)),
        Wishes(locked=joins_of([(0, RIGHT, 1, TOP)])),
    ],
)
def test_wishes_that_cannot_be_met_are_one_sentence(prepared, wishes):
    with pytest.raises(BadInput) as caught:
        assemble(prepared[0], FAST, wishes=wishes)
    assert str(caught.value).endswith(".")


def test_worn_borders_are_noticed(picture):
    puzzle, truth = worn(*cut(picture, piece_size=28, seed=3), "eroded 1", 3)
    found = [solve(puzzle, FAST.changed(wear=wear)) for wear in ("clean", "auto")]
    assert any("worn" in note for note in found[1].notes)
    assert score(puzzle, truth, found[1]).neighbour >= score(puzzle, truth, found[0]).neighbour
    whole = solve(cut(picture, piece_size=28, seed=3)[0], FAST)
    assert not whole.notes


def test_a_locked_row_over_the_whole_width_finds_its_place(prepared):
    """The picture is full of better ones, which must make room."""
    ready, truth = prepared
    row = np.argsort(truth.position[:, 0] + 1000 * (truth.position[:, 1] != 28))[:12]
    mixed = row[[3, 0, 7, 1, 9, 2, 11, 4, 5, 6, 8, 10]]
    chain = [(int(a), RIGHT, int(b), LEFT) for a, b in itertools.pairwise(mixed)]
    for method in ("mst", "greedy"):
        solution = assemble(ready, FAST.changed(method=method), wishes=Wishes(locked=joins_of(chain)))
        assert all(holds(solution, join) for join in chain)
        assert solution.placed.all()


def test_random_wishes_are_met_or_refused(prepared):
    ready, truth = prepared
    rng = np.random.default_rng(5)
    met = 0
    for _ in range(40):
        rows = [(int(a), s, int(b), (s + 2) % 4) for (a, b), s in zip(
            [rng.choice(ready.puzzle.count, 2, replace=False) for _ in range(6)], rng.integers(0, 4, 6).tolist(), strict=True)]  # fmt: skip
        pins = tuple(Pin(int(i), *truth.position[i].tolist()) for i in rng.integers(0, ready.puzzle.count, 2))
        wishes = Wishes(joins_of(rows[:3]), joins_of(rows[3:]), pins[: int(rng.integers(0, 3))])
        values = FAST.changed(frame=str(rng.choice(["known", "unknown"])), method=str(rng.choice(["mst", "loops"])))
        try:
            solution = assemble(ready, values, wishes=wishes)
        except BadInput:
            continue
        met += 1
        assert all(holds(solution, row) for row in rows[:3])
        assert not any(holds(solution, row) for row in rows[3:])
        moved = [solution.position[p.piece] - (p.x, p.y) for p in wishes.pinned]
        assert all((move == moved[0]).all() for move in moved)
        assert values.frame == "unknown" or not np.any(moved)
        cells = np.column_stack([solution.picture, solution.position])[solution.placed]
        assert len(np.unique(cells, axis=0)) == len(cells)
    assert met > 20


def test_pins_may_not_make_a_forbidden_join(prepared):
    ready, _ = prepared
    pins = (Pin(0, 28, 28), Pin(1, 56, 28))
    with pytest.raises(BadInput, match="forbidden"):
        assemble(ready, FAST, wishes=Wishes(forbidden=joins_of([(0, RIGHT, 1, LEFT)]), pinned=pins))


@pytest.mark.parametrize("turned", [False, True])
def test_three_right_pins_do_no_harm(picture, turned):
    puzzle, truth = cut(picture, piece_size=28, turned=turned, seed=13)
    pins = tuple(Pin(i, *truth.position[i].tolist(), int(truth.turns[i])) for i in (2, 40, 77))
    solution = solve(puzzle, FAST, wishes=Wishes(pinned=pins))
    assert (solution.position == truth.position).all()
    assert (solution.turns == truth.turns).all()


def test_progress_never_goes_back(picture):
    puzzle, _ = cut(picture, piece_size=28, seed=1)
    seen: list[float] = []
    solve(puzzle, PuzzleParameters(), progress=lambda share, words: seen.append(share))
    assert seen == sorted(seen)
    assert min(seen) >= 0
    assert max(seen) == 1


def test_pieces_too_small_to_compare_are_refused():
    tiny = Puzzle(tuple(Piece(rectangle(1, 1), np.full((1, 1, 3), k), np.ones((1, 1), dtype=bool)) for k in range(4)))
    with pytest.raises(BadInput, match="too small"):
        solve(tiny, FAST)


@pytest.fixture
def few_pieces() -> tuple:
    return cut(np.full((280, 336, 3), 250, dtype=np.uint8), piece_size=28, seed=0)


def test_equal_pieces_are_of_one_kind(few_pieces):
    ready = prepare(few_pieces[0], FAST)
    assert not kinds_of(ready.evidence).any()
    assert assemble(ready, FAST).placed.all()
