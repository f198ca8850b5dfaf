"""How well distances find true partners: every query ranks all candidates, and some of them are true.

*Top-1* and *top-7*: the share of queries with a true candidate first, or among the first seven (the K that matching
keeps). *Mean average precision*: the mean over the true candidates of the share of true ones down to each. *AUC*: the
chance that a true candidate lies nearer than a false one. Equal distances count as the mean of all their orders in
AUC, and against the query elsewhere. Queries without a true candidate, or with nothing else, are left out.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ..arrays import frozen_array

TOP = 7
MEASURES = ("top-1", f"top-{TOP}", "mean average precision", "AUC")


class Retrieval(NamedTuple):
    """The figures of each query, rows of `figures` (q, 4) in the order of MEASURES, and those of `chance` (q, 4).

    `size` (q,) int64 is how many segments a query unites.
    """

    figures: np.ndarray
    chance: np.ndarray
    size: np.ndarray


def retrieval(distance: object, truth: object, size: object) -> Retrieval:
    """Judge distances (n, m) of n queries by `truth` (n, m) bool; `size` (n,) is handed on for the queries judged."""
    d = frozen_array(distance, np.float64, (None, None), "The distances")
    true = frozen_array(truth, bool, d.shape, "The truth")
    sizes = frozen_array(size, np.int64, (len(d),), "The sizes")
    number = true.sum(axis=1)
    kept = (number > 0) & (number < d.shape[1])
    d, true, number = d[kept], true[kept], number[kept]
    order = np.lexsort((true, d))  # of equal distances the false ones come first
    hits = np.take_along_axis(true, order, axis=1)
    rank = np.arange(1, d.shape[1] + 1)
    precision = (hits * np.cumsum(hits, axis=1) / rank).sum(axis=1) / number
    first, among = hits[:, :1].any(axis=1), hits[:, :TOP].any(axis=1)
    figures = np.stack([first, among, precision, _auc(d, true)], axis=1).astype(np.float64).reshape(-1, 4)
    return Retrieval(figures, _chance(number, d.shape[1]), sizes[kept])


def _auc(d: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Mann-Whitney: share of the pairs of a true and a false candidate where the true one is nearer, (q,)."""
    found = np.empty(len(d))
    for row, (distance, mask) in enumerate(zip(d, true, strict=True)):
        right, wrong = distance[mask], np.sort(distance[~mask])
        nearer = np.searchsorted(wrong, right, side="left") + np.searchsorted(wrong, right, side="right")
        found[row] = 1 - nearer.mean() / (2 * len(wrong))
    return found


def _chance(number: np.ndarray, m: int) -> np.ndarray:
    """What a random order of m candidates gives with so many true ones, exactly, (q, 4)."""
    t = number.astype(np.float64)
    missed = np.ones(len(t))
    for k in range(min(TOP, m)):
        missed *= np.maximum(m - t - k, 0) / (m - k)
    harmonic = (1 / np.arange(1, m + 1)).sum()
    precision = (harmonic + (t - 1) / max(m - 1, 1) * (m - harmonic)) / m
    return np.stack([t / m, 1 - missed, precision, np.full(len(t), 0.5)], axis=1).reshape(-1, 4)


def joined(parts: Iterable[Retrieval]) -> Retrieval:
    """The queries of several pairs as one."""
    found = list(parts)
    empty = Retrieval(np.zeros((0, 4)), np.zeros((0, 4)), np.zeros(0, dtype=np.int64))
    return Retrieval(*(np.concatenate(columns) for columns in zip(empty, *found, strict=True)))
