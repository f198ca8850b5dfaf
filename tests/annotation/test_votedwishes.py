"""From votes to wishes and back into the matching, by content: other names, orders and methods do not matter."""

import json
from pathlib import Path

import numpy as np
import pytest

from annotation import study
from annotation.__main__ import main
from annotation.results.votedwishes import read_voted_wishes, voted_wishes
from engine.errors import BadInput
from engine.shapes.describing import describe
from engine.shapes.matching import propose, rematch
from engine.shapes.mesh import Mesh
from engine.shapes.parameters import preset
from engine.shapes.segmentation import SegmentedShape, segmentation_from_labels
from engine.shapes.wishes import Wishes

LIGHT = preset("top-down").changed(light_fields=1, resolution=64)


@pytest.fixture
def proposals(lamp, coarse_lamp):
    return propose(describe(lamp, LIGHT), describe(coarse_lamp, LIGHT), LIGHT)


@pytest.fixture
def asked(proposals, tmp_path):
    """A study of what top-down and the bottom layer find, and a function that votes on a pair of it."""
    handle = study.create_study(tmp_path / "lamps.db", name="Lamps", seed="s")
    known = {}
    for method in ("top-down", "bottom"):
        result = rematch(proposals, LIGHT.changed(method=method))
        study.add_result(handle, result)
        known |= {(m.source, m.target): m.id for m in result.matches()}

    def vote(pair, *answers):
        for code, answer in zip("abcdefg", answers, strict=False):
            study.record_vote(handle, known[pair], code, answer)

    yield handle, known, vote
    handle.close()


def test_majorities_become_wishes_and_the_matching_honours_them(asked, proposals, lamp, coarse_lamp):
    handle, known, vote = asked
    right, wrong, tie, unsure, *_ = sorted(known)
    vote(right, "correct", "correct", "wrong")
    vote(wrong, "wrong")
    vote(tie, "correct", "wrong")
    vote(unsure, "unsure")
    found = voted_wishes(handle, lamp, coarse_lamp)
    assert found.wishes == Wishes((right,), (wrong,))
    assert (found.items, found.undecided, found.excluded) == (len(known), len(known) - 2, 0)
    result = rematch(proposals, LIGHT, wishes=found.wishes)
    pairs = {(m.source, m.target): m for m in result.matches()}
    assert pairs[right].pinned
    assert wrong not in pairs


def test_taken_from_the_other_side_and_under_other_labels(asked, lamp, coarse_lamp):
    handle, known, vote = asked
    pair = sorted(known)[0]
    vote(pair, "correct")
    assert voted_wishes(handle, coarse_lamp, lamp).wishes == Wishes((pair[::-1],))
    renamed = SegmentedShape(Mesh(lamp.mesh.vertices, lamp.mesh.faces, "other name"), lamp.segmentation, "other.off")
    assert voted_wishes(handle, renamed, coarse_lamp).wishes == Wishes((pair,))
    joined = SegmentedShape(lamp.mesh, segmentation_from_labels(np.minimum(lamp.segmentation.labels, 1)))
    assert voted_wishes(handle, joined, coarse_lamp).items <= 1  # only what is made of the same faces
    moved = SegmentedShape(Mesh(lamp.mesh.vertices + 1.0, lamp.mesh.faces, "moved"), lamp.segmentation)
    assert voted_wishes(handle, moved, coarse_lamp).items == 0


def test_of_matches_that_share_a_union_the_one_with_more_votes_is_pinned(proposals, tmp_path, lamp, coarse_lamp):
    pairs = ((0,), (0,)), ((0,), (1,)), ((3,), (1,))
    with study.create_study(tmp_path / "s.db", name="S") as handle:
        ids = []
        for pair in pairs:
            result = rematch(proposals, LIGHT, wishes=Wishes((pair,)))
            study.add_result(handle, result)
            ids += [m.id for m in result.matches() if m.pinned]
        for item, votes in zip(ids, (2, 3, 1), strict=True):
            for code in "abc"[:votes]:
                study.record_vote(handle, item, code, "correct")
        found = voted_wishes(handle, lamp, coarse_lamp)
    assert found.wishes.pinned == (pairs[1],)
    assert found.excluded == 2
    assert "2 called correct exclude others" in found.sentence()


