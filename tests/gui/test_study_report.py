"""The report of a study from the window's command line: shapes are drawn, where the command without it has none."""

import base64
import re

from annotation import study
from annotation.storage.blobs import keep_shapes
from engine.shapes.identity import match_id, mesh_id, node_id, segment_ids
from gui.__main__ import main


def side(shape, row):
    return {"file": f"{shape.mesh.name}.off", "sha256": mesh_id(shape.mesh), "segments": [shape.segmentation.names[row]]}


def test_a_disputed_match_is_drawn_with_both_parts_marked(tmp_path, make_bar, monkeypatch):
    one, other = make_bar(3), make_bar(2)
    ids = [node_id([segment_ids(shape.mesh, shape.segmentation)[1]]) for shape in (one, other)]
    item = study.shape_item(match_id(*ids), side(one, 1), side(other, 1))
    run = study.Run("shape", "learned", "learned", {}, "bars", {"file": "a.off", "sha256": "a", "segments": 3, "faces": 9},
                    {"file": "b.off", "sha256": "b", "segments": 2, "faces": 9}, {}, (study.Proposal(item, 1.0, 1),))  # fmt: skip
    with study.create_study(tmp_path / "bars.db", name="Bars") as handle:
        study.add_run(handle, run)
        keep_shapes(handle, [one, other])
        for code, answer in (("anna", "correct"), ("bert", "wrong")):
            study.record_vote(handle, item.id, code, answer)
    drawn = []

    def draw(shown):
        drawn.append((shown.source_segments, shown.target_segments))
        return b"\x89PNG bars"

    monkeypatch.setattr("gui.__main__.match_picture", draw)
    assert main(["study", "table", str(tmp_path / "bars.db"), "--format", "html", "--out", str(tmp_path / "t.html")]) == 0
    pictures = re.findall(r'src="data:image/png;base64,([^"]+)"', (tmp_path / "t.html").read_text())
    assert [base64.b64decode(picture) for picture in pictures] == [b"\x89PNG bars"]
    assert drawn == [((1,), (1,))]
