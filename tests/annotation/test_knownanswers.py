"""Known answers: from a table, from votes, from classes of faces, and from pictures."""

import re

import numpy as np
import pytest
from judging_world import ONE_TO_ONE, study_of
from judging_world import result as hand_made
from puzzle_world import picture, solved

from annotation import study
from annotation.design.knownanswers import known_by_truth, known_by_votes, merged, read_known
from annotation.records import Practice
from annotation.results.matchesfile import run_of_json
from annotation.results.puzzlejoins import join_ids, truth_answers
from annotation.results.resultfiles import ResultFile, find_results, find_shapes, read_all
from engine.errors import BadInput
from engine.matchfile import result_to_json, write_matches
from engine.puzzles.gathering import Cutting, gather
from engine.puzzles.imagefile import png_bytes
from engine.puzzles.solutionfile import write_solution
from engine.shapes.describing import describe
from engine.shapes.matching import propose, rematch
from engine.shapes.meshfile import load_shape
from engine.shapes.parameters import preset
from engine.shapes.segmentationparameters import DEFAULT

LIGHT = preset("top-down").changed(light_fields=1, resolution=64)


def table(folder, text, encoding="utf-8"):
    path = folder / "gold.csv"
    path.write_bytes(text.encode(encoding))
    return path


def test_a_table_of_answers(tmp_path):
    text = "Item, Answer ,reason\nx,correct,\"Both, feet\"\n\ny,WRONG\nz,wrong,'=no formula\nx,correct,again\n"
    assert read_known(table(tmp_path, text, "utf-8-sig")) == {
        "x": Practice("correct", "Both, feet"), "y": Practice("wrong", ""), "z": Practice("wrong", "=no formula")}  # fmt: skip
    assert read_known(table(tmp_path, "answer,note,item\nwrong,?,x\n")) == {"x": Practice("wrong", "")}


@pytest.mark.parametrize(("text", "words"), [
    ("", "no columns item and answer"), ("x,correct\n", "no columns item and answer"),
    ("item,answer\nx,unsure\n", "line 2: an item with the answer correct or wrong"),
    ("item,answer\nx,correct\n,wrong\n", "line 3"), ("item,answer\nx\n", "line 2"),
    ("item,answer\nx,correct\ny,wrong\nx,wrong\n", "line 4: x is called correct and wrong"),
])  # fmt: skip
def test_a_table_that_cannot_be_used_is_one_sentence(tmp_path, text, words):
    with pytest.raises(BadInput, match=words):
        read_known(table(tmp_path, text))


def test_no_table_is_one_sentence(tmp_path):
    with pytest.raises(BadInput, match="No such file"):
        read_known(tmp_path / "gold.csv")
    with pytest.raises(BadInput, match="no CSV table in UTF-8"):
        read_known(table(tmp_path, "item,answer\nä,wrong\n", "latin-1"))


def test_answers_of_a_volunteer_and_of_the_majority(place):
    with study_of(place) as handle:
        foot, stem, shade = sorted(item.id for item in study.items(handle, "anna"))
        for code, votes in {"anna": ("correct", "unsure"), "bert": ("wrong", "wrong"), "carl": ("correct", "wrong")}.items():
            for item, answer in zip((foot, stem), votes, strict=True):
                study.record_vote(handle, item, code, answer, comment=f"{code} looked")
        study.record_vote(handle, shade, "anna", "correct")
        study.record_vote(handle, shade, "bert", "wrong")
        assert known_by_votes(handle, "bert")[foot] == Practice("wrong", "bert looked")
        assert set(known_by_votes(handle, "anna")) == {foot, shade}
        assert known_by_votes(handle) == {foot: Practice("correct", ""), stem: Practice("wrong", "")}
        with pytest.raises(BadInput, match="no volunteer 'zoe'"):
            known_by_votes(handle, "zoe")


def off(shape):
    """The text of a mesh file."""
    rows = [" ".join(f"{x:.17g}" for x in vertex) for vertex in shape.mesh.vertices]
    rows += ["3 " + " ".join(map(str, face)) for face in shape.mesh.faces]
    return "\n".join(["OFF", f"{len(shape.mesh.vertices)} {len(shape.mesh.faces)} 0", *rows, ""])


def written(shape, path, classes=None):
    """A mesh with its segments, and the class of each segment where it is given, as files."""
    path.parent.mkdir(exist_ok=True)
    path.write_text(off(shape))
    path.with_suffix(".seg").write_text("\n".join(map(str, shape.segmentation.labels.tolist())))
    if classes is not None:
        found = np.array(classes)[shape.segmentation.labels]
        path.with_suffix(".sem").write_text("\n".join(map(str, found.tolist())))
    return path


@pytest.fixture
def matched(tmp_path, lamp, coarse_lamp):
    """The folder of a result between two lamps of files, and the result."""
    paths = (written(lamp, tmp_path / "meshes" / "lamp.off", [0, 1, 1, 2, 3]),
             written(coarse_lamp, tmp_path / "meshes" / "coarse.off", [0, 1, 2, 3]))  # fmt: skip
    shapes = [describe(load_shape(path), LIGHT) for path in paths]
    found = rematch(propose(*shapes, LIGHT), LIGHT)
    (tmp_path / "set" / "pair").mkdir(parents=True)
    write_matches(found, tmp_path / "set" / "pair")
    return tmp_path, found


