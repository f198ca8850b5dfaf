"""From the rings of a solid to triangles of even size."""

from itertools import pairwise

import numpy as np

from .solids import Solid

CORNER = np.cos(np.radians(35))
FEWEST_SIDES, MOST_SIDES = 12, 64


def loft(solid: Solid, edge: float) -> tuple[np.ndarray, np.ndarray]:
    """A closed triangle mesh of the solid: vertices (n, 3) float64, faces (m, 3) int64, outward, edges near `edge`."""
    angles = _angles(solid, edge)
    where = _ring_positions(solid, edge)
    points = _outlines(solid, angles)
    if solid.closed:
        points = np.concatenate([points, points[:1]])
    low = np.minimum(where.astype(int), len(points) - 2)
    t = (where - low)[:, None, None]
    rings = (1 - t) * points[low] + t * points[low + 1]
    vertices, faces = _stitch(rings[:-1] if solid.closed else rings, solid.closed)
    return vertices, faces if _volume(vertices, faces) > 0 else faces[:, ::-1].copy()


def _outlines(solid: Solid, angles: np.ndarray) -> np.ndarray:
    """Points of all rings at the angles (s,): (k, s, 3)."""
    cos, sin = np.cos(angles), np.sin(angles)
    exponent = 2 / solid.power
    x = (np.sign(cos) * np.abs(cos) ** exponent)[None, :, None] * solid.radii[:, None, :1] * solid.u[:, None, :]
    y = (np.sign(sin) * np.abs(sin) ** exponent)[None, :, None] * solid.radii[:, None, 1:] * solid.v[:, None, :]
    return solid.centres[:, None, :] + x + y


def _angles(solid: Solid, edge: float) -> np.ndarray:
    """Angles (s,) that divide the longest ring into equal lengths."""
    dense = np.linspace(0, 2 * np.pi, 721)
    ring = _outlines(solid, dense)[int(np.argmax(solid.radii.sum(axis=1)))]
    length = np.r_[0, np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))]
    sides = int(np.clip(round(length[-1] / edge), FEWEST_SIDES, MOST_SIDES))
    return np.interp(np.arange(sides) * length[-1] / sides, length, dense)


def _ring_positions(solid: Solid, edge: float) -> np.ndarray:
    """Fractional ring indices spaced by about `edge` along the surface, with every corner of the profile kept."""
    ring = _outlines(solid, np.arange(8) * np.pi / 4)
    if solid.closed:
        ring = np.concatenate([ring, ring[:1]])
    step = np.diff(ring, axis=0)
    length = np.linalg.norm(step, axis=2)
    along = np.r_[0, np.cumsum(np.maximum(length.mean(axis=1), 1e-9))]
    cosine = (step[:-1] * step[1:]).sum(axis=2) / np.maximum(length[:-1] * length[1:], 1e-12)
    corners = np.r_[0, 1 + np.flatnonzero(np.median(cosine, axis=1) < CORNER), len(ring) - 1]
    runs = [np.linspace(along[a], along[b], max(1, round((along[b] - along[a]) / edge)) + 1)[:-1]
            for a, b in pairwise(corners)]  # fmt: skip
    where = np.concatenate([*runs, along[-1:]])
    return np.asarray(np.interp(where, along, np.arange(len(ring))))


def _stitch(rings: np.ndarray, closed: bool) -> tuple[np.ndarray, np.ndarray]:
    """Join neighbouring rings (k, s, 3) by triangles along the shorter diagonal; end rings of radius 0 become poles."""
    k, s = rings.shape[:2]
    grid = np.arange(k * s).reshape(k, s)
    below = grid if closed else grid[:-1]
    above = np.roll(grid, -1, axis=0) if closed else grid[1:]
    a, b, c, d = (x.ravel() for x in (below, np.roll(below, -1, 1), np.roll(above, -1, 1), above))
    flat = rings.reshape(-1, 3)
    short = np.linalg.norm(flat[a] - flat[c], axis=1) <= np.linalg.norm(flat[b] - flat[d], axis=1)
    first = np.where(short[:, None], np.c_[a, b, c], np.c_[a, b, d])
    second = np.where(short[:, None], np.c_[a, c, d], np.c_[b, c, d])
    faces = np.stack([first, second], axis=1).reshape(-1, 3)
    if not closed:
        merge = np.arange(k * s)
        merge[:s], merge[-s:] = 0, (k - 1) * s
        faces = merge[faces]
        faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    used, faces = np.unique(faces, return_inverse=True)
    return flat[used], faces.reshape(-1, 3)


def _volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = (vertices[faces[:, j]] for j in range(3))
    return float((a * np.cross(b, c)).sum()) / 6
