"""Folders of pieces: what was cut comes back; scanned pieces lose their ground; outlines are traced; one sentence each."""

import json

import numpy as np
import pytest
from PIL import Image

from engine.errors import BadInput
from engine.puzzles.cutting import cut
from engine.puzzles.imagefile import png_bytes
from engine.puzzles.piecefolder import equal_squares, image_files, read_pieces, write_pieces
from engine.puzzles.pieces import Piece, rectangle
from engine.puzzles.scenery import landscape
from engine.puzzles.tracing import boundary, trace, whole
from engine.puzzles.turning import turned_raster

PAPER = (246, 244, 240)


@pytest.fixture(scope="module")
def scene():
    return landscape(320, 256, seed=3)


def scanned(puzzle, folder, *, ground=PAPER, noise=2.0, quality=92):
    """Each piece on plain paper with a margin, a little noise, as JPEG."""
    rng = np.random.default_rng(0)
    for k, piece in enumerate(puzzle.pieces):
        h, w = piece.mask.shape
        page = np.full((h + 30, w + 40, 3), ground, dtype=float) + rng.normal(0, noise, (h + 30, w + 40, 3))
        page[12 : 12 + h, 17 : 17 + w][piece.mask] = piece.image[piece.mask]
        Image.fromarray(np.clip(page, 0, 255).astype(np.uint8)).save(folder / f"scan {k}.jpg", quality=quality)


@pytest.mark.parametrize(("kind", "px"), [("squares", 32), ("merged", 32), ("rectangles", None), ("triangles", 32)])
def test_what_was_cut_comes_back_exactly(scene, tmp_path, kind, px):
    puzzle, _ = cut(scene, kind=kind, piece_size=px, pieces=None if px else 12, turned=True, seed=2)
    paths = write_pieces(puzzle, tmp_path)
    found = read_pieces(tmp_path, turned=True)
    assert found.count == puzzle.count == len(paths)
    assert found.square == puzzle.square
    assert found.frame is None
    assert found.turned
    for old, new, path in zip(puzzle.pieces, found.pieces, paths, strict=True):
        assert np.array_equal(old.polygon, new.polygon)
        assert np.array_equal(old.mask, new.mask)
        assert np.array_equal(old.image, new.image)
        assert new.name == path.name
    assert (tmp_path / "pieces.json").exists() == (kind in ("merged", "triangles"))


@pytest.mark.parametrize(("kind", "off"), [("merged", 0.0), ("triangles", 0.51)])
def test_outlines_are_traced_where_no_file_gives_them(scene, tmp_path, kind, off):
    """Upright sides come out exact, slopes within the half pixel by which their steps stand beside the line."""
    puzzle, _ = cut(scene, kind=kind, piece_size=32, turned=True, seed=2)
    write_pieces(puzzle, tmp_path)
    (tmp_path / "pieces.json").unlink()
    for old, new in zip(puzzle.pieces, read_pieces(tmp_path).pieces, strict=True):
        y, x = (np.flatnonzero(old.mask.any(axis=axis))[0] for axis in (1, 0))
        v, u = (np.flatnonzero(new.mask.any(axis=axis))[0] for axis in (1, 0))
        assert len(new.polygon) == len(old.polygon)
        apart = np.abs((new.polygon - (u, v))[:, None] - (old.polygon - (x, y))[None]).max(axis=2).min(axis=1)
        assert apart.max() <= off
        assert np.array_equal(new.image[new.mask], old.image[old.mask])
        assert (new.polygon >= 0).all()
        assert (new.polygon <= new.mask.shape[::-1]).all()


def test_scanned_squares_lose_their_ground_and_are_squares_again(scene, tmp_path):
    """Also where a cloud at the border is as pale as the paper."""
    puzzle, _ = cut(scene, piece_size=64, seed=1)
    scanned(puzzle, tmp_path)
    found = read_pieces(tmp_path)
    assert found.square == 64
    off = np.abs(found.rasters().astype(int) - puzzle.rasters().astype(int))
    assert np.median(off) <= 4
    assert "plain ground" in found.notes[0]


def test_scanned_triangles_have_their_corners(scene, tmp_path):
    puzzle, _ = cut(scene, kind="triangles", piece_size=64, seed=1)
    scanned(puzzle, tmp_path, ground=(20, 20, 22))
    found = read_pieces(tmp_path)
    assert [len(piece.polygon) for piece in found.pieces] == [len(piece.polygon) for piece in puzzle.pieces]
    sides = [np.sort(np.hypot(*(np.roll(p.polygon, -1, axis=0) - p.polygon).T)) for p in found.pieces]
    true = [np.sort(np.hypot(*(np.roll(p.polygon, -1, axis=0) - p.polygon).T)) for p in puzzle.pieces]
    assert max(np.abs(a - b).max() for a, b in zip(sides, true, strict=True)) < 0.07 * 64


