"""Candidate matches between two sets of rows, and which of them are proposed."""

from dataclasses import dataclass

import numpy as np

from ..arrays import frozen_array
from ..errors import BadInput


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """Pairs (c, 2) int64 of a source and a target row, sorted and distinct, with `similarity` (c,) in [0, 1]."""

    pairs: np.ndarray
    similarity: np.ndarray

    def __post_init__(self) -> None:
        pairs = frozen_array(np.asarray(self.pairs).reshape(-1, 2), np.int64, (None, 2), "The candidate pairs")
        similarity = frozen_array(self.similarity, np.float64, (len(pairs),), "The similarities")
        if len(similarity) and not (similarity.min() >= 0 and similarity.max() <= 1):
            raise BadInput("Similarities of candidates must lie in [0, 1].")
        object.__setattr__(self, "pairs", pairs)
        object.__setattr__(self, "similarity", similarity)


def k_best(pairs: np.ndarray, distance: np.ndarray, k: int, *, side: int) -> np.ndarray:
    """Which of the pairs (c, 2) are among the k nearest of their row on `side` (0 source, 1 target), (c,) bool.

    Ties go to the smaller row of the other side, so the answer does not depend on the order of the pairs.
    """
    order = np.lexsort((pairs[:, 1 - side], distance, pairs[:, side]))
    rows = pairs[order, side]
    starts = np.searchsorted(rows, rows, side="left")
    kept = np.zeros(len(pairs), dtype=bool)
    kept[order] = np.arange(len(pairs)) - starts < k
    return kept