def test_classes_of_faces_tell_what_is_clear(matched):
    folder, result = matched
    files = find_results([str(folder / "set")])
    runs = read_all(files)
    found = find_shapes(files, runs)
    assert found.missing == ()
    assert len(found.shapes) == 2
    known = known_by_truth(files, runs, found.shapes)
    classes = [0, 1, 1, 2, 3], [0, 1, 2, 3]
    clear = 0
    for match in result.matches():
        one, other = ({side[s] for s in segments} for side, segments in zip(classes, match[1:3], strict=True))
        if one == other and len(one) == 1:
            clear += 1
            assert known[match.id].answer == "correct"
        elif not one & other:
            clear += 1
            assert known[match.id].answer == "wrong"
    assert clear >= 3
    assert all(told.reason for told in known.values())
    (folder / "meshes" / "lamp.sem").unlink()
    assert known_by_truth(files, runs, found.shapes) == {}
    assert known_by_truth(files, runs, {}) == {}


def test_shapes_are_found_by_content_wherever_they_lie(matched, tmp_path_factory):
    folder, _ = matched
    files = find_results([str(folder / "set")])
    runs, elsewhere = read_all(files), tmp_path_factory.mktemp("elsewhere")
    (folder / "meshes").rename(elsewhere / "deep")
    assert len(find_shapes(files, runs).missing) == 2
    found = find_shapes(files, runs, [elsewhere])
    assert (len(found.shapes), found.missing) == (2, ())
    (elsewhere / "deep" / "lamp.seg").write_text("\n".join(["0"] * 30 + ["1"] * 30))
    (told,) = find_shapes(files, runs, [elsewhere]).missing
    assert "lamp.off" in told
    assert "other segments" in told
    (elsewhere / "deep" / "lamp.seg").write_text("no labels")
    assert "cannot be read" in find_shapes(files, runs, [elsewhere]).missing[0]
    (elsewhere / "deep" / "coarse.off").write_text("no mesh")
    assert len(find_shapes(files, runs, [elsewhere]).missing) == 2


@pytest.mark.parametrize(("method", "count"), [("parts", 3), ("patches", 4)])
def test_automatic_segments_are_made_again(tmp_path, lamp, coarse_lamp, method, count):
    paths = [tmp_path / "lamp.off", tmp_path / "coarse.off"]
    for path, shape in zip(paths, (lamp, coarse_lamp), strict=True):
        path.write_text(off(shape))
    automatic = DEFAULT.changed(method=method, segments=count)
    shapes = [describe(load_shape(path, automatic=automatic), LIGHT) for path in paths]
    write_matches(rematch(propose(*shapes, LIGHT), LIGHT), tmp_path)
    files = find_results([str(tmp_path / "matches.json")])
    found = find_shapes(files, read_all(files))
    assert found.missing == ()
    assert {shape.segmentation.count for shape in found.shapes.values()} == {count}


@pytest.mark.parametrize("name", ["C:\\\\meshes\\\\lamp.off", "x" * 5000, "a\\u0000b", "", "/", ".."])
def test_any_name_of_a_mesh_is_looked_for_without_harm(matched, name):
    folder, _ = matched
    path = folder / "set" / "pair" / "matches.json"
    path.write_text(re.sub(r'"file": "[^"]*lamp.off"', lambda _: f'"file": "{name}"', path.read_text()))
    files = find_results([str(path)])
    found = find_shapes(files, read_all(files), [folder / "meshes"])
    assert len(found.missing) == (0 if name.endswith("lamp.off") else 1)


def test_pictures_tell_of_every_join(tmp_path):
    (tmp_path / "noise.png").write_bytes(png_bytes(picture()))
    puzzle, truth, source = gather([tmp_path / "noise.png"], Cutting(piece_size=8, seed=0))
    (tmp_path / "one").mkdir()
    solution = solved(puzzle, truth)
    write_solution(tmp_path / "one", puzzle, solution, source=source)
    files = (ResultFile(tmp_path / "one" / "solution.json", ""),)
    known = known_by_truth(files, read_all(files), {})
    right = dict(zip(join_ids(puzzle, solution.joins), truth_answers(puzzle, truth, solution.joins), strict=True))
    assert {item: told.answer == "correct" for item, told in known.items()} == right


def test_results_without_truth_tell_nothing(tmp_path):
    run = run_of_json(result_to_json(hand_made(*ONE_TO_ONE)))
    assert known_by_truth([ResultFile(tmp_path / "x.json", "")], [run], {}) == {}


def test_what_is_named_first_counts():
    one, other = {"x": Practice("correct", "1")}, {"x": Practice("wrong", "2"), "y": Practice("wrong", "2")}
    assert merged(one, other) == {"x": one["x"], "y": other["y"]}
    assert merged() == {}


def test_sets_are_named_by_folders_by_hand_or_not_at_all(tmp_path):
    write_matches(hand_made(*ONE_TO_ONE), tmp_path)
    text = (tmp_path / "matches.json").read_text()
    for place in ("all/lamps/a_b/x.json", "all/vases/a_b/matches.json", "all/pairs/c_d/matches.json", "all/vases/a_b/parameters.json"):
        path = tmp_path / place
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("{}" if "parameters" in place else text)

    def sets(*given, name=""):
        return [(file.path.name, file.set_name) for file in find_results(map(str, given), name)]

    everything = tmp_path / "all"
    assert sets(everything) == [("x.json", "lamps"), ("matches.json", "all"), ("matches.json", "vases")]
    assert {name for _, name in sets(everything, name="one")} == {"one"}
    assert sets(everything / "vases") == [("matches.json", "vases")]
    assert sets(everything / "vases" / "a_b") == [("matches.json", "a_b")]
    assert sets(everything / "vases" / "a_b" / "matches.json") == [("matches.json", "")]
    assert sets(f"mine={everything / 'lamps'}") == [("x.json", "mine")]
    assert sets(f"mine={everything / 'lamps'}", everything / "lamps") == [("x.json", "mine")]  # each once
    (tmp_path / "empty").mkdir()
    with pytest.raises(BadInput, match="holds no results"):
        sets(tmp_path / "empty")
