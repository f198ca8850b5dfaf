"""A solution file finds its pieces again, and only those that were solved."""

import json

import numpy as np
import pytest
from puzzle_world import joins_of, picture, solved, touching

from engine.errors import BadInput
from engine.puzzles.gathering import Cutting, gather
from engine.puzzles.identity import join_ids, puzzle_id
from engine.puzzles.imagefile import png_bytes
from engine.puzzles.piecefolder import write_pieces
from engine.puzzles.reopening import reopen
from engine.puzzles.solutionfile import write_solution


@pytest.fixture
def written(tmp_path):
    """An image, and in a folder beside it a solution of its pieces."""
    image, out = tmp_path / "noise.png", tmp_path / "out"
    image.write_bytes(png_bytes(picture()))
    out.mkdir()
    puzzle, truth, source = gather([image], Cutting(piece_size=8, turned=True, seed=3))
    solution = solved(puzzle, truth)
    write_solution(out, puzzle, solution, source=source)
    return out / "solution.json", puzzle, truth, solution


def edited(path, change):
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content))


def test_a_solution_comes_back_with_its_puzzle_and_truth(written):
    path, puzzle, truth, solution = written
    found = reopen(path)
    assert puzzle_id(found.puzzle) == puzzle_id(puzzle)
    assert all(np.array_equal(a.image, b.image) for a, b in zip(found.puzzle.pieces, puzzle.pieces, strict=True))
    assert np.array_equal(found.truth.position, truth.position)
    assert np.array_equal(found.solution.position, solution.position)
    assert join_ids(found.puzzle, found.solution.joins) == join_ids(puzzle, solution.joins)
    assert not found.guided


def test_wishes_that_were_honoured_are_told(written):
    edited(written[0], lambda c: c["source"].update(lock="wishes.json"))
    assert reopen(written[0]).guided


def test_a_folder_of_pieces_is_read_again(written, tmp_path):
    _, puzzle, truth, _ = written
    folder = tmp_path / "pieces"
    write_pieces(puzzle, folder)
    read, none, source = gather([folder], Cutting(turned=True))
    assert none is None
    write_solution(folder, read, solved(read, truth, joins_of(truth, touching(truth))), source=source)
    (folder / "assembled.png").rename(tmp_path / "assembled.png")
    found = reopen(folder / "solution.json")
    assert found.truth is None
    assert puzzle_id(found.puzzle) == puzzle_id(puzzle)


def test_the_image_is_found_where_it_was_or_beside_the_solution(written, tmp_path, monkeypatch):
    path = written[0]
    monkeypatch.chdir(path.parent)
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (tmp_path / "noise.png").rename(elsewhere / "noise.png")
    edited(path, lambda c: c["source"]["files"][0].update(path=""))
    with pytest.raises(BadInput, match=r"noise\.png.*is not to be found; put it beside"):
        reopen(path)
    edited(path, lambda c: c["source"]["files"][0].update(path=str(elsewhere / "noise.png")))
    assert reopen(path).puzzle.count == 12
    edited(path, lambda c: c["source"]["files"][0].update(path="nowhere/noise.png"))
    (elsewhere / "noise.png").rename(path.parent / "noise.png")
    assert reopen(path).puzzle.count == 12


def test_another_image_of_that_name_is_refused(written, tmp_path):
    (tmp_path / "noise.png").write_bytes(png_bytes(picture(seed=9)))
    with pytest.raises(BadInput, match="put back the one that was solved"):
        reopen(written[0])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c["source"].clear(), "made of"),
        (lambda c: c["source"].update(cut="stars"), "made of"),
        (lambda c: c["source"].update(missing=2), "made of"),
        (lambda c: c["source"].update(piece_size="many"), "made of"),
        (lambda c: c.pop("pieces_sha256"), "made of"),
        (lambda c: c["source"].update(seed=4), "not those"),
        (lambda c: c["source"].update(rotate=False), "not those"),
        (lambda c: c.update(pieces_sha256="0"), "not those"),
        (lambda c: c.update(pieces=13), "not those"),
        (lambda c: c.update(joins=[{"a": 99}]), "damaged"),
        (lambda c: c.update(schema="concord.solution/2"), "schema"),
    ],
)
def test_a_file_that_does_not_fit_is_one_sentence(written, change, words):
    edited(written[0], change)
    with pytest.raises(BadInput, match=words) as told:
        reopen(written[0])
    assert "\n" not in str(told.value)
