"""Shape distributions D1, D2, D3, D4 and A3 (Osada, Funkhouser, Chazelle & Dobkin 2002) of unions of segments.

Surface points are drawn once for each segment; a union's tuples of points are taken from the points of its segments,
by area, along one fixed sequence that covers the unit cube evenly. So a union of segments is described by the points
that describe its segments, and 1000 nodes take a fraction of a second.
"""

import numpy as np
from numba import njit, prange

from .segmentation import SegmentedShape
from .segmentgraph import sample_surface

DISTRIBUTIONS = ("d1", "d2", "d3", "d4", "a3")
BINS = 64
TUPLES = 2048
POINTS = 8192
_LEAST = 128  # points of the smallest segment
_LONGEST = np.array([2.5, 3.5, 2.0, 1.2, 1.0])  # where the last bin ends: radii (D1 to D4), half turns (A3)


def shape_distributions(
    shape: SegmentedShape, members: np.ndarray, area: np.ndarray, *, seed: int
) -> dict[str, np.ndarray]:
    """Histograms that sum to 1, (k, 64) float32 each, of the unions `members` (k, s); `area` (s,) of the segments.

    D1: distance of a surface point from the union's centroid; D2: of two points; D3: root of the area of the triangle
    of three; D4: cube root of the volume of the tetrahedron of four; A3: angle of three. Lengths are in units of the
    union's own root mean square distance from its centroid, so that neither size nor pose matters. A value between the
    middles of two bins counts in both, by how near it is.
    """
    points, owner = sample_surface(shape, POINTS, seed, least=_LEAST)
    points = points - points.mean(axis=0)
    start = np.searchsorted(owner, np.arange(members.shape[1] + 1))
    centre, radius = _frames(points, start, members, area)
    found = _histograms(points, start, members, _weights(area), centre, radius, _sequence(TUPLES), _LONGEST, BINS)
    return dict(zip(DISTRIBUTIONS, (found / TUPLES).astype(np.float32), strict=True))


def _weights(area: np.ndarray) -> np.ndarray:
    """Share of each segment in the area, (s,) > 0 so that a union of faces without area still has a distribution."""
    return np.maximum(area / max(float(area.sum()), 1e-300), 1e-9)


def _frames(
    points: np.ndarray, start: np.ndarray, members: np.ndarray, area: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Centroid (k, 3) and root mean square distance from it (k,) of each union, from its segments' points."""
    number = np.diff(start)
    first = np.add.reduceat(points, start[:-1]) / number[:, None]
    second = np.add.reduceat((points**2).sum(axis=1), start[:-1]) / number
    weight = members * _weights(area)
    weight /= weight.sum(axis=1, keepdims=True)
    centre = weight @ first
    return centre, np.sqrt(np.maximum(weight @ second - (centre**2).sum(axis=1), 1e-300))


def _sequence(count: int) -> np.ndarray:
    """`count` points that cover the four-dimensional unit cube evenly, (count, 4): multiples of powers of 1/φ₄.

    φ₄ is the real root of x⁵ = x + 1, the golden ratio of four dimensions.
    """
    ratio = 1.1673039782614187
    return (0.5 + np.arange(1, count + 1)[:, None] * ratio ** -np.arange(1.0, 5.0)) % 1.0


@njit(cache=True, nogil=True, parallel=True)
def _histograms(points, start, members, weight, centre, radius, sequence, longest, bins):  # type: ignore[no-untyped-def]
    """How many tuples of each union fall into each bin of the five measures, (5, k, bins)."""
    nodes = len(members)
    out = np.zeros((5, nodes, bins))
    for node in prange(nodes):
        inside = np.flatnonzero(members[node])
        height = np.concatenate((np.zeros(1), np.cumsum(weight[inside])))
        p = np.empty((4, 3))
        value = np.empty(5)
        for t in range(len(sequence)):
            for k in range(4):
                u = sequence[t, k] * height[-1]
                at_segment = 0
                while height[at_segment + 1] <= u and at_segment + 1 < len(inside):
                    at_segment += 1
                s = inside[at_segment]
                number = start[s + 1] - start[s]
                share = (u - height[at_segment]) / max(height[at_segment + 1] - height[at_segment], 1e-300)
                row = start[s] + min(int(share * number), number - 1)
                for d in range(3):
                    p[k, d] = (points[row, d] - centre[node, d]) / radius[node]
            _measure(p, value)
            for m in range(5):
                at = min(max(value[m] / longest[m] * bins - 0.5, 0.0), bins - 1.0)
                low = min(int(at), bins - 2)
                out[m, node, low] += 1 - (at - low)
                out[m, node, low + 1] += at - low
    return out


@njit(cache=True, nogil=True)
def _measure(p, value):  # type: ignore[no-untyped-def]
    """D1, D2, D3, D4 and A3 of four points (4, 3) about the origin."""
    ax, ay, az = p[1, 0] - p[0, 0], p[1, 1] - p[0, 1], p[1, 2] - p[0, 2]
    bx, by, bz = p[2, 0] - p[0, 0], p[2, 1] - p[0, 1], p[2, 2] - p[0, 2]
    x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    cross = np.sqrt(x * x + y * y + z * z)
    volume = abs(x * (p[3, 0] - p[0, 0]) + y * (p[3, 1] - p[0, 1]) + z * (p[3, 2] - p[0, 2])) / 6.0
    value[0] = np.sqrt(p[0, 0] ** 2 + p[0, 1] ** 2 + p[0, 2] ** 2)
    value[1] = np.sqrt(ax * ax + ay * ay + az * az)
    value[2] = np.sqrt(0.5 * cross)
    value[3] = np.cbrt(volume)
    value[4] = np.arctan2(cross, ax * bx + ay * by + az * bz) / np.pi
