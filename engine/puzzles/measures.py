"""How unlike two sides of pieces are: the measures of the literature on strips of border pixels.

A side is two strips of L pixels, read clockwise around its piece: the border itself (`outer`) and the pixels one
step further in (`inner`). A partner is read backwards. All measures are dissimilarities >= 0, smaller is better.

References
----------
MGC: Gallagher, "Jigsaw puzzles with pieces of unknown orientation" (CVPR 2012). L_p^q: Pomeranz, Shemesh &
Ben-Shahar, "A fully automated greedy square jigsaw puzzle solver" (CVPR 2011). PT: Paikin & Tal, "Solving multiple
square jigsaw puzzles with missing pieces" (CVPR 2015). EMD: thesis, Equations 5.1-5.2.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit, prange

from ..arrays import frozen_array

SSD, LPQ, PT, MGC, MGC_ROOT, MGC_PT, EMD = range(7)
CODES = {
    "ssd": SSD, "ssd-lab": SSD, "lpq": LPQ, "pt": PT, "mgc": MGC, "mgc-root": MGC_ROOT, "mgc-pt": MGC_PT,
    "emd": EMD, "emd-lab": EMD,
}  # fmt: skip
IN_LAB = frozenset({"ssd-lab", "lpq", "pt", "emd-lab"})
P, Q = 0.3, 1 / 16  # the exponents of L_p^q

_DUMMIES = np.array(
    [(0, 0, 0), (1, 1, 1), (-1, -1, -1), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)],
    dtype=np.float64,
)


@dataclass(frozen=True, slots=True, eq=False)
class Strips:
    """Border pixels of s sides: `outer` and `inner` (s, L, 3) float32 RGB in 0..255, clockwise; `gap` is the distance
    in pixels between the two strips, `seam` that between facing borders (1 where nothing was lost)."""

    outer: np.ndarray
    inner: np.ndarray
    gap: float = 1.0
    seam: float = 1.0

    def __post_init__(self) -> None:
        for name in ("outer", "inner"):
            array = frozen_array(getattr(self, name), np.float32, (None, None, 3), f"The {name} strips")
            object.__setattr__(self, name, array)

    def part(self, start: int, stop: int) -> "Strips":
        """The pixels start..stop-1 of each side: a sub-edge."""
        return Strips(self.outer[:, start:stop], self.inner[:, start:stop], self.gap, self.seam)

    def lab(self) -> "Strips":
        """The same strips in CIE L*a*b*."""
        return Strips(to_lab(self.outer), to_lab(self.inner), self.gap, self.seam)


def smoothed(strips: Strips, width: int) -> Strips:
    """The same strips, each value the mean of `width` (odd) pixels along the side; ends are repeated."""
    from scipy.ndimage import uniform_filter1d  # type: ignore[attr-defined]

    outer, inner = (uniform_filter1d(a, width, axis=1, mode="nearest") for a in (strips.outer, strips.inner))
    return Strips(outer, inner, strips.gap, strips.seam)


def across(strips: Strips, seam: float) -> Strips:
    """The same strips for pieces whose facing borders lie `seam` pixels apart."""
    return Strips(strips.outer, strips.inner, strips.gap, seam)


def to_lab(colours: np.ndarray) -> np.ndarray:
    """CIE L*a*b* of sRGB colours (..., 3) in 0..255, float32."""
    import cv2

    flat = np.ascontiguousarray(colours, dtype=np.float32).reshape(1, -1, 3) / np.float32(255)
    return (
        cv2.cvtColor(flat, cv2.COLOR_RGB2LAB).reshape(np.shape(colours))
        if flat.size
        else flat.reshape(np.shape(colours))
    )


def side_strips(rasters: np.ndarray, rows: int = 1) -> Strips:
    """The strips of all sides of n square pieces (n, px, px, 3): row 4 i + side, sides top, right, bottom, left.

    Each strip is the mean of `rows` pixel rows.
    """
    n, px = rasters.shape[:2]
    rows = min(rows, px // 2)
    strips = []
    for first in (0, rows):
        sides = [
            np.rot90(rasters, k, axes=(1, 2))[:, first : first + rows].mean(axis=1, dtype=np.float32) for k in range(4)
        ]
        strips.append(np.stack(sides, axis=1).reshape(4 * n, px, 3))  # each side came to the top
    return Strips(strips[0], strips[1], gap=float(rows), seam=float(rows))


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """What one measure needs of s sides, computed once: strips in its colour space, and for MGC the mean gradient
    (s, 3) float64 and the inverse of its covariance with the dummies (s, 3, 3); for EMD sorted values."""

    code: int
    outer: np.ndarray
    inner: np.ndarray
    mean: np.ndarray
    inverse: np.ndarray


def gradient_statistics(strips: Strips) -> tuple[np.ndarray, np.ndarray]:
    """μ (s, 3) and S⁻¹ (s, 3, 3) float64 of MGC: the dummies count in S, not in μ."""
    gradient = (strips.outer.astype(np.float64) - strips.inner) / strips.gap
    s = len(gradient)
    everything = np.concatenate([gradient, np.broadcast_to(_DUMMIES, (s, *_DUMMIES.shape))], axis=1)
    centred = everything - everything.mean(axis=1, keepdims=True)
    covariance = np.einsum("spc,spd->scd", centred, centred) / (everything.shape[1] - 1)
    return gradient.mean(axis=1), np.linalg.inv(covariance)


def measured(measure: str, strips: Strips, parts: int = 1) -> Measured:
    """Prepare a measure (a key of `CODES`); `parts` divides each side into equal multisets for EMD."""
    code = CODES[measure]
    lab = strips.lab() if measure in IN_LAB or code == MGC_PT else strips
    none = np.zeros((len(strips.outer), 0)), np.zeros((len(strips.outer), 0, 0))
    if code in (MGC, MGC_ROOT):
        mean, inverse = gradient_statistics(strips)
        return Measured(code, strips.outer, strips.inner, mean, inverse)
    if code == EMD:
        return Measured(code, _sorted_parts(lab.outer, parts), lab.inner, *none)
    return Measured(code, lab.outer, lab.inner, *none)


def _sorted_parts(values: np.ndarray, parts: int) -> np.ndarray:
    """Parts of ⌊L/parts⌋ pixels, spread evenly and alike from both ends, each sorted by channel."""
    size = values.shape[1] // parts
    starts = np.linspace(0, values.shape[1] - size, parts).round().astype(int)
    return np.concatenate([np.sort(values[:, start : start + size], axis=1) for start in starts], axis=1)


def dissimilarity(measure: str, strips: Strips, rows: np.ndarray, columns: np.ndarray, parts: int = 1) -> np.ndarray:
    """D (r, c) float64 between the sides `rows` and the sides `columns`, each column read backwards.

    The same piece is not excluded; that is the caller's. `measure` is a key of `CODES`.
    """
    rows, columns = np.asarray(rows, dtype=np.int64), np.asarray(columns, dtype=np.int64)
    if measure == "mgc-pt":
        return np.sqrt(dissimilarity("pt", strips, rows, columns) + 1e-3) * dissimilarity(
            "mgc-root", strips, rows, columns
        )
    m = measured(measure, strips, parts)
    result = np.empty((len(rows), len(columns)))
    _dense(m.code, m.outer, m.inner, m.mean, m.inverse, strips.seam, rows, columns, max(parts, 1), result)
    return result


def dissimilarity_of_pairs(measure: str, strips: Strips, pairs: np.ndarray, parts: int = 1) -> np.ndarray:
    """D (c,) float64 of the pairs (c, 2) of sides, the second read backwards."""
    pairs = np.asarray(pairs, dtype=np.int64)
    if measure == "mgc-pt":
        root, pt = (dissimilarity_of_pairs(name, strips, pairs) for name in ("mgc-root", "pt"))
        return np.sqrt(pt + 1e-3) * root
    m = measured(measure, strips, parts)
    result = np.empty(len(pairs))
    _sparse(m.code, m.outer, m.inner, m.mean, m.inverse, strips.seam, pairs, max(parts, 1), result)
    return result


@njit(cache=True, nogil=True, parallel=True)
def _dense(code, outer, inner, mean, inverse, seam, rows, columns, parts, result):  # type: ignore[no-untyped-def]
    for i in prange(len(rows)):
        for j in range(len(columns)):
            result[i, j] = _pair(code, outer, inner, mean, inverse, seam, rows[i], columns[j], parts)


@njit(cache=True, nogil=True, parallel=True)
def _sparse(code, outer, inner, mean, inverse, seam, pairs, parts, result):  # type: ignore[no-untyped-def]
    for i in prange(len(pairs)):
        result[i] = _pair(code, outer, inner, mean, inverse, seam, pairs[i, 0], pairs[i, 1], parts)


@njit(cache=True, nogil=True)
def _pair(code, outer, inner, mean, inverse, seam, r, c, parts):  # type: ignore[no-untyped-def]
    if code == SSD:
        return ssd(outer[r], outer[c])
    if code == LPQ:
        return lpq(outer[r], inner[r], outer[c], inner[c])
    if code == PT:
        return predicted_l1(outer[r], inner[r], outer[c], inner[c])
    if code == MGC:
        return mgc(outer[r], mean[r], inverse[r], outer[c], mean[c], inverse[c], seam, False)
    if code == MGC_ROOT:
        return mgc(outer[r], mean[r], inverse[r], outer[c], mean[c], inverse[c], seam, True)
    return emd(outer[r], outer[c], parts)


@njit(cache=True, nogil=True)
def ssd(a, b):  # type: ignore[no-untyped-def]
    """Σ (a − b)² of two strips (L, 3), the second read backwards."""
    n, total = len(a), 0.0
    for p in range(n):
        for ch in range(3):
            d = np.float64(a[p, ch]) - b[n - 1 - p, ch]
            total += d * d
    return total


@njit(cache=True, nogil=True)
def predicted_l1(a, a_in, b, b_in):  # type: ignore[no-untyped-def]
    """Σ |2a − a_in − b| + |2b − b_in − a|: the border predicted one step outwards, both ways (Paikin & Tal 2015)."""
    n, total = len(a), 0.0
    for p in range(n):
        o = n - 1 - p
        for ch in range(3):
            x, y = np.float64(a[p, ch]), np.float64(b[o, ch])
            total += abs(2 * x - a_in[p, ch] - y) + abs(2 * y - b_in[o, ch] - x)
    return total


@njit(cache=True, nogil=True)
def lpq(a, a_in, b, b_in):  # type: ignore[no-untyped-def]
    """(Σ |2a − a_in − b|^p + |2b − b_in − a|^p)^(q/p), p = 0.3, q = 1/16 (Pomeranz et al. 2011)."""
    n, total = len(a), 0.0
    for p in range(n):
        o = n - 1 - p
        for ch in range(3):
            x, y = np.float64(a[p, ch]), np.float64(b[o, ch])
            total += abs(2 * x - a_in[p, ch] - y) ** P + abs(2 * y - b_in[o, ch] - x) ** P
    return total ** (Q / P)


@njit(cache=True, nogil=True)
def mgc(a, mean_a, inverse_a, b, mean_b, inverse_b, seam, root):  # type: ignore[no-untyped-def]
    """Mahalanobis gradient compatibility: D_ab + D_ba over the pixels, with a square root per pixel if `root`.

    `seam` is the distance in pixels between the two borders, over which the mean gradients are expected to go on.
    """
    n, total = len(a), 0.0
    for p in range(n):
        o = n - 1 - p
        d0 = np.float64(b[o, 0]) - a[p, 0]
        d1 = np.float64(b[o, 1]) - a[p, 1]
        d2 = np.float64(b[o, 2]) - a[p, 2]
        x = _mahalanobis(d0 - seam * mean_a[0], d1 - seam * mean_a[1], d2 - seam * mean_a[2], inverse_a)
        y = _mahalanobis(-d0 - seam * mean_b[0], -d1 - seam * mean_b[1], -d2 - seam * mean_b[2], inverse_b)
        total += np.sqrt(x) + np.sqrt(y) if root else x + y
    return total


@njit(cache=True, nogil=True)
def _mahalanobis(x, y, z, m):  # type: ignore[no-untyped-def]
    value = m[0, 0] * x * x + m[1, 1] * y * y + m[2, 2] * z * z
    return max(value + 2 * (m[0, 1] * x * y + m[0, 2] * x * z + m[1, 2] * y * z), 0.0)


@njit(cache=True, nogil=True)
def emd(a, b, parts):  # type: ignore[no-untyped-def]
    """(1/L) Σ |sort(a) − sort(b)|, the mean over channels (thesis, Equations 5.1-5.2).

    The strips are sorted by channel within each of the `parts`; part k lies opposite to part `parts` − 1 − k.
    """
    n, total = len(a), 0.0
    size = n // parts
    for p in range(n):
        o = (parts - 1 - p // size) * size + p % size
        for ch in range(3):
            total += abs(np.float64(a[p, ch]) - b[o, ch])
    return total / (3 * n)
