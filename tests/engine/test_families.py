"""Shape families: deterministic, labelled, closed, welded or touching as promised."""

import numpy as np
import pytest
from scipy.spatial import KDTree

from assets import example_pairs
from engine.errors import BadInput, BadParameter
from engine.shapes.families import (
    FAMILIES,
    LABELS,
    VARIANTS,
    make_collection,
    make_pair,
    make_shape,
    parse_segments,
)
from engine.shapes.families.lofting import loft
from engine.shapes.families.solids import ellipsoid, torus, tube, turned
from engine.shapes.families.welding import surface_nets, surface_samples, weld
from engine.shapes.meshfile import load_shape
from engine.shapes.oversegmentation import connected_pieces, face_neighbours

BOTH = [(family, variant) for family in FAMILIES for variant in VARIANTS]


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum()) / 6


def edge_counts(faces: np.ndarray) -> np.ndarray:
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    return np.unique(edges, axis=0, return_counts=True)[1]


@pytest.mark.parametrize(
    ("solid", "expected"),
    [
        (turned("cylinder", [(0.3, 0), (0.3, 1)]), np.pi * 0.3**2),
        (turned("cone", [(0.3, 0), (0, 1)]), np.pi * 0.3**2 / 3),
        (ellipsoid("ball", (1, 2, 3), (0.3, 0.2, 0.25)), 4 / 3 * np.pi * 0.3 * 0.2 * 0.25),
        (torus("ring", (0, 0, 0), (0, 1, 0), 0.4, 0.1), 2 * np.pi**2 * 0.4 * 0.1**2),
        (tube("rod", [(0, 0, 0), (0, 0, 1)], 0.1), np.pi * 0.1**2 * (1 + 4 / 3 * 0.1)),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_a_solid_is_closed_and_has_the_volume_of_its_formula(solid, expected):
    vertices, faces = loft(solid, 0.02)
    assert (edge_counts(faces) == 2).all()
    assert volume(vertices, faces) == pytest.approx(expected, rel=0.04)


def test_surface_nets_of_a_ball_are_closed_and_face_outwards():
    grid = np.stack(np.meshgrid(*[np.arange(24.0)] * 3, indexing="ij"), axis=-1)
    vertices, faces = surface_nets(np.linalg.norm(grid - 11.3, axis=-1) - 8)
    assert (edge_counts(faces) == 2).all()
    assert volume(vertices, faces) == pytest.approx(4 / 3 * np.pi * 8**3, rel=0.03)


def test_two_overlapping_cylinders_weld_into_one_surface_whose_labels_part_at_the_waist():
    parts = [
        loft(turned("a", [(0.3, 0), (0.3, 1)]), 0.05),
        loft(turned("b", [(0.15, 0), (0.15, 1)], (0, 0, 0.98)), 0.05),
    ]
    vertices, faces, part = weld(parts, 0.05)
    assert connected_pieces(face_neighbours(faces), len(faces)).max() == 0
    height = vertices[faces].mean(axis=1)[:, 2]
    assert (part[height < 0.9] == 0).all()
    assert (part[height > 1.1] == 1).all()


@pytest.mark.parametrize(("family", "variant"), BOTH)
def test_the_same_seed_gives_the_same_shape_and_another_seed_another(family, variant):
    first, again, other = (make_shape(family, seed, variant=variant) for seed in (3, 3, 4))
    assert np.array_equal(first.mesh.vertices, again.mesh.vertices)
    assert np.array_equal(first.mesh.faces, again.mesh.faces)
    assert np.array_equal(first.label, again.label)
    assert first.mesh.vertices.shape != other.mesh.vertices.shape or not np.allclose(
        first.mesh.vertices, other.mesh.vertices
    )


@pytest.mark.parametrize(("family", "variant"), BOTH)
@pytest.mark.parametrize("seed", [0, 5, 11])
def test_every_face_has_a_label_and_a_part_and_the_variants_keep_their_word(family, variant, seed):
    shape = make_shape(family, seed, variant=variant)
    m = len(shape.mesh.faces)
    assert 2000 <= m <= 12000
    assert shape.label_names == LABELS[family]
    assert len(shape.label) == len(shape.part) == m
    assert shape.label.min() >= 0
    assert shape.label.max() < len(shape.label_names)
    for part in np.unique(shape.part):
        assert len(np.unique(shape.label[shape.part == part])) == 1
    assert np.array_equal(np.unique(shape.part), np.arange(shape.part.max() + 1))

    pieces = connected_pieces(face_neighbours(shape.mesh.faces), m)
    owners = [np.unique(shape.mesh.faces[shape.part == p]) for p in range(shape.part.max() + 1)]
    shared = len(np.concatenate(owners)) - len(np.unique(np.concatenate(owners)))
    if variant == "welded":
        assert pieces.max() == 0
        assert shared > 0
    else:
        assert pieces.max() == shape.part.max()
        assert shared == 0
        assert (edge_counts(shape.mesh.faces) == 2).all()


def test_parts_of_a_touching_shape_lie_close_to_each_other():
    """Joined by touch within 1.2 % of the diagonal, every shape is one piece."""
    for family in FAMILIES:
        shape = make_shape(family, 7, variant="touching")
        count = shape.part.max() + 1
        size = np.linalg.norm(np.ptp(shape.mesh.vertices, axis=0))
        trees = [
            KDTree(surface_samples(shape.mesh.vertices, shape.mesh.faces[shape.part == p], 0.01 * size))
            for p in range(count)
        ]
        near = [
            (i, j)
            for i in range(count)
            for j in range(i)
            if trees[i].query(trees[j].data, distance_upper_bound=0.012 * size)[0].min() < 0.012 * size
        ]
        assert connected_pieces(np.array(near), count).max() == 0, family


def test_a_turned_pose_is_a_rotation_of_the_upright_one():
    upright, turned_one = (make_shape("lamps", 2, pose=pose) for pose in ("upright", "turned"))
    a, b = (x.mesh.vertices - x.mesh.vertices.mean(axis=0) for x in (upright, turned_one))
    assert np.allclose(np.linalg.norm(a, axis=1), np.linalg.norm(b, axis=1), atol=1e-5)
    rotation = np.linalg.lstsq(a, b, rcond=None)[0]
    assert np.linalg.det(rotation) == pytest.approx(1, abs=1e-4)
    assert not np.allclose(rotation, np.eye(3), atol=0.1)


def test_a_pair_shares_its_classes_and_disagrees_in_its_segments():
    pair = make_pair("vases", 1, segments=(10, 14))
    assert pair.label_names == LABELS["vases"]
    assert len(pair.source_label) == len(pair.source.mesh.faces)
    assert len(pair.target_label) == len(pair.target.mesh.faces)
    for shape in (pair.source, pair.target):
        assert 10 <= shape.segmentation.count <= 14


def test_a_collection_reads_back_as_it_was_made(tmp_path):
    paths = make_collection(tmp_path / "new", ["candles"], 1, 4, "welded", "12-13")
    pair = make_pair("candles", 4, variant="welded", segments=(12, 13))
    assert [p.name for p in paths] == ["candles_004_a.off", "candles_004_b.off"]
    for path, shape, label in zip(
        paths, (pair.source, pair.target), (pair.source_label, pair.target_label), strict=True
    ):
        read = load_shape(path)
        assert np.array_equal(read.mesh.vertices, shape.mesh.vertices)
        assert np.array_equal(read.mesh.faces, shape.mesh.faces)
        assert np.array_equal(read.segmentation.labels, shape.segmentation.labels)
        assert np.array_equal(np.loadtxt(path.with_suffix(".sem"), dtype=int), label)
    assert '"branch"' in (tmp_path / "new" / "candles" / "labels.json").read_text()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda out: make_shape("lamp", 0), "no shape family named 'lamp'"),
        (lambda out: make_shape("lamps", 0, variant="glued"), "no variant named 'glued'"),
        (lambda out: make_shape("lamps", -1), "seed"),
        (lambda out: make_pair("lamps", 0, segments=(9, 4)), "2 <= LOW <= HIGH"),
        (lambda out: make_collection(out, ["boats"]), "no shape family named 'boats'"),
        (lambda out: make_collection(out, count=0), "number of pairs"),
        (lambda out: make_collection(out, segments="ten"), "LOW-HIGH"),
        (lambda out: parse_segments("4-"), "LOW-HIGH"),
        (lambda out: parse_segments("1-5"), "2 <= LOW <= HIGH"),
    ],
)
def test_bad_parameters_get_one_sentence_and_nothing_is_written(call, words, tmp_path):
    with pytest.raises(BadParameter, match=words):
        call(tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_file_in_the_place_of_the_folder_is_refused(tmp_path):
    (tmp_path / "file").write_text("here")
    with pytest.raises(BadInput, match="output folder"):
        make_collection(tmp_path / "file", ["lamps"])


def test_the_bundled_pairs_load_and_their_truth_fits():
    pairs = example_pairs()
    assert pairs[0][0] == "lamps"
    assert len(pairs) >= 6
    for _, *paths in pairs:
        for path in paths:
            shape, label = load_shape(path), np.loadtxt(path.with_suffix(".sem"), dtype=int)
            assert len(label) == len(shape.mesh.faces)
            assert 10 <= shape.segmentation.count <= 20
