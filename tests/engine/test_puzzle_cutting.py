"""Cutting pictures: every pixel in one piece, nothing told by the order, the truth puts all together again."""

import time

import numpy as np
import pytest

from engine.errors import BadInput
from engine.puzzles.cutting import KINDS, cut, drop, mix
from engine.puzzles.dissection import outline
from engine.puzzles.turning import turned_piece, turned_raster


def picture(w=96, h=72, seed=0):
    return np.random.default_rng(seed).integers(0, 256, (h, w, 3), dtype=np.uint8)


def made(kind, **more):
    size = {"pieces": 20} if kind == "rectangles" else {"piece_size": 12}
    return cut(picture(), kind=kind, **size, **more)


def put_together(puzzle, truth, k=0):
    """The picture that the truth makes, and how many pieces cover each of its pixels."""
    w, h = truth.sizes[k]
    canvas, covered = np.zeros((h, w, 3), dtype=np.uint8), np.zeros((h, w), dtype=int)
    for i in np.flatnonzero(truth.picture == k):
        x, y = truth.position[i]
        mask = turned_raster(puzzle.pieces[i].mask, truth.turns[i])
        place = np.s_[y : y + mask.shape[0], x : x + mask.shape[1]]
        canvas[place][mask] = turned_raster(puzzle.pieces[i].image, truth.turns[i])[mask]
        covered[place] += mask
    return canvas, covered


