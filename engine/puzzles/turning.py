"""Quarter turns of pieces: rasters, polygons and whole pieces, clockwise as seen (y down)."""

import numpy as np

from .pieces import Piece


def turned_raster(raster: np.ndarray, turns: int) -> np.ndarray:
    """A raster (h, w, ...) after clockwise quarter turns."""
    return np.rot90(raster, -turns)


def turned_polygon(polygon: np.ndarray, size: tuple[int, int], turns: int) -> np.ndarray:
    """The corners (v, 2) in the raster turned clockwise; `size` is (w, h) before. The order of corners stays."""
    w, h = size
    for _ in range(turns % 4):
        polygon = np.column_stack([h - polygon[:, 1], polygon[:, 0]])
        w, h = h, w
    return polygon


def from_the_top(polygon: np.ndarray) -> np.ndarray:
    """The same clockwise polygon (v, 2), its first corner the topmost and then leftmost."""
    return np.roll(polygon, -np.lexsort((polygon[:, 0], polygon[:, 1]))[0], axis=0)


def turned_piece(piece: Piece, turns: int) -> Piece:
    """A piece after clockwise quarter turns; its sides are counted anew from the topmost, leftmost corner."""
    h, w = piece.mask.shape
    polygon = from_the_top(turned_polygon(piece.polygon, (w, h), turns))
    return Piece(polygon, turned_raster(piece.image, turns), turned_raster(piece.mask, turns), piece.name)


def turned_vectors(vectors: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Vectors (k, 2), y down, after clockwise quarter turns (k,)."""
    x, y, t = vectors[:, 0], vectors[:, 1], turns % 4
    return np.stack([np.choose(t, [x, -y, -x, y]), np.choose(t, [y, x, -y, -x])], axis=1)
