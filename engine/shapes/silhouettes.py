"""Silhouettes of segments as bit images, so that a union of segments is drawn by OR.

An image of side S is S rows of S/8 bytes; pixel x of a row is bit x % 8 of byte x // 8.
"""

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def _set_span(row: np.ndarray, first: int, last: int) -> None:
    """Set the pixels first..last of a row, clipped to the image."""
    side = 8 * row.shape[0]
    first, last = max(first, 0), min(last, side - 1)
    if first > last:
        return
    a, b = first >> 3, last >> 3
    left, right = 0xFF << (first & 7) & 0xFF, 0xFF >> (7 - (last & 7))
    if a == b:
        row[a] |= np.uint8(left & right)
        return
    row[a] |= np.uint8(left)
    for k in range(a + 1, b):
        row[k] = np.uint8(0xFF)
    row[b] |= np.uint8(right)


@njit(cache=True, nogil=True)
def draw_triangles(xy: np.ndarray, faces: np.ndarray, rows: np.ndarray, image: np.ndarray) -> None:
    """Fill the projections of the triangles `faces[rows]` into `image` (S, S/8) uint8.

    `xy` (n, 2) float64 are projected vertices in pixels, pixel (i, j) covering [i, i+1) x [j, j+1). A row of pixels is
    filled between the triangle's crossings with its middle line, at least the pixel halfway; a triangle between two
    middle lines fills its span in its own row. So nothing that is drawn vanishes, and what one triangle covers does
    not depend on the others: images of segments combine by OR into the image of their union, bit for bit.
    """
    side = image.shape[0]
    for r in rows:
        x0, y0 = xy[faces[r, 0], 0], xy[faces[r, 0], 1]
        x1, y1 = xy[faces[r, 1], 0], xy[faces[r, 1], 1]
        x2, y2 = xy[faces[r, 2], 0], xy[faces[r, 2], 1]
        low, high = min(y0, y1, y2), max(y0, y1, y2)
        top, bottom = max(int(np.ceil(low - 0.5)), 0), min(int(np.floor(high - 0.5)), side - 1)
        if top > bottom:
            y = int(np.floor((low + high) / 2))
            if 0 <= y < side:
                _set_span(image[y], int(np.floor(min(x0, x1, x2))), int(np.floor(max(x0, x1, x2))))
            continue
        for y in range(top, bottom + 1):
            middle = y + 0.5
            left, right = np.inf, -np.inf
            for e in range(3):
                if e == 0:
                    xa, ya, xb, yb = x0, y0, x1, y1
                elif e == 1:
                    xa, ya, xb, yb = x1, y1, x2, y2
                else:
                    xa, ya, xb, yb = x2, y2, x0, y0
                if (ya <= middle) != (yb <= middle) or ya == middle or yb == middle:
                    x = xa if ya == yb else xa + (xb - xa) * (middle - ya) / (yb - ya)
                    x = min(max(x, min(xa, xb)), max(xa, xb))
                    left, right = min(left, x), max(right, x)
            if left > right:
                continue
            first, last = int(np.ceil(left - 0.5)), int(np.floor(right - 0.5))
            if first > last:
                first = last = int(np.floor((left + right) / 2))
            _set_span(image[y], first, last)


@njit(cache=True, nogil=True)
def draw_segments(xy: np.ndarray, faces: np.ndarray, order: np.ndarray, bounds: np.ndarray, images: np.ndarray) -> None:
    """One image a segment: faces `order[bounds[i]:bounds[i + 1]]` into `images[i]` (s, S, S/8), cleared first."""
    images[:] = 0
    for i in range(len(bounds) - 1):
        draw_triangles(xy, faces, order[bounds[i] : bounds[i + 1]], images[i])


@njit(cache=True, nogil=True)
def filled_box(image: np.ndarray) -> tuple[int, int, int, int]:
    """First and last row, first and last byte column that hold a set pixel; (0, -1, 0, -1) for an empty image."""
    top, bottom, left, right = image.shape[0], -1, image.shape[1], -1
    for y in range(image.shape[0]):
        for k in range(image.shape[1]):
            if image[y, k]:
                top, bottom = min(top, y), y
                left, right = min(left, k), max(right, k)
    return (top, bottom, left, right) if bottom >= 0 else (0, -1, 0, -1)
