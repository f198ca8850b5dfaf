"""Corners and halves by hand; what MatchLift and diffusion pruning confirm on pictures drawn by numbers."""

import numpy as np
import pytest

from engine.consistency.apart import all_the_same, capped_components, matchlift_apart
from engine.consistency.matchlift import matchlift
from engine.errors import BadInput, BadParameter, Cancelled
from engine.puzzles.confirming import confirm_diffusion, confirm_matchlift, confirmed_joins
from engine.puzzles.corners import (
    corner_matrix,
    corner_similarity,
    join_confidence,
    meeting_corners,
    universe_of,
    unlike_corners,
)
from engine.puzzles.cutting import cut
from engine.puzzles.halves import half_dissimilarity, half_strips, least_of_halves, meeting_halves
from engine.puzzles.measures import Strips, dissimilarity, side_strips
from engine.puzzles.parameters import PuzzleParameters
from engine.puzzles.pieces import BOTTOM, LEFT, RIGHT, TOP
from engine.puzzles.pruning import affinity, correspondences, distinctness, prune
from engine.puzzles.solving import assemble, prepare

LIFT = {"t_1": 0.6, "t_2": 0.5, "sparsity": 0.1, "penalty": 4.0, "tolerance": 1e-3, "max_steps": 300}
ROUNDS = {"knn": 2, "t_1": 0.1, "t_2": 0.7, "t_3": 0.3, "iterations": 20}
PRUNE = ROUNDS | {"least": 0.5}
TL, TR, BR, BL = range(4)


