"""Measures of sides: hand-made values, laws, and independent programs."""

import numpy as np
import pytest

from engine.progress import silent
from engine.puzzles.measures import (
    CODES,
    Strips,
    dissimilarity,
    dissimilarity_of_pairs,
    gradient_statistics,
    side_strips,
)
from engine.puzzles.shortlist import mgc_forms, nearest, pairs_of, ssd_forms

ALL = sorted([*CODES, "mgc-pt"])


@pytest.fixture
def rasters() -> np.ndarray:
    return np.random.default_rng(4).integers(0, 256, (6, 9, 9, 3)).astype(np.uint8)


def strips(outer: list, inner: list) -> Strips:
    """Grey strips from lists of values, one list a side."""
    return Strips(*(np.repeat(np.array(v, dtype=np.float32)[..., None], 3, axis=2) for v in (outer, inner)))


def test_sides_are_read_clockwise():
    raster = np.arange(9).reshape(1, 3, 3, 1).repeat(3, axis=3).astype(np.uint8)
    found = side_strips(raster)
    assert found.outer[..., 0].tolist() == [[0, 1, 2], [2, 5, 8], [8, 7, 6], [6, 3, 0]]
    assert found.inner[..., 0].tolist() == [[3, 4, 5], [1, 4, 7], [5, 4, 3], [7, 4, 1]]


def test_ssd_by_hand():
    two = strips([[10, 20], [23, 14]], [[0, 0], [0, 0]])
    assert dissimilarity("ssd", two, [0], [1])[0, 0] == 3 * (4**2 + 3**2)  # 10 meets 14, 20 meets 23


def test_mgc_by_hand():
    """Flat strips: no gradients, so the covariance is that of the nine dummies, and every pixel differs by one grey."""
    two = strips([[5, 5], [6, 6]], [[5, 5], [6, 6]])
    dummies = np.array([(0, 0, 0), (1, 1, 1), (-1, -1, -1), *np.eye(3), *-np.eye(3)])
    inverse = np.linalg.inv(np.cov(np.concatenate([np.zeros((2, 3)), dummies]).T))
    one = np.ones(3) @ inverse @ np.ones(3)
    assert dissimilarity("mgc", two, [0], [1])[0, 0] == pytest.approx(2 * 2 * one)
    assert dissimilarity("mgc-root", two, [0], [1])[0, 0] == pytest.approx(2 * 2 * np.sqrt(one))


def test_the_mean_gradient_leaves_the_dummies_out():
    one = strips([[8, 8, 8, 8]], [[2, 2, 2, 2]])
    assert gradient_statistics(one)[0].tolist() == [[6, 6, 6]]
    wider = Strips(one.outer, one.inner, gap=2.0)
    assert gradient_statistics(wider)[0].tolist() == [[3, 3, 3]]  # per pixel


def test_a_straight_continuation_is_perfect_for_predictions():
    """A ramp that goes on across the seam: the prediction of either border is the other."""
    two = strips([[20, 20], [30, 30]], [[10, 10], [40, 40]])
    grey = two.lab()
    a_in, a, b, b_in = (colours[0].astype(float) for colours in (grey.inner[0], grey.outer[0], grey.outer[1], grey.inner[1]))
    expected = 2 * (np.abs(2 * a - a_in - b) + np.abs(2 * b - b_in - a)).sum()  # two pixels alike
    assert dissimilarity("pt", two, [0], [1])[0, 0] == pytest.approx(expected, rel=1e-6)
    assert dissimilarity("mgc", two, [0], [1])[0, 0] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("lab", [False, True])
def test_emd_is_that_of_an_exact_solver(rasters, lab):
    import ot

    sides = side_strips(rasters)
    seen = (sides.lab() if lab else sides).outer.astype(np.float64)
    weight = np.full(9, 1 / 9)
    expected = np.mean([ot.emd2(weight, weight, np.abs(seen[1, :, None, c] - seen[7, None, :, c])) for c in range(3)])
    assert dissimilarity("emd-lab" if lab else "emd", sides, [1], [7])[0, 0] == pytest.approx(expected, rel=1e-6)


