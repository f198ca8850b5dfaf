"""Joins of puzzles in a study: known by what they look like, shown without who proposed them, judged as matches are."""

import base64
import io
import json

import numpy as np
import pytest
from judging_world import ONE_TO_ONE, result, study_of
from PIL import Image
from puzzle_world import PX, cut_up, joins_of, picture, solved, touching

from annotation import study
from annotation.exchange.exporting import votes_csv
from annotation.exchange.merging import merge
from annotation.findings.precision import precision_table
from annotation.results.puzzlejoins import (
    LONGEST,
    add_solution,
    join_ids,
    join_items,
    piece_ids,
    puzzle_id,
    solution_items,
    truth_answers,
)
from engine.puzzles.cutting import cut
from engine.puzzles.pieces import Piece, Puzzle, Truth, rectangle
from engine.puzzles.scoring import contacts
from engine.puzzles.solution import Joins


def pasted(payload) -> np.ndarray:
    """The two pieces of a payload laid where it says, (h, w, 4); what nothing covers is transparent."""
    w, h = payload["size"]
    canvas = Image.new("RGBA", (w, h))
    for piece in payload["pieces"]:
        image = Image.open(io.BytesIO(base64.b64decode(piece["png"]))).convert("RGBA")
        canvas.alpha_composite(image, (piece["x"], piece["y"]))
    return np.asarray(canvas)


# --- identity


@pytest.mark.parametrize("turned", [False, True])
def test_the_same_picture_cut_again_has_the_same_pieces_and_joins(turned):
    (first, truth), (again, truth_again) = cut_up(seed=0), cut_up(seed=5, turned=turned)
    assert turned == bool(truth_again.turns.any())
    assert puzzle_id(again) == puzzle_id(first)
    assert sorted(piece_ids(again)) == sorted(piece_ids(first))
    ids = join_ids(first, joins_of(truth, touching(truth)))
    assert len(set(ids)) == 17  # 3 rows of 3 and 4 columns of 2
    assert set(join_ids(again, joins_of(truth_again, touching(truth_again)))) == set(ids)


def test_a_join_is_the_same_from_either_piece():
    puzzle, truth = cut_up(seed=3, turned=True)
    pairs = touching(truth)
    assert join_ids(puzzle, joins_of(truth, pairs)) == join_ids(puzzle, joins_of(truth, [(b, a) for a, b in pairs]))


def test_another_place_or_turn_is_another_join():
    puzzle, _truth = cut_up()
    beside, below, turned = (
        join_ids(puzzle, Joins([[0, 1, 1, 3]], [offset], [turn], [0.5]))
        for offset, turn in (((PX, 0), 0), ((0, PX), 0), ((PX, 0), 1))
    )
    assert len({*beside, *below, *turned}) == 3


def test_pixels_outside_the_mask_do_not_count_and_the_mask_does():
    full, some = np.ones((4, 4), bool), np.tri(4, dtype=bool)
    dark, light = np.zeros((4, 4, 3), np.uint8), np.full((4, 4, 3), 9, np.uint8)
    light[some] = 0
    pieces = [Piece(rectangle(4, 4), image, mask) for image in (dark, light) for mask in (some, full)]
    ids = piece_ids(Puzzle(tuple(pieces)))
    assert ids[0] == ids[2]
    assert len(set(ids)) == 3


def test_pieces_that_look_the_same_are_asked_about_once():
    flat = np.full((3 * PX, 4 * PX, 3), 77, np.uint8)
    puzzle, truth = cut_up(image=flat)
    assert len(set(join_ids(puzzle, joins_of(truth, touching(truth))))) == 1


