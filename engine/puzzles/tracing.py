"""From the mask of a piece to its polygon: the boundary between pixels, its straight sides, and their corners."""

from typing import Any

import numpy as np
from scipy import ndimage as _ndimage

from .turning import from_the_top

ndimage: Any = _ndimage  # its functions are not seen by type checkers
_STEPS = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])  # right, down, left, up: clockwise as seen, y down


def whole(mask: np.ndarray) -> tuple[np.ndarray, float]:
    """The largest part of a mask (joined by edges of pixels) without holes, and the second's share of its area."""
    labels, count = ndimage.label(mask)
    if count == 0:
        return np.zeros_like(mask, dtype=bool), 0.0
    sizes = np.bincount(labels.ravel())[1:]
    largest = ndimage.binary_fill_holes(labels == 1 + int(sizes.argmax()))
    sizes = np.sort(sizes)
    return largest, float(sizes[-2] / sizes[-1]) if count > 1 else 0.0


def boundary(mask: np.ndarray) -> np.ndarray:
    """The outline of a mask in one part without holes: corners of pixels (b, 2) int64, clockwise, a pixel apart."""
    filled = np.pad(mask, 1)
    inside = filled[1:-1, 1:-1]
    outside = (
        ~filled[:-2, 1:-1],
        ~filled[1:-1, 2:],
        ~filled[2:, 1:-1],
        ~filled[1:-1, :-2],
    )  # above, right, below, left
    starts = ((0, 0), (1, 0), (1, 1), (0, 1))
    leaving: dict[tuple[int, int], list[int]] = {}
    for direction, (open_side, (dx, dy)) in enumerate(zip(outside, starts, strict=True)):
        for y, x in zip(*np.nonzero(inside & open_side), strict=True):
            leaving.setdefault((int(x) + dx, int(y) + dy), []).append(direction)
    first = min(leaving, key=lambda p: (p[1], p[0]))
    outline: list[tuple[int, int]] = []
    here, direction = first, 0
    while not outline or here != first:
        # Where two pixels touch at a corner, turn right: pixels that share no edge are not joined.
        choices = leaving[here]
        direction = choices[0] if len(choices) == 1 else min(choices, key=lambda d: (direction + 1 - d) % 4)
        outline.append(here)
        here = (here[0] + int(_STEPS[direction][0]), here[1] + int(_STEPS[direction][1]))
    return np.array(outline, dtype=np.int64)


def trace(mask: np.ndarray, *, roughness: float) -> np.ndarray:
    """The polygon of a piece from its mask, (v, 2) float64, clockwise, the topmost and then leftmost corner first.

    `mask` (h, w) bool is in one part without holes. Corners are chosen as Douglas and Peucker (1973) do, with the
    tolerance `roughness` in pixels; then a line is fitted to the boundary of each side, and neighbouring lines meet in
    the corner. Sides along the pixel grid come out exact.
    """
    if mask.all():
        h, w = mask.shape
        return np.array([[0, 0], [w, 0], [w, h], [0, h]], dtype=np.float64)
    outline = boundary(mask)
    corners = _without_flat(outline, _corners(outline.astype(np.float64), roughness), roughness)
    lines = [_line(outline, start, end) for start, end in zip(corners, np.roll(corners, -1), strict=True)]
    met = [
        _meeting(lines[k - 1], lines[k], outline[c].astype(np.float64), 2 * roughness) for k, c in enumerate(corners)
    ]
    return from_the_top(np.round(met, 6))


def _corners(points: np.ndarray, tolerance: float) -> np.ndarray:
    """Rows of a closed line that a polygon within the tolerance keeps, ascending."""
    start = int(((points - points.mean(axis=0)) ** 2).sum(axis=1).argmax())
    far = int(((points - points[start]) ** 2).sum(axis=1).argmax())
    around = np.vstack((np.roll(points, -start, axis=0), points[start]))
    middle, kept = (far - start) % len(points), set[int]()
    stack = [(0, middle), (middle, len(points))]
    while stack:
        a, b = stack.pop()
        kept.add(a)
        if b - a > 1:
            away = _distance(around[a + 1 : b], around[a], around[b])
            k = int(away.argmax())
            if away[k] > tolerance:
                stack += [(a, a + 1 + k), (a + 1 + k, b)]
    return np.sort((np.array(sorted(kept)) + start) % len(points))


def _distance(points: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Distances of points (p, 2) from the segment ab, (p,)."""
    along = b - a
    length = float(along @ along)
    t = np.clip((points - a) @ along / length, 0, 1) if length else np.zeros(len(points))
    return np.hypot(*(points - a - t[:, None] * along).T)


def _without_flat(outline: np.ndarray, corners: np.ndarray, tolerance: float) -> np.ndarray:
    """Drop corners whose two sides are one line within the tolerance, the straightest first; three always stay."""
    left = list(corners)
    while len(left) > 3:
        ends = zip(np.roll(left, 1), np.roll(left, -1), strict=True)
        spread = [_spread(_middles(outline, int(start), int(end))) for start, end in ends]
        flattest = int(np.argmin(spread))
        if spread[flattest] > 0.35 * tolerance:
            break
        left.pop(flattest)
    return np.array(left)


def _spread(points: np.ndarray) -> float:
    """Root mean square distance of points (p, 2) from the line that fits them best."""
    covariance = np.cov(points.T, bias=True)
    return float(np.sqrt(max(np.linalg.eigvalsh(covariance)[0], 0.0)))


def _middles(outline: np.ndarray, start: int, end: int) -> np.ndarray:
    """The middles of the steps of a closed outline from one row to another, (p, 2) float64."""
    rows = np.arange(start, end if end > start else end + len(outline))
    return (outline[rows % len(outline)] + outline[(rows + 1) % len(outline)]) / 2


def _line(outline: np.ndarray, start: int, end: int) -> tuple[np.ndarray, np.ndarray]:
    """A point and the unit direction of the line along one side, fitted to the middles of its boundary steps.

    A side that strays less than a pixel from the grid over its whole length is taken to lie on it.
    """
    middles = _middles(outline, start, end)
    cut = len(middles) // 8
    middles = middles[cut : len(middles) - cut]
    for axis in (0, 1):
        if np.ptp(outline[[start, end]][:, axis]) < 2 and np.ptp(middles[:, axis]) <= 1:
            steps = middles[middles[:, axis] % 1 == 0, axis]
            values, counts = np.unique(steps, return_counts=True)
            point = middles[0].copy()
            point[axis] = values[counts.argmax()]
            return point, np.eye(2)[1 - axis]
    for _ in range(2):
        centre = middles.mean(axis=0)
        direction = np.linalg.svd(middles - centre, full_matrices=False)[2][0]
        off = np.abs((middles - centre) @ np.array([-direction[1], direction[0]]))
        near = off <= max(3 * float(np.median(off)), 1.0)
        if near.all() or near.sum() < 2:
            break
        middles = middles[near]  # burrs do not turn the line
    return centre, direction


def _meeting(
    one: tuple[np.ndarray, np.ndarray], other: tuple[np.ndarray, np.ndarray], corner: np.ndarray, reach: float
) -> np.ndarray:
    """Where two lines meet, or the corner of the boundary itself where they meet farther than `reach` from it."""
    (p, u), (q, v) = one, other
    cross = u[0] * v[1] - u[1] * v[0]
    if abs(cross) < 0.1:
        return corner
    met = p + u * (((q - p)[0] * v[1] - (q - p)[1] * v[0]) / cross)
    return met if float(np.hypot(*(met - corner))) <= reach else corner
