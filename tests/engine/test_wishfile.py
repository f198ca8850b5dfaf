"""Wishes on disk: round trips, either order of the shapes, and one sentence for whatever cannot be used."""

import csv
import json

import numpy as np
import pytest
from world import LAMP, boxes

from engine.__main__ import main
from engine.errors import BadInput
from engine.matchfile import result_to_csv, result_to_json
from engine.report import report_page
from engine.shapes.matching import match_shapes
from engine.shapes.mesh import Mesh
from engine.shapes.parameters import preset
from engine.shapes.segmentation import SegmentedShape, segmentation_from_labels
from engine.shapes.wishes import Wishes
from engine.shapes.wishfile import read_wishes, write_wishes

SAMPLE = Wishes((((0,), (3,)), ((1, 2), (1,))), (((3,), (2,)),))


@pytest.fixture
def shapes(lamp, coarse_lamp):
    """The lamp with the labels 10, 20, … and its coarse sister with words."""
    ten = SegmentedShape(lamp.mesh, segmentation_from_labels(10 * (1 + lamp.segmentation.labels)), "lamp.off")
    return ten, coarse_lamp


@pytest.fixture
def save(tmp_path):
    def write(content):
        path = tmp_path / "wishes.json"
        path.write_text(content if isinstance(content, str) else json.dumps({"schema": "concord.shape-wishes/1", **content}))
        return path

    return write


def test_a_round_trip_gives_the_same_wishes(shapes, tmp_path):
    write_wishes(tmp_path / "w.json", SAMPLE, *shapes)
    assert read_wishes(tmp_path / "w.json", *shapes) == SAMPLE
    content = json.loads((tmp_path / "w.json").read_text())
    assert content["pinned"][1] == {"source": [20, 30], "target": [1]}
    assert content["source"]["file"] == "lamp.off"


def test_the_other_order_of_the_shapes_turns_the_wishes(shapes, tmp_path):
    write_wishes(tmp_path / "w.json", SAMPLE, *shapes)
    assert read_wishes(tmp_path / "w.json", *shapes[::-1]) == SAMPLE.turned()


def test_a_shape_with_itself_is_not_turned(shapes, tmp_path):
    wishes = Wishes((((0,), (3,)),))
    write_wishes(tmp_path / "w.json", wishes, shapes[0], shapes[0])
    assert read_wishes(tmp_path / "w.json", shapes[0], shapes[0]) == wishes


def test_a_file_written_by_hand_needs_no_hashes(shapes, save):
    assert read_wishes(save({"forbidden": [{"source": [30, 20, 20], "target": [1]}]}), *shapes) == Wishes((), (((1, 2), (1,)),))
    assert read_wishes(save({}), *shapes) == Wishes()


@pytest.mark.parametrize(("content", "words"), [
    ("{", "not whole JSON"),
    ("[" * 100_000, "not whole JSON"),
    ('{"schema": "concord.wishes/1"}', "no file of wishes for shapes"),
    ("[1]", "no file of wishes for shapes"),
    ({"pined": []}, "has 'pined', which no file of wishes for shapes has"),
    ({"pinned": 3}, "'pinned' in .* must be a list"),
    ({"pinned": [3]}, "'pinned' in .* must be a list"),
    ({"forbidden": [{"source": [10]}]}, "forbidden match 1 in .* needs a list of labels as its 'target'"),
    ({"pinned": [{"source": [], "target": [0]}]}, "needs a list of labels as its 'source'"),
    ({"pinned": [{"source": [11], "target": [0]}]}, "pinned match 1 in .* names the segment 11, which lamp does not have"),
    ({"pinned": [{"source": [True], "target": [0]}]}, "names the segment True"),
    ({"pinned": [{"source": [[10]], "target": [0]}]}, r"names the segment \[10\]"),
    ({"pinned": [{"source": [10], "target": [0]}, {"source": [10], "target": [1]}]}, "10 of the source is pinned to both 0 and 1"),
    ({"pinned": [{"source": [10], "target": [0]}], "forbidden": [{"source": [10], "target": [0]}]}, "10 → 0 is both pinned and"),
])  # fmt: skip
def test_damaged_and_impossible_files_are_one_sentence(shapes, save, content, words):
    with pytest.raises(BadInput, match=words) as caught:
        read_wishes(save(content), *shapes)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400