def test_emd_of_halves_is_the_mean_over_halves_that_face_each_other():
    two = strips([[1, 2, 3, 4], [4, 3, 7, 7]], [[0] * 4, [0] * 4])
    assert dissimilarity("emd", two, [0], [1])[0, 0] == pytest.approx((2 + 2 + 4 + 3) / 4)
    halves = [abs(1 - 7) + abs(2 - 7), abs(3 - 3) + abs(4 - 4)]  # 1 2 meets 7 7, 3 4 meets 4 3
    assert dissimilarity("emd", two, [0], [1], parts=2)[0, 0] == pytest.approx(sum(halves) / 4)


def test_emd_does_not_see_the_order_of_pixels(rasters):
    sides = side_strips(rasters)
    mixed = Strips(sides.outer[:, np.random.default_rng(0).permutation(9)], sides.inner)
    both = [dissimilarity("emd", s, range(8), range(8)) for s in (sides, mixed)]
    assert np.allclose(*both)


@pytest.mark.parametrize("measure", ALL)
def test_every_measure_is_symmetric_and_the_same_in_pairs(rasters, measure):
    sides = side_strips(rasters)
    dense = dissimilarity(measure, sides, range(24), range(24), parts=2)
    assert np.allclose(dense, dense.T)
    assert (dense >= 0).all()
    pairs = np.argwhere(np.ones((24, 24)))
    assert np.allclose(dissimilarity_of_pairs(measure, sides, pairs, parts=2), dense.ravel())


@pytest.mark.parametrize("measure", ALL)
def test_turning_all_pieces_only_renames_the_sides(rasters, measure):
    turned = np.rot90(rasters, -1, axes=(1, 2))  # one clockwise quarter turn: side s becomes side s + 1
    rows = np.arange(24)
    moved = rows // 4 * 4 + (rows % 4 + 1) % 4
    before = dissimilarity(measure, side_strips(rasters), rows, rows)
    assert np.allclose(dissimilarity(measure, side_strips(turned), moved, moved), before)


def test_a_side_of_one_colour_ties_with_its_like():
    flat = np.full((2, 5, 5, 3), 200, dtype=np.uint8)
    assert np.allclose([dissimilarity(m, side_strips(flat), [1], [7])[0, 0] for m in CODES if m != "mgc-pt"], 0)


@pytest.mark.parametrize(("forms", "measure"), [(mgc_forms, "mgc"), (ssd_forms, "ssd")])
def test_matrix_products_are_the_measures(rasters, forms, measure):
    sides = side_strips(rasters)
    x, y = forms(sides)
    dense = dissimilarity(measure, sides, range(24), range(24))
    assert np.allclose(x.astype(np.float64) @ y.T, dense, rtol=1e-3, atol=1e-3 * dense.max())


@pytest.mark.parametrize("turned", [False, True])
def test_the_nearest_are_those_of_the_dense_matrix(rasters, turned):
    sides = side_strips(rasters)
    found = nearest(ssd_forms(sides), 6, 3, turned=turned, progress=silent)
    dense = dissimilarity("ssd", sides, range(24), range(24))
    side = np.arange(24)
    dense[side[:, None] // 4 == side[None] // 4] = np.inf
    if not turned:
        dense[(side[:, None] % 4 + 2) % 4 != side[None] % 4] = np.inf
    assert (found == np.argsort(dense, axis=1)[:, :3]).all()


def test_short_lists_are_filled_with_nothing():
    two = side_strips(np.random.default_rng(1).integers(0, 256, (2, 4, 4, 3)).astype(np.uint8))
    found = nearest(ssd_forms(two), 2, 3, turned=False, progress=silent)
    assert found.tolist() == [[6, -1, -1], [7, -1, -1], [4, -1, -1], [5, -1, -1], [2, -1, -1], [3, -1, -1], [0, -1, -1], [1, -1, -1]]
    assert pairs_of([found]).tolist() == [[0, 6], [1, 7], [2, 4], [3, 5]]
