"""What is written of a puzzle: the stable JSON, the CSV, wishes and their contradictions, the pictures and the report."""

import csv
import io
import json
from dataclasses import replace

import numpy as np
import pytest
from puzzle_world import COLUMNS, PX, ROWS, cut_up, joins_of, picture, solved, touching

from engine.errors import BadInput
from engine.puzzlereport import puzzle_report, reliability
from engine.puzzles.cutting import cut, mix
from engine.puzzles.identity import size_of, turned_offset
from engine.puzzles.parameters import PuzzleParameters
from engine.puzzles.pieces import Puzzle
from engine.puzzles.rendering import (
    assembled,
    close_up,
    confidence_colours,
    marked,
    sheet,
    shelves,
    side_ends,
    thumbnail,
)
from engine.puzzles.scoring import score
from engine.puzzles.solution import UNPLACED, Joins, Pin, PuzzleSolution, Wishes, no_joins
from engine.puzzles.solutionfile import joins_to_csv, read_solution, solution_to_json, write_solution
from engine.puzzles.wishcheck import check_wishes
from engine.puzzles.wishfile import read_wishes, write_wishes

KEYS = {"schema", "pieces", "placed", "unplaced", "joins", "scores", "method", "measure", "parameters", "seconds"}


@pytest.fixture
def world():
    puzzle, truth = cut_up(turned=True, seed=4)
    return puzzle, truth, solved(puzzle, truth)


def same(a, b):
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ("picture", "position", "turns", "sizes"))


def same_joins(a, b):
    return all(np.array_equal(getattr(a, n), getattr(b, n)) for n in ("sides", "offset", "turn", "confidence")) and (
        a.confirmed_by == b.confirmed_by
    )


# --- solution.json


def test_the_json_has_the_promised_keys(world):
    puzzle, truth, solution = world
    content = solution_to_json(puzzle, solution, scores=score(puzzle, truth, solution))
    assert content["schema"] == "concord.solution/1"
    assert set(content) >= KEYS
    assert content["pieces"] == len(content["placed"]) == COLUMNS * ROWS
    assert set(content["placed"][0]) >= {"piece", "x", "y", "quarter_turns"}
    assert set(content["joins"][0]) >= {"a", "side_a", "b", "side_b", "confidence", "confirmed_by"}
    assert set(content["scores"]) >= {"direct", "neighbour", "largest_component", "perfect", "direct_tie_aware",
                                      "neighbour_tie_aware"}  # fmt: skip
    assert content["scores"]["perfect"] is True
    assert content["pictures"] == [{"width": COLUMNS * PX, "height": ROWS * PX}]
    assert solution_to_json(puzzle, solution)["scores"] is None


def test_a_solution_comes_back(world, tmp_path):
    puzzle, truth, _ = world
    where, position, turns = truth.picture.copy(), truth.position.copy(), truth.turns.copy()
    where[3], position[3], turns[3] = UNPLACED, 0, 0
    left = solved(puzzle, truth, picture=where, position=position, turns=turns, why_unplaced={3: "no place"},
                  judge={"mst": 1.5}, notes=("a note",))  # fmt: skip
    write_solution(tmp_path, puzzle, left)
    back = read_solution(tmp_path / "solution.json")
    assert same(left, back)
    assert same_joins(left.joins, back.joins)
    for name in ("puzzle", "method", "measure", "parameters", "seconds", "judge", "why_unplaced", "notes"):
        assert getattr(back, name) == getattr(left, name), name
    assert json.loads((tmp_path / "solution.json").read_text())["unplaced"] == [3]


def test_mixed_pictures_say_which_piece_belongs_where(tmp_path):
    puzzle, truth = mix([cut_up(), cut_up(image=picture(seed=2))], seed=0)
    solution = solved(puzzle, truth)
    written = write_solution(tmp_path, puzzle, solution)
    assert {path.name for path in written} == {"solution.json", "joins.csv", "assembled.png", "assembled-2.png"}
    content = json.loads((tmp_path / "solution.json").read_text())
    assert [entry["picture"] for entry in content["placed"]] == truth.picture.tolist()
    assert same(read_solution(tmp_path / "solution.json"), solution)


