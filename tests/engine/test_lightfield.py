"""Silhouettes combine by OR, moments agree with mahotas, distances obey their laws."""

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation
from world import bar, boxes

from engine.shapes.lightfield import (
    axis_permutations,
    dodecahedron_axes,
    light_field_descriptors,
    light_field_distances,
    quantile_signatures,
    signature_distances,
    view_frames,
)  # fmt: skip
from engine.shapes.mesh import Mesh
from engine.shapes.moments import GRID, centred_disc, disc_moments, orders, radial, tables
from engine.shapes.silhouettes import draw_segments, draw_triangles, filled_box


def picture(image):
    return np.unpackbits(image, axis=1, bitorder="little").astype(bool)


def draw(points, triangles, side=64):
    image = np.zeros((side, side // 8), np.uint8)
    draw_triangles(np.array(points, float), np.array(triangles), np.arange(len(triangles)), image)
    return picture(image)


def test_a_triangle_covers_the_pixels_whose_middles_it_holds():
    image = draw([(10, 10), (50, 10), (10, 50)], [(0, 1, 2)])
    y, x = np.mgrid[:64, :64] + 0.5
    assert np.array_equal(image, (x >= 10) & (y >= 10) & (x + y <= 60))


def test_front_and_back_do_not_cancel_and_orientation_does_not_matter():
    square = [(8, 8), (40, 8), (40, 40), (8, 40)]
    once = draw(square, [(0, 1, 2), (0, 2, 3)])
    assert once.sum() == 32 * 32
    assert np.array_equal(once, draw(square, [(0, 1, 2), (0, 2, 3), (2, 1, 0), (3, 2, 0)]))


def test_a_sheet_seen_from_its_edge_stays_a_line():
    across = draw([(8, 20.2), (40, 20.2), (40, 20.3)], [(0, 1, 2)])
    assert across[20, 8:41].all()
    down = draw([(20.2, 8), (20.2, 40), (20.3, 40)], [(0, 1, 2)])
    assert down[8:40, 20].all()


def test_what_lies_outside_the_image_is_left_out():
    image = draw([(-100, -100), (300, -100), (-100, 300)], [(0, 1, 2)])
    assert image.all()


def test_or_of_segments_is_the_silhouette_of_the_union():
    rng = np.random.default_rng(0)
    mesh = trimesh.creation.icosphere(3)
    labels = rng.integers(0, 5, len(mesh.faces))
    order = np.argsort(labels, kind="stable")
    bounds = np.searchsorted(labels[order], np.arange(6))
    xy = 64 + 60 * mesh.vertices[:, :2]
    images = np.zeros((5, 128, 16), np.uint8)
    draw_segments(xy, mesh.faces, order, bounds, images)
    union = np.zeros((128, 16), np.uint8)
    draw_triangles(xy, mesh.faces, np.flatnonzero((labels == 1) | (labels == 3)), union)
    assert np.array_equal(images[1] | images[3], union)


def disc_of(image_bool):
    packed = np.packbits(image_bool, axis=1, bitorder="little")
    disc = np.zeros((GRID, GRID), np.uint8)
    assert centred_disc(packed, filled_box(packed), disc)
    return disc


def moments_of(disc):
    out = np.zeros(45, np.float32)
    disc_moments(disc, *tables(), out)
    return out


def test_zernike_magnitudes_agree_with_mahotas():
    mahotas = pytest.importorskip("mahotas")
    y, x = np.mgrid[:200, :200]
    blob = ((x - 90) / 70) ** 2 + ((y - 120) / 40) ** 2 < 1
    blob |= (abs(x - 90) < 12) & (y < 120) & (y > 20)
    disc = disc_of(blob)
    ours = moments_of(disc)[:35]
    theirs = mahotas.features.zernike_moments(disc, GRID / 2, degree=10, cm=(GRID / 2 - 0.5, GRID / 2 - 0.5))
    names = [(n, m) for n in range(11) for m in range(n + 1) if (n - m) % 2 == 0]
    wanted = dict(zip(names, theirs, strict=True))
    assert ours == pytest.approx([wanted[o] for o in orders()[1:]], abs=0.03)


def test_radial_polynomials_by_hand():
    r = np.linspace(0, 1, 5)
    assert radial(2, 0, r) == pytest.approx(2 * r**2 - 1)
    assert radial(3, 1, r) == pytest.approx(3 * r**3 - 2 * r)
    assert radial(4, 0, r) == pytest.approx(6 * r**4 - 6 * r**2 + 1)
    assert len(orders()) == 36


def test_a_disc_has_no_fourier_part_and_no_angular_moments():
    y, x = np.mgrid[:256, :256] + 0.5
    values = moments_of(disc_of((x - 128) ** 2 + (y - 128) ** 2 < 100**2))
    angular = [k for k, (_, m) in enumerate(orders()[1:]) if m > 0]
    assert values[angular].max() < 0.05
    assert values[35:].max() < 0.02


def test_mirroring_a_silhouette_changes_nothing():
    y, x = np.mgrid[:256, :256]
    shape = ((x > 40) & (x < 90) & (y > 30) & (y < 220)) | ((y > 170) & (y < 220) & (x >= 90) & (x < 200))
    assert moments_of(disc_of(shape)) == pytest.approx(moments_of(disc_of(shape[:, ::-1])), abs=0.05)


def test_the_rotations_of_the_dodecahedron_form_a_group_of_60_permutations():
    permutations = axis_permutations()
    assert permutations.shape == (60, 10)
    assert permutations[0].tolist() == list(range(10))
    rows = {tuple(p) for p in permutations.tolist()}
    assert len(rows) == 60
    assert all(tuple(a[b]) in rows for a in permutations for b in permutations[::7])
    cosine = np.abs(dodecahedron_axes() @ dodecahedron_axes().T)
    for p in permutations:
        assert np.allclose(cosine[np.ix_(p, p)], cosine)


def test_view_frames_are_orthonormal_and_seeded():
    frames = view_frames(3, seed=5)
    assert np.allclose(np.einsum("vkd,vld->vkl", frames, frames), np.eye(2))
    assert np.array_equal(frames, view_frames(3, seed=5))
    assert not np.allclose(frames, view_frames(3, seed=6))


def describe(shape, members, **options):
    settings = {"light_fields": 2, "resolution": 128, "seed": 0} | options
    return light_field_descriptors(shape.mesh, shape.segmentation.labels, np.asarray(members, bool), **settings)


def moved(shape, rotation, scale=1.0, shift=0.0):
    return type(shape)(Mesh(scale * shape.mesh.vertices @ rotation.T + shift, shape.mesh.faces, "moved"), shape.segmentation)


def test_size_and_place_do_not_count(lamp):
    members = [[1, 0, 0, 0, 0], [0, 1, 1, 0, 0], [1, 1, 1, 1, 1]]
    a, b = describe(lamp, members), describe(moved(lamp, np.eye(3), 7.0, 3.0), members)
    pairs = np.stack([np.arange(3)] * 2, axis=1)
    assert light_field_distances(a, b, pairs).max() < 0.25
    assert light_field_distances(a, a, pairs) == pytest.approx(0, abs=1e-6)


def test_a_rotation_of_the_dodecahedron_is_found(lamp):
    turn = Rotation.create_group("I").as_matrix()[17]
    members = [[1, 1, 1, 1, 1], [1, 0, 0, 0, 0]]
    whole = describe(lamp, members, light_fields=1)
    base = Rotation.random(1, rng=np.random.default_rng(0)).as_matrix()[0]
    turned = describe(moved(lamp, base @ turn @ base.T), members, light_fields=1)
    other = describe(moved(lamp, Rotation.from_rotvec([0.3, 0.2, 0.1]).as_matrix()), members, light_fields=1)
    pairs = np.array([[0, 0], [1, 1]])
    aligned, tilted = light_field_distances(whole, turned, pairs), light_field_distances(whole, other, pairs)
    assert (aligned < 0.5 * tilted).all()


def test_distances_are_symmetric_and_tell_shapes_apart():
    thin, cube = bar([4, 4]), boxes([((0, 0, 0), (1, 1, 1)), ((1, 0, 0), (2, 1, 1))])
    a, b = describe(thin, [[1, 1], [1, 0]]), describe(cube, [[1, 0], [0, 1]])
    pairs = np.array([[0, 0], [1, 0], [1, 1]])
    forth, back = light_field_distances(a, b, pairs), light_field_distances(b, a, pairs[:, ::-1].copy())
    assert forth == pytest.approx(back, abs=1e-5)
    assert forth[0] > 3 * light_field_distances(b, b, np.array([[0, 1]]))[0]


def test_distances_agree_with_the_definition(lamp):
    members = [[1, 0, 0, 0, 0], [0, 0, 0, 1, 1]]
    a, b = describe(lamp, members), describe(lamp, members, seed=3)
    found = light_field_distances(a, b, np.array([[0, 1]]))[0]
    best = min(
        np.abs(a[0, f] - b[1, g][p]).sum(axis=1).mean() for f in range(2) for g in range(2) for p in axis_permutations()
    )
    assert found == pytest.approx(best, rel=1e-5)


def test_how_arrays_lie_in_memory_changes_no_bit():
    a, b = np.random.default_rng(0).random((2, 12, 1, 10, 45), dtype=np.float32)
    pairs = np.argwhere(np.ones((12, 12), dtype=bool))
    wanted = light_field_distances(a, b, pairs)
    spread = np.zeros((24, 1, 10, 45), dtype=np.float32)
    spread[::2] = a
    kept = b.copy()
    kept.flags.writeable = False
    assert np.array_equal(light_field_distances(spread[::2], b, pairs), wanted)
    assert np.array_equal(light_field_distances(a, kept, np.asfortranarray(pairs)), wanted)


def test_signature_distance_by_hand_and_never_above_the_exact_one(lamp):
    members = np.random.default_rng(0).random((20, 5)) < 0.5
    members[:, 0] |= ~members.any(axis=1)
    a = describe(lamp, members, light_fields=1)
    signatures = quantile_signatures(a)
    assert signatures.shape == (20, 450)
    quick = signature_distances(signatures, signatures)
    assert quick[3, 7] == pytest.approx(np.abs(signatures[3] - signatures[7]).sum() / 10, rel=1e-5)
    pairs = np.argwhere(np.ones((20, 20), bool))
    exact = light_field_distances(a, a, pairs)
    assert (quick[pairs[:, 0], pairs[:, 1]] <= exact + 1e-4).all()
