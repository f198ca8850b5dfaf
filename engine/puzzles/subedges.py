"""The sides of polygonal pieces as strips of pixels at equal steps of arc length, the same number from both sides.

Samples at arc-length positions give two pieces the same number of pixels along a common slope, which rows of raster
pixels do not. On an upright or level side the samples are the pixel rows themselves (½ and 1½ px inwards); on a slope
they are mixed from the pixels around (1 and 2 px inwards), each weighted by whether it belongs to the piece.
"""

from dataclasses import dataclass

import numpy as np

from .pieces import Piece
from .turning import turned_polygon

SNAP = 1.01  # pixels that a traced corner may be off a level or upright side
LITTLE = 0.2  # share of the pixels around a sample below which it is taken from the nearest one


@dataclass(frozen=True, slots=True, eq=False)
class Sides:
    """The s sides of n polygonal pieces, piece by piece, and what is seen along them.

    `first` (n+1,) int64: piece i has the sides first[i]..first[i+1]-1, side k of its polygon being first[i]+k.
    `piece` (s,) int64. `start` and `end` (s, 4, 2) float64 are a side's corners in pixels of its piece's raster after
    0..3 clockwise quarter turns. `strip` (s+1,) int64: side e has the samples strip[e]..strip[e+1]-1, clockwise, of
    `outer` and `inner` (p, 3) float32 RGB in 0..255. `step` (s,) float64 is the arc length of a sample, `reach`
    (s,) float64 how far the outer samples lie inside the side, in pixels; the inner ones lie one pixel further in.
    """

    first: np.ndarray
    piece: np.ndarray
    start: np.ndarray
    end: np.ndarray
    strip: np.ndarray
    outer: np.ndarray
    inner: np.ndarray
    step: np.ndarray
    reach: np.ndarray

    def __len__(self) -> int:
        return len(self.piece)


def snapped(polygon: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """The corners (v, 2) with sides that are level or upright up to a pixel made exactly so, on whole pixels.

    `size` is the (w, h) of the raster; a side that is within a pixel of its border is put onto it.
    """
    corners = np.array(polygon, dtype=np.float64)
    for axis, extent in ((0, size[0]), (1, size[1])):
        values = corners[:, axis].copy()
        following = np.roll(values, -1)
        along = np.abs(np.roll(corners[:, 1 - axis], -1) - corners[:, 1 - axis])
        for k in np.flatnonzero((np.abs(values - following) <= SNAP) & (along > 4 * SNAP)):
            level = np.round((values[k] + following[k]) / 2)
            level = 0.0 if level <= SNAP else float(extent) if level >= extent - SNAP else level
            corners[[k, (k + 1) % len(corners)], axis] = level
    return corners


def sides_of(pieces: tuple[Piece, ...]) -> Sides:
    """Sample all sides of n pieces."""
    table = [_side_table(piece) for piece in pieces]
    counts = np.array([len(part[0]) for part in table])
    samples = np.concatenate([part[2] for part in table])
    return Sides(
        first=np.concatenate([[0], np.cumsum(counts)]),
        piece=np.repeat(np.arange(len(pieces)), counts),
        start=np.concatenate([part[0] for part in table]),
        end=np.concatenate([part[1] for part in table]),
        strip=np.concatenate([[0], np.cumsum(samples)]),
        outer=np.concatenate([part[3] for part in table]),
        inner=np.concatenate([part[4] for part in table]),
        step=np.concatenate([part[5] for part in table]),
        reach=np.concatenate([part[6] for part in table]),
    )


def _side_table(piece: Piece) -> tuple[np.ndarray, ...]:
    """Of one piece: starts and ends (v, 4, 2), samples (v,), outer and inner (p, 3), steps and reaches (v,)."""
    h, w = piece.mask.shape
    corners = snapped(piece.polygon, (w, h))
    start = np.stack([turned_polygon(corners, (w, h), t) for t in range(4)], axis=1)
    vector = np.roll(corners, -1, axis=0) - corners
    length = np.maximum(np.hypot(*vector.T), 1e-9)
    samples = np.maximum(np.round(length), 1).astype(np.int64)
    inward = np.stack([-vector[:, 1], vector[:, 0]], axis=1) / length[:, None]
    level = (np.abs(vector) < 1e-9).any(axis=1)
    side = np.repeat(np.arange(len(corners)), samples)
    along = (np.arange(len(side)) - np.repeat(np.cumsum(samples) - samples, samples) + 0.5) / samples[side]
    points = corners[side] + along[:, None] * vector[side]
    reach = np.where(level, 0.5, 1.0)
    depth = reach[side, None]
    outer, inner = (sampled(piece, points + (depth + more) * inward[side]) for more in (0, 1))
    return start, np.roll(start, -1, axis=0), samples, outer, inner, length / samples, reach


def sampled(piece: Piece, points: np.ndarray) -> np.ndarray:
    """Colours (p, 3) float32 at points (p, 2), mixed from the four pixels around that belong to the piece.

    Where hardly any does, as in a sharp corner, the colour is that of the nearest pixel that does.
    """
    h, w = piece.mask.shape
    colours, weight = np.zeros((len(points), 3)), np.zeros(len(points))
    x, y = points.T - 0.5
    left, top = np.floor(x + 1e-9).astype(int), np.floor(y + 1e-9).astype(int)
    for dy, dx in ((0, 0), (0, 1), (1, 0), (1, 1)):
        part = np.maximum(1 - np.abs(x - left - dx), 0) * np.maximum(1 - np.abs(y - top - dy), 0)
        row, column = np.clip(top + dy, 0, h - 1), np.clip(left + dx, 0, w - 1)
        part = part * (piece.mask[row, column] & (row == top + dy) & (column == left + dx))
        colours += part[:, None] * piece.image[row, column]
        weight += part
    colours /= np.maximum(weight, 1e-9)[:, None]
    for k in np.flatnonzero(weight < LITTLE):
        colours[k] = _nearest(piece, x[k], y[k])
    return colours.astype(np.float32)


def _nearest(piece: Piece, x: float, y: float) -> np.ndarray:
    """The colour of the pixel of the piece whose centre is nearest, (x, y) counted from the first pixel's centre."""
    rows, columns = np.nonzero(piece.mask)
    k = ((rows - y) ** 2 + (columns - x) ** 2).argmin()
    return piece.image[rows[k], columns[k]]
