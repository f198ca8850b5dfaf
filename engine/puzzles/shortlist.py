"""Which sides may be partners: the nearest by distances that are exact matrix products, block by block.

Dense matrices of all pairs would take 8 GB at 22,834 pieces; lists of the nearest take 18 MB.
"""

import numpy as np
from numba import njit, prange

from ..progress import Progress
from .measures import Strips, gradient_statistics

BLOCK = 2048  # rows of a block
OPPOSITE = ((1, 3), (3, 1), (2, 0), (0, 2))  # right-left, left-right, bottom-top, top-bottom


def mgc_forms(strips: Strips) -> tuple[np.ndarray, np.ndarray]:
    """X and Y (s, 6 L + 14) float32 with X[i] · Y[j] = MGC (no root) of side i and side j read backwards."""
    a = strips.outer.astype(np.float64) - 128
    mean, inverse = gradient_statistics(strips)
    s, L = a.shape[:2]
    predicted = a + mean[:, None]  # what the next pixels should be
    weighted = np.einsum("spc,scd->spd", predicted, inverse)
    squared = np.einsum("spc,spc->s", weighted, predicted)
    outer = np.einsum("spc,spd->scd", a, a).reshape(s, 9)
    flat, one = inverse.reshape(s, 9), np.ones((s, 1))
    left = [-2 * weighted.reshape(s, 3 * L), flat, squared[:, None], one]
    right = [a[:, ::-1].reshape(s, 3 * L), outer, one, squared[:, None]]
    x = [*left, a.reshape(s, 3 * L), outer]
    y = [*right, -2 * weighted[:, ::-1].reshape(s, 3 * L), flat]
    return np.concatenate(x, axis=1).astype(np.float32), np.concatenate(y, axis=1).astype(np.float32)


def ssd_forms(strips: Strips) -> tuple[np.ndarray, np.ndarray]:
    """X and Y (s, 3 L + 2) float32 with X[i] · Y[j] = SSD of side i and side j read backwards."""
    a = strips.outer - strips.outer.mean(axis=(0, 1))
    s = len(a)
    squared, one = np.einsum("spc,spc->s", a, a)[:, None], np.ones((s, 1), dtype=np.float32)
    x = np.concatenate([-2 * a.reshape(s, -1), squared, one], axis=1)
    return x, np.concatenate([a[:, ::-1].reshape(s, -1), one, squared], axis=1)


def nearest(
    forms: tuple[np.ndarray, np.ndarray], pieces: int, k: int, *, turned: bool, progress: Progress
) -> np.ndarray:
    """The k nearest sides of each of the 4 n sides, (4 n, k) int32, nearest first; never of the same piece.

    With `turned` any side of another piece may be a partner, without only the opposite one. Rows are filled with -1
    where there are fewer than k.
    """
    x, y = forms
    found = np.full((4 * pieces, k), -1, dtype=np.int32)
    groups = [(np.arange(4 * pieces), np.arange(4 * pieces))] if turned else [
        (np.arange(a, 4 * pieces, 4), np.arange(b, 4 * pieces, 4)) for a, b in OPPOSITE
    ]  # fmt: skip
    blocks = [
        (rows[start : start + BLOCK], columns) for rows, columns in groups for start in range(0, len(rows), BLOCK)
    ]
    turned_y: dict[int, np.ndarray] = {}
    for number, (rows, columns) in enumerate(blocks):
        key = int(columns[0]) if not turned else -1
        if key not in turned_y:
            turned_y = {key: np.ascontiguousarray(y[columns].T)}
        product = x[rows] @ turned_y[key]
        _smallest(product, rows, columns, k, found)
        progress((number + 1) / len(blocks), "comparing sides")
    return found


@njit(cache=True, nogil=True, parallel=True)
def _smallest(product, rows, columns, k, found):  # type: ignore[no-untyped-def]
    """Insert the k smallest of each row into `found`, leaving out sides of the same piece."""
    for i in prange(len(rows)):
        side = rows[i]
        values = np.full(k, np.inf, dtype=np.float32)
        where = np.full(k, -1, dtype=np.int32)
        last = np.float32(np.inf)
        for j in range(len(columns)):
            value = product[i, j]
            if value < last and columns[j] // 4 != side // 4:
                place = k - 1
                while place > 0 and values[place - 1] > value:
                    values[place] = values[place - 1]
                    where[place] = where[place - 1]
                    place -= 1
                values[place] = value
                where[place] = columns[j]
                last = values[k - 1]
        found[side] = where


def pairs_of(lists: list[np.ndarray]) -> np.ndarray:
    """The distinct pairs (c, 2) int64 of sides in lists of nearest sides, sorted; each pair once, smaller side first."""
    every = []
    for found in lists:
        rows = np.repeat(np.arange(len(found)), found.shape[1])
        columns = found.ravel().astype(np.int64)
        kept = columns >= 0
        low, high = np.minimum(rows, columns)[kept], np.maximum(rows, columns)[kept]
        every.append(low * len(found) + high)
    keys = np.unique(np.concatenate(every))
    return np.stack(np.divmod(keys, len(lists[0])), axis=1)