DAMAGE = [
    lambda c: c.pop("placed"), lambda c: c["placed"][0].pop("x"), lambda c: c["placed"][0].update(piece=99),
    lambda c: c["placed"].append(c["placed"][0]), lambda c: c["placed"][0].update(picture=1),
    lambda c: c["placed"][0].update(x=0.5), lambda c: c["placed"][0].update(x=True), lambda c: c.update(pieces=10**9),
    lambda c: c.update(pieces=-1), lambda c: c["joins"][0].update(a=99), lambda c: c["joins"][0].update(confidence="x"),
    lambda c: c.update(parameters={"colour": 1}), lambda c: c.update(parameters=[]), lambda c: c.update(seconds=[1]),
    lambda c: c["placed"][0].update(y=10**400), lambda c: c["pictures"][0].update(width=-1),
    lambda c: c["pictures"][0].update(width=10**9, height=10**9), lambda c: c["pictures"][0].update(height=float("nan")),
]  # fmt: skip


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_solution_is_one_sentence(world, tmp_path, damage):
    puzzle, _, solution = world
    content = solution_to_json(puzzle, solution)
    damage(content)
    (tmp_path / "solution.json").write_text(json.dumps(content))
    with pytest.raises(BadInput, match=r"solution\.json is damaged"):
        read_solution(tmp_path / "solution.json")


@pytest.mark.parametrize(("text", "words"), [("{", "not JSON"), ("[]", "not a solution"), ('{"schema": "x"}', "not a solution")])
def test_what_is_no_solution_is_one_sentence(tmp_path, text, words):
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(BadInput, match=words):
        read_solution(tmp_path / "a.json")


def test_nothing_is_written_where_one_file_cannot_be(world, tmp_path):
    puzzle, _, solution = world
    (tmp_path / "assembled.png").mkdir()
    with pytest.raises(BadInput, match="cannot be written"):
        write_solution(tmp_path, puzzle, solution)
    assert [path.name for path in tmp_path.iterdir()] == ["assembled.png"]


# --- joins.csv


def test_joins_are_listed_by_confidence_and_no_name_is_a_formula(world):
    puzzle, truth, _ = world
    pieces = (replace(puzzle.pieces[0], name="=HYPERLINK(1)"), replace(puzzle.pieces[1], name="two\nlines"), *puzzle.pieces[2:])
    joins = joins_of(truth, touching(truth)[:3], confidence=[0.2, 0.9, 0.5])
    joins = replace(joins, sides=np.array([[0, 0, 1, 2], [1, 0, 2, 2], [0, 1, 2, 3]]))
    rows = list(csv.DictReader(io.StringIO(joins_to_csv(Puzzle(pieces), joins, np.array([True, False, True])))))
    assert [row["confidence"] for row in rows] == ["0.900000", "0.500000", "0.200000"]
    assert [row["right"] for row in rows] == ["no", "yes", "yes"]
    assert rows[2]["name_a"] == "'=HYPERLINK(1)"
    assert rows[2]["name_b"] == "two lines"
    assert (rows[1]["side_a"], rows[1]["side_b"]) == ("right", "left")


# --- pictures


@pytest.mark.parametrize("turned", [False, True])
def test_the_truth_is_assembled_to_the_picture(turned):
    puzzle, truth = cut_up(turned=turned)
    canvas = assembled(puzzle, solved(puzzle, truth))
    assert np.array_equal(canvas[..., :3], picture())
    assert (canvas[..., 3] == 255).all()


@pytest.mark.parametrize("kind", ["merged", "triangles", "rectangles"])
def test_polygons_are_assembled_to_the_picture(kind):
    image = picture(32)
    how = {"pieces": 6} if kind == "rectangles" else {"piece_size": 32}
    puzzle, truth = cut(image, kind=kind, turned=True, seed=1, **how)
    canvas = assembled(puzzle, solved(puzzle, truth, no_joins()))
    assert np.array_equal(canvas[..., :3], image)