def picture(w=168, h=126, seed=0):
    """Smooth noise: what a picture is like at its borders."""
    rng = np.random.default_rng(seed)
    big = rng.standard_normal((h // 6 + 4, w // 6 + 4, 3)).repeat(6, axis=0).repeat(6, axis=1)
    for axis in (0, 1):
        for _ in range(2):
            big = (big + np.roll(big, 3, axis=axis) + np.roll(big, 1, axis=axis)) / 3
    grain = rng.standard_normal((h, w, 3))
    return np.clip(128 + 90 * big[6 : h + 6, 6 : w + 6] + 3 * grain, 0, 255).astype(np.uint8)


def all_rows(n):
    """All right-left and bottom-top pairs of n unturned pieces, (2 n (n - 1), 2)."""
    i, j = np.nonzero(~np.eye(n, dtype=bool))
    return np.concatenate([np.column_stack([4 * i + RIGHT, 4 * j + LEFT]), np.column_stack([4 * i + BOTTOM, 4 * j + TOP])])


def truly(rows, true):
    """Which rows (c, 2) of sides touch in the true cells (n, 2)."""
    step = np.array([(0, -1), (1, 0), (0, 1), (-1, 0)])[rows[:, 0] % 4]
    return (true[rows[:, 1] // 4] - true[rows[:, 0] // 4] == step).all(axis=1)


@pytest.fixture(scope="module")
def puzzle():
    """48 shuffled squares of 21 px: puzzle, strips, true cells, all rows, their halves' dissimilarity, which are true."""
    made, truth = cut(picture(), piece_size=21, seed=3)
    strips, true = side_strips(made.rasters()), truth.position // 21
    rows = all_rows(made.count)
    return made, strips, true, rows, half_dissimilarity("mgc-root", strips, rows), truly(rows, true)


def test_halves_of_two_sides_that_meet_lie_against_each_other():
    rows = np.array([[4 * 0 + RIGHT, 4 * 1 + LEFT]])
    assert meeting_halves(rows).tolist() == [[[2, 15], [3, 14]]]  # right's upper half is its first, left's is its second
    pixels = np.arange(4 * 7 * 3, dtype=np.float32).reshape(4, 7, 3)
    halves = half_strips(Strips(pixels, pixels))
    assert halves.outer.shape == (8, 3, 3)
    assert np.array_equal(halves.outer[2], pixels[1, :3])
    assert np.array_equal(halves.outer[3], pixels[1, 4:])  # the middle pixel of seven is in neither half


def test_halves_of_equal_length_add_up_to_the_whole_side():
    made, _ = cut(picture(), piece_size=14, seed=0)
    strips = side_strips(made.rasters())
    rows = all_rows(made.count)[:50]
    whole = np.array([dissimilarity("ssd", strips, [a], [b])[0, 0] for a, b in rows])
    assert half_dissimilarity("ssd", strips, rows).sum(axis=1) == pytest.approx(whole)


def test_corners_that_meet_are_those_of_the_thesis():
    rows = np.array([[4 * 0 + RIGHT, 4 * 1 + LEFT], [4 * 0 + BOTTOM, 4 * 1 + TOP]])
    assert meeting_corners(rows).tolist() == [
        [[TR, 4 + TL], [BR, 4 + BL]],  # III ~ I, IV ~ II
        [[BR, 4 + TR], [BL, 4 + TL]],  # IV ~ III, II ~ I
    ]


def test_similarity_of_corners_is_one_for_best_buddies_alone():
    rows = np.array([[1, 7], [1, 11], [5, 11]])
    halves = np.array([[1.0, 2.0], [2.0, 1.0], [4.0, 4.0]])
    similarity = corner_similarity(rows, halves)
    assert similarity[0] == pytest.approx([1, 0.5], rel=0.01)
    assert similarity[1] == pytest.approx([0.5, 1], rel=0.01)
    assert similarity[2] == pytest.approx([0.5, 0.25], rel=0.01)
    assert least_of_halves(rows, halves)[[2, 3]].tolist() == [1.0, 1.0]


def test_corner_matrix_is_symmetric_thresholded_and_keeps_to_kinds(puzzle):
    _, _, _, rows, halves, _ = puzzle
    matrix = corner_matrix(rows, corner_similarity(rows, halves), 48, t_1=0.8)
    assert np.array_equal(matrix, matrix.T)
    assert matrix[matrix > 0].min() >= 0.8
    for label in unlike_corners(48, turned=False):
        assert not matrix[label[:, None] == label].any()
    assert len(unlike_corners(48, turned=True)) == 1
    kinds = np.argwhere(matrix) % 4
    assert not ((kinds == [TL, BR]).all(axis=1) | (kinds == [TR, BL]).all(axis=1)).any()  # those have no input


def test_the_universe_is_the_points_of_the_grid():
    assert universe_of(4, 3) == 20


@pytest.mark.parametrize("at_once", [48, 0])
def test_matchlift_confirms_true_joins(puzzle, at_once):
    _, _, _, rows, halves, right = puzzle
    found = confirm_matchlift(rows, halves, count=48, universe=universe_of(8, 6), at_once=at_once, **LIFT)
    assert right[found.kept].mean() > 0.97
    assert found.kept[right].mean() > 0.85
    assert np.array_equal(found.kept, found.confidence >= 0.5)


def test_small_parts_give_the_joins_of_one_large_lift(puzzle):
    _, _, _, rows, halves, _ = puzzle
    whole, parts = (confirm_matchlift(rows, halves, count=48, universe=200, at_once=n, **LIFT) for n in (48, 0))
    assert (whole.kept != parts.kept).sum() <= 2
    assert np.abs(whole.confidence - parts.confidence).max() < 0.25
    assert np.abs(whole.confidence - parts.confidence).mean() < 1e-3


def test_matchlift_completes_a_join_that_its_loop_implies():
    """Three joins of a 2 × 2 square are good, the fourth is too unlike to be an input."""
    pieces = {"a": 0, "b": 1, "c": 2, "d": 3}
    rows = np.array([[4 * pieces[p] + s, 4 * pieces[q] + t] for p, s, q, t in
                     (("a", RIGHT, "b", LEFT), ("a", BOTTOM, "c", TOP), ("b", BOTTOM, "d", TOP), ("c", RIGHT, "d", LEFT),
                      ("c", RIGHT, "b", LEFT))])  # fmt: skip
    halves = np.array([[1, 1], [1, 1], [1, 1], [9, 9], [5, 5]], dtype=float)
    found = confirm_matchlift(rows, halves, count=4, at_once=4, **LIFT | {"t_1": 0.7})
    inner = join_confidence(rows, matchlift(
        corner_matrix(rows, np.where(halves < 2, 1.0, 0.0), 4, t_1=0.7), np.arange(16) // 4, universe=9,
        impossible=np.equal.outer(np.arange(16) % 4, np.arange(16) % 4), sparsity=0.1, penalty=4.0, tolerance=1e-4,
        max_steps=2000).matches)  # fmt: skip
    assert found.kept[:3].all()
    assert inner[3, 0] > 0.9  # the corner in the middle is the same for all four pieces
    assert not found.kept[4]


def test_the_order_of_pieces_and_of_the_two_sides_says_nothing(puzzle):
    _, _, _, rows, halves, _ = puzzle
    order = np.random.default_rng(0).permutation(48)
    renamed = 4 * np.argsort(order)[rows // 4] + rows % 4
    shuffled = np.random.default_rng(1).permutation(len(rows))
    for confirm, how in ((confirm_diffusion, PRUNE), (confirm_matchlift, LIFT | {"at_once": 0})):
        plain = confirm(rows, halves, count=48, **how)
        again = confirm(renamed[shuffled], halves[shuffled], count=48, **how)
        assert again.confidence == pytest.approx(plain.confidence[shuffled], abs=1e-3)
        swapped = confirm(rows[:, ::-1], halves[:, ::-1], count=48, **how)  # the halves change places with the sides
        assert swapped.confidence == pytest.approx(plain.confidence, abs=1e-3)


def test_diffusion_confirms_true_joins(puzzle):
    _, _, _, rows, halves, right = puzzle
    found = confirm_diffusion(rows, halves, count=48, **PRUNE)
    assert right[found.kept].mean() > 0.95
    assert found.kept[right].mean() > 0.9
    first = confirm_diffusion(rows, halves, count=48, **PRUNE | {"iterations": 1})
    assert right[first.kept].all()
    assert 0 < first.kept.sum() < found.kept.sum()
    every = confirm_diffusion(rows, halves, count=48, **PRUNE | {"least": 0.0})
    wrong = every.kept & ~right  # sides of the frame, which have no partner, are joined last
    assert 0 < wrong.sum() < 14
    assert every.confidence[wrong].max() < np.median(every.confidence[every.kept & right])


def test_every_side_is_confirmed_once(puzzle):
    _, _, _, rows, halves, _ = puzzle
    kept = rows[confirm_diffusion(rows, halves, count=48, **PRUNE).kept]
    assert len(np.unique(kept)) == kept.size


def test_correspondences_of_one_join_by_hand():
    rows = np.array([[1, 7], [1, 11]])
    halves = np.array([[2.0, 4.0], [6.0, 3.0]])
    sim, valid = correspondences(rows, halves, knn=1, t_1=0.1)
    assert sim[0] == pytest.approx([1, 4 / 3, 1, 1], rel=0.01)  # halves 2, 3 look from side 1; 15, 14 from side 7
    assert sim[1] == pytest.approx([3, 1, 1, 1], rel=0.01)
    assert valid.tolist() == [[True, False, True, True], [False, True, True, True]]
    assert not correspondences(rows, halves, knn=2, t_1=0.5)[1][1, 0]  # 1/3 is below t1
    assert correspondences(rows, halves, knn=2, t_1=0.1)[1].all()


def test_affinity_is_that_of_equation_5_4():
    m = affinity(np.array([[1.0, 1.25, 2.0, 4.0]]), np.array([[True, True, True, False]]), t_2=0.6)[0]
    assert m[0].tolist() == [1, pytest.approx(0.8), 0, 0]  # (1/1.25)/1; (1/2)/1 < t2; not a candidate
    assert m[1].tolist() == [pytest.approx(0.8), 1, 0, 0]  # (1.25/2)/1.25 = 0.5 < t2
    assert m[3].tolist() == [0, 0, 0, 0]
    assert np.array_equal(m, m.T)


def test_a_join_needs_both_halves_from_both_sides():
    good = prune(np.array([[1, 7]]), np.array([[1.0, 1.0]]), **ROUNDS | {"t_3": 1.0})
    assert good.kept.tolist() == [True]
    rows = np.array([[1, 7], [1, 11], [1, 15]])
    one_sided = np.array([[1.0, 9.0], [5.0, 1.0], [6.0, 2.0]])  # the second half of side 1 prefers the two others
    assert not prune(rows, one_sided, **ROUNDS | {"t_3": 1.0}).kept[0]


def test_halves_too_unlike_each_other_are_refused():
    rows = np.array([[1, 7], [1, 11], [5, 7], [5, 11]])
    halves = np.array([[1.0, 100.0], [100.0, 1.0], [100.0, 1.0], [1.0, 100.0]])
    assert not prune(rows, halves, **ROUNDS | {"t_3": 1.0, "t_1": 0.0, "t_2": 0.0}).kept.any()


def test_later_rounds_find_what_freed_sides_leave():
    """Side 5 likes 7 best, but 7 belongs to 1; once that is settled 5 and 11 find each other."""
    rows = np.array([[1, 7], [5, 7], [5, 11], [1, 11]])
    halves = np.array([[1.0, 1.0], [1.2, 1.2], [3.0, 3.0], [9.0, 9.0]])
    found = prune(rows, halves, **ROUNDS | {"t_3": 1.0, "knn": 1})
    assert found.kept.tolist() == [True, False, True, False]
    assert found.round.tolist() == [0, -1, 1, -1]


def test_distinctness_compares_with_the_best_rival():
    rows = np.array([[1, 7], [1, 11]])
    ratio = distinctness(rows, np.array([[1.0, 1.0], [2.0, 2.0]]))
    assert ratio[0] < 0.5  # half as unlike as its rival at one end, without rivals at the other
    assert ratio[1] > 0.9


def test_identical_pieces_neither_crash_nor_confirm_two_partners_of_a_side():
    strips = side_strips(np.full((9, 8, 8, 3), 77, dtype=np.uint8))
    rows = all_rows(9)
    halves = half_dissimilarity("mgc-root", strips, rows)
    kept = rows[confirm_diffusion(rows, halves, count=9, **PRUNE).kept]
    assert len(np.unique(kept)) == kept.size
    lifted = confirm_matchlift(rows, halves, count=9, at_once=0, **LIFT)
    assert np.isfinite(lifted.confidence).all()


def test_no_candidates_confirm_nothing():
    none = np.zeros((0, 2))
    assert len(confirm_diffusion(none, none, count=3, **PRUNE).kept) == 0
    assert len(confirm_matchlift(none, none, count=3, at_once=0, **LIFT).kept) == 0


def test_whole_sides_stand_for_their_halves(puzzle):
    _, _, _, rows, halves, right = puzzle
    found = confirm_diffusion(rows, halves.sum(axis=1), count=48, **PRUNE)
    assert right[found.kept].mean() > 0.95


@pytest.mark.parametrize(
    ("rows", "d", "words"),
    [
        ([[1, 99]], [[1, 1]], "0 to 11"),
        ([[1, 3]], [[1, 1]], "itself"),
        ([[1, 7]], [[np.nan, 1]], "finite"),
        ([[1, 7]], [[-1, 1]], "negative"),
        ([[1, 7, 3]], [[1, 1]], "shape"),
        ([[1, 7]], [[1, 1], [1, 1]], "shape"),
    ],
)
def test_bad_candidates_are_refused_in_a_sentence(rows, d, words):
    with pytest.raises(BadInput, match=words):
        confirm_diffusion(np.array(rows), np.array(d, float), count=3, **PRUNE)


def test_cancelling_stops_either(puzzle):
    _, _, _, rows, halves, _ = puzzle

    def cancel(share, words):
        raise Cancelled

    with pytest.raises(Cancelled):
        confirm_diffusion(rows, halves, count=48, progress=cancel, **PRUNE)
    for at_once in (0, 48):
        with pytest.raises(Cancelled):
            confirm_matchlift(rows, halves, count=48, at_once=at_once, progress=cancel, **LIFT)


def test_the_methods_of_the_solver_say_what_confirmed_a_join(puzzle):
    made, strips = puzzle[:2]
    prepared = prepare(made, PuzzleParameters())
    for method in ("matchlift", "diffusion"):
        solution = assemble(prepared, PuzzleParameters(method=method))
        assert solution.joins.confirmed_by.count(method) > 40
    with pytest.raises(BadParameter, match="does not confirm"):
        confirmed_joins("mst", made, strips, prepared.candidates, PuzzleParameters())


def test_turned_pieces_are_confirmed_too():
    made, truth = cut(picture(seed=5), piece_size=21, turned=True, seed=1)
    prepared = prepare(made, PuzzleParameters(method="diffusion"))
    sides = prepared.candidates.pairs
    a, b = sides.T
    true = truth.position // 21
    where = np.array([(0, -1), (1, 0), (0, 1), (-1, 0)])[(a % 4 + truth.turns[a // 4]) % 4]
    opposite = (a % 4 + truth.turns[a // 4] + 2 - b % 4 - truth.turns[b // 4]) % 4 == 0
    right = (true[b // 4] - true[a // 4] == where).all(axis=1) & opposite
    for method in ("matchlift", "diffusion"):
        found = confirmed_joins(method, made, prepared.strips, prepared.candidates, PuzzleParameters())
        assert right[found.kept].mean() > 0.9
        assert found.kept[right].mean() > 0.7


def test_components_are_joined_by_the_heaviest_first_and_capped():
    edges, weight = np.array([[0, 1], [1, 2], [2, 3], [4, 5]]), np.array([0.9, 0.5, 0.8, 0.7])
    assert len(np.unique(capped_components(edges, weight, 6, 6))) == 2
    capped = capped_components(edges, weight, 6, 3)
    assert capped[0] == capped[1] != capped[2] == capped[3]  # the weak link in the middle gave way
    assert capped[4] == capped[5]


def test_elements_are_all_the_same_where_the_solver_says_so():
    rng = np.random.default_rng(0)
    answers = []
    for _ in range(30):
        w = np.triu(np.where(rng.random((5, 5)) < 0.8, rng.random((5, 5)), 0), 1)
        lifted = matchlift(w + w.T, np.arange(5), universe=None, sparsity=0.2, penalty=2.0, tolerance=1e-5, max_steps=5000)
        answers.append(all_the_same(w + w.T, 0.2))
        assert answers[-1] == (lifted.matches.min() > 0.99)
    assert 3 < sum(answers) < 27


def test_apart_equals_one_lift_without_a_bound():
    rng = np.random.default_rng(0)
    objects, edges = np.repeat(np.arange(10), 3), []
    for base in (0, 15):  # two islands of five objects, some links of which are wrong
        for _ in range(25):
            a, b = base + rng.choice(15, 2, replace=False)
            if objects[a] != objects[b]:
                edges.append(sorted((int(a), int(b))))
    edges = np.unique(np.array(edges), axis=0)
    weight = rng.uniform(0.3, 1, len(edges))
    similarity = np.zeros((30, 30))
    similarity[tuple(edges.T)] = similarity[tuple(edges.T[::-1])] = weight
    how = {"sparsity": 0.1, "penalty": 4.0, "tolerance": 1e-5, "max_steps": 5000}
    whole = matchlift(similarity, objects, universe=None, **how).matches
    i, j = np.nonzero(objects[:, None] < objects[None])
    parts = matchlift_apart(edges, weight, [objects], np.column_stack([i, j]), largest=30, **how)
    assert parts == pytest.approx(whole[i, j], abs=5e-3)
    with pytest.raises(BadInput, match="never be the same"):
        matchlift_apart(np.array([[0, 1]]), np.ones(1), [objects], np.array([[0, 4]]), largest=9, **how)
