"""What an item shows is found again: shapes in the study or beside it, joins as pictures."""

import base64
import io

import numpy as np
import pytest
from judging_world import study_of
from PIL import Image
from world import bar

from annotation import study
from annotation.records import Item
from annotation.results.shownitems import item_picture, join_png, no_drawing, shown_parts
from annotation.storage.blobs import keep_shapes
from engine.errors import BadInput, ConcordError
from engine.shapes.identity import match_id, mesh_id, node_id, segment_ids


def side(shape, rows):
    return {"file": f"{shape.mesh.name}.off", "sha256": mesh_id(shape.mesh), "segments": [shape.segmentation.names[k] for k in rows]}


def match_of(one, first, other, second):
    """The item of a match between unions of segments."""
    ids = [node_id(segment_ids(shape.mesh, shape.segmentation)[k] for k in rows) for shape, rows in ((one, first), (other, second))]
    return study.shape_item(match_id(*ids), side(one, first), side(other, second))


@pytest.fixture
def shapes():
    return bar([1, 2, 3], "long"), bar([2, 1], "short")


@pytest.fixture
def handle(tmp_path):
    with study_of(tmp_path / "a.db") as opened:
        yield opened


def test_shapes_kept_in_the_study_are_found_with_their_segments(handle, shapes):
    item = match_of(shapes[0], (1, 2), shapes[1], (0,))
    keep_shapes(handle, shapes)
    found = shown_parts(handle, item)
    names = {found.source.segmentation.count: found.source_segments, found.target.segmentation.count: found.target_segments}
    assert names == {3: (1, 2), 2: (0,)}
    assert item_picture(handle, item, lambda shown: bytes([shown is not None, len(shown.source_segments)]))[0] == 1


def test_another_cut_of_the_mesh_is_not_taken_for_it(handle, shapes):
    item = match_of(shapes[0], (1, 2), shapes[1], (0,))
    lied = Item("0" * 64, "shape", item.payload)
    keep_shapes(handle, shapes)
    with pytest.raises(BadInput, match=r"long.off.*neither in the study nor beside it"):
        shown_parts(handle, lied)


def test_shapes_that_are_nowhere_are_told(handle, shapes):
    with pytest.raises(BadInput, match="beside it"):
        shown_parts(handle, match_of(shapes[0], (0,), shapes[1], (0,)))
    with pytest.raises(ConcordError, match="extra 'gui'"):
        no_drawing(None)


def png(width, height, value):
    out = io.BytesIO()
    Image.new("RGBA", (width, height), (value, value, value, 255)).save(out, "PNG")
    return base64.b64encode(out.getvalue()).decode()


def join(**changes):
    pieces = [{"piece": "a", "x": 0, "y": 0, "png": png(4, 3, 255)}, {"piece": "b", "x": 4, "y": 0, "png": png(2, 3, 90)}]
    return {"size": [6, 3], "pieces": pieces} | changes


def test_a_join_is_shown_together_and_apart():
    """Six wide together, and four and two apart with gaps of twelve; enlarged by a whole number."""
    image = Image.open(io.BytesIO(join_png(join())))
    scale = 320 // 6
    assert image.size == (scale * (6 + 12 + 4 + 12 + 2), scale * 3)
    pixels = np.asarray(image)[scale // 2, scale // 2 :: scale, 0]
    assert [int(pixels[k]) for k in (0, 3, 4, 5, 18, 21, 34, 35)] == [255, 255, 90, 90, 255, 255, 90, 90]
    assert np.asarray(image)[0, scale * 7, 3] == 0


@pytest.mark.parametrize("changes", [
    {"size": [0, 3]}, {"size": [5000, 3]}, {"size": "?"}, {"pieces": [{}]}, {"pieces": [{"x": 0, "y": 0, "png": "!"}]},
    {"pieces": [{"x": 0, "y": 0, "png": base64.b64encode(b"no picture").decode()}]},
    {"pieces": [{"x": 0, "y": 0, "png": png(4100, 1, 0)}]},
])  # fmt: skip
def test_a_damaged_join_is_told_in_a_sentence(changes):
    with pytest.raises(BadInput, match="damaged"):
        join_png(join(**changes))
