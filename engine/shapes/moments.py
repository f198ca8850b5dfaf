"""What a light field remembers of one silhouette: Zernike magnitudes and Fourier magnitudes.

A silhouette is centred on its centroid and scaled so that its furthest pixel lies on the unit circle, then resampled
to a disc of `GRID` x `GRID` pixels (Khotanzad & Hong 1990 for the Zernike part; Zhang & Lu 2002 for the Fourier one).
"""

from functools import cache
from math import factorial

import numpy as np
from numba import njit

GRID = 64  # side of the resampled disc, in pixels
DEGREE = 10
ZERNIKE = 35  # magnitudes with n <= DEGREE, without the constant (0, 0)
FOURIER = 10
COEFFICIENTS = ZERNIKE + FOURIER
ANGLES = 64


_BITS = np.arange(256)[:, None] >> np.arange(8) & 1
_ONES = _BITS.sum(axis=1)  # set bits of a byte
_PLACES = (_BITS * np.arange(8)).sum(axis=1)  # sum of their places
_FIRST = _BITS.argmax(axis=1)
_LAST = 7 - _BITS[:, ::-1].argmax(axis=1)


@cache
def orders() -> tuple[tuple[int, int], ...]:
    """The 36 pairs (n, m) with n <= 10, 0 <= m <= n, n - m even; the first is (0, 0)."""
    return tuple((n, m) for n in range(DEGREE + 1) for m in range(n % 2, n + 1, 2))


def radial(n: int, m: int, radius: np.ndarray) -> np.ndarray:
    """The radial polynomial R_nm at `radius` in [0, 1]."""
    total = np.zeros_like(radius)
    for k in range((n - m) // 2 + 1):
        weight = (-1) ** k * factorial(n - k)
        weight //= factorial(k) * factorial((n + m) // 2 - k) * factorial((n - m) // 2 - k)
        total += weight * radius ** (n - 2 * k)
    return total


@cache
def zernike_table() -> np.ndarray:
    """Sums along the rows of the disc of the real and imaginary parts of all basis functions.

    (GRID, GRID + 1, 72) float32: entry [y, x] is the sum over the pixels 0..x-1 of row y, so that a run of pixels is
    the difference of two entries. Pixels outside the unit circle count nothing.
    """
    x = (np.arange(GRID) + 0.5) / (GRID / 2) - 1
    X, Y = np.meshgrid(x, x)
    radius, angle = np.hypot(X, Y), np.arctan2(Y, X)
    parts = []
    for n, m in orders():
        value = np.where(radius <= 1, radial(n, m, radius), 0.0) * (n + 1) / np.pi
        parts += [value * np.cos(m * angle), -value * np.sin(m * angle)]
    table = np.zeros((GRID, GRID + 1, len(parts)))
    table[:, 1:] = np.cumsum(np.stack(parts, axis=-1), axis=1)
    return table.astype(np.float32)


@cache
def ray_table() -> np.ndarray:
    """Pixels (y, x) met on the way from the rim to the centre along each angle, (ANGLES, GRID, 2) int64."""
    angle = 2 * np.pi * (np.arange(ANGLES) + 0.5) / ANGLES
    r = (GRID / 2) * (1 - (np.arange(GRID) + 0.5) / GRID)
    y, x = (GRID / 2 + np.multiply.outer(f(angle), r) for f in (np.sin, np.cos))
    return np.clip(np.floor(np.stack([y, x], axis=-1)), 0, GRID - 1).astype(np.int64)


@cache
def fourier_table() -> np.ndarray:
    """Cosines and sines of the frequencies 1..10 at the angles, (10, 2, ANGLES) float64."""
    angle = 2 * np.pi * (np.arange(ANGLES) + 0.5) / ANGLES
    phase = np.multiply.outer(np.arange(1, FOURIER + 1), angle)
    return np.stack([np.cos(phase), np.sin(phase)], axis=1)


def tables() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The three tables that `describe_image` needs."""
    return zernike_table(), ray_table(), fourier_table()


@njit(cache=True, nogil=True)
def centred_disc(image: np.ndarray, box: tuple[int, int, int, int], disc: np.ndarray) -> bool:
    """Resample a bit image (S, S/8) about its centroid into `disc` (GRID, GRID) uint8; False where it is empty."""
    top, bottom, left, right = box
    count = 0
    sum_x = sum_y = 0.0
    for y in range(top, bottom + 1):
        row = 0
        for k in range(left, right + 1):
            byte = image[y, k]
            if byte:
                row += _ONES[byte]
                sum_x += 8 * k * _ONES[byte] + _PLACES[byte]
        count += row
        sum_y += row * (y + 0.5)
    if count == 0:
        return False
    cx, cy = sum_x / count + 0.5, sum_y / count
    furthest = 0.0
    for y in range(top, bottom + 1):
        a, b = left, right
        while a <= right and image[y, a] == 0:
            a += 1
        if a > right:
            continue
        while image[y, b] == 0:
            b -= 1
        dx = max(cx - (8 * a + _FIRST[image[y, a]]), 8 * b + _LAST[image[y, b]] + 1 - cx)
        dy = max(abs(y - cy), abs(y + 1 - cy))
        furthest = max(furthest, dx * dx + dy * dy)
    scale = np.sqrt(furthest) / (GRID / 2)
    for v in range(GRID):
        y = int(np.floor(cy + (v + 0.5 - GRID / 2) * scale))
        for u in range(GRID):
            disc[v, u] = 0
        if y < top or y > bottom:
            continue
        for u in range(GRID):
            x = int(np.floor(cx + (u + 0.5 - GRID / 2) * scale))
            if 8 * left <= x < 8 * right + 8:
                disc[v, u] = image[y, x >> 3] >> (x & 7) & 1
    return True


@njit(cache=True, nogil=True, fastmath=True)
def disc_moments(
    disc: np.ndarray, zernike: np.ndarray, rays: np.ndarray, fourier: np.ndarray, out: np.ndarray
) -> None:
    """Write the 35 Zernike and 10 Fourier magnitudes of a disc (GRID, GRID) uint8 to `out` (45,) float32.

    Zernike: |Z_nm| of the image divided by its number of pixels, as (n + 1)/π · mean of the conjugate basis function
    over the set pixels. Fourier: |F_k| / F_0, k = 1..10, of the distance from the centre to the furthest set pixel.
    """
    width = zernike.shape[2]
    total = np.zeros(width, dtype=np.float32)
    count = 0
    for y in range(GRID):
        x = 0
        while x < GRID:
            if not disc[y, x]:
                x += 1
                continue
            start = x
            while x < GRID and disc[y, x]:
                x += 1
            count += x - start
            for c in range(width):
                total[c] += zernike[y, x, c] - zernike[y, start, c]
    for k in range(1, width // 2):
        out[k - 1] = np.sqrt(total[2 * k] ** 2 + total[2 * k + 1] ** 2) / max(count, 1)
    reach = np.zeros(ANGLES)
    for a in range(ANGLES):
        for step in range(GRID):
            if disc[rays[a, step, 0], rays[a, step, 1]]:
                reach[a] = 1.0 - (step + 0.5) / GRID
                break
    mean = max(reach.sum(), 1e-9)
    for k in range(FOURIER):
        cosine = sine = 0.0
        for a in range(ANGLES):
            cosine += fourier[k, 0, a] * reach[a]
            sine += fourier[k, 1, a] * reach[a]
        out[width // 2 - 1 + k] = np.sqrt(cosine * cosine + sine * sine) / mean