def test_no_piece_no_pixel():
    puzzle, truth = cut_up()
    where = np.where(np.arange(puzzle.count) == 5, UNPLACED, 0)
    canvas = assembled(puzzle, solved(puzzle, truth, no_joins(), picture=where))
    x, y = truth.position[5]
    assert not canvas[y : y + PX, x : x + PX].any()
    assert (canvas[..., 3] > 0).sum() == (puzzle.count - 1) * PX * PX


def test_a_piece_that_reaches_over_the_edge_is_cut_off():
    puzzle, truth = cut_up()
    moved = truth.position.copy()
    moved[0] = (-3, COLUMNS * PX - 3)
    assert assembled(puzzle, solved(puzzle, truth, no_joins(), position=moved)).shape == (ROWS * PX, COLUMNS * PX, 4)


def test_marks_leave_right_pieces_as_they_are_and_change_wrong_ones():
    puzzle, truth = cut_up()
    solution = solved(puzzle, truth)
    canvas = assembled(puzzle, solution)
    right = np.arange(puzzle.count) != 2
    shown = marked(canvas, puzzle, solution, right=right, joins=False)
    changed = (shown != canvas[..., :3]).any(axis=2)
    x, y = truth.position[2]
    assert changed[y : y + PX, x : x + PX].mean() > 0.9
    changed[y : y + PX, x : x + PX] = False
    assert not changed.any()


@pytest.mark.parametrize("turned", [False, True])
def test_joins_are_drawn_where_their_pieces_touch(turned):
    puzzle, truth = cut_up(turned=turned)
    solution = solved(puzzle, truth)
    for (a, b), ends in zip(touching(truth), side_ends(puzzle, solution, range(len(solution.joins))), strict=True):
        low = np.maximum(truth.position[a], truth.position[b])
        high = np.minimum(truth.position[a], truth.position[b]) + PX
        assert np.array_equal(np.sort(ends, axis=0), [low, high])


def test_a_long_and_a_short_side_share_the_short_one():
    puzzle = Puzzle(cut(picture(16), kind="rectangles", pieces=3, seed=0)[0].pieces)
    _, truth = cut(picture(16), kind="rectangles", pieces=3, seed=0)
    sizes = np.array([piece.mask.shape[::-1] for piece in puzzle.pieces])
    a, b = next((i, j) for i in range(3) for j in range(3) if i != j and truth.position[j, 0] == truth.position[i, 0] + sizes[i, 0])
    join = Joins(np.array([[a, 1, b, 3]]), truth.position[[b]] - truth.position[[a]], np.zeros(1), np.ones(1))
    ends = side_ends(puzzle, solved(puzzle, truth, join), [0])[0]
    low = max(truth.position[a, 1], truth.position[b, 1])
    high = min(truth.position[a, 1] + sizes[a, 1], truth.position[b, 1] + sizes[b, 1])
    assert ends[:, 0].tolist() == [truth.position[b, 0]] * 2
    assert sorted(ends[:, 1]) == [low, high]


def test_colours_go_from_warm_to_blue():
    colours = confidence_colours(np.array([0.0, 0.5, 1.0, 2.0])).astype(int)
    assert colours[0, 0] > colours[0, 2]
    assert colours[2, 2] > colours[2, 0]
    assert np.array_equal(colours[2], colours[3])


def test_a_close_up_shows_the_two_pieces_as_they_lie():
    puzzle, truth = cut_up(turned=True)
    solution = solved(puzzle, truth)
    a, b = touching(truth)[0]
    low = np.minimum(truth.position[a], truth.position[b])
    high = np.maximum(truth.position[a], truth.position[b]) + PX
    shown = close_up(puzzle, solution, 0, longest=2 * PX)
    assert np.array_equal(shown, picture()[low[1] : high[1], low[0] : high[0]])


def test_the_sheet_shows_every_piece_in_order():
    puzzle, _ = cut_up(px=16)
    page = sheet(puzzle, width=120)
    assert page.shape[1] == 120
    assert len(np.unique(page.reshape(-1, 3), axis=0)) > 100


