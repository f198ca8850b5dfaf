"""Files from strangers: formats, labels, and what is wrong said in one sentence."""

import json

import numpy as np
import pytest
import trimesh

from engine.errors import BadInput
from engine.shapes.mesh import components
from engine.shapes.meshfile import load_shape, read_labels

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
        ("cut.off", OFF.replace("4 2 0", "4 3 0"), ["4 vertices and 3 faces", "holds 2 faces"]),
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


QUAD = "OFF\n5 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0 0\n4 0 1 2 3\n3 1 4 2\n"


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("1\n", "1 labels but .* 2 faces"),
        ("1\n2\n3", "3 labels"),
        ("1\nx", "Line 2 .* says 'x'; give one whole number"),
        ("1.5\n2", "Line 1 .* whole number"),
        ("1\n\n# two\n", "Line 3"),
        ("1\n1_0\n", "Line 2"),
        ("1\n٢\n", "Line 2"),
        ("1\n\x00\n", "Line 2"),
        ("1\n" + "x" * 9999, "Line 2 .* says 'x{20}…'"),
        ("", "empty"),
        ("\n \n", "0 labels"),
    ],
)
def test_wrong_label_files(tmp_path, content, words):
    mesh = write(tmp_path, "a.off", OFF)
    with pytest.raises(BadInput, match=words) as error:
        load_shape(mesh, write(tmp_path, "labels.seg", content))
    assert str(error.value).isprintable()


@pytest.mark.parametrize("content", [b"3\r\n1\r\n", b"\xef\xbb\xbf3\n1", b"\n3\n\n1\n\n\n", b"3\r1\r", b" +3 \n1\t\n"])
def test_label_files_of_other_editors_are_read(tmp_path, content):
    assert read_labels(write(tmp_path, "a.seg", content)).tolist() == [3, 1]


@pytest.mark.parametrize("word", ["1" * 40, str(2**63), str(-(2**63) - 1), "1" * 5000])
def test_labels_beyond_64_bits_are_refused(tmp_path, word):
    with pytest.raises(BadInput, match=r"Line 2 .* whole number"):
        read_labels(write(tmp_path, "a.seg", f"{-(2**63)}\n{word}"))


def test_a_label_a_polygon_goes_to_each_triangle_of_its_fan(tmp_path):
    shape = load_shape(write(tmp_path, "a.off", QUAD), write(tmp_path, "a.seg", "8\n3\n"))
    assert shape.mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3], [1, 4, 2]]
    assert [shape.segmentation.names[n] for n in shape.segmentation.labels] == [8, 8, 3]


def test_labels_a_triangle_of_polygons_are_taken_and_it_says_so(tmp_path):
    shape = load_shape(write(tmp_path, "a.off", QUAD), write(tmp_path, "a.seg", "8\n3\n5\n"))
    assert [shape.segmentation.names[n] for n in shape.segmentation.labels] == [8, 3, 5]
    assert "one for each triangle" in shape.notes[0]


def test_labels_that_fit_neither_polygons_nor_triangles_are_refused_with_both_counts(tmp_path):
    with pytest.raises(BadInput, match=r"4 labels but .* 2 polygons, which are 3 triangles"):
        load_shape(write(tmp_path, "a.off", QUAD), write(tmp_path, "a.seg", "1\n1\n1\n1\n"))


@pytest.mark.parametrize("head", ["OFF\n5 2 0", "OFF 5 2 0", "OFF5 2 0", "# made by hand\n\nOFF # really\n5 2"])
def test_headers_of_off_files_in_the_wild(tmp_path, head):
    assert len(load_shape(write(tmp_path, "a.off", QUAD.replace("OFF\n5 2 0", head))).mesh.faces) == 3


def test_coloured_off_files_keep_their_positions(tmp_path):
    text = "COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 255 0 0 255\n0 1 0 255 0 0 255\n3 0 1 2 0.5 0.5 0.5\n"
    assert load_shape(write(tmp_path, "a.off", text)).mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


