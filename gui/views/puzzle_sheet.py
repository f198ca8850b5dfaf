"""The pixels of a laid-out puzzle as one image with smaller copies of itself, warped onto the screen in a millisecond."""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from engine.puzzles.pieces import Puzzle

from .puzzle_layout import Layout
from .puzzle_scene import View

MOST_PIXELS = 24_000_000  # of the sheet; larger puzzles are kept smaller, and sharpened piece by piece from close by
SMALLEST_LEVEL = 32
MOST_SHARPENED = 80  # pieces that are drawn one by one where the sheet is too coarse
CRISP = 2.0  # screen pixels for one of a piece from which on pixels are shown as squares


@lru_cache(maxsize=2)
def rasters(puzzle: Puzzle) -> tuple[np.ndarray, ...]:
    """All pieces as premultiplied BGRA (h, w, 4) uint8, as Qt paints them."""
    made = []
    for piece in puzzle.pieces:
        raster = np.empty((*piece.mask.shape, 4), np.uint8)
        raster[..., :3], raster[..., 3] = piece.image[..., ::-1], 255
        if not piece.mask.all():
            raster[~piece.mask] = 0
        made.append(raster)
    return tuple(made)


@lru_cache(maxsize=2)
def filled(puzzle: Puzzle) -> tuple[bool, ...]:
    """Which pieces fill their rasters."""
    return tuple(bool(piece.mask.all()) for piece in puzzle.pieces)


@dataclass(slots=True, eq=False)
class Sheet:
    """All pieces of a layout at `scale` (at most 1) from `origin` on; `levels[k]` is 2^k times smaller."""

    layout: Layout
    origin: tuple[float, float]
    scale: float
    levels: list[np.ndarray] = field(default_factory=list)

    def paste(self, piece: int, layout: Layout) -> None:
        """Put one piece where a layout has it; `refresh` makes it seen from afar."""
        raster = np.rot90(rasters(layout.puzzle)[piece], -int(layout.turns[piece]))
        x, y = ((layout.position[piece] - self.origin) * self.scale).round().astype(int)
        raster = _resized(raster, self.scale)
        h, w = raster.shape[:2]
        part = self.levels[0][y : y + h, x : x + w]
        raster = raster[: part.shape[0], : part.shape[1]]
        if filled(layout.puzzle)[piece]:
            part[...] = raster
        else:
            np.copyto(part, raster, where=raster[..., 3:] > 0)

    def clear(self, piece: int, layout: Layout) -> None:
        """Take one piece away from where a layout has it, with its box."""
        x, y = ((layout.position[piece] - self.origin) * self.scale).round().astype(int)
        w, h = np.ceil(layout.size[piece] * self.scale).astype(int)
        self.levels[0][max(y, 0) : y + h, max(x, 0) : x + w] = 0

    def lift(self, pieces: frozenset[int]) -> None:
        """Take pieces away and draw again what their boxes hid."""
        self._clear_all(pieces, self.layout, self.layout)
        self.refresh()

    def _clear_all(self, pieces: frozenset[int], old: Layout, new: Layout) -> None:
        """Clear the boxes of pieces in an old layout, and draw again what else a new one has there."""
        low, high = new.position, new.position + new.size
        start, stop = old.position, old.position + old.size
        hidden: set[int] = set()
        for piece in pieces:
            self.clear(piece, old)
            hidden |= set(np.flatnonzero(((low < stop[piece]) & (high > start[piece])).all(axis=1)).tolist())
        for other in sorted(hidden - pieces, key=lambda k: (bool(new.placed[k]), k)):
            self.paste(other, new)

    def follow(self, layout: Layout) -> bool:
        """Show another layout of the same puzzle by moving what differs; False where drawing all is as quick."""
        old = self.layout
        if old.puzzle is not layout.puzzle or (layout.box.x, layout.box.y) != self.origin or self.scale < 1:
            return False
        differs = (old.position != layout.position).any(axis=1) | (old.turns != layout.turns)
        moved = frozenset(np.flatnonzero(differs).tolist())
        if _scale(layout) < 1 or 4 * len(moved) > len(differs):
            return False
        self._clear_all(moved, old, layout)
        before, size = self.levels[0], _size(layout, 1.0)
        if before.shape != size:
            self.levels[0] = np.zeros(size, np.uint8)
            h, w = np.minimum(before.shape[:2], size[:2])
            self.levels[0][:h, :w] = before[:h, :w]
        for piece in sorted(moved, key=lambda k: (bool(layout.placed[k]), k)):
            self.paste(piece, layout)
        self.layout = layout
        self.refresh()
        return True

    def refresh(self) -> None:
        """Make the smaller copies again."""
        import cv2

        del self.levels[1:]
        while min(self.levels[-1].shape[:2]) > SMALLEST_LEVEL:
            self.levels.append(cv2.resize(self.levels[-1], None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA))

    def warped(self, view: View, width: int, height: int, ratio: float = 1.0) -> np.ndarray:
        """What a window of `width` × `height` device pixels sees, premultiplied BGRA (height, width, 4) uint8.

        `ratio` is the number of device pixels for one of the view's.
        """
        import cv2

        zoom = view.scale * ratio / self.scale
        level = int(np.clip(np.floor(-np.log2(max(zoom, 1e-9))), 0, len(self.levels) - 1))
        picture = self.levels[level]
        step_x, step_y = self.levels[0].shape[1] / picture.shape[1], self.levels[0].shape[0] / picture.shape[0]
        x, y = view.to_screen(np.array(self.origin)) * ratio
        matrix = _warp(zoom * step_x, zoom * step_y, x, y)
        flags = cv2.INTER_NEAREST if zoom >= CRISP else cv2.INTER_LINEAR
        seen = cv2.warpAffine(picture, matrix, (width, height), flags=flags, borderMode=cv2.BORDER_CONSTANT)
        if self.scale < 1 and view.scale * ratio > self.scale:
            self._sharpen(seen, view, ratio)
        return seen

    def _sharpen(self, seen: np.ndarray, view: View, ratio: float) -> None:
        """Draw the pieces in sight from their own pixels, unless they are many."""
        import cv2

        layout, scale = self.layout, view.scale * ratio
        low = view.to_screen(layout.position) * ratio
        high = low + layout.size * scale
        rows = np.flatnonzero(((high > 0) & (low < (seen.shape[1], seen.shape[0]))).all(axis=1))
        if len(rows) > MOST_SHARPENED:
            return
        flags = cv2.INTER_NEAREST if scale >= CRISP else cv2.INTER_LINEAR
        for piece in rows.tolist():
            raster = np.rot90(rasters(layout.puzzle)[piece], -int(layout.turns[piece]))
            (x0, y0), (x1, y1) = np.floor(low[piece]).astype(int), np.ceil(high[piece]).astype(int)
            x, y, right, below = max(x0, 0), max(y0, 0), min(x1, seen.shape[1]), min(y1, seen.shape[0])
            matrix = _warp(scale, scale, low[piece][0] - x, low[piece][1] - y)
            drawn = cv2.warpAffine(np.ascontiguousarray(raster), matrix, (right - x, below - y), flags=flags,
                                   borderMode=cv2.BORDER_CONSTANT)  # fmt: skip
            np.copyto(seen[y:below, x:right], drawn, where=drawn[..., 3:] == 255)


