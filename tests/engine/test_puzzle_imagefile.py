"""Strangers' images: every mode, depth and turn gives the pixels that people see, or one sentence."""

import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from engine.errors import BadInput
from engine.puzzles.imagefile import opaque, png_bytes, read_image

CORNERS = np.array([[[255, 0, 0], [0, 255, 0], [9, 9, 9]], [[0, 0, 255], [255, 255, 255], [99, 99, 99]]], dtype=np.uint8)


def saved(tmp_path, image, name="a.png", **how):
    image.save(tmp_path / name, **how)
    return read_image(tmp_path / name)


def test_colours_come_back_as_they_are(tmp_path):
    for name in ("a.png", "a.tif", "a.bmp", "a.ppm", "a.webp"):
        pixels = saved(tmp_path, Image.fromarray(CORNERS), name, **({"lossless": True} if name == "a.webp" else {}))
        assert np.array_equal(pixels[..., :3], CORNERS), name
        assert (pixels[..., 3] == 255).all()


@pytest.mark.parametrize("name", ["a.png", "a.tif"])
def test_16_bit_grey_is_scaled_not_cut(tmp_path, name):
    grey = np.array([[0, 257, 32896, 65535]], dtype=np.uint16)
    assert saved(tmp_path, Image.fromarray(grey), name)[0, :, 0].tolist() == [0, 1, 128, 255]


@pytest.mark.parametrize(
    ("values", "seen"),
    [([0.0, 0.5, 1.0], [0, 128, 255]), ([0.0, 128.0, 255.0], [0, 128, 255]), ([-10.0, 0.0, 10.0], [0, 128, 255]),
     ([0.0, np.nan, 65535.0], [0, 0, 255])],
)  # fmt: skip
def test_real_valued_images_are_scaled_by_their_range(tmp_path, values, seen):
    pixels = saved(tmp_path, Image.fromarray(np.array([values], dtype=np.float32)), "a.tif")
    assert pixels[0, :, 1].tolist() == seen


def test_grey_palette_and_cmyk_have_the_colours_people_see(tmp_path):
    assert saved(tmp_path, Image.fromarray(CORNERS[..., 0]))[0, 0].tolist() == [255, 255, 255, 255]
    palette = Image.fromarray(CORNERS).convert("P", palette=Image.Palette.ADAPTIVE)
    assert np.array_equal(saved(tmp_path, palette, "a.gif")[..., :3], CORNERS)
    assert np.array_equal(saved(tmp_path, Image.fromarray(CORNERS).convert("CMYK"), "b.tif")[..., :3], CORNERS)


def test_transparency_of_every_kind_is_seen(tmp_path):
    rgba = np.dstack((CORNERS, np.array([[0, 128, 255]] * 2, dtype=np.uint8)))
    assert np.array_equal(saved(tmp_path, Image.fromarray(rgba)), rgba)
    assert saved(tmp_path, Image.fromarray(CORNERS), transparency=(255, 0, 0))[..., 3].tolist() == [[0, 255, 255], [255] * 3]
    grey = np.array([[0, 700]], dtype=np.uint16)
    assert saved(tmp_path, Image.fromarray(grey), transparency=700)[..., 3].tolist() == [[255, 0]]


def test_half_transparent_pixels_are_laid_on_white():
    assert opaque(np.array([[[10, 20, 30, 255], [0, 0, 0, 0], [0, 0, 0, 128]]], dtype=np.uint8)).tolist() == [
        [[10, 20, 30], [255, 255, 255], [127, 127, 127]]
    ]


@pytest.mark.parametrize("orientation", range(1, 9))
def test_the_camera_is_held_upright(tmp_path, orientation):
    """Pillow's own turning is the witness."""
    from PIL import ImageOps

    exif = Image.Exif()
    exif[0x0112] = orientation
    pixels = saved(tmp_path, Image.fromarray(CORNERS), "a.tif", exif=exif)
    with Image.open(tmp_path / "a.tif") as image:
        assert np.array_equal(pixels[..., :3], np.asarray(ImageOps.exif_transpose(image)))
    assert pixels.shape[:2] == ((3, 2) if orientation > 4 else (2, 3))


def test_an_animation_gives_its_first_picture(tmp_path):
    frames = [Image.new("RGB", (4, 3), colour) for colour in ("red", "blue")]
    pixels = saved(tmp_path, frames[0], "a.gif", save_all=True, append_images=frames[1:])
    assert pixels.shape == (3, 4, 4)
    assert pixels[0, 0].tolist() == [255, 0, 0, 255]


def test_a_written_png_comes_back(tmp_path):
    (tmp_path / "a.png").write_bytes(png_bytes(CORNERS))
    assert np.array_equal(read_image(tmp_path / "a.png")[..., :3], CORNERS)


def huge_png(width, height, rows=None):
    """A PNG of black grey pixels that is small on disk; valid, or with fewer rows than it says."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    deflate = zlib.compressobj(1)
    hundred = bytes(100 * (width + 1))
    data = b"".join(deflate.compress(hundred) for _ in range((rows or height) // 100)) + deflate.flush()
    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


@pytest.mark.parametrize("size", [(30_000, 30_000), (11_000, 10_000)])
def test_a_huge_image_is_refused_before_it_is_decoded(tmp_path, size):
    import tracemalloc

    (tmp_path / "huge.png").write_bytes(huge_png(*size))
    read_image_of_one_pixel = tmp_path / "one.png"
    Image.new("RGB", (1, 1)).save(read_image_of_one_pixel)
    read_image(read_image_of_one_pixel)  # what Pillow loads at first use is not counted
    tracemalloc.start()
    with pytest.raises(BadInput, match="more than 100 million pixels; scale it down"):
        read_image(tmp_path / "huge.png")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 5_000_000


def test_what_is_no_image_is_one_sentence(tmp_path):
    (tmp_path / "words.png").write_text("hello")
    Image.fromarray(np.random.default_rng(0).integers(0, 255, (50, 50, 3), dtype=np.uint8)).save(tmp_path / "a.png")
    (tmp_path / "cut.png").write_bytes((tmp_path / "a.png").read_bytes()[:2000])
    for name, words in (("words.png", "is not an image"), ("cut.png", "damaged or cut off"), ("none.png", "There is no file"),
                        (".", "is not a file")):  # fmt: skip
        with pytest.raises(BadInput, match=words) as caught:
            read_image(tmp_path / name)
        assert str(tmp_path / name) in str(caught.value)
        assert "\n" not in str(caught.value)