def test_obj_corners_count_back_from_the_vertices_so_far(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3//1 -2 -1/4/5\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf -3 -2 \\\n -1\nf 1/2 2/2 6/2\n"
    assert load_shape(write(tmp_path, "a.obj", text)).mesh.faces.tolist() == [[0, 1, 2], [3, 4, 5], [0, 1, 5]]


def test_a_long_chain_of_continued_obj_lines_takes_no_long_time(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 \\\n" + "\\\n" * 200_000 + "3\nf 1 2 9\n"
    with pytest.raises(BadInput, match=r"Face 1 of .* outside"):
        load_shape(write(tmp_path, "a.obj", text))


@pytest.mark.parametrize("face", ["f 0 1 2", "f 1 2 4", "f -4 1 2", "f 1 2", "f 1 2 x", "f 1//// 2 3", "f 1 2 3_1", "n 1 2 3",
                                  "f 1 2 " + "9" * 30])  # fmt: skip
def test_obj_faces_that_make_no_sense_are_refused(tmp_path, face):
    text = f"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n{face}\n"
    with pytest.raises(BadInput, match=r"(Line 5|Face 1|A face) of .*a\.obj"):
        load_shape(write(tmp_path, "a.obj", text))


PLY = "ply\nformat {} 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\nelement face {}\n" \
      "property list uchar int vertex_indices\nproperty {} segment\nend_header\n"  # fmt: skip
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


@pytest.mark.parametrize("order", ["<", ">", ""])
def test_ply_polygons_of_different_sizes_keep_their_segments(tmp_path, order):
    name = {"<": "binary_little_endian", ">": "binary_big_endian", "": "ascii"}[order]
    rows = [(4, 0, 1, 2, 3, 7), (3, 0, 1, 2, -2)]
    if order:
        body = np.array(SQUARE, dtype=order + "f8").tobytes()
        body += b"".join(bytes([row[0]]) + np.array(row[1:], dtype=order + "i4").tobytes() for row in rows)
    else:
        body = "".join(" ".join(map(str, row)) + "\n" for row in SQUARE + rows).encode()
    shape = load_shape(write(tmp_path, "a.ply", PLY.format(name, 2, "int").encode() + body))
    assert shape.mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 2]]
    assert [shape.segmentation.names[n] for n in shape.segmentation.labels] == [7, 7, -2]


@pytest.mark.parametrize(
    ("faces", "kind", "rows", "words"),
    [
        (2, "int", "3 0 1 2 7\n", "ends before"),
        (10**15, "int", "3 0 1 2 7\n", "rows of 'face' but is too short"),
        (-1, "int", "3 0 1 2 7\n", "Line 7 .* header"),
        (1, "int", "3 0 1 2 7\n3 0 1 2 7\n", "goes on"),
        (1, "int", "9 0 1 2 7\n", "ends before"),
        (1, "int", "-3 0 1 2 7\n", "impossible length"),
        (1, "int", "2000000000 0 1 2 7\n", "impossible length"),
        (1, "int", "2 0 1 7\n", "fewer than three"),
        (1, "int", "3 0 1 4 7\n", "index outside"),
        (1, "int", "3 0 1 1.5 7\n", "no whole number"),
        (1, "float", "3 0 1 2 7.5\n", "a segment that is no whole number"),
        (1, "float", "3 0 1 2 nan\n", "a segment that is no whole number"),
        (1, "int", "3 0 1 2 x\n", "not a number"),
        (1, "madeup", "3 0 1 2 7\n", "Line 9"),
    ],
)
def test_ply_files_that_lie_are_refused(tmp_path, faces, kind, rows, words):
    body = "".join(" ".join(map(str, row)) + "\n" for row in SQUARE) + rows
    with pytest.raises(BadInput, match=words):
        load_shape(write(tmp_path, "a.ply", PLY.format("ascii", faces, kind) + body))