def compose(layout: Layout) -> Sheet:
    """All pieces of a layout as a sheet, those in pictures above those in the tray."""
    scale = _scale(layout)
    sheet = Sheet(layout, (layout.box.x, layout.box.y), scale, [np.zeros(_size(layout, scale), np.uint8)])
    for piece in (*np.flatnonzero(~layout.placed).tolist(), *np.flatnonzero(layout.placed).tolist()):
        sheet.paste(piece, layout)
    sheet.refresh()
    return sheet


def _scale(layout: Layout) -> float:
    return min(1.0, (MOST_PIXELS / max(layout.box.w * layout.box.h, 1)) ** 0.5)


def _size(layout: Layout, scale: float) -> tuple[int, int, int]:
    return int(np.ceil(layout.box.h * scale)) + 1, int(np.ceil(layout.box.w * scale)) + 1, 4


def _warp(zoom_x: float, zoom_y: float, x: float, y: float) -> np.ndarray:
    """The matrix (2, 3) that puts the corner of an image at (x, y); cv2 counts from the centres of pixels."""
    return np.array([[zoom_x, 0, x + (zoom_x - 1) / 2], [0, zoom_y, y + (zoom_y - 1) / 2]])


def _resized(raster: np.ndarray, scale: float) -> np.ndarray:
    if scale == 1:
        return raster
    import cv2

    h, w = raster.shape[:2]
    size = (max(1, int(np.ceil(w * scale))), max(1, int(np.ceil(h * scale))))
    return cv2.resize(np.ascontiguousarray(raster), size, interpolation=cv2.INTER_AREA)