def test_however_often_the_picture_is_cut_no_vote_falls_on_another_join():
    rng, said = np.random.default_rng(0), {}
    for seed in range(25):
        puzzle, truth = cut_up(seed=seed, turned=bool(seed % 2))
        sides = rng.integers(0, 4, (60, 4))
        sides[:, 0], sides[:, 2] = np.transpose([rng.choice(12, 2, replace=False) for _ in range(60)])
        steps = np.array([[0, -PX], [PX, 0], [0, PX], [-PX, 0]])[sides[:, 1]]
        guessed = Joins(sides, steps, (sides[:, 1] + 2 - sides[:, 3]) % 4, np.full(60, 0.5))
        for joins in (guessed, joins_of(truth, touching(truth))):
            for item, right in zip(join_ids(puzzle, joins), truth_answers(puzzle, truth, joins), strict=True):
                assert said.setdefault(item, right) == right
    assert sum(said.values()) == 17


# --- truth


def test_truth_says_which_joins_are_in_the_picture():
    puzzle, truth = cut_up(seed=2, turned=True)
    true = touching(truth)
    far = [(a, b) for a in range(12) for b in range(a + 1, 12) if (a, b) not in true][:4]
    wrong = joins_of(truth, far)
    beside = Joins(wrong.sides, np.tile([PX, 0], (4, 1)), wrong.turn, wrong.confidence)
    assert truth_answers(puzzle, truth, joins_of(truth, true)) == (True,) * 17
    assert truth_answers(puzzle, truth, beside) == (False,) * 4


def test_equal_pieces_may_be_exchanged():
    image = picture()
    image[:, : 2 * PX] = np.tile(image[:, :PX], (1, 2, 1))  # the second column repeats the first
    puzzle, truth = cut_up(image=image)
    at = {tuple(place): k for k, place in enumerate(truth.position.tolist())}
    first, second, third, last = (at[column * PX, 0] for column in range(4))
    joins = Joins([[first, 1, third, 3], [second, 1, third, 3], [first, 1, last, 3]], [[PX, 0]] * 3, [0] * 3, [0.5] * 3)
    assert truth_answers(puzzle, truth, joins) == (True, True, False)


def test_a_pixel_beside_its_place_is_right_and_two_are_not():
    puzzle, truth = cut_up(seed=2, turned=True)
    exact = joins_of(truth, touching(truth)[:1] * 3)
    moved = Joins(exact.sides, np.add(exact.offset, [[0, 0], [1, -1], [0, 2]]), exact.turn, exact.confidence)
    assert truth_answers(puzzle, truth, moved) == (True, True, False)


def test_two_triangles_of_one_square_have_the_same_corner_and_each_its_joins():
    puzzle, truth = cut(picture(20), kind="triangles", piece_size=20, seed=3)
    pairs = contacts(puzzle, truth.picture, truth.position, truth.turns)
    sides = np.insert(pairs, [1, 2], 0, axis=1)
    joins = Joins(sides, truth.position[pairs[:, 1]] - truth.position[pairs[:, 0]], 0 * pairs[:, 0], 0.5 + 0 * pairs[:, 0])
    assert (joins.offset == 0).all(axis=1).any()
    assert all(truth_answers(puzzle, truth, joins))
    moved = Joins(sides, joins.offset + np.array([20, 0]), joins.turn, joins.confidence)
    assert not any(truth_answers(puzzle, truth, moved))


def test_a_join_across_two_pictures_is_wrong():
    puzzle, truth = cut_up()
    (a, b), *_ = touching(truth)
    apart = Truth(truth.position, truth.turns, np.arange(12) == a, [[32, 24], [32, 24]])
    assert truth_answers(puzzle, truth, joins_of(truth, [(a, b)])) == (True,)
    assert truth_answers(puzzle, apart, joins_of(truth, [(a, b)])) == (False,)


# --- what a volunteer sees


@pytest.mark.parametrize("turned", [False, True])
def test_a_join_is_shown_as_it_lies_in_the_assembled_picture(turned):
    puzzle, truth = cut_up(seed=4, turned=turned)
    pairs = touching(truth)
    for item, (a, b) in zip(solution_items(puzzle, solved(puzzle, truth)), pairs, strict=True):
        x, y = np.minimum(truth.position[a], truth.position[b])
        shown = pasted(item.payload)
        assert (shown[..., 3] == 255).all()
        assert np.array_equal(shown[..., :3], picture()[y : y + shown.shape[0], x : x + shown.shape[1]])


