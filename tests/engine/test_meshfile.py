"""Files from strangers: formats, labels, and what is wrong said in one sentence."""

import numpy as np
import pytest
import trimesh

from engine.errors import BadInput
from engine.shapes.meshfile import components, load_shape, read_labels

OFF = "OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n"


def write(folder, name, content):
    path = folder / name
    path.write_bytes(content) if isinstance(content, bytes) else path.write_text(content)
    return path


def two_parts():
    return trimesh.util.concatenate([trimesh.creation.box(), trimesh.creation.icosphere(1).apply_translation((4, 0, 0))])


def test_labels_beside_the_mesh_are_found_and_keep_their_names(tmp_path):
    mesh = write(tmp_path, "a.off", OFF)
    write(tmp_path, "a.seg", "40\n7\n")
    shape = load_shape(mesh)
    assert shape.segmentation.names == (7, 40)
    assert shape.segmentation.labels.tolist() == [1, 0]
    assert shape.notes == ()


def test_named_labels_win_over_those_beside_the_mesh(tmp_path):
    mesh = write(tmp_path, "a.off", OFF)
    write(tmp_path, "a.seg", "1\n2\n")
    other = write(tmp_path, "b.seg", "5 5")
    assert load_shape(mesh, other).segmentation.names == (5,)


@pytest.mark.parametrize("suffix", ["off", "ply", "stl", "obj"])
def test_without_labels_the_components_are_the_segments_and_it_says_so(tmp_path, suffix):
    path = tmp_path / f"a.{suffix}"
    two_parts().export(path)
    shape = load_shape(path)
    assert sorted(np.bincount(shape.segmentation.labels)) == [12, 80]
    assert "connected components" in shape.notes[0]


def test_glb_parts_are_segments_at_their_place_in_the_scene(tmp_path):
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box(), node_name="seat", geom_name="seat")
    scene.add_geometry(trimesh.creation.icosphere(1), node_name="arm", geom_name="arm",
                       transform=trimesh.transformations.translation_matrix((4, 0, 0)))  # fmt: skip
    scene.export(tmp_path / "a.glb")
    shape = load_shape(tmp_path / "a.glb")
    assert shape.segmentation.names == ("arm", "seat")
    arm = shape.mesh.vertices[shape.mesh.faces[shape.segmentation.labels == 0]]
    assert arm[..., 0].mean() == pytest.approx(4, abs=0.1)


def test_obj_groups_are_segments(tmp_path):
    text = "g one\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\ng two\nf 2 4 3\ng one\nf 1 3 4\n"
    shape = load_shape(write(tmp_path, "a.obj", text))
    assert shape.segmentation.names == ("one", "two")
    assert np.bincount(shape.segmentation.labels).tolist() == [2, 1]


def test_obj_with_a_label_file_keeps_the_order_of_its_faces(tmp_path):
    text = "g one\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 3 3 0\nf 1 2 3\ng two\nf 2 4 3\ng one\nf 1 3 4\n"
    mesh = write(tmp_path, "a.obj", text)
    write(tmp_path, "a.seg", "1\n2\n3\n")
    shape = load_shape(mesh)
    far = shape.mesh.vertices[shape.mesh.faces].max(axis=(1, 2))
    assert far.tolist() == [1, 3, 3]


def test_ply_face_property_is_the_label(tmp_path):
    text = ("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 2\nproperty list uchar int vertex_indices\nproperty int segment\nend_header\n"
            "0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2 7\n3 1 3 2 9\n")  # fmt: skip
    shape = load_shape(write(tmp_path, "a.ply", text))
    assert shape.segmentation.names == (7, 9)
    assert "segment" in shape.notes[0]


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("none.off", None, ["cannot be read"]),
        ("empty.off", "", ["is empty"]),
        ("text.off", "hello world", ["OFF"]),
        ("mesh.txt", "hello", ["convert", ".ply"]),
        ("noise.glb", b"\x00\x01" * 99, ["GLB"]),
        ("noise.ply", b"\x93\x01" * 99, ["PLY"]),
        ("noise.stl", b"\x93\x01" * 20, ["triangles"]),
        ("nan.off", OFF.replace("1 1 0", "1 nan 0"), ["not finite"]),
        ("huge.off", OFF.replace("1 1 0", "1 1e200 0"), ["beyond"]),
        ("range.off", OFF.replace("3 1 3 2", "3 1 9 2"), ["index"]),
        ("negative.off", OFF.replace("3 1 3 2", "3 1 -1 2"), ["index"]),
        ("nofaces.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", ["no faces"]),
        ("cut.off", OFF.replace("4 2 0", "4 3 0"), ["promises 3", "holds 2"]),
        ("point.off", "OFF\n3 1 0\n0 0 0\n0 0 0\n0 0 0\n3 0 1 2\n", ["one point"]),
    ],
)
def test_bad_files_get_one_sentence(tmp_path, name, content, words):
    path = tmp_path / name
    if content is not None:
        write(tmp_path, name, content)
    with pytest.raises(BadInput) as error:
        load_shape(path)
    text = str(error.value)
    assert "\n" not in text
    assert path.stem in text
    assert all(word in text for word in words), text


def test_a_folder_is_no_mesh(tmp_path):
    with pytest.raises(BadInput, match="folder"):
        load_shape(tmp_path)


@pytest.mark.parametrize(("content", "words"), [("1\n", "1 labels"), ("1\n2\n3", "3 labels"), ("1\nx", "whole number"),
                                                ("1.5\n2", "whole number"), ("", "empty")])  # fmt: skip
def test_wrong_label_files(tmp_path, content, words):
    mesh = write(tmp_path, "a.off", OFF)
    with pytest.raises(BadInput, match=words):
        load_shape(mesh, write(tmp_path, "labels.seg", content))


def test_labels_beyond_64_bits_are_refused(tmp_path):
    with pytest.raises(BadInput, match="whole number"):
        read_labels(write(tmp_path, "a.seg", "1" * 40))


def test_components_can_merge_equal_positions(tmp_path):
    mesh = two_parts()
    soup = trimesh.Trimesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3), process=False)
    soup.export(tmp_path / "soup.off")
    shape = load_shape(tmp_path / "soup.off")
    assert shape.segmentation.count == len(mesh.faces)
    assert len(np.unique(components(shape.mesh, merge=True))) == 2