def test_boxes_stand_side_by_side_in_rows():
    places, height = shelves(np.array([[4, 3], [5, 9], [6, 2], [30, 1]]), 15, 1)
    assert places.tolist() == [[1, 1], [6, 1], [1, 11], [1, 14]]
    assert height == 16


def test_thumbnails_shrink_and_never_grow():
    assert thumbnail(np.zeros((40, 20, 3), np.uint8), longest=10).shape == (10, 5, 3)
    assert thumbnail(np.zeros((4, 2, 3), np.uint8), longest=10).shape == (4, 2, 3)


# --- the report


def test_the_report_says_what_is_known_and_only_that(world):
    puzzle, truth, solution = world
    bare = puzzle_report(puzzle, solution)
    assert "Scores" not in bare
    assert "share right" not in bare
    assert "http" not in bare
    right = np.ones(puzzle.count, dtype=bool)
    right[:2] = False
    full = puzzle_report(puzzle, solution, scores=score(puzzle, truth, solution), right=right,
                         right_joins=np.ones(len(solution.joins), dtype=bool), source={"seed": 4, "pieces": None})  # fmt: skip
    assert "100.0 %" in full
    assert "the 2 wrongly placed pieces are hatched" in full
    assert full.count("data:image/") >= 3
    assert "method*" in full  # loops was asked for, which is not the default
    assert "seed" in full


def test_names_cannot_break_the_page():
    puzzle, truth = cut_up()
    evil = "<script>alert(1)</script>"
    puzzle = replace(puzzle, name=evil, pieces=tuple(replace(p, name=evil) for p in puzzle.pieces), notes=(evil,))
    solution = solved(puzzle, truth, joins_of(truth, touching(truth), confidence=[0.1] * len(touching(truth))))
    assert "<script" not in puzzle_report(puzzle, solution)


def test_reliability_by_hand():
    rows = reliability(np.array([0.05, 0.95, 0.97, 1.0]), np.array([False, True, False, True]))
    assert [row[0] for row in rows] == ["0.99 to 1", "0.95 to 0.99", "0 to 0.1"]
    assert [(row[1], row[3]) for row in rows] == [(1, 1.0), (2, 0.5), (1, 0.0)]
    assert rows[1][2] == pytest.approx(0.96)
    assert reliability(np.array([0.5]), None) == [("0.5 to 0.7", 1, 0.5, None)]


# --- wishes


def test_wishes_come_back(world, tmp_path):
    puzzle, truth, _ = world
    pairs = touching(truth)
    wishes = Wishes(joins_of(truth, pairs[:2]), joins_of(truth, pairs[4:5]), (Pin(7, 8, 16, 3),))
    write_wishes(tmp_path / "w.json", wishes)
    back = read_wishes(tmp_path / "w.json", puzzle)
    assert back.pinned == wishes.pinned
    for a, b in ((back.locked, wishes.locked), (back.forbidden, wishes.forbidden)):
        assert all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ("sides", "offset", "turn"))


def test_a_person_writes_names_and_sides_only(tmp_path):
    puzzle, truth = cut_up()
    a, b = next((a, b) for a, b in touching(truth) if truth.position[b, 0] == truth.position[a, 0] + PX)
    write(tmp_path, {"locked": [{"a": puzzle.pieces[a].name, "side_a": "right", "b": b, "side_b": "left"}]})
    locked = read_wishes(tmp_path / "w.json", puzzle).locked
    assert locked.sides.tolist() == [[a, 1, b, 3]]
    assert locked.offset.tolist() == [[PX, 0]]
    assert locked.turn.tolist() == [0]