def area(polygon):
    x, y = polygon.T
    return (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2  # positive: clockwise, y down


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_the_truth_makes_the_picture_again_and_every_pixel_is_in_one_piece(kind, turned):
    puzzle, truth = made(kind, turned=turned, seed=3)
    canvas, covered = put_together(puzzle, truth)
    assert (covered == 1).all()
    assert (canvas == picture()).all()
    assert puzzle.frame == (96, 72) == tuple(truth.sizes[0])
    assert set(truth.turns) == ({0, 1, 2, 3} if turned else {0})


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_polygons_are_clockwise_from_the_top_and_hold_the_pixels(kind, turned):
    for piece in made(kind, turned=turned)[0].pieces:
        h, w = piece.mask.shape
        assert (piece.polygon.min(axis=0) == 0).all()
        assert (piece.polygon.max(axis=0) == (w, h)).all()
        slope = sum(abs(a - b).min() for a, b in zip(piece.polygon, np.roll(piece.polygon, -1, axis=0), strict=True))
        assert abs(area(piece.polygon) - piece.mask.sum()) <= slope / 2
        first = min(map(tuple, piece.polygon), key=lambda corner: corner[::-1])
        assert tuple(piece.polygon[0]) == first


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_seed_cuts_the_same_and_another_differs(kind):
    (a, truth), (b, same), (_, other) = made(kind, seed=5), made(kind, seed=5), made(kind, seed=6)
    assert (truth.position == same.position).all()
    assert all(
        (p.image == q.image).all() and (p.polygon == q.polygon).all() for p, q in zip(a.pieces, b.pieces, strict=True)
    )
    assert truth.position.shape != other.position.shape or (truth.position != other.position).any()


@pytest.mark.parametrize("kind", KINDS)
def test_the_order_of_pieces_says_nothing(kind):
    places = made(kind)[1].position
    in_reading_order = np.lexsort((places[:, 0], places[:, 1]))
    fixed = (in_reading_order == np.arange(len(places))).mean()
    assert fixed < 0.3


def test_a_diagonal_pixel_belongs_to_the_upper_half():
    puzzle, _ = cut(picture(), kind="triangles", piece_size=12)
    halves = [piece for piece in puzzle.pieces if len(piece.polygon) == 3]
    upper = [piece for piece in halves if piece.mask[0].all()]
    assert {int(piece.mask.sum()) for piece in upper} == {12 * 13 // 2}
    assert {int(piece.mask.sum()) for piece in halves} == {12 * 13 // 2, 12 * 11 // 2}
    assert len(halves) == 2 * round(0.4 * 48)


def test_merged_pieces_are_one_to_three_squares():
    puzzle, _ = made("merged")
    cells = [int(piece.mask.sum()) // 144 for piece in puzzle.pieces]
    assert puzzle.count == 36
    assert sum(cells) == 48
    assert set(cells) == {1, 2, 3}


def test_the_outline_of_an_l():
    cells = np.array([[1, 0], [1, 1]], dtype=bool)
    assert outline(cells).tolist() == [[0, 0], [1, 0], [1, 1], [2, 1], [2, 2], [0, 2]]


def test_a_picture_is_cropped_around_its_centre():
    puzzle, truth = cut(picture(50, 39), piece_size=12)
    assert puzzle.count == 12
    assert (put_together(puzzle, truth)[0] == picture(50, 39)[1:37, 1:49]).all()


@pytest.mark.parametrize(("kind", "count"), [("squares", 432), ("merged", 324), ("triangles", 605), ("rectangles", 50)])
def test_the_wanted_number_of_pieces(kind, count):
    assert cut(picture(672, 504), kind=kind, pieces=count)[0].count == count


def test_four_quarter_turns_are_none():
    piece = made("triangles")[0].pieces[0]
    back = turned_piece(turned_piece(piece, 3), 1)
    assert (back.image == piece.image).all()
    assert (back.polygon == piece.polygon).all()


def test_mixed_puzzles_remember_their_pictures():
    other = picture(48, 60, seed=1)
    puzzle, truth = mix([made("squares"), cut(other, piece_size=12, turned=True)], seed=1)
    assert (puzzle.count, puzzle.pictures, puzzle.frame, puzzle.turned) == (48 + 20, 2, None, True)
    assert (put_together(puzzle, truth, 0)[0] == picture()).all()
    assert (put_together(puzzle, truth, 1)[0] == other).all()
    assert len({piece.name for piece in puzzle.pieces}) == puzzle.count


def test_lost_pieces_leave_the_others_in_place():
    puzzle, truth = drop(*made("rectangles"), missing=0.25, seed=2)
    canvas, covered = put_together(puzzle, truth)
    assert puzzle.count == 15
    assert covered.max() == 1
    assert (canvas[covered == 1] == picture()[covered == 1]).all()


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"piece_size": 0}, "too small"), ({"piece_size": -5}, "too small"), ({"piece_size": 80}, "at least 2"),
        ({"pieces": 1}, "at least 2"), ({"pieces": 100000}, "at most 432"), ({"pieces": 0}, "at least 2"),
        ({"pieces": 9, "piece_size": 9}, "not both"), ({"kind": "circles"}, "ways are"),
        ({"kind": "rectangles", "pieces": 5000}, "fewer pieces"), ({"kind": "rectangles", "piece_size": 9}, "no piece size"),
    ],
)  # fmt: skip
def test_what_cannot_be_cut_is_said(asked, words):
    with pytest.raises(BadInput, match=words):
        cut(picture(), **asked)


def test_a_picture_must_have_three_channels():
    with pytest.raises(BadInput, match="picture to be cut"):
        cut(np.zeros((40, 40)))
    with pytest.raises(BadInput, match="at least 2"):
        cut(np.zeros((1, 1, 3)))


@pytest.mark.parametrize("missing", [1.0, 0.99, -0.1])
def test_all_pieces_cannot_be_lost(missing):
    with pytest.raises(BadInput, match="lose fewer"):
        drop(*made("squares"), missing=missing, seed=0)


def test_large_pictures_are_cut_fast():
    large = np.zeros((123 * 28, 185 * 28, 3), dtype=np.uint8)
    start = time.perf_counter()
    assert cut(large, piece_size=28)[0].count == 22755
    assert time.perf_counter() - start < 10  # a second or so; a loop over all pixels takes minutes