def test_a_payload_tells_nothing_but_what_the_pieces_look_like():
    puzzle, truth = cut_up()
    one, same = solution_items(puzzle, solved(puzzle, truth)), solution_items(
        puzzle, solved(puzzle, truth, joins_of(truth, touching(truth), confidence=[0.1] * 17), asked="greedy",
                       measure="ssd"))  # fmt: skip
    assert one == same
    for item in one:
        assert set(item.payload) == {"size", "pieces"}
        assert all(set(piece) == {"piece", "x", "y", "png"} for piece in item.payload["pieces"])


def test_the_payload_does_not_depend_on_which_piece_is_named_first():
    puzzle, truth = cut_up()
    pairs = touching(truth)
    assert join_items(puzzle, joins_of(truth, pairs)) == join_items(puzzle, joins_of(truth, [(b, a) for a, b in pairs]))


def test_large_pieces_are_stored_small_and_still_touch():
    px = 125
    image = np.repeat(np.repeat(picture(1), px, axis=0), px, axis=1)  # one colour a piece
    puzzle, truth = cut_up(image=image, px=px)
    items = solution_items(puzzle, solved(puzzle, truth, joins_of(truth, touching(truth, px), px)))
    for item in items:
        shown = pasted(item.payload)
        assert max(shown.shape) <= LONGEST
        assert (shown[..., 3] == 255).all()
        assert len(np.unique(shown.reshape(-1, 4), axis=0)) == 2


