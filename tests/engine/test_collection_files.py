"""The files of a collection and its command: what is found, what is written, what other parts read."""

import csv
import json

import numpy as np
import pytest
from test_results import save
from world import LAMP, boxes

from annotation.results.resultfile import read_results
from engine.__main__ import build_app, main
from engine.cli import run
from engine.errors import BadInput
from engine.shapes.collection_inputs import collection_files, load_collection, meshes_in

QUICK = ["--set", "light_fields=1", "resolution=64"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("lamps")
    parts = [LAMP[0], ((-0.2, -0.2, 0.5), (0.2, 0.2, 5.5)), LAMP[3], LAMP[4]]
    save(boxes(LAMP, "a"), made, "lamp 2")
    save(boxes([(np.multiply(low, 1.1), np.multiply(high, 1.1)) for low, high in parts], "b"), made, "lamp 10")
    save(boxes([((x, y, z * 1.2), (u, v, w * 1.2)) for (x, y, z), (u, v, w) in LAMP], "c"), made, "=lamp 3")
    return made


@pytest.fixture(scope="module")
def written(folder, tmp_path_factory):
    out = tmp_path_factory.mktemp("out") / "result"
    assert main(["collection", str(folder), "--out", str(out), *QUICK]) == 0
    return out


def test_the_folder_has_every_file(written):
    assert sorted(p.name for p in written.iterdir()) == ["collection.csv", "collection.json", "pairs", "parts.csv", "report.html"]
    pairs = sorted(p.name for p in (written / "pairs").iterdir())
    assert pairs == ["lamp_2-lamp_10", "lamp_3-lamp_10", "lamp_3-lamp_2"]
    for name in pairs:
        assert {p.name for p in (written / "pairs" / name).iterdir()} == {"matches.json", "matches.csv", "parameters.json"}


def test_collection_json_agrees_with_the_tables_and_the_pairs(written):
    content = json.loads((written / "collection.json").read_text())
    assert content["schema"] == "concord.collection/1"
    assert [shape["name"] for shape in content["shapes"]] == ["=lamp 3", "lamp 2", "lamp 10"]
    assert content["shapes"][0]["segments"] == [10, 11, 12, 13, 14]
    with (written / "parts.csv").open() as handle:
        rows = list(csv.DictReader(handle))
    told = [("" if part is None else str(part)) for shape in content["shapes"] for part in shape["parts"]]
    assert [row["part"] for row in rows] == told
    assert rows[0]["shape"] == "'=lamp 3"  # no formula in a spreadsheet
    with (written / "collection.csv").open() as handle:
        lines = list(csv.DictReader(handle))
    assert sum(pair["matches"] for pair in content["pairs"]) == len(lines)
    assert all(0 <= float(line[f"support_{kind}"]) <= 1 for line in lines for kind in ("cycles", "matchlift"))
    for pair in content["pairs"]:
        matches = json.loads((written / pair["file"]).read_text())
        assert matches["supported_by"] == content["support"] == "cycles"
        values = [m["support"] for m in matches["matches"]]
        assert len(values) == pair["matches"]
        assert pair["supported"] == sum(v >= 0.5 for v in values)
        assert pair["mean_support"] == pytest.approx(np.mean(values), abs=1e-5)


def test_matches_with_a_support_are_read_and_make_a_study(written, tmp_path, capsys):
    from annotation.__main__ import main as study

    files = sorted(map(str, (written / "pairs").rglob("matches.json")))
    assert [len(read_results(file).proposals) > 0 for file in files] == [True] * 3
    assert study(["create", str(tmp_path / "lamps.db"), *files]) == 0
    assert (tmp_path / "lamps.db").is_file()


def test_the_report_names_shapes_parts_and_supports(written):
    text = (written / "report.html").read_text()
    assert all(word in text for word in ("=lamp 3", "Part", "matchlift", "cycles (chosen)", "part_from", "Pairs"))
    assert "<img" not in text


def test_pictures_come_from_the_hook(folder, tmp_path):
    shown = []

    def draw(found):
        shown.append(found)
        return [("All of them", b"PNG")]

    assert run(build_app(draw_collection=draw), ["collection", str(folder), "--out", str(tmp_path / "o"), *QUICK]) == 0
    assert len(shown) == 1
    assert "All of them" in (tmp_path / "o" / "report.html").read_text()


def test_options_win_in_their_order(folder, tmp_path):
    (tmp_path / "p.json").write_text(json.dumps({"K": 3, "support": "cycles", "method": "thesis"}))
    words = ["collection", str(folder), "--out", str(tmp_path / "o"), "--parameters", str(tmp_path / "p.json"), "--support",
             "matchlift", "--method", "top-down", *QUICK, "K=5", "part_from=0.6"]  # fmt: skip
    assert main(words) == 0
    content = json.loads((tmp_path / "o" / "collection.json").read_text())
    assert (content["support"], content["method"], content["parameters"]["K"]) == ("matchlift", "top-down", 5)
    assert content["collection_parameters"]["part_from"] == 0.6


def test_meshes_without_labels_are_cut_and_a_method_brings_its_preset(folder, tmp_path, capsys):
    for k in range(3):
        save(boxes(LAMP, "x"), tmp_path, f"bare{k}", labels=False)
    words = ["collection", str(tmp_path), "--segments", "3", "--segmentation", "patches", "--method", "hungarian"]
    assert main([*words, "--out", str(tmp_path / "o"), *QUICK]) == 0
    content = json.loads((tmp_path / "o" / "collection.json").read_text())
    assert (content["method"], content["preset"]) == ("hungarian", "hungarian")
    assert content["parameters"]["size_weight"] == 1.0
    assert [len(shape["segments"]) for shape in content["shapes"]] == [3, 3, 3]
    assert "automatically (patches)" in capsys.readouterr().out


def test_a_bad_mesh_is_left_out_with_a_sentence(folder, tmp_path, capsys):
    (tmp_path / "broken.off").write_text("OFF\n3 1 0\n0 0 0\n")
    meshes = [str(path) for path in meshes_in(folder)]
    assert main(["collection", *meshes, str(tmp_path / "broken.off"), "--out", str(tmp_path / "o"), *QUICK]) == 0
    assert "broken.off was left out" in capsys.readouterr().out
    content = json.loads((tmp_path / "o" / "collection.json").read_text())
    assert len(content["shapes"]) == 3
    assert content["left_out"][0].startswith("broken.off was left out")
    assert "Left out" in (tmp_path / "o" / "report.html").read_text()


@pytest.mark.parametrize(("words", "sentence"), [
    ([], "needs meshes"),
    (["{folder}/lamp 2.off"], "only one"),
    (["{empty}"], "needs meshes"),
    (["{folder}/lamp 2.off", "{folder}/none.off"], "at least two shapes, and 1 can be used"),
    (["{folder}", "--labels", "fine.seg"], "There are no labels"),
    (["{folder}", "--set", "partners=1"], "partners"),
    (["{folder}", "--set", "nothing=1"], "no parameter named 'nothing'"),
    (["{folder}", "--method", "magic"], "method"),
    (["{folder}", "--preset", "magic"], "no preset"),
])  # fmt: skip
def test_bad_input_is_one_sentence_and_leaves_no_folder(folder, tmp_path, capsys, words, sentence):
    (tmp_path / "empty").mkdir()
    words = [word.format(folder=folder, empty=tmp_path / "empty") for word in words]
    assert main(["collection", *words, "--out", str(tmp_path / "o")]) == 2
    error = capsys.readouterr().err
    assert sentence in error
    assert error.count("\n") == 1
    assert not (tmp_path / "o").exists()


def test_labels_find_their_meshes(tmp_path):
    for name in ("a.off", "a.b.off", "c.off", "a.seg", "a.fine.seg", "a.b.fine.seg", "c.fine.seg"):
        (tmp_path / name).write_text("")
    meshes = [tmp_path / name for name in ("a.off", "a.b.off", "c.off")]
    named = [tmp_path / "a.b.fine.seg", tmp_path / "a.fine.seg"]
    assert [labels for _, labels in collection_files([*meshes, *named])] == [named[1], named[0], None]
    assert [labels.name for _, labels in collection_files(meshes, "fine.seg")] == ["a.fine.seg", "a.b.fine.seg", "c.fine.seg"]
    assert [mesh.name for mesh in meshes_in(tmp_path)] == ["a.b.off", "a.off", "c.off"]


def test_the_same_mesh_counts_once_and_folders_that_cannot_be_read_are_named(folder, tmp_path):
    files = collection_files([folder, folder / "lamp 2.off"])
    assert len(files) == 3
    shapes, failures = load_collection(files)
    assert (len(shapes), failures) == (3, [])
    with pytest.raises(BadInput, match="cannot be read"):
        meshes_in(tmp_path / "nowhere")


def test_a_name_that_is_not_there_is_said_to_be_missing(tmp_path, capsys):
    assert main(["collection", str(tmp_path / "nothing"), "--out", str(tmp_path / "out")]) == 2
    assert "nothing is not there" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
