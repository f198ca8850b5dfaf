"""Geometry in the plane: hulls, distances and areas."""

from __future__ import annotations

import numpy as np


def convex_hull(points: np.ndarray) -> np.ndarray:
    """Corners (h, 2) of the hull of points (q, 2), counter-clockwise (monotone chain); two for points on a line."""
    ordered = sorted({(float(x), float(y)) for x, y in points})
    if len(ordered) < 3:
        return np.array(ordered)
    return np.array(_half(ordered)[:-1] + _half(ordered[::-1])[:-1])


def _half(ordered: list[tuple[float, float]]) -> list[tuple[float, float]]:
    chain: list[tuple[float, float]] = []
    for p in ordered:
        while len(chain) > 1 and _turn(chain[-2], chain[-1], p) <= 0:
            chain.pop()
        chain.append(p)
    return chain


def _turn(o: tuple[float, float], a: tuple[float, float], b: tuple[float, float]) -> float:
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])


def distance_to_segments(point: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Distance (q,) of a point (2,) from the line segments a (q, 2) to b (q, 2)."""
    along = b - a
    length = np.maximum((along**2).sum(axis=1), 1e-12)
    share = np.clip(((point - a) * along).sum(axis=1) / length, 0.0, 1.0)
    return np.hypot(*(a + share[:, None] * along - point).T)


def contains(polygon: np.ndarray, point: np.ndarray) -> bool:
    """Whether a convex counter-clockwise polygon (h, 2) contains a point (2,)."""
    if len(polygon) < 3:
        return False
    side, to = np.roll(polygon, -1, axis=0) - polygon, point - polygon
    return bool((side[:, 0] * to[:, 1] - side[:, 1] * to[:, 0] >= 0).all())


def polygon_area(polygon: np.ndarray) -> float:
    """Area of a counter-clockwise polygon (h, 2)."""
    x, y = polygon.T
    return float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)))