def test_a_shape_with_itself_is_pinned_in_both_directions(tmp_path, lamp):
    described = describe(lamp, LIGHT)
    result = rematch(propose(described, described, LIGHT), LIGHT, wishes=Wishes((((0,), (3,)),)))
    with study.create_study(tmp_path / "s.db", name="S") as handle:
        study.add_result(handle, result)
        study.record_vote(handle, next(m.id for m in result.matches() if m.pinned), "anna", "correct")
        assert voted_wishes(handle, lamp, lamp).wishes.pinned == (((0,), (3,)), ((3,), (0,)))


def test_a_guided_result_is_counted_apart(proposals, tmp_path):
    with study.create_study(tmp_path / "s.db", name="S") as handle:
        study.add_result(handle, rematch(proposals, LIGHT))
        study.add_result(handle, rematch(proposals, LIGHT, wishes=Wishes((((0,), (0,)),))))
        with handle.reading() as connection:
            methods = connection.exec_driver_sql("SELECT method FROM run ORDER BY method").scalars().all()
    assert methods == ["top-down", "top-down (guided)"]


def save(shape, path):
    v, f = shape.mesh.vertices.tolist(), shape.mesh.faces.tolist()
    lines = ["OFF", f"{len(v)} {len(f)} 0", *(" ".join(map(repr, p)) for p in v), *("3 " + " ".join(map(str, t)) for t in f)]
    path.write_text("\n".join(lines))
    path.with_suffix(".seg").write_text("\n".join(map(str, shape.segmentation.labels)))
    return str(path)


def test_the_command_writes_what_match_reads(asked, tmp_path, lamp, coarse_lamp, capsys):
    from gui.__main__ import main as concord

    handle, known, vote = asked
    pair = sorted(known)[0]
    vote(pair, "correct")
    files = [save(lamp, tmp_path / "a.off"), save(coarse_lamp, tmp_path / "b.off")]
    assert main(["wishes", str(handle.path), *files, "--out", str(tmp_path / "w.json")]) == 0
    assert "1 pinned and 0 forbidden" in capsys.readouterr().out
    light = ["--method", "top-down", "--set", "light_fields=1", "resolution=64"]
    for option in (["--wishes", str(tmp_path / "w.json")], ["--votes", str(handle.path)]):
        assert concord(["match", *files, "--out", str(tmp_path / "out"), *light, *option]) == 0
        content = json.loads((tmp_path / "out" / "matches.json").read_text())
        assert [(m["source"], m["target"]) for m in content["matches"] if m["pinned"]] == [tuple(map(list, pair))]
    capsys.readouterr()
    assert main(["wishes", str(tmp_path / "none.db"), *files, "--out", str(tmp_path / "n.json")]) == 2
    assert capsys.readouterr().err.strip().count("\n") == 0
    assert not (tmp_path / "n.json").exists()


def test_a_study_that_knows_nothing_of_the_pair_is_refused(asked, coarse_lamp):
    handle, *_ = asked
    with pytest.raises(BadInput, match="holds no match of"):
        read_voted_wishes(handle.path, coarse_lamp, coarse_lamp)


def test_wishes_of_meshes_that_were_cut_automatically_need_the_same_number(tmp_path, lamp, capsys):
    from gui.__main__ import main as concord

    meshes = [Path(save(lamp, tmp_path / name)) for name in ("a.off", "b.off")]
    for mesh in meshes:
        mesh.with_suffix(".seg").unlink()
    out, file = tmp_path / "out", tmp_path / "s.db"
    cut = ["--segments", "4", "--segmentation", "patches"]
    light = ["--set", "light_fields=1", "resolution=64", "--method", "bottom"]
    assert concord(["match", *map(str, meshes), "--out", str(out), *cut, *light]) == 0
    assert main(["create", str(file), str(out / "matches.json")]) == 0
    words = ["wishes", str(file), *map(str, meshes), "--out", str(tmp_path / "w.json")]
    main(words)
    assert "on 4 matches" not in capsys.readouterr().out
    assert main([*words, *cut]) == 0
    assert "0 pinned and 0 forbidden by the votes on 4 matches of this pair" in capsys.readouterr().out