def test_pieces_of_any_outline_are_shown_with_it():
    puzzle, truth = cut(picture(20), kind="triangles", piece_size=20, seed=3)
    halves = [k for k, piece in enumerate(puzzle.pieces) if not piece.mask.all()]
    a, b = next((a, b) for a in halves for b in halves if a < b and (truth.position[a] == truth.position[b]).all())
    (item,) = join_items(puzzle, joins_of(truth, [(a, b)], 20))
    x, y = truth.position[a] - 4 * (truth.position[a] // 20 < 0)
    assert item.payload["size"] == [20, 20]
    assert np.array_equal(pasted(item.payload)[..., :3], picture(20)[y : y + 20, x : x + 20])


# --- the study


@pytest.fixture
def voted(tmp_path):
    """A study of both kinds, in which the truth has voted on the joins."""
    puzzle, truth = cut_up()
    joins = joins_of(truth, touching(truth))
    with study_of(tmp_path / "both.db", result(*ONE_TO_ONE), set_name="lamps") as handle:
        add_solution(handle, puzzle, solved(puzzle, truth), set_name="pictures")
        for item, right in zip(join_ids(puzzle, joins), truth_answers(puzzle, truth, joins), strict=True):
            study.record_vote(handle, item, "truth", "correct" if right else "wrong")
        yield handle


def test_both_kinds_have_their_rows_in_one_table(voted):
    rows = {row.method: row for row in precision_table(voted)}
    joins, matches = rows["loops"], rows["top-down"]
    assert (joins.preset, joins.set_name, joins.pairs, joins.matches, joins.correct, joins.micro) == (
        "mgc", "pictures", 1, 17, 17, 1.0)  # fmt: skip
    assert (matches.pairs, matches.matches, matches.unjudged) == (1, 3, 3)


def test_a_vote_serves_every_method_and_every_cut(voted):
    again, truth = cut_up(seed=8, turned=True)
    add_solution(voted, again, solved(again, truth, asked="greedy"))
    assert len(study.items(voted, "anna")) == 17 + 3
    row = next(row for row in precision_table(voted) if row.method == "greedy")
    assert (row.matches, row.correct) == (17, 17)


def test_undo_and_majority_are_those_of_matches(voted):
    puzzle, truth = cut_up()
    item = join_ids(puzzle, joins_of(truth, touching(truth)))[0]
    study.record_vote(voted, item, "anna", "wrong")
    assert study.majority(voted)[item].verdict == "tie"
    assert study.undo_vote(voted, "anna") == item
    assert study.majority(voted)[item].verdict == "correct"


def test_merging_takes_joins_along(voted, tmp_path):
    with study.create_study(tmp_path / "empty.db", name="empty"):
        pass
    new = merge(tmp_path / "empty.db", voted.path, other_study=True)
    assert (new.items, new.runs, new.events) == (20, 2, 17)
    assert merge(tmp_path / "empty.db", voted.path, other_study=True) == (0, 0, 0, 0, 0)
    with study.open_study(tmp_path / "empty.db") as handle:
        assert precision_table(handle) == precision_table(voted)
        assert {i.id: i for i in study.items(handle, "anna")} == {i.id: i for i in study.items(voted, "anna")}


def test_two_studies_that_show_a_join_from_different_sides_merge_alike(tmp_path):
    shown = []
    for order in ((0, 5), (5, 0)):
        paths = [tmp_path / f"{order[0]}-{seed}.db" for seed in order]
        for path, seed in zip(paths, order, strict=True):
            puzzle, truth = cut_up(seed=seed, turned=seed > 0)
            joins = joins_of(truth, touching(truth))
            with study.create_study(path, name="Joins", seed="same") as handle:
                study.add_items(handle, join_items(puzzle, joins))  # as the pieces were read, some upside down
        merge(paths[0], paths[1], other_study=True)
        with study.open_study(paths[0]) as handle:
            shown.append(study.items(handle, "anna"))
    assert shown[0] == shown[1]
    assert len(shown[0]) == 17


def test_the_same_solution_is_the_same_run_and_people_s_wishes_make_another(voted):
    puzzle, truth = cut_up()
    joins = joins_of(truth, touching(truth))
    by_person = Joins(joins.sides, joins.offset, joins.turn, joins.confidence, ("person",) + ("",) * 16)
    first = add_solution(voted, puzzle, solved(puzzle, truth), set_name="pictures")
    assert add_solution(voted, puzzle, solved(puzzle, truth, seconds={}), set_name="pictures") == first
    assert add_solution(voted, puzzle, solved(puzzle, truth), set_name="pictures", guided=True) != first
    add_solution(voted, puzzle, solved(puzzle, truth, by_person), set_name="pictures")
    assert {row.method for row in precision_table(voted)} == {"loops", "loops (guided)", "top-down"}


def test_a_run_keeps_what_it_was_made_with_apart_from_its_items(voted):
    with voted.reading() as connection:
        ((method, preset, parameters, source),) = connection.exec_driver_sql(
            "SELECT method, preset, parameters, source FROM run WHERE kind = 'puzzle'").all()  # fmt: skip
        scores = connection.exec_driver_sql(
            "SELECT score FROM run_match JOIN run ON run.id = run_id WHERE kind = 'puzzle' ORDER BY rank").scalars().all()  # fmt: skip
    assert (method, preset) == ("loops", "mgc")
    assert json.loads(parameters)["method"] == "loops"
    assert json.loads(source)["pieces"] == 12
    assert scores == [0.9] * 17


def test_the_choice_among_methods_is_a_row_of_its_own(voted):
    puzzle, truth = cut_up()
    add_solution(voted, puzzle, solved(puzzle, truth, asked="auto"))
    add_solution(voted, puzzle, solved(puzzle, truth, asked="mst"))
    assert [row.method for row in precision_table(voted)] == ["auto", "loops", "mst", "top-down"]


def test_votes_are_exported_without_pictures(voted):
    text = votes_csv(voted)
    assert text.count("puzzle") == 17
    assert "png" not in text
    assert max(map(len, text.splitlines())) < 2000
