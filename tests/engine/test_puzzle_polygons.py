"""Puzzles of polygons: strips and contacts by hand, laws of the solver, wishes honoured exactly."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from assets import example_picture
from engine.errors import BadInput, Cancelled
from engine.puzzles.alignments import FIRST, LAST, alignments, contest
from engine.puzzles.clusters import Layout, Trials, apart, bounds, contact_total, held, movement, rotated
from engine.puzzles.contacts import overlapping, statistics, touching, unlikeness
from engine.puzzles.cutting import cut, drop, mix
from engine.puzzles.hypotheses import Rules, put_together, room_around
from engine.puzzles.measures import CODES, IN_LAB, Strips, dissimilarity_of_pairs, gradient_statistics, to_lab
from engine.puzzles.packing import packed, rotated_layout
from engine.puzzles.parameters import MEASURES, PuzzleParameters
from engine.puzzles.pieces import Piece, Puzzle, rectangle
from engine.puzzles.polygonmodels import model_of, triangle
from engine.puzzles.polygons import assemble_polygons, ground_for, is_exact, prepare_polygons
from engine.puzzles.scoring import right_joins, score
from engine.puzzles.solution import UNPLACED, Joins, Pin, Wishes
from engine.puzzles.solving import assemble, candidate_joins, prepare, solve
from engine.puzzles.subedges import sides_of, snapped
from engine.puzzles.turning import turned_piece

USUAL = PuzzleParameters()
NOTHING = np.zeros((0, 5), dtype=np.int64)


@pytest.fixture(scope="module")
def picture() -> np.ndarray:
    return np.asarray(Image.open(example_picture()).convert("RGB"))[100:380, 60:396]


@pytest.fixture(scope="module")
def rectangles(picture):
    return cut(picture, kind="rectangles", pieces=24, seed=1)


@pytest.fixture(scope="module")
def prepared(rectangles):
    return prepare_polygons(rectangles[0], USUAL)


def plain(w, h, colour=(9, 9, 9)):
    return Piece(rectangle(w, h), np.full((h, w, 3), colour), np.ones((h, w)))


def ground_of_plain(*sizes, slack=0.0):
    puzzle = Puzzle(tuple(plain(w, h) for w, h in sizes))
    return puzzle, ground_for(puzzle, "learned", model_of("learned").form)[1]._replace(slack=slack)


# --- strips


def test_strips_of_a_rectangle_are_its_pixel_rows_clockwise():
    image = np.random.default_rng(0).integers(0, 256, (6, 9, 3))
    sides = sides_of((Piece(rectangle(9, 6), image, np.ones((6, 9))),))
    rows = [image[0], image[:, -1], image[-1, ::-1], image[::-1, 0]]
    inner = [image[1], image[:, -2], image[-2, ::-1], image[::-1, 1]]
    assert np.diff(sides.strip).tolist() == [9, 6, 9, 6]
    assert sides.outer == pytest.approx(np.concatenate(rows))
    assert sides.inner == pytest.approx(np.concatenate(inner))
    assert sides.reach.tolist() == [0.5] * 4


def test_both_halves_of_a_square_have_as_many_samples_on_their_diagonal_and_see_the_same_ramp():
    ramp = np.repeat(np.arange(20)[None, :, None] * 10, 20, axis=0).repeat(3, axis=2)
    y, x = np.mgrid[:20, :20]
    halves = (Piece([[0, 0], [20, 0], [20, 20]], ramp, x >= y), Piece([[0, 0], [20, 20], [0, 20]], ramp, y > x))
    sides = sides_of(halves)
    upper, lower = (sides.outer[sides.strip[e] : sides.strip[e + 1], 0] for e in (2, 3))
    assert len(upper) == len(lower) == round(np.hypot(20, 20))
    across = 2 / np.sqrt(2) * 10  # two pixels between the strips, along the slope of the ramp
    difference = (upper - lower[::-1])[2:-2]
    assert difference == pytest.approx(np.full(len(difference), across), abs=6)


def test_samples_of_a_slope_come_from_the_piece_alone():
    y, x = np.mgrid[:20, :20]
    image = np.where((x >= y)[..., None], 200, 0)
    sides = sides_of((Piece([[0, 0], [20, 0], [20, 20]], np.repeat(image, 3, axis=2), x >= y),))
    assert sides.outer.min() == pytest.approx(200)


def test_traced_corners_snap_to_level_sides_and_to_the_border():
    traced = np.array([[0.7, 0.2], [29.6, 0.0], [30.0, 19.4], [0.0, 20.0]])
    assert snapped(traced, (30, 20)).tolist() == [[0, 0], [30, 0], [30, 20], [0, 20]]
    slope = np.array([[0.0, 0.0], [30.0, 0.0], [30.0, 20.0]])
    assert snapped(slope, (30, 20)).tolist() == slope.tolist()


def test_an_exact_outline_is_told_from_a_traced_one():
    assert is_exact(plain(8, 5))
    assert not is_exact(Piece(rectangle(7, 5), np.zeros((5, 8, 3)), np.ones((5, 8))))
    assert not is_exact(Piece(rectangle(8, 4.7), np.zeros((5, 8, 3)), np.ones((5, 8))))


# --- contacts


def test_where_two_rectangles_touch():
    _, ground = ground_of_plain((10, 20), (15, 30))
    right, left = 1, 4 + 3  # sides are numbered clockwise from the top
    assert touching(ground, right, 0, left, 0, 10, 0) == (20, 0, 10)
    assert touching(ground, right, 0, left, 0, 10, 5) == (15, 5, 15)
    assert touching(ground, right, 0, left, 0, 10, -25) == (5, 0, 0)
    assert touching(ground, right, 0, left, 0, 11, 0)[0] == 0  # a gap
    assert touching(ground, right, 0, 4 + 1, 0, 10, 0)[0] == 0  # both face right
    assert touching(ground, right, 0, 4 + 2, 1, 10, 0) == (15, 0, 0)  # a bottom faces left after a turn


def test_slack_lets_traced_sides_touch():
    _, ground = ground_of_plain((10, 20), (15, 30), slack=1.0)
    assert touching(ground, 1, 0, 7, 0, 11, 0)[0] == 20
    assert touching(ground, 1, 0, 7, 0, 13, 0)[0] == 0
    assert not overlapping(ground, 0, 0, 1, 0, 9, 0)
    assert overlapping(ground, 0, 0, 1, 0, 8, 0)


def test_triangles_overlap_by_pixels_not_by_boxes():
    y, x = np.mgrid[:10, :10]
    halves = (Piece([[0, 0], [10, 0], [10, 10]], np.zeros((10, 10, 3)), x >= y),
              Piece([[0, 0], [10, 10], [0, 10]], np.zeros((10, 10, 3)), y > x))  # fmt: skip
    _, ground = ground_for(Puzzle(halves), "learned", model_of("learned").form)
    assert not overlapping(ground, 0, 0, 1, 0, 0, 0)
    assert not overlapping(ground, 0, 0, 1, 2, 10, 0)
    assert overlapping(ground, 0, 0, 1, 0, 1, 0)
    assert not overlapping(ground, 0, 2, 1, 2, 0, 0)
    assert overlapping(ground, 0, 0, 1, 1, 0, 0)


def test_statistics_are_those_of_the_square_solver():
    rng = np.random.default_rng(2)
    outer, inner = rng.integers(0, 256, (2, 1, 12, 3)).astype(np.float32)
    mean, inverse = np.empty(3), np.empty((3, 3))
    statistics(outer[0], inner[0], mean, inverse)
    means, inverses = gradient_statistics(Strips(outer, inner))
    assert mean == pytest.approx(means[0])
    assert inverse == pytest.approx(inverses[0], rel=1e-6)


@pytest.mark.parametrize("measure", ["ssd", "ssd-lab", "pt", "mgc", "mgc-root", "emd", "emd-lab"])
def test_a_contact_is_measured_as_sides_of_squares_are(measure):
    rng = np.random.default_rng(3)
    outer, inner = rng.integers(0, 256, (2, 2, 12, 3)).astype(np.float32)
    expected = dissimilarity_of_pairs(measure, Strips(outer, inner), [[0, 1]])[0]
    if measure in IN_LAB:
        outer, inner = to_lab(outer), to_lab(inner)
    value = unlikeness(CODES[measure], outer[0], inner[0], outer[1], inner[1], 1.0)
    assert value * (1 if measure in ("emd", "emd-lab") else 12) == pytest.approx(expected)


def test_the_form_is_read_row_by_row():
    assert triangle(np.arange(6.0)).tolist() == [[0, 1, 2], [0, 3, 4], [0, 0, 5]]


# --- candidates


def test_candidates_of_two_rectangles():
    _, ground = ground_of_plain((10, 20), (15, 20))
    a = alignments(ground, np.repeat([0, 1], 4), features=9, turned=False)
    found = {(tuple(s), tuple(o), int(c)) for s, o, c in zip(a.side.tolist(), a.offset.tolist(), a.corner, strict=True)}
    assert found == {
        ((1, 7), (10, 0), FIRST + LAST), ((3, 5), (-15, 0), FIRST + LAST),  # beside each other: both corners meet
        ((0, 6), (0, -20), FIRST), ((0, 6), (-5, -20), LAST), ((2, 4), (-5, 20), FIRST), ((2, 4), (0, 20), LAST),
    }  # fmt: skip
    turned = alignments(ground, np.repeat([0, 1], 4), features=9, turned=True)
    assert set(turned.turn) == {0, 1, 2, 3}
    assert len(turned.side) == 12 * 2 + 4  # each two sides meet after one turn; four of them have the same length


def test_rivals_at_a_corner_share_its_probability():
    a = alignments(ground_of_plain((20, 20), (20, 20), (20, 20))[1], np.repeat([0, 1, 2], 4), features=9, turned=False)
    standing = contest(a, np.where((a.side == (1, 7)).all(axis=1), 3.0, 0.0), 12)
    chosen = (a.side == (1, 7)).all(axis=1)
    assert standing[chosen, 0] == pytest.approx(3.0 - np.logaddexp(0.0, -3.0))  # against piece 2 and nobody
    rival = (a.side == (1, 11)).all(axis=1)
    assert standing[rival, 0] == pytest.approx(0.0 - np.logaddexp(3.0, -3.0))


# --- clusters


@pytest.mark.parametrize("turns", range(4))
def test_turning_a_box_four_times_brings_it_back(turns):
    x, y = rotated(3, 5, 7, 2, turns)
    w, h = (2, 7) if turns % 2 else (7, 2)
    assert rotated(x, y, w, h, -turns) == (3, 5)


def test_a_movement_puts_a_piece_beside_another_however_both_stand():
    _, ground = ground_of_plain((10, 20), (15, 30))
    for ta in range(4):
        for tb in range(4):
            layout = Layout(np.arange(2), np.array([[7, -3], [50, 60]]), np.array([ta, tb]))
            turns, x, y = movement(ground, layout, 0, 1, 1, 10, 4)
            moved = Layout(np.zeros(2, dtype=np.int64), layout.place.copy(), layout.turns.copy())
            box = bounds(ground, layout, np.array([1]), 0, 1, turns, x, y)
            moved.place[1], moved.turns[1] = box[:2], (tb + turns) % 4
            assert (moved.turns[1] - ta) % 4 == 1
            kept = np.zeros(1, dtype=bool)
            trial = Trials(np.array([[1, 7]]), np.array([1]), np.array([[10, 4]]), np.zeros(1))
            held(ground, moved, trial, kept)
            assert kept.all()
            moved.place[1] += (0, 1)
            held(ground, moved, trial, kept)
            assert not kept.any()


def merged(ground, n, trials, **rules):
    usual = {"forbidden": NOTHING, "fixed": -1, "width": 0, "height": 0, "either_way": False, "base": 0.0}
    return put_together(ground, apart(n), trials, Rules(**usual | rules), 0.5)


def trials_of(rows):
    sides, offsets, odds = zip(*rows, strict=True)
    return Trials(np.array(sides), np.zeros(len(rows), dtype=np.int64), np.array(offsets), np.array(odds, dtype=float))


def test_no_merge_overlaps_outgrows_the_frame_or_is_forbidden():
    _, ground = ground_of_plain((10, 10), (10, 10), (10, 10))
    ground = ground._replace(form=np.zeros_like(ground.form))  # contacts say nothing
    trials = trials_of([((1, 7), (10, 0), 9), ((1, 11), (10, 0), 8), ((5, 11), (10, 0), 7)])
    assert merged(ground, 3, trials).chosen.tolist() == [0, 2]
    assert merged(ground, 3, trials, width=20, height=99).chosen.tolist() == [0]
    assert merged(ground, 3, trials, width=9, height=30, either_way=True).chosen.tolist() == []
    assert merged(ground, 3, trials, width=10, height=30, either_way=True).chosen.tolist() == [0, 2]
    barred = np.array([[0, 1, 0, 10, 0]])
    the_other_way = np.array([[1, 0, 0, -10, 0]])
    for rows in (barred, the_other_way):
        assert merged(ground, 3, trials, forbidden=rows).chosen.tolist() == [1]


def test_contacts_that_arise_count():
    """Four squares in a ring: the join that closes it is made though it is unlikely by itself, if its contacts fit."""
    _, ground = ground_of_plain((10, 10), (10, 10), (10, 10), (10, 10))
    form = np.zeros_like(ground.form)
    form[0, 0] = 2.0  # every contact has the log odds 2
    trials = trials_of([((1, 7), (10, 0), 5), ((9, 15), (10, 0), 5), ((2, 8), (0, 10), -1)])
    assert len(merged(ground._replace(form=form), 4, trials).chosen) == 3
    form[0, 0] = -2.0
    assert len(merged(ground._replace(form=form), 4, trials).chosen) == 2


# --- packing


def test_white_pieces_are_packed_without_a_gap():
    rng = np.random.default_rng(4)
    puzzle, truth = cut(np.full((60, 90, 3), 255), kind="rectangles", pieces=9, seed=5)
    _, ground = ground_for(puzzle, "learned", model_of("learned").form)
    core = int(rng.integers(9))
    found = packed(
        ground, apart(9), apart(9), core, NOTHING, (90, 60), fixed=False, turned=False, base=0.0, most=100_000
    )
    assert found is not None
    covered = np.zeros((60, 90), dtype=int)
    for piece, (x, y) in zip(puzzle.pieces, found.place, strict=True):
        covered[y : y + piece.mask.shape[0], x : x + piece.mask.shape[1]] += 1
    assert (covered == 1).all()
    assert truth.position.shape == found.place.shape


def test_what_cannot_be_packed_is_not():
    _, ground = ground_of_plain((10, 10), (10, 10), (5, 30))
    assert (
        packed(ground, apart(3), apart(3), 0, NOTHING, (20, 10), fixed=False, turned=False, base=0.0, most=99) is None
    )


def test_four_turns_of_a_layout_are_none():
    _, ground = ground_of_plain((10, 20), (15, 30))
    layout = Layout(np.zeros(2, dtype=np.int64), np.array([[0, 0], [10, 5]]), np.array([0, 1]))
    once = rotated_layout(ground, layout, 1, (40, 50))
    assert once.place.tolist() == [[30, 0], [30, 10]]
    back = rotated_layout(ground, once, 3, (50, 40))
    assert back.place.tolist() == layout.place.tolist()
    assert back.turns.tolist() == layout.turns.tolist()


def test_a_ragged_cluster_lies_at_its_straight_border():
    _, ground = ground_of_plain((10, 10), (10, 20), (10, 30))
    layout = Layout(np.zeros(3, dtype=np.int64), np.array([[0, 20], [10, 10], [20, 0]]), np.zeros(3, dtype=np.int64))
    assert room_around(ground, layout, np.ones(3, dtype=bool), (30, 45))[0] == (0, 15)  # level below


# --- the whole solver


@pytest.mark.parametrize("kind", ["rectangles", "merged", "triangles"])
def test_a_picture_is_put_together(picture, kind):
    puzzle, truth = cut(picture, kind=kind, seed=2, **({"pieces": 24} if kind == "rectangles" else {"piece_size": 56}))
    solution = solve(puzzle, USUAL)
    scores = score(puzzle, truth, solution)
    assert scores.direct == 1.0
    assert scores.neighbour == 1.0
    assert right_joins(puzzle, truth, solution).all()
    assert tuple(solution.sizes[0]) == puzzle.frame


def test_turned_pieces_are_put_together(picture):
    puzzle, truth = cut(picture, kind="triangles", piece_size=70, turned=True, seed=3)
    assert score(puzzle, truth, solve(puzzle, USUAL)).direct == 1.0


def test_the_order_of_pieces_changes_nothing(rectangles, prepared):
    puzzle, _ = rectangles
    order = np.random.default_rng(0).permutation(puzzle.count)
    other = solve(replace(puzzle, pieces=tuple(puzzle.pieces[i] for i in order)), USUAL)
    assert (other.position == assemble_polygons(prepared, USUAL).position[order]).all()


def test_pieces_turned_before_reading_end_where_they_were(picture):
    puzzle, _ = cut(picture, kind="rectangles", pieces=12, seed=4)
    upright = solve(puzzle, USUAL)
    read = tuple(turned_piece(piece, k % 4) for k, piece in enumerate(puzzle.pieces))
    turned = solve(replace(puzzle, pieces=read, turned=True, frame=None), USUAL)
    relative = (turned.turns + np.arange(puzzle.count)) % 4
    assert len(set(relative.tolist())) == 1  # the picture may lie on its side, but as a whole
    assert sorted(turned.sizes[0]) == sorted(upright.sizes[0])


def test_the_frame_may_be_unknown(rectangles, prepared):
    puzzle, truth = rectangles
    free = replace(puzzle, frame=None)
    assert score(free, truth, assemble_polygons(replace(prepared, puzzle=free), USUAL)).direct == 1.0


def test_lost_pieces_leave_the_others_where_they_are(picture):
    puzzle, truth = drop(*cut(picture, kind="merged", piece_size=56, seed=1), missing=0.12, seed=0)
    assert score(puzzle, truth, solve(puzzle, USUAL)).neighbour > 0.9


def test_two_pictures_are_told_apart(picture):
    other = np.ascontiguousarray(picture[::-1, :, ::-1] // 2)
    puzzle, truth = mix([cut(p, kind="rectangles", pieces=12, seed=k) for k, p in enumerate((picture, other))], seed=1)
    solution = solve(puzzle, USUAL)
    assert score(puzzle, truth, solution).direct == 1.0
    assert len(solution.sizes) == 2


@pytest.mark.parametrize("measure", [m for m in MEASURES if m != "learned"])
def test_every_measure_puts_a_clear_picture_together_mostly(rectangles, measure):
    puzzle, truth = rectangles
    solution = solve(puzzle, PuzzleParameters(measure=measure))
    assert solution.measure == measure
    assert score(replace(puzzle, frame=None), truth, solution).direct > 0.5


def test_joins_lie_as_the_pieces_do(rectangles, prepared):
    puzzle, _ = rectangles
    solution = assemble_polygons(prepared, USUAL)
    joins = solution.joins
    a, b = joins.sides[:, 0], joins.sides[:, 2]
    assert (a < b).all()
    assert (joins.offset == solution.position[b] - solution.position[a]).all()
    assert ((joins.confidence >= 0) & (joins.confidence <= 1)).all()
    for i, side, j, other in joins.sides.tolist():
        assert (other - side) % 2 == 0 or puzzle.turned  # rectangles touch with opposite sides
        assert i != j
    assert joins.confidence.mean() > 0.8


def test_likely_partners_name_both_pieces_from_either_side(prepared):
    joins = assemble_polygons(prepared, USUAL).joins
    k = int(joins.confidence.argmax())
    a, side_a, b, side_b = joins.sides[k].tolist()
    from_a, from_b = candidate_joins(prepared, a, side_a), candidate_joins(prepared, b, side_b)
    assert (from_a.sides[:, :2] == (a, side_a)).all()
    assert (np.diff(from_a.confidence) <= 0).all()
    rows = [
        np.flatnonzero((j.sides[:, 2:] == end).all(axis=1)) for j, end in ((from_a, (b, side_b)), (from_b, (a, side_a)))
    ]
    there = {tuple(offset) for offset in from_a.offset[rows[0]].tolist()}
    back = {tuple(offset) for offset in (-from_b.offset[rows[1]]).tolist()}
    assert there == back != set()
    with pytest.raises(BadInput, match="no side"):
        candidate_joins(prepared, 0, 4)


def test_likely_partners_of_turned_pieces_agree_from_both_sides(picture):
    puzzle, _ = cut(picture, kind="rectangles", pieces=8, turned=True, seed=4)
    ready = prepare(puzzle, USUAL)
    joins = candidate_joins(ready, 0, 1)
    for (_, side, b, other), turn, offset in list(zip(joins.sides.tolist(), joins.turn, joins.offset, strict=True))[
        :10
    ]:
        back = candidate_joins(ready, b, other)
        (row,) = [
            k for k in range(len(back)) if back.sides[k, 2:].tolist() == [0, side]
            and where_it_stands(ready, 0, b, turn, offset) == where_it_stands(ready, b, 0, back.turn[k], back.offset[k], True)
        ]  # fmt: skip
        assert (back.turn[row] + turn) % 4 == 0


def where_it_stands(ready, a, b, turn, offset, swap=False):
    """Where b stands to a, both seen while the first named (of the join) stands as read; from the other end if `swap`."""
    ground = ready.ground
    layout = apart(ready.puzzle.count)
    turns, x, y = movement(ground, layout, a, b, turn, *offset)
    if not swap:
        return turns, x, y
    back = rotated(-x, -y, 0, 0, -turns)
    return (-turns) % 4, *back


def test_work_can_be_cancelled(prepared):
    def stop(share, words):
        if share > 0.3:
            raise Cancelled

    with pytest.raises(Cancelled):
        assemble_polygons(prepared, USUAL, progress=stop)


# --- wishes


def one(joins, k):
    return Joins(joins.sides[[k]], joins.offset[[k]], joins.turn[[k]], joins.confidence[[k]])


def stands(solution, join):
    a, b = int(join.sides[0, 0]), int(join.sides[0, 2])
    return tuple(solution.position[b] - solution.position[a]) == tuple(join.offset[0])


def test_a_forbidden_join_is_not_made_and_a_locked_one_is(prepared):
    solution = assemble_polygons(prepared, USUAL)
    for k in (0, len(solution.joins) // 2):
        join = one(solution.joins, k)
        without = assemble_polygons(prepared, USUAL, wishes=Wishes(forbidden=join))
        assert not stands(without, join) or without.picture[join.sides[0, [0, 2]]].min() == UNPLACED
    wrong = next(
        one(joins, row) for piece in range(24) for joins in [candidate_joins(prepared, piece, 1)]
        for row in range(len(joins)) if not stands(solution, one(joins, row)) and joins.confidence[row] < 0.01
    )  # fmt: skip
    forced = assemble_polygons(prepared, USUAL, wishes=Wishes(locked=wrong))
    assert stands(forced, wrong)
    row = [k for k in range(len(forced.joins)) if forced.joins.confirmed_by[k] == "person"]
    assert len(row) == 1
    assert forced.joins.confidence[row[0]] == 1.0


def test_locking_what_is_right_changes_nothing(prepared):
    solution = assemble_polygons(prepared, USUAL)
    again = assemble_polygons(prepared, USUAL, wishes=Wishes(locked=one(solution.joins, 3)))
    assert (again.position == solution.position).all()


def test_pinned_pieces_stay_where_they_are(rectangles, prepared):
    puzzle, truth = rectangles
    x, y = truth.position[5].tolist()
    solution = assemble_polygons(prepared, USUAL, wishes=Wishes(pinned=(Pin(5, x, y),)))
    assert score(puzzle, truth, solution).direct == 1.0
    free = replace(prepared, puzzle=replace(puzzle, frame=None))
    away = assemble_polygons(free, USUAL, wishes=Wishes(pinned=(Pin(5, x + 300, y + 200),)))
    assert tuple(away.position[5]) == (x + 300, y + 200)
    assert (away.position - solution.position == (300, 200)).all()


def test_contradictory_wishes_are_one_sentence(prepared):
    join = one(assemble_polygons(prepared, USUAL).joins, 0)
    with pytest.raises(BadInput, match="locked and forbidden"):
        assemble(prepared, USUAL, wishes=Wishes(locked=join, forbidden=join))
    with pytest.raises(BadInput, match="overlap"):
        assemble(prepared, USUAL, wishes=Wishes(pinned=(Pin(0, 0, 0), Pin(1, 1, 1))))


def test_nothing_overlaps_and_all_contacts_are_counted_once(rectangles, prepared):
    solution = assemble_polygons(prepared, USUAL)
    layout = Layout(solution.picture.copy(), solution.position.copy(), solution.turns.copy())
    covered = np.zeros(rectangles[0].frame[::-1], dtype=int)
    for piece, (x, y) in zip(rectangles[0].pieces, solution.position, strict=True):
        covered[y : y + piece.mask.shape[0], x : x + piece.mask.shape[1]] += 1
    assert (covered == 1).all()
    seam = (np.diff(owner(rectangles[0], solution), axis=0) != 0).sum() + (
        np.diff(owner(rectangles[0], solution), axis=1) != 0
    ).sum()
    _, length = contact_total(prepared.ground, layout, 0.0)
    assert length == pytest.approx(seam, abs=4 * len(solution.joins))


def owner(puzzle, solution):
    w, h = puzzle.frame
    result = np.zeros((h, w), dtype=int)
    for k, (piece, (x, y)) in enumerate(zip(puzzle.pieces, solution.position, strict=True)):
        result[y : y + piece.mask.shape[0], x : x + piece.mask.shape[1]] = k
    return result


# --- real pictures


def test_real_pictures_cut_by_guillotine(real_puzzles):
    right = []
    for name in ("kodim05.png", "kodim08.png", "kodim11.png"):
        path = real_puzzles / "kodak12" / name
        if not path.is_file():
            continue
        puzzle, truth = cut(np.asarray(Image.open(path).convert("RGB")), kind="rectangles", pieces=50, seed=7)
        right.append(score(puzzle, truth, solve(puzzle, USUAL)).direct)
    if not right:
        pytest.skip("the pictures that this test names are not in the folder kodak12")
    assert np.mean(right) >= 0.95
