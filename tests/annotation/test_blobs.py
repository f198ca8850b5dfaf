"""Shapes in a study: they come back as they were, and are known by what the items say of them."""

import io
import zipfile

import numpy as np
import pytest
from judging_world import study_of

from annotation.storage import blobs
from annotation.storage.blobs import keep_shapes, kept_shapes, shape_key
from engine.errors import BadInput
from engine.shapes.identity import mesh_id, node_id, segment_ids
from engine.shapes.mesh import Mesh
from engine.shapes.segmentation import Segmentation, SegmentedShape


@pytest.fixture
def shape():
    vertices = np.random.default_rng(3).normal(size=(5, 3))
    return SegmentedShape(Mesh(vertices, [[0, 1, 2], [1, 2, 3], [2, 3, 4]]), Segmentation([0, 1, 0], (7, "seat")))


def side(shape, segmentation=True):
    found = {"sha256": mesh_id(shape.mesh)}
    whole = node_id(segment_ids(shape.mesh, shape.segmentation))
    return found | {"segmentation": whole} if segmentation else found


def test_a_shape_comes_back_with_the_same_segments(tmp_path, shape):
    with study_of(tmp_path / "a.db") as handle:
        assert [keep_shapes(handle, [shape, shape]), keep_shapes(handle, [shape])] == [1, 0]
        (found,) = kept_shapes(handle, side(shape))
    assert segment_ids(found.mesh, found.segmentation) == segment_ids(shape.mesh, shape.segmentation)
    assert found.segmentation.names == (7, "seat")


def test_without_a_hash_of_the_segments_all_of_the_mesh_are_candidates(tmp_path, shape):
    other = SegmentedShape(shape.mesh, Segmentation([0, 0, 1], (0, 1)))
    with study_of(tmp_path / "a.db") as handle:
        keep_shapes(handle, [shape, other])
        assert len(kept_shapes(handle, side(shape, segmentation=False))) == 2
        assert len(kept_shapes(handle, side(shape))) == 1
        assert kept_shapes(handle, {"sha256": "0" * 64}) == ()
    assert shape_key(side(shape)) != shape_key(side(other))


@pytest.mark.parametrize("keep", [0, 10, 0.5])
def test_a_shape_whose_bytes_are_damaged_is_told(tmp_path, shape, keep):
    with study_of(tmp_path / "a.db") as handle:
        keep_shapes(handle, [shape])
        with handle.writing() as connection:
            whole = bytes(connection.exec_driver_sql("SELECT content FROM blob").scalar_one())
            broken = bytes(a ^ 255 if k % 40 == 0 else a for k, a in enumerate(whole)) if keep == 0.5 else whole[:keep]
            connection.exec_driver_sql("UPDATE blob SET content = ?", (broken,))
        with pytest.raises(BadInput, match="damaged"):
            kept_shapes(handle, side(shape))


def test_a_few_bytes_that_unpack_to_more_than_a_shape_are_told(tmp_path, shape, monkeypatch):
    with study_of(tmp_path / "a.db") as handle:
        keep_shapes(handle, [shape])
        monkeypatch.setattr(blobs, "MOST_BYTES", 500)
        monkeypatch.setattr(np, "load", lambda *_, **__: pytest.fail("it was unpacked"))
        with pytest.raises(BadInput, match="damaged"):
            kept_shapes(handle, side(shape))


@pytest.mark.parametrize(("name", "count"), [("vertices", 2**60), ("vertices", 10**12), ("more", 1)])
def test_arrays_that_claim_to_be_larger_than_they_are_or_strange_are_told(tmp_path, shape, name, count):
    with study_of(tmp_path / "a.db") as handle:
        keep_shapes(handle, [shape])
        with handle.writing() as connection:
            whole = bytes(connection.exec_driver_sql("SELECT content FROM blob").scalar_one())
            out, array = io.BytesIO(), io.BytesIO()
            np.lib.format.write_array_header_1_0(array, {"descr": "<f8", "fortran_order": False, "shape": (count, 3)})
            with zipfile.ZipFile(io.BytesIO(whole)) as old, zipfile.ZipFile(out, "w") as new:
                for info in old.infolist():
                    if info.filename != f"{name}.npy":
                        new.writestr(info.filename, old.read(info))
                new.writestr(f"{name}.npy", array.getvalue())
            connection.exec_driver_sql("UPDATE blob SET content = ?", (out.getvalue(),))
        with pytest.raises(BadInput, match="damaged"):
            kept_shapes(handle, side(shape))