def test_a_cut_file_is_refused_wherever_it_is_cut(shapes, tmp_path):
    write_wishes(tmp_path / "w.json", SAMPLE, *shapes)
    text = (tmp_path / "w.json").read_text().strip()
    for length in range(0, len(text), 37):
        (tmp_path / "cut.json").write_text(text[:length])
        with pytest.raises(BadInput):
            read_wishes(tmp_path / "cut.json", *shapes)


def test_other_shapes_and_other_labels_are_refused(shapes, tmp_path):
    write_wishes(tmp_path / "w.json", SAMPLE, *shapes)
    source, target = shapes
    moved = SegmentedShape(Mesh(source.mesh.vertices + 1, source.mesh.faces, "moved"), source.segmentation)
    joined = SegmentedShape(source.mesh, segmentation_from_labels(np.minimum(source.segmentation.labels, 3)))
    for other in (moved, joined):
        with pytest.raises(BadInput, match="written for other shapes or other labels"):
            read_wishes(tmp_path / "w.json", other, target)


def test_results_name_what_was_pinned(shapes):
    p = preset("top-down").changed(light_fields=1, resolution=64)
    plain, guided = (match_shapes(*shapes, p, wishes=wishes) for wishes in (Wishes(), SAMPLE))
    assert "wishes" not in result_to_json(plain)
    assert "pinned" not in result_to_json(plain)["matches"][0]
    content = result_to_json(guided)
    assert content["wishes"]["forbidden"] == [{"source": [40], "target": [2]}]
    assert [(m["source"], m["target"]) for m in content["matches"] if m["pinned"]] == [
        (m["source"], m["target"]) for m in content["matches"] if (m["source"], m["target"]) in (([10], [3]), ([20, 30], [1]))]  # fmt: skip
    assert sum(m["pinned"] for m in content["matches"]) == 2
    rows = list(csv.DictReader(result_to_csv(guided).splitlines()))
    assert sorted((r["source"], r["target"]) for r in rows if r["pinned"] == "pinned") == [("10", "3"), ("20;30", "1")]
    assert "pinned" not in result_to_csv(plain)
    assert "Wishes that were honoured" in report_page(guided)
    assert "Wishes that were honoured" not in report_page(plain)


def test_the_command_honours_a_file_and_refuses_a_damaged_one(tmp_path, capsys, save):
    files = []
    for name, parts in (("a", LAMP), ("b", LAMP[:4])):
        mesh = boxes(parts).mesh
        lines = ["OFF", f"{len(mesh.vertices)} {len(mesh.faces)} 0", *(" ".join(map(str, v)) for v in mesh.vertices.tolist()),
                 *("3 " + " ".join(map(str, f)) for f in mesh.faces.tolist())]  # fmt: skip
        files.append(tmp_path / f"{name}.off")
        files[-1].write_text("\n".join(lines))
        files[-1].with_suffix(".seg").write_text("\n".join(map(str, np.repeat(np.arange(len(parts)), 12))))
    light = ["--set", "light_fields=1", "resolution=64"]
    wishes = save({"pinned": [{"source": [0], "target": [3]}], "forbidden": [{"source": [1], "target": [1]}]})
    command = ["match", *map(str, files), "--out", str(tmp_path / "out"), *light, "--wishes", str(wishes)]
    assert main(command) == 0
    assert "1 pinned, 1 forbidden" in capsys.readouterr().out
    content = json.loads((tmp_path / "out" / "matches.json").read_text())
    found = [(m["source"], m["target"]) for m in content["matches"]]
    assert ([0], [3]) in found
    assert ([1], [1]) not in found
    for content, words in (("{", "not whole JSON"), ({"pinned": [{"source": [9], "target": [0]}]}, "names the segment 9")):
        save(content)
        assert main(command) == 2
        said = capsys.readouterr()
        assert words in said.err
        assert said.err.strip().count("\n") == 0
    assert main([*command[:-2], "--votes", str(tmp_path / "study.db")]) == 2
    assert "concord match --votes" in capsys.readouterr().err