def test_a_dark_picture_of_squares_is_not_taken_for_plain_ground(tmp_path):
    """All borders are black, but what differs is strewn over the piece."""
    sky = np.zeros((96, 96, 3), dtype=np.uint8)
    stars = np.random.default_rng(0).integers(3, 29, (90, 2))
    for k, (x, y) in enumerate(stars):
        sky[(k % 3) * 32 + y, (k // 3 % 3) * 32 + x] = 255
    write_pieces(cut(sky, piece_size=32)[0], tmp_path)
    assert read_pieces(tmp_path).square == 32


def test_identical_pieces_are_still_a_puzzle(tmp_path):
    write_pieces(cut(np.full((64, 64, 3), 90, dtype=np.uint8), piece_size=16)[0], tmp_path)
    assert read_pieces(tmp_path).square == 16


def test_files_are_in_the_order_of_their_numbers_and_others_are_left_alone(tmp_path):
    for name in ("piece 10.png", "piece 9.png", "notes.txt", ".hidden.png", "A.PNG"):
        (tmp_path / name).write_bytes(png_bytes(np.zeros((4, 4, 3), dtype=np.uint8)))
    (tmp_path / "inner").mkdir()
    assert [path.name for path in image_files(tmp_path)] == ["A.PNG", "piece 9.png", "piece 10.png"]


def test_nearly_equal_squares_are_made_equal_and_others_left():
    def square(w, h):
        return Piece(rectangle(w, h), np.zeros((h, w, 3)), np.ones((h, w)))

    made, px = equal_squares([square(100, 101), square(99, 100), square(100, 102)])
    assert px == 100
    assert {piece.mask.shape for piece in made} == {(100, 100)}
    assert equal_squares([square(100, 100), square(100, 120)])[1] == 0
    assert equal_squares([square(100, 100)] * 2)[1] == 0


def folder_of(tmp_path, **images):
    for name, pixels in images.items():
        Image.fromarray(np.asarray(pixels, dtype=np.uint8)).save(tmp_path / f"{name}.png")
    return tmp_path


def two_dots():
    pixels = np.zeros((20, 40, 4))
    pixels[5:15, 5:15] = pixels[5:15, 25:35] = 255
    return pixels


GOOD = np.full((20, 20, 3), 50)


@pytest.mark.parametrize(
    ("images", "words"),
    [({}, "holds no images"), ({"a": GOOD}, "holds only one image"), ({"a": GOOD, "b": np.zeros((9, 9, 4))}, "b.png shows no piece"),
     ({"a": GOOD, "b": two_dots()}, "b.png shows more than one piece")],
)  # fmt: skip
def test_a_bad_folder_is_one_sentence(tmp_path, images, words):
    with pytest.raises(BadInput, match=words):
        read_pieces(folder_of(tmp_path, **images))


def test_the_unreadable_file_is_named(tmp_path):
    folder_of(tmp_path, a=GOOD, c=GOOD)
    (tmp_path / "b.png").write_bytes(b"\x89PNG\r\n\x1a\n nothing more")
    with pytest.raises(BadInput, match=r"b\.png is"):
        read_pieces(tmp_path)


def outlines(polygon, name="a.png"):
    return json.dumps({"schema": "concord.pieces/1", "pieces": [{"file": name, "polygon": polygon}]})


@pytest.mark.parametrize(
    "text",
    ["{", "[]", "{}", '{"schema": "concord.pieces/2", "pieces": []}', outlines([[0, 0], [1, 1]]), outlines("x"),
     outlines([[0, 0], [0, 9], [9, 9]]), outlines([[0, 0], [float("nan"), 0], [9, 9]]), outlines([[0, 0], [30, 0], [9, 9]])],
)  # fmt: skip
def test_damaged_outlines_are_one_sentence(tmp_path, text):
    folder_of(tmp_path, a=GOOD, b=GOOD)
    (tmp_path / "pieces.json").write_text(text)
    with pytest.raises(BadInput, match=r"pieces\.json"):
        read_pieces(tmp_path)


def test_pieces_are_not_written_among_other_images(scene, tmp_path):
    puzzle, _ = cut(scene, piece_size=64)
    folder_of(tmp_path, holiday=GOOD)
    with pytest.raises(BadInput, match="holds images already"):
        write_pieces(puzzle, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["holiday.png"]


# --- tracing


def test_the_boundary_of_an_l_runs_clockwise():
    mask = np.array([[1, 1], [1, 0]], dtype=bool)
    assert boundary(mask).tolist() == [[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2], [0, 1]]
    assert trace(mask.repeat(9, axis=0).repeat(9, axis=1), roughness=1.2).tolist() == [
        [0, 0], [18, 0], [18, 9], [9, 9], [9, 18], [0, 18]]  # fmt: skip


def test_pixels_that_touch_at_a_corner_are_two_things():
    body, second = whole(np.eye(2, dtype=bool))
    assert body.sum() == 1
    assert second == 1.0
    ring = np.ones((5, 5), dtype=bool)
    ring[2, 2] = False
    assert whole(ring)[0].all()


def drawn(corners, size=200):
    """The pixels whose centres lie inside a convex polygon, by half planes."""
    y, x = np.mgrid[:size, :size] + 0.5
    inside = np.ones((size, size), dtype=bool)
    for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        inside &= (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) >= 0
    return inside


TILTED = np.array([[60.0, 20], [180, 70], [140, 166], [20, 116]])


@pytest.mark.parametrize("turns", range(4))
def test_a_tilted_quadrilateral_has_its_four_corners_however_it_is_turned(turns):
    mask = turned_raster(drawn(TILTED), turns)
    found = trace(mask, roughness=1.2)
    true = TILTED - 100
    for _ in range(turns):
        true = np.column_stack([-true[:, 1], true[:, 0]])
    assert len(found) == 4
    assert np.abs(found[:, None] - (true + 100)[None]).max(axis=2).min(axis=1).max() < 0.8


def test_a_rough_border_gives_straight_sides():
    rng = np.random.default_rng(0)
    mask = drawn(TILTED)
    edge = np.zeros_like(mask)
    edge[1:-1, 1:-1] = (mask[1:-1, 1:-1] != mask[:-2, 1:-1]) | (mask[1:-1, 1:-1] != mask[1:-1, :-2])
    rough = whole(mask ^ (edge & (rng.random(mask.shape) < 0.4)))[0]
    found = trace(rough, roughness=3.0)
    assert len(found) == 4
    assert np.abs(found[:, None] - TILTED[None]).max(axis=2).min(axis=1).max() < 1.6
