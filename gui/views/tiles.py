"""Pictures of many shapes as tiles: drawn once, then coloured, lit up and picked as often as wanted without drawing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PySide6.QtGui import QImage

from ..palette import Theme, rgb, segment_colours
from .cameras import direction, fitting_distance, look_from
from .pane import Pane
from .scene import Scene

FINE = 2  # pixels of a tile for each of the picture, along either side
WHITE = 214
_GROUND = -1
_HEIGHT, _TURN = 20.0, 30.0


@dataclass(frozen=True, slots=True, eq=False)
class Tile:
    """How light each pixel of a shape is, (h, w) uint8 with `WHITE` for its own colour, and its segment or -1, int16 or int32."""

    light: np.ndarray
    segments: np.ndarray


class TileMaker:
    """Draws the tiles of shapes, one after the other, with one off-screen window. `close` it before its owner goes."""

    def __init__(self, theme: Theme) -> None:
        self._pane = Pane(theme)

    def tile(self, scene: Scene, size: int, turn: float = 0.0) -> Tile:
        """A square tile of `size` pixels, `turn` degrees around the upright axis from the usual view."""
        pane, side = self._pane, FINE * size
        pane.set_scene(scene)
        pane.set_colours(np.full((scene.count, 3), WHITE, np.uint8))
        towards = direction(_HEIGHT, _TURN + turn)
        pane.camera = look_from(towards, fitting_distance(scene, towards, 1.0))
        image = pane.image(side, side, moving=True)
        seen = np.frombuffer(image.constBits(), np.uint8).reshape(side, side, 4)[..., 0].copy()
        return Tile(seen, pane.segment_map(side, side).astype(np.int16 if scene.count < 2**15 else np.int32))

    def close(self) -> None:
        """Give the window back."""
        self._pane.close()


def part_colours(parts: np.ndarray, theme: Theme, lit: int = -1) -> np.ndarray:
    """Colours (s, 3) uint8 of segments by their part; no part is faded, and all others but `lit` where one is lit."""
    table = segment_colours(int(parts.max(initial=-1)) + 1)
    out = np.broadcast_to(rgb(theme.faded), (len(parts), 3)).copy()
    chosen = (parts == lit) if lit >= 0 else parts >= 0
    out[chosen] = table[parts[chosen]]
    return out


def groups(parts: np.ndarray) -> np.ndarray:
    """Number (s,) of what each segment is drawn in one piece with: its part, or only itself where it has none."""
    own = -2 - np.arange(len(parts))
    return np.where(parts >= 0, parts, own)


def coloured(tile: Tile, colours: np.ndarray, group: np.ndarray, theme: Theme) -> QImage:
    """The tile in the colours (s, 3) of its segments, with lines between pixels of different groups (s,)."""
    h, w = tile.segments.shape
    table = np.concatenate([colours, rgb(theme.paper)[None]]).astype(np.float32)  # row -1 is the ground
    light = np.where(tile.segments >= 0, tile.light.astype(np.float32) / WHITE, np.float32(1))
    numbers = np.unique(group, return_inverse=True)[1].astype(np.int32)
    light[_lines(np.append(numbers, np.int32(_GROUND))[tile.segments])] *= 0.35 if theme.dark else 0.45
    small = np.zeros((h // FINE, w // FINE, 3), np.float32)
    for y in range(FINE):
        for x in range(FINE):
            small += np.minimum(table[tile.segments[y::FINE, x::FINE]] * light[y::FINE, x::FINE, None], 255)
    pixels = np.ascontiguousarray((small / FINE**2).astype(np.uint8))
    return QImage(pixels.data, w // FINE, h // FINE, 3 * (w // FINE), QImage.Format.Format_RGB888).copy()


def segment_at(tile: Tile, x: float, y: float) -> int:
    """The segment at a place in shares of the tile's sides, or -1 for none."""
    h, w = tile.segments.shape
    column, row = int(x * w), int(y * h)
    return int(tile.segments[row, column]) if 0 <= row < h and 0 <= column < w else -1


def _lines(group: np.ndarray) -> np.ndarray:
    """Pixels (h, w) bool where the surface passes from one group to another; the outline of the shape is none."""
    out = np.zeros(group.shape, bool)
    for axis in (0, 1):
        a, b = np.moveaxis(group, axis, 0)[:-1], np.moveaxis(group, axis, 0)[1:]
        differ = (a != b) & (a != _GROUND) & (b != _GROUND)
        view = np.moveaxis(out, axis, 0)
        view[:-1] |= differ
        view[1:] |= differ
    return out