def test_sides_of_polygons_meet_corner_to_corner(tmp_path):
    puzzle, truth = cut(picture(16), kind="triangles", piece_size=16, seed=0)
    halves = [(i, j) for i in range(puzzle.count) for j in range(puzzle.count)
              if i != j and (truth.position[i] == truth.position[j]).all()]  # fmt: skip
    a, b = halves[0]
    sides = [next(k for k in range(3) if (np.diff(p.polygon[[k, (k + 1) % 3]], axis=0) != 0).all()) for p in
             (puzzle.pieces[a], puzzle.pieces[b])]  # fmt: skip
    write(tmp_path, {"locked": [{"a": a, "side_a": sides[0], "b": b, "side_b": sides[1]}]})
    locked = read_wishes(tmp_path / "w.json", puzzle).locked
    assert locked.offset.tolist() == [[0, 0]]


def write(tmp_path, content):
    (tmp_path / "w.json").write_text(json.dumps({"schema": "concord.wishes/1", **content}))


def join(a, side_a, b, side_b):
    return {"a": a, "side_a": side_a, "b": b, "side_b": side_b}


RIGHT_01, RIGHT_12, DOWN_03, DOWN_14 = join(0, 1, 1, 3), join(1, 1, 2, 3), join(0, 2, 3, 0), join(1, 2, 4, 0)
DOWN_01 = join(0, 2, 1, 0)
CONTRADICTIONS = [
    ({"locked": [join(0, 1, 99, 3)]}, "names the piece 99"), ({"locked": [join(0, 4, 1, 3)]}, "names the side 4"),
    ({"locked": [join("nobody", 1, 1, 3)]}, "'nobody'"), ({"locked": [join(True, 1, 1, 3)]}, "True"),
    ({"locked": [join(0, 1, 0, 3)]}, "to itself"), ({"locked": [RIGHT_01, join(0, 1, 2, 3)]}, "piece 1 and to piece 2"),
    ({"locked": [RIGHT_01], "forbidden": [join(1, 3, 0, 1)]}, "locked and forbidden"),
    ({"locked": [join(0, 1, 1, 2)]}, "turns a piece, but pieces are not turned"),
    ({"locked": [RIGHT_01, RIGHT_12, join(0, 3, 2, 1)]}, "contradicts the other locked joins"),
    ({"locked": [RIGHT_01, DOWN_14, DOWN_03, join(3, 1, 5, 3)]}, "overlap"),
    ({"locked": [RIGHT_01, RIGHT_12, join(2, 1, 3, 3), join(3, 1, 4, 3)]}, "more than the picture"),
    ({"pinned": [{"piece": 0, "x": 0, "y": 0}, {"piece": 1, "x": 0, "y": 0}]}, "overlap as they are pinned"),
    ({"pinned": [{"piece": 0, "x": 0, "y": 0}, {"piece": 0, "x": 8, "y": 0}]}, "two places"),
    ({"pinned": [{"piece": 0, "x": 3, "y": 0}]}, "multiples of 8"), ({"pinned": [{"piece": 0, "x": 320, "y": 0}]}, "outside"),
    ({"pinned": [{"piece": 0, "x": -8, "y": 0}]}, "outside"), ({"pinned": [{"piece": 12, "x": 0, "y": 0}]}, "names the piece 12"),
    ({"pinned": [{"piece": 0, "x": 0, "y": 0, "quarter_turns": 1}]}, "pin of piece 0 turns it"),
    ({"pinned": [{"piece": 0, "x": "a", "y": 0}]}, "whole numbers"), ({"pinned": [{"piece": 0, "y": 0}]}, "whole numbers"),
    ({"locked": [RIGHT_01], "pinned": [{"piece": 0, "x": 0, "y": 0}, {"piece": 1, "x": 16, "y": 0}]}, "contradicts the pins"),
    ({"locked": [RIGHT_01], "pinned": [{"piece": 0, "x": 24, "y": 0}]}, "outside"),
    ({"locked": [RIGHT_01], "pinned": [{"piece": 1, "x": 0, "y": 0}]}, "outside"),
    ({"locked": [RIGHT_01, DOWN_14, DOWN_03], "forbidden": [join(4, 3, 3, 1)]},
     "piece 4 side 3 and piece 3 side 1 is forbidden, but locked joins put"),
    ({"pinned": [{"piece": 0, "x": 8, "y": 8}, {"piece": 1, "x": 8, "y": 16}], "forbidden": [DOWN_01]}, "forbidden, but pins"),
    ({"locked": [RIGHT_12], "pinned": [{"piece": 0, "x": 0, "y": 0}, {"piece": 2, "x": 16, "y": 0}], "forbidden": [RIGHT_01]},
     "piece 0 side 1 and piece 1 side 3 is forbidden, but pins and locked joins put"),
    ({"locked": {}}, "must be a list"), ({"locked": [1]}, "must be a list"),
]  # fmt: skip


