"""What is written: the stable JSON, the CSV, the report; and the command line with every bad input."""

import json
import stat

import numpy as np
import pytest

from engine.__main__ import main, parameter_text, preset_name
from engine.errors import BadInput
from engine.matchfile import result_to_json, write_matches
from engine.parameters import declared
from engine.report import report_page
from engine.shapes.matching import match_shapes
from engine.shapes.parameters import MatchParameters, preset
from engine.spreadsheet import safe_cell
from engine.store import output_folder, write_atomically

OUTPUTS = {"matches.json", "matches.csv", "parameters.json", "report.html"}


@pytest.fixture(scope="module")
def result():
    from world import LAMP, boxes

    shape = boxes(LAMP, "lamp")
    return match_shapes(shape, shape, preset("top-down").changed(K=5), preset="top-down")


def save(shape, folder, name, labels=True):
    mesh = shape.mesh
    lines = ["OFF", f"{len(mesh.vertices)} {len(mesh.faces)} 0"]
    lines += [" ".join(map(str, v)) for v in mesh.vertices.tolist()] + [f"3 {a} {b} {c}" for a, b, c in mesh.faces.tolist()]
    (folder / f"{name}.off").write_text("\n".join(lines))
    if labels:
        (folder / f"{name}.seg").write_text("\n".join(str(10 + v) for v in shape.segmentation.labels))
    return str(folder / f"{name}.off")


def test_matches_json_has_exactly_the_keys_of_its_schema(result):
    content = result_to_json(result)
    assert content["schema"] == "concord.matches/1"
    assert set(content) == {"schema", "source", "target", "method", "preset", "parameters", "matches", "unmatched",
                            "graph", "seconds"}  # fmt: skip
    for side in ("source", "target"):
        assert set(content[side]) == {"file", "sha256", "segments", "faces", "segmentation"}
        assert content[side]["faces"] == 60
    assert set(content["graph"]) == {"source_nodes", "target_nodes"}
    assert set(content["unmatched"]) == {"source", "target"}
    keys = {"id", "source", "target", "score", "votes", "source_layer", "target_layer"}
    assert all(set(m) == keys for m in content["matches"])
    json.dumps(content, allow_nan=False)


def test_unmatched_segments_are_those_in_no_match(result):
    content = result_to_json(result)
    used = {label for m in content["matches"] for label in m["source"]}
    assert sorted(used | set(content["unmatched"]["source"])) == [0, 1, 2, 3, 4]
    assert not used & set(content["unmatched"]["source"])


def test_written_files_agree(result, tmp_path):
    write_matches(result, tmp_path)
    content = json.loads((tmp_path / "matches.json").read_text())
    rows = (tmp_path / "matches.csv").read_text().splitlines()
    assert len(rows) == 1 + len(content["matches"])
    assert rows[1].split(",")[0] == content["matches"][0]["id"]
    assert json.loads((tmp_path / "parameters.json").read_text()) == content["parameters"]


def test_cells_that_a_spreadsheet_would_run_are_escaped():
    texts = ("=1+1", "@x", "-3", "+2.5", "-a", "5;6", "-3;-2", "-3;=2")
    assert [safe_cell(t) for t in texts] == ["'=1+1", "'@x", "-3", "+2.5", "'-a", "5;6", "-3;-2", "'-3;=2"]


def test_the_report_is_self_contained_and_stars_what_was_changed(result):
    page = report_page(result, [("a <title>", b"\x89PNG")], [("More", "<p>more</p>")])
    assert "K*" in page
    assert "a &lt;title&gt;" in page
    assert "data:image/png;base64," in page
    assert "<p>more</p>" in page
    assert "http://" not in page
    assert "https://" not in page


def test_atomic_writes_leave_the_old_file_where_the_new_one_fails(tmp_path, monkeypatch):
    file = tmp_path / "a.txt"
    write_atomically(file, "old")
    monkeypatch.setattr("os.replace", lambda *a: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    with pytest.raises(BadInput, match="No space left"):
        write_atomically(file, "new")
    assert file.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]
    assert stat.S_IMODE(file.stat().st_mode) & 0o600 == 0o600


def test_results_are_written_all_or_none(result, tmp_path):
    (tmp_path / "parameters.json").mkdir()
    with pytest.raises(BadInput, match="parameters"):
        write_matches(result, tmp_path, report="page")
    assert [p.name for p in tmp_path.iterdir()] == ["parameters.json"]


def test_a_parameters_file_decides_the_name_of_the_preset():
    rigid = preset("thesis-rigid")
    assert preset_name(preset("top-down"), "top-down") == "top-down"
    assert preset_name(rigid, "top-down") == "thesis-rigid"
    assert preset_name(rigid.changed(K=3), "top-down") == ""
    assert preset_name(rigid.changed(K=3), "thesis-rigid") == "thesis-rigid"


def test_an_output_folder_that_is_a_file_is_refused(tmp_path):
    (tmp_path / "out").write_text("x")
    with pytest.raises(BadInput, match="output folder"):
        output_folder(tmp_path / "out")