def test_stl_text_keeps_its_solids_and_refuses_a_cut(tmp_path):
    facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    text = f"solid my_leg\n{facet}{facet}endsolid my_leg\nsolid seat\n{facet}endsolid seat\n"
    shape = load_shape(write(tmp_path, "a.stl", text))
    assert shape.segmentation.names == ("my_leg", "seat")
    assert shape.segmentation.labels.tolist() == [0, 0, 1]
    with pytest.raises(BadInput, match="cut off"):
        load_shape(write(tmp_path, "b.stl", text.removesuffix("endsolid seat\n")))


def test_a_binary_stl_with_an_absurd_count_is_refused(tmp_path):
    with pytest.raises(BadInput, match=r"promises 4,294,967,295 triangles, its size fits 1"):
        load_shape(write(tmp_path, "a.stl", b"\0" * 80 + b"\xff" * 4 + b"\0" * 50))


def changed_glb(folder, change):
    """A GLB file of a box and a ball with its plan changed."""
    scene = trimesh.Scene()
    for name, part in (("box", trimesh.creation.box()), ("ball", trimesh.creation.icosphere(3))):
        scene.add_geometry(part, node_name=name, geom_name=name)
    data = scene.export(file_type="glb")
    length = int.from_bytes(data[12:16], "little")
    plan = json.loads(data[20 : 20 + length])
    change(plan)
    text = json.dumps(plan).encode()
    data = data[:12] + len(text).to_bytes(4, "little") + b"JSON" + text + data[20 + length :]
    return write(folder, "a.glb", data[:8] + len(data).to_bytes(4, "little") + data[12:])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda p: p["buffers"][0].update(uri="file:///etc/passwd"), "another file"),
        (lambda p: p["buffers"][0].update(uri="http://localhost/x"), "another file"),
        (lambda p: p["accessors"][0].update(count=10**12), "more numbers than it has bytes"),
        (lambda p: p["accessors"][0].update(count=-1), "no whole number of at least 0"),
        (lambda p: p["accessors"][0].pop("bufferView"), "sparse or left out"),
        (lambda p: p["bufferViews"].extend(p["bufferViews"] * 999), "more numbers than it has bytes"),
        (lambda p: p["nodes"][-1].update(children=[len(p["nodes"]) - 1]), "no tree"),
        (lambda p: p["nodes"].extend([{"mesh": 0}] * 30_000), "30,002 nodes"),
        (lambda p: p["meshes"][0]["primitives"].extend(p["meshes"][0]["primitives"] * 30_000), "30,002 nodes or parts"),
        (lambda p: p["nodes"].extend([{"mesh": n % 2} for n in range(9000)]) or p["scenes"][0].update(nodes=[*range(9002)]),
         "repeats its parts"),
        (lambda p: p.update(extensionsRequired=["KHR_draco_mesh_compression"]), "KHR_draco.* without compression"),
        (lambda p: p["nodes"][-1].update(translation=[float("inf"), 0, 0]), "not finite"),
        (lambda p: p.pop("meshes"), "cannot be read as GLB"),
        (lambda p: p.pop("scenes"), "no triangles"),
    ],
)
def test_glb_plans_that_ask_too_much_are_refused(tmp_path, change, words):
    with pytest.raises(BadInput, match=words):
        load_shape(changed_glb(tmp_path, change))


def test_an_index_of_one_glb_part_cannot_reach_into_the_next(tmp_path):
    def shorten(plan):
        plan["accessors"][plan["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]["count"] = 4

    with pytest.raises(BadInput, match=r"part 'box' .* outside of its vertices"):
        load_shape(changed_glb(tmp_path, shorten))


def test_components_can_merge_equal_positions(tmp_path):
    mesh = two_parts()
    soup = trimesh.Trimesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3), process=False)
    soup.export(tmp_path / "soup.off")
    shape = load_shape(tmp_path / "soup.off")
    assert shape.segmentation.count == len(mesh.faces)
    assert len(np.unique(components(shape.mesh, merge=True))) == 2