@pytest.mark.parametrize(("content", "words"), CONTRADICTIONS)
def test_a_contradiction_is_one_sentence(tmp_path, content, words):
    write(tmp_path, content)
    with pytest.raises(BadInput, match=words) as caught:
        read_wishes(tmp_path / "w.json", cut_up()[0])
    assert str(caught.value).count("\n") == 0


@pytest.mark.parametrize(
    "content",
    [{}, {"locked": [RIGHT_01, RIGHT_01]}, {"locked": [RIGHT_01, DOWN_03, DOWN_14, join(3, 1, 4, 3)]},
     {"locked": [RIGHT_01], "pinned": [{"piece": 0, "x": 8, "y": 0}, {"piece": 1, "x": 16, "y": 0}]},
     {"locked": [RIGHT_01], "forbidden": [join(0, 1, 2, 3)]}, {"locked": [RIGHT_01], "forbidden": [join(1, 1, 0, 3)]},
     {"pinned": [{"piece": 0, "x": 8, "y": 8}, {"piece": 1, "x": 16, "y": 8}], "forbidden": [DOWN_01]}],
)  # fmt: skip
def test_what_agrees_is_taken(tmp_path, content):
    write(tmp_path, content)
    read_wishes(tmp_path / "w.json", cut_up()[0])


def test_the_truth_never_contradicts_itself():
    """Every true join locked and every piece pinned at its place, turned or not, squares or polygons."""
    for turned in (False, True):
        puzzle, truth = cut_up(turned=turned, seed=3)
        pins = tuple(Pin(i, *truth.position[i].tolist(), int(truth.turns[i])) for i in range(puzzle.count))
        check_wishes(puzzle, Wishes(joins_of(truth, touching(truth)), no_joins(), pins))
        check_wishes(puzzle, Wishes(joins_of(truth, touching(truth))))
        swapped = (pins[0]._replace(piece=pins[1].piece), pins[1]._replace(piece=pins[0].piece), *pins[2:])
        with pytest.raises(BadInput):
            check_wishes(puzzle, Wishes(joins_of(truth, touching(truth)), no_joins(), swapped))
    puzzle, truth = cut(picture(16), kind="merged", piece_size=16, seed=0)
    pins = tuple(Pin(i, *truth.position[i].tolist()) for i in range(puzzle.count))
    check_wishes(puzzle, Wishes(pinned=pins))
    with pytest.raises(BadInput, match="overlap"):
        check_wishes(puzzle, Wishes(pinned=(pins[0], pins[1]._replace(x=pins[0].x, y=pins[0].y))))


def pins_of(*places):
    return Wishes(pinned=tuple(Pin(i, PX * x, PX * y) for i, (x, y) in enumerate(places)))


def test_pins_and_what_is_locked_to_them_stay_in_the_frame_as_it_lies():
    """A frame of 4 × 3 cells stands for no pin, though a locked chain of four may stand in it while nothing is pinned."""
    puzzle, _ = cut_up(turned=True)
    check_wishes(puzzle, pins_of((3, 2), (0, 0)))
    with pytest.raises(BadInput, match="outside the picture of 32 × 24"):
        check_wishes(puzzle, pins_of((0, 0), (2, 3)))
    column = [(k, 2, k + 1, 0) for k in range(3)]
    locked = Joins(column, np.zeros((3, 2)), np.zeros(3), np.ones(3))
    check_wishes(puzzle, Wishes(locked))
    with pytest.raises(BadInput, match="outside the picture"):
        check_wishes(puzzle, Wishes(locked, pinned=(Pin(0, 0, 0),)))
    check_wishes(puzzle, Wishes(locked, pinned=(Pin(0, 0, 0, 3),)))  # the column lies down, to the right
    with pytest.raises(BadInput, match="outside the picture"):
        check_wishes(puzzle, Wishes(locked, pinned=(Pin(0, 0, 0, 1),)))  # to the left
    check_wishes(replace(puzzle, frame=None), Wishes(locked, pinned=(Pin(0, 0, 0),)))
    check_wishes(replace(puzzle, frame=(2 * PX, 2 * PX)), Wishes(locked))  # too small for anybody to keep to