def test_match_from_the_command_line(lamp, coarse_lamp, tmp_path, capsys):
    a, b = save(lamp, tmp_path, "a"), save(coarse_lamp, tmp_path, "b")
    assert main(["match", a, b, "--out", str(tmp_path / "out"), "--preset", "thesis-rigid", "--set", "K=5", "c_0=0.6"]) == 0
    assert {p.name for p in (tmp_path / "out").iterdir()} == OUTPUTS
    content = json.loads((tmp_path / "out" / "matches.json").read_text())
    assert content["parameters"]["K"] == 5
    assert content["parameters"]["c_0"] == 0.6
    assert all(label >= 10 for m in content["matches"] for label in m["source"])
    assert "matches between a (5 segments" in capsys.readouterr().out
    again = ["match", a, b, "--out", str(tmp_path / "again"), "--preset", "thesis-rigid",
             "--parameters", str(tmp_path / "out" / "parameters.json")]  # fmt: skip
    assert main(again) == 0
    assert json.loads((tmp_path / "again" / "matches.json").read_text())["matches"] == content["matches"]


def test_the_method_of_the_command_line_wins_over_the_preset(lamp, coarse_lamp, tmp_path):
    a, b = save(lamp, tmp_path, "a"), save(coarse_lamp, tmp_path, "b")

    def told(*words):
        assert main(["match", a, b, "--out", str(tmp_path / "out"), *words, "--set", "light_fields=1"]) == 0
        return json.loads((tmp_path / "out" / "matches.json").read_text())

    own = told("--method", "hungarian")
    assert (own["method"], own["preset"]) == ("hungarian", "hungarian")
    assert own["parameters"]["size_weight"] == preset("hungarian").size_weight
    other = told("--method", "hungarian", "--preset", "thesis-rigid")
    assert (other["method"], other["preset"]) == ("hungarian", "")
    assert other["parameters"]["size_weight"] == preset("thesis-rigid").size_weight
    with_file = told("--method", "shed", "--parameters", str(tmp_path / "out" / "parameters.json"))
    assert with_file["method"] == "shed"


BAD = {
    "unknown method": (["match", "{a}", "{a}", "--method", "magic", "--out", "{out}"], "There is no method named 'magic'"),
    "missing mesh": (["match", "{a}", "none.off", "--out", "{out}"], "none.off"),
    "missing labels": (["match", "{a}", "{a}", "--source-labels", "none.seg", "--out", "{out}"], "none.seg"),
    "unknown way to cut": (["match", "{a}", "{a}", "--segmentation", "knife", "--out", "{out}"], "--segmentation cannot be 'knife'"),
    "unknown preset": (["match", "{a}", "{a}", "--preset", "fast", "--out", "{out}"], "'fast'"),
    "unknown parameter": (["match", "{a}", "{a}", "--set", "gamma=1", "--out", "{out}"], "'gamma'"),
    "out of range": (["match", "{a}", "{a}", "--set", "delta_1=3", "--out", "{out}"], "from 0 to 1"),
    "not a name": (["match", "{a}", "{a}", "--set", "self=1", "--out", "{out}"], "'self'"),
    "not a multiple": (["match", "{a}", "{a}", "--set", "resolution=100", "--out", "{out}"], "multiple of 64"),
    "too many segments": (["match", "{a}", "{soup}", "--set", "most_segments=10", "--out", "{out}"], "most_segments"),
    "flat": (["match", "{a}", "{flat}", "--out", "{out}"], "no area"),
    "deep parameter file": (["match", "{a}", "{a}", "--parameters", "{deep}", "--out", "{out}"], "not JSON"),
    "no value": (["match", "{a}", "{a}", "--set", "K", "--out", "{out}"], "NAME=VALUE"),
    "bad parameter file": (["match", "{a}", "{a}", "--parameters", "{a}", "--out", "{out}"], "not JSON"),
    "one segment": (["match", "{a}", "{one}", "--out", "{out}"], "one single segment"),
    "output is a file": (["match", "{a}", "{a}", "--out", "{a}"], "output folder"),
    "no output": (["match", "{a}", "{a}"], "--out"),
    "unknown option": (["match", "{a}", "{a}", "--out", "{out}", "--fast"], "--fast"),
    "unknown command": (["mach"], "mach"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_gets_one_sentence_and_exit_code_2(lamp, tmp_path, capsys, case):
    a = save(lamp, tmp_path, "a")
    one = save(type(lamp)(lamp.mesh, lamp.segmentation), tmp_path, "one", labels=False)
    (tmp_path / "one.seg").write_text("0\n" * 60)
    (tmp_path / "flat.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n")
    corners = "".join(f"{k} 0 0\n{k}.5 0 0\n{k} 1 0\n" for k in range(12))
    triangles = "".join(f"3 {3 * k} {3 * k + 1} {3 * k + 2}\n" for k in range(12))
    (tmp_path / "soup.off").write_text(f"OFF\n36 12 0\n{corners}{triangles}")
    (tmp_path / "deep.json").write_text("[" * 100_000)
    arguments, words = BAD[case]
    places = {"a": a, "one": one, "out": str(tmp_path / "out"), "flat": str(tmp_path / "flat.off"),
              "soup": str(tmp_path / "soup.off"), "deep": str(tmp_path / "deep.json")}  # fmt: skip
    assert main([word.format(**places) for word in arguments]) == 2
    error = capsys.readouterr().err
    assert error.startswith("concord: ")
    assert error.count("\n") == 1
    assert words in error
    out = tmp_path / "out"
    assert not out.exists() or not list(out.iterdir())


def test_the_parameter_list_names_every_parameter_and_its_range():
    text = parameter_text()
    for info in declared(MatchParameters):
        assert info.name in text
    assert "0..0.99" in text
    assert "thesis-nonrigid" in text


def test_arrays_of_a_result_are_read_only(result):
    with pytest.raises(ValueError):
        result.score[0] = 1
    assert result.source_members.dtype == np.bool_
