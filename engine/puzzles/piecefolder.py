"""A folder of piece images as a puzzle without truth, and a puzzle as such a folder."""

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import BadInput
from ..progress import Progress, silent
from ..store import output_folder, write_together
from .imagefile import SUFFIXES, plain_text, png_bytes, read_image
from .masks import SEEN, is_rectangle, plain_ground, polygon_of, standing_out, unbitten, without_rough_border
from .pieces import Piece, Puzzle, rectangle
from .tracing import whole
from .turning import from_the_top

SCHEMA, OUTLINES = "concord.pieces/1", "pieces.json"
MOST_PIXELS = 400_000_000  # of all images of a folder together
SECOND_PART = 0.2  # the share of a piece that cannot be dust


def read_pieces(folder: Path | str, *, turned: bool = False, progress: Progress = silent) -> Puzzle:
    """The puzzle in a folder: one piece an image, on a transparent or a plain ground, or filling its image.

    Files that are no images by their name are left alone. A `pieces.json` beside them (schema concord.pieces/1) gives
    exact outlines; without it, they are traced. Squares of nearly the same size are scaled to the same size. Raises
    `BadInput` in one sentence that names the file.
    """
    folder = Path(folder)
    paths = image_files(folder)
    if len(paths) < 2:
        found = f"only one image ({paths[0].name})" if paths else "no images"
        raise BadInput(f"The folder {folder} holds {found}; a puzzle takes at least 2 pieces, one image each.")
    outlines = _read_outlines(folder / OUTLINES)
    images = _read_all(paths, progress)
    seen = any((image[..., 3] < SEEN).any() for image in images)
    ground = None if seen or outlines else plain_ground(images)
    pieces = []
    for k, (path, image) in enumerate(zip(paths, images, strict=True)):
        progress(0.7 + 0.3 * k / len(paths), "tracing the pieces")
        pieces.append(
            _outlined(path, image, outlines[path.name]) if path.name in outlines else _cropped(path, image, ground)
        )
    notes = [] if ground is None else [f"The plain ground of the images, {_hex(ground[0])}, was taken away."]
    if ground is not None or seen:
        pieces, scaled = equal_squares(pieces)
        notes += [f"The pieces were scaled to {scaled} × {scaled} pixels."] if scaled else []
    return Puzzle(tuple(pieces), turned=turned, name=plain_text(folder.resolve().name) or "pieces", notes=tuple(notes))


def image_files(folder: Path | str) -> list[Path]:
    """The images in a folder by their names, 2 before 10; raises `BadInput` where it cannot be listed."""
    try:
        paths = [p for p in Path(folder).iterdir() if p.suffix.lower() in SUFFIXES and not p.name.startswith(".")]
    except OSError as error:
        raise BadInput(f"The folder {folder} cannot be listed ({error.strerror}); check the name.") from None
    return sorted(
        paths, key=lambda p: [(int(t), "") if t.isdecimal() else (-1, t) for t in re.split(r"(\d{1,18})", p.name)]
    )


def _read_all(paths: Sequence[Path], progress: Progress) -> list[np.ndarray]:
    images, total = [], 0
    for k, path in enumerate(paths):
        progress(0.7 * k / len(paths), "reading the pieces")
        images.append(read_image(path))
        total += images[-1].shape[0] * images[-1].shape[1]
        if total > MOST_PIXELS:
            limit = MOST_PIXELS // 10**6
            raise BadInput(f"The images in {path.parent} have more than {limit} million pixels; scale them down first.")
    return images


def _cropped(path: Path, image: np.ndarray, ground: tuple[np.ndarray, float] | None) -> Piece:
    """A piece without the ground around it."""
    seen = image[..., 3] >= SEEN if ground is None else standing_out(image, *ground)
    body, second = whole(seen)
    if not body.any():
        raise BadInput(f"The image {path} shows no piece, it is wholly transparent; remove it from the folder.")
    if second > SECOND_PART:
        raise BadInput(f"The image {path} shows more than one piece; give one image for each, on a ground unlike it.")
    rows, columns = _bounds(body)
    image, body, seen = image[rows, columns], body[rows, columns], seen[rows, columns]
    if is_rectangle(body):
        return _rectangular(plain_text(path.name), image[without_rough_border(body)])
    if ground is None:
        return _fitting(polygon_of(body, scanned=False), image, body & seen, plain_text(path.name))
    body = unbitten(body)
    if is_rectangle(body):
        return _rectangular(plain_text(path.name), image)
    return _fitting(polygon_of(body, scanned=True), image, body, plain_text(path.name))


def _rectangular(name: str, image: np.ndarray) -> Piece:
    h, w = image.shape[:2]
    return Piece(rectangle(w, h), image[..., :3], np.ones((h, w), dtype=bool), name)


def _bounds(mask: np.ndarray) -> tuple[slice, slice]:
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)


