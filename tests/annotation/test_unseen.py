"""Matches whose shapes the study does not keep, counted for the researcher."""

import numpy as np
import pytest

from annotation import study
from annotation.results.unseen import unseen, unseen_words
from annotation.storage.blobs import keep_shapes
from engine.shapes.identity import match_id, mesh_id, node_id, segment_ids
from engine.shapes.mesh import Mesh
from engine.shapes.segmentation import Segmentation, SegmentedShape


def strip(seed):
    """Three triangles, each a segment."""
    vertices = np.random.default_rng(seed).normal(size=(5, 3))
    return SegmentedShape(Mesh(vertices, [[0, 1, 2], [1, 2, 3], [2, 3, 4]]), Segmentation([0, 1, 2], (0, 1, 2)))


@pytest.fixture
def bars():
    return strip(1), strip(2)


def match(one, other, segment, *, cut=True):
    """An item of one segment of each; without `cut` it does not say how the meshes were cut up."""
    sides, unions = [], []
    for shape in (one, other):
        ids = segment_ids(shape.mesh, shape.segmentation)
        side = {"file": "x.off", "sha256": mesh_id(shape.mesh), "segments": [segment]}
        sides.append(side | ({"segmentation": node_id(ids)} if cut else {}))
        unions.append(node_id([ids[segment]]))
    return study.shape_item(match_id(*unions), *sides)


def test_matches_are_seen_once_both_shapes_are_kept(tmp_path, bars):
    with study.create_study(tmp_path / "s.study", name="s", seed="1") as handle:
        study.add_items(handle, [match(*bars, 0), match(*bars, 1, cut=False)])
        assert unseen(handle) == 2
        keep_shapes(handle, bars[:1])
        assert unseen(handle) == 2
        keep_shapes(handle, bars[1:])
        assert unseen(handle) == 0


def test_only_what_is_asked_counts(tmp_path, bars):
    from annotation.design.designing import put_asked
    from annotation.design.sampling import Drawn

    items = [match(*bars, k) for k in range(3)]
    with study.create_study(tmp_path / "s.study", name="s", seed="1") as handle:
        study.add_items(handle, items)
        with handle.writing() as connection:
            put_asked(connection, [Drawn(items[0].id, "judged", None, "", "", None, False)])
        assert unseen(handle) == 1


def test_the_sentence_counts():
    assert unseen_words(0) == ""
    assert unseen_words(1).startswith("1 match is asked")
    assert unseen_words(2).startswith("2 matches are asked")
