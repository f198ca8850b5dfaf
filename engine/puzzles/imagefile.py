"""Reading a stranger's image into RGBA pixels, and writing pixels as PNG."""

import io
import os
import struct
import warnings
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import BadInput

if TYPE_CHECKING:
    from PIL import Image

MOST_PIXELS = 100_000_000  # of one image; a photograph of 24 million pixels makes 22,755 pieces
FORMATS = ("PNG", "JPEG", "MPO", "TIFF", "BMP", "WEBP", "GIF", "PPM", "AVIF")
SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".webp", ".gif", ".ppm", ".pgm", ".pnm", ".avif")
# What Pillow's decoders are known to raise on damaged files.
_DAMAGE = (OSError, SyntaxError, ValueError, TypeError, LookupError, ArithmeticError, EOFError, AttributeError,
           RuntimeError, struct.error, zlib.error)  # fmt: skip
_ORIENTATION = 0x0112  # the EXIF tag that says how the camera was held


def read_image(path: Path | str) -> np.ndarray:
    """The pixels of an image file as people see them, (h, w, 4) uint8 RGBA.

    Grey, palette, CMYK and 16-bit images are converted, EXIF rotation is applied, an animation or a file of several
    pages gives its first. Raises `BadInput` for what is not an image, is damaged, or has more than `MOST_PIXELS`
    pixels, which is refused before anything is decoded.
    """
    path = Path(path)
    try:
        there, is_file = path.exists(), path.is_file()
    except OSError as error:
        raise BadInput(f"The image {path} cannot be opened ({error.strerror}); check the name.") from None
    if not there:
        raise BadInput(f"There is no file {path}; check the name.")
    if not is_file:
        raise BadInput(f"{path} is not a file; give an image such as PNG, JPEG, TIFF, BMP or WebP.")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return _decoded(path)


def _decoded(path: Path) -> np.ndarray:
    from PIL import Image, UnidentifiedImageError

    Image.init()
    try:
        with Image.open(path, formats=[name for name in FORMATS if name in Image.OPEN]) as image:
            if image.width * image.height > MOST_PIXELS:
                raise Image.DecompressionBombError
            with _quiet() if image.format == "TIFF" else nullcontext():
                image.load()
            return np.ascontiguousarray(_upright(_rgba(image), _orientation(image)))
    except Image.DecompressionBombError:
        limit = MOST_PIXELS // 10**6
        raise BadInput(f"The image {path} has more than {limit} million pixels; scale it down first.") from None
    except UnidentifiedImageError:
        raise BadInput(
            f"{path} is not an image that can be read; give PNG, JPEG, TIFF, BMP, WebP, GIF or PPM."
        ) from None
    except PermissionError:
        raise BadInput(f"The image {path} cannot be opened; you have no permission to read it.") from None
    except _DAMAGE:
        raise BadInput(f"The image {path} is damaged or cut off; save it again, for example as PNG.") from None


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep what C libraries print on the standard error to themselves: libtiff describes every damage there."""
    try:
        kept = os.dup(2)
    except OSError:  # there is no standard error
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


def _rgba(image: "Image.Image") -> np.ndarray:
    """The pixels of a decoded image of any mode, (h, w, 4) uint8."""
    if image.mode == "F" or image.mode.startswith("I"):
        return _deep_grey(np.asarray(image), image.info.get("transparency"))
    if image.mode not in ("1", "L", "LA", "P", "PA", "RGB", "RGBA", "RGBX"):
        image = image.convert("RGBA" if image.mode == "RGBa" else "LA" if image.mode == "La" else "RGB")
    return np.asarray(image.convert("RGBA"))


def _deep_grey(values: np.ndarray, transparent: object) -> np.ndarray:
    """Grey values of more than 8 bits as RGBA: scaled from [0, 1], 8 or 16 bits, else from the darkest to the brightest."""
    grey = np.nan_to_num(values.astype(np.float64), posinf=0.0, neginf=0.0)
    low, high = float(grey.min()), float(grey.max())
    if values.dtype.kind == "f" and low >= 0 and high <= 1:
        grey = grey * 255
    elif values.dtype.itemsize == 2 or (low >= 0 and 255 < high <= 65535):
        grey = grey / 257
    elif low < 0 or high > 65535:
        grey = (grey - low) * (255 / (high - low))
    seen = np.round(grey).astype(np.uint8)
    alpha = (
        np.where(values == transparent, 0, 255).astype(np.uint8)
        if isinstance(transparent, int)
        else np.full_like(seen, 255)
    )
    return np.dstack((seen, seen, seen, alpha))


def _orientation(image: "Image.Image") -> int:
    try:
        return int(image.getexif().get(_ORIENTATION, 1))
    except _DAMAGE:
        return 1  # the pixels are good, only the notes about them are not


def _upright(pixels: np.ndarray, orientation: int) -> np.ndarray:
    """Undo how the camera was held (EXIF 2.3, tag 274): 1 to 8, anything else is taken for 1."""
    if orientation in (5, 6, 7, 8):
        pixels = pixels.swapaxes(0, 1)
    if orientation in (3, 4, 7, 8):
        pixels = pixels[::-1]
    if orientation in (2, 3, 6, 7):
        pixels = pixels[:, ::-1]
    return pixels


def plain_text(name: str) -> str:
    """The name of a file as text that can be written: bytes that are no UTF-8 are replaced."""
    return name.encode("utf-8", "replace").decode("utf-8")


def opaque(rgba: np.ndarray) -> np.ndarray:
    """RGBA pixels laid on white, (h, w, 3) uint8."""
    if (rgba[..., 3] == 255).all():
        return np.ascontiguousarray(rgba[..., :3])
    alpha = rgba[..., 3:].astype(np.uint32)
    return ((rgba[..., :3] * alpha + 255 * (255 - alpha) + 127) // 255).astype(np.uint8)


def png_bytes(pixels: np.ndarray, *, effort: int = 4) -> bytes:
    """An array (h, w), (h, w, 3) or (h, w, 4) of uint8 as a PNG file; `effort` 0..9 trades time for size."""
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format="PNG", compress_level=effort)
    return buffer.getvalue()