def _fitting(polygon: np.ndarray, image: np.ndarray, mask: np.ndarray, name: str) -> Piece:
    """A piece whose raster is grown, where it must be, to hold its polygon, and is black outside its mask."""
    h, w = mask.shape
    low = np.minimum(np.floor(polygon.min(axis=0)), 0).astype(int)
    high = np.maximum(np.ceil(polygon.max(axis=0)), (w, h)).astype(int)
    pad = ((-low[1], high[1] - h), (-low[0], high[0] - w))
    pixels = np.where(mask[..., None], image[..., :3], 0).astype(np.uint8)
    return Piece(polygon - low, np.pad(pixels, (*pad, (0, 0))), np.pad(mask, pad), name)


def _outlined(path: Path, image: np.ndarray, polygon: np.ndarray) -> Piece:
    """A piece whose outline is known, its raster as it stands in the file."""
    h, w = image.shape[:2]
    mask = image[..., 3] >= SEEN
    if (polygon < 0).any() or (polygon > (w, h)).any() or not mask.any():
        raise BadInput(
            f"The outline of {path.name} in {path.parent / OUTLINES} does not fit its image of {w} × {h} pixels."
        )
    return Piece(from_the_top(polygon), np.where(mask[..., None], image[..., :3], 0), mask, plain_text(path.name))


def equal_squares(pieces: Sequence[Piece]) -> tuple[list[Piece], int]:
    """The pieces scaled to one size if all are nearly equal squares, and that size; else as they are, and 0."""
    sides = np.array([piece.mask.shape for piece in pieces])
    px = round(float(np.median(sides)))
    if (
        not all(piece.mask.all() for piece in pieces)
        or np.abs(sides - px).max() > max(2, 0.04 * px)
        or not np.ptp(sides)
    ):
        return list(pieces), 0
    import cv2

    scaled = [np.asarray(cv2.resize(piece.image, (px, px), interpolation=cv2.INTER_LINEAR)) for piece in pieces]
    full = np.ones((px, px), dtype=bool)
    return [Piece(rectangle(px, px), image, full, piece.name) for piece, image in zip(pieces, scaled, strict=True)], px


def write_pieces(puzzle: Puzzle, folder: Path | str, *, progress: Progress = silent) -> list[Path]:
    """Write every piece as a PNG file, transparent outside its polygon, all or none; returns the paths.

    Outlines that a reader could not see in the pixels go to `pieces.json`. The folder must hold no images yet, or
    they would be taken for pieces. The reader gets the pieces in the same order.
    """
    folder = output_folder(folder)
    if image_files(folder) or (folder / OUTLINES).exists():
        raise BadInput(
            f"The folder {folder} holds images already, which would mix with the pieces; choose an empty one."
        )
    digits, contents, outlines = len(str(puzzle.count)), dict[Path, bytes | str](), []
    for k, piece in enumerate(puzzle.pieces):
        progress(k / puzzle.count, "writing the pieces")
        path = folder / f"piece-{k + 1:0{digits}}.png"
        alpha = np.where(piece.mask, 255, 0).astype(np.uint8)
        contents[path] = png_bytes(piece.image if piece.mask.all() else np.dstack((piece.image, alpha)))
        outlines.append({"file": path.name, "polygon": piece.polygon.tolist()})
    written = list(contents)
    if not all(piece.mask.all() for piece in puzzle.pieces):
        contents[folder / OUTLINES] = json.dumps({"schema": SCHEMA, "pieces": outlines}) + "\n"
    write_together(contents, synced=False)
    return written


def _read_outlines(path: Path) -> dict[str, np.ndarray]:
    """Outlines by the names of the files, from a `pieces.json` if there is one."""
    if not path.exists():
        return {}
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        found = {str(entry["file"]): _polygon(entry["polygon"]) for entry in content["pieces"]}
        if content["schema"] != SCHEMA:
            raise ValueError
    except OSError as error:
        raise BadInput(f"The outlines {path} cannot be read ({error.strerror}); make the file readable.") from None
    except (ValueError, TypeError, KeyError, RecursionError):
        raise BadInput(
            f"{path} does not hold outlines of schema {SCHEMA}; remove it, and they will be traced."
        ) from None
    return found


def _polygon(rows: Any) -> np.ndarray:
    """A clockwise polygon of at least three finite corners, or a `ValueError`."""
    polygon = np.array(rows, dtype=np.float64)
    if polygon.ndim != 2 or polygon.shape[1] != 2 or len(polygon) < 3 or not np.isfinite(polygon).all():
        raise ValueError
    following = np.roll(polygon, -1, axis=0)
    if (polygon[:, 0] * following[:, 1] - polygon[:, 1] * following[:, 0]).sum() <= 0:
        raise ValueError
    return polygon


def _hex(colour: np.ndarray) -> str:
    return "#" + "".join(f"{round(float(c)):02x}" for c in colour)