def test_without_a_frame_pins_are_no_further_apart_than_the_pieces_reach():
    puzzle = replace(cut_up()[0], frame=None)
    n = puzzle.count
    for fine in (pins_of((n, 0)), pins_of((-2, 0), (n - 2, 0)), pins_of((0, 0), (0, n))):
        check_wishes(puzzle, fine)
    for far in (pins_of((n + 1, 0)), pins_of((-2, 0), (n - 1, 0)), pins_of((0, 0), (0, n + 1)), pins_of((0, -10**9))):
        with pytest.raises(BadInput, match="bring them nearer"):
            check_wishes(puzzle, far)
    polygons, _ = cut(picture(16), kind="triangles", piece_size=16, seed=0)
    far = Joins([[0, 0, 1, 0]], [[10**9, 0]], [0], [1])
    with pytest.raises(BadInput, match="bring them nearer"):
        check_wishes(replace(polygons, frame=None), Wishes(far))


def test_sides_alone_say_how_squares_are_joined():
    """What a join says of offset and turn besides is not needed: two joins that contradict each other do so without it."""
    puzzle, _ = cut_up()
    around = Joins([(0, 1, 1, 3), (1, 2, 2, 0), (2, 3, 3, 1), (3, 0, 4, 2)], np.zeros((4, 2)), np.zeros(4), np.ones(4))
    with pytest.raises(BadInput, match="Pieces 0 and 4 would overlap"):
        check_wishes(puzzle, Wishes(around))
    with pytest.raises(BadInput, match="turns a piece"):
        check_wishes(puzzle, Wishes(Joins([(0, 1, 1, 1)], [[PX, 0]], [0], [1])))


def test_polygons_may_not_be_pinned_into_a_forbidden_join():
    """A true join of two merged pieces, forbidden and pinned; slid by more than a pixel it is another."""
    puzzle, truth = cut(picture(16), kind="merged", piece_size=16, turned=True, seed=2)
    a, b = 0, int(np.argmin(np.abs(truth.position[1:] - truth.position[0]).sum(axis=1))) + 1
    pins = tuple(Pin(i, *truth.position[i].tolist(), int(truth.turns[i])) for i in (a, b))
    here, there = (size_of(puzzle.pieces[i], int(truth.turns[i])) for i in (a, b))
    offset = tuple((truth.position[b] - truth.position[a]).tolist())
    for _ in range(-int(truth.turns[a]) % 4):  # turned together until a stands as it was read
        offset, here, there = turned_offset(offset, here, there), here[::-1], there[::-1]
    for off, refused in ((0, True), (1, True), (2, False)):
        forbidden = Joins([[a, 0, b, 0]], [(offset[0] + off, offset[1])], [(truth.turns[b] - truth.turns[a]) % 4], [1])
        if refused:
            with pytest.raises(BadInput, match="is forbidden, but pins"):
                check_wishes(puzzle, Wishes(forbidden=forbidden, pinned=pins))
        else:
            check_wishes(puzzle, Wishes(forbidden=forbidden, pinned=pins))


def test_parameters_of_a_solution_are_those_it_was_made_with(world):
    puzzle, truth, _ = world
    solution: PuzzleSolution = solved(puzzle, truth, asked="auto")
    assert solution_to_json(puzzle, solution)["method"] == "mst"
    assert solution_to_json(puzzle, solution)["parameters"]["method"] == PuzzleParameters().method
