"""The ceiling of a pair: what choosing by the truth itself would score on the same nodes.

Where nodes mix classes no method can be perfect. Every segment is given that node of the other shape which serves it
best, one node to as many segments as it likes; no set of matches of these nodes transfers more. Lenient and strict
precision can be 1 as soon as one right pair of nodes exists: a method may match that pair alone.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import frozen_array
from .correspondence import WHOLE, verdicts


class Ceiling(NamedTuple):
    """Whether a right pair exists, and areas of the best label transfer: given rightly, of all, of classes in both."""

    lenient: bool
    strict: bool
    right: float
    area: float
    total: float

    @property
    def precision(self) -> float:
        """The most that label transfer can reach where every segment is given classes."""
        return self.right / self.area if self.area else float("nan")

    @property
    def recall(self) -> float:
        """The most that label transfer can reach; no set of matches on these nodes has more."""
        return self.right / self.total if self.total else float("nan")


def ceiling(source: np.ndarray, target: np.ndarray, source_nodes: np.ndarray, target_nodes: np.ndarray) -> Ceiling:
    """The ceiling of tables (s, c) and (t, c) of area per class, for nodes (k, s) and (l, t) bool of their segments."""
    source = frozen_array(source, np.float64, (None, None), "The source's table")
    target = frozen_array(target, np.float64, (None, source.shape[1]), "The target's table")
    h, g = _partial(source, source_nodes), _partial(target, target_nodes)
    all_h, all_g = source.sum(axis=0), target.sum(axis=0)
    both = np.minimum(all_h, all_g) > 0
    lenient, strict = _exists(h, g, all_h, all_g)
    right = _best(source, g) + _best(target, h) if len(h) and len(g) else 0.0
    return Ceiling(lenient, strict, right, float(all_h.sum() + all_g.sum()), float((all_h + all_g)[both].sum()))


def _partial(table: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Area per class of the nodes that are neither empty nor (nearly) the whole shape."""
    h = np.asarray(nodes, dtype=np.float64) @ table
    return h[(h.sum(axis=1) > 0) & (h.sum(axis=1) <= WHOLE * table.sum())]


def _best(table: np.ndarray, other: np.ndarray) -> float:
    """Area of the segments that gets its own class when each takes the classes of the node that serves it best."""
    return float((table @ (other / other.sum(axis=1, keepdims=True)).T).max(axis=1).sum())


def _exists(h: np.ndarray, g: np.ndarray, all_h: np.ndarray, all_g: np.ndarray) -> tuple[bool, bool]:
    """Whether any pair of nodes is right by the lenient and by the strict rule."""
    found = [False, False]
    for row in range(len(h) if len(g) else 0):
        right = verdicts(h[row : row + 1], g, all_h, all_g)
        found = [known or bool(verdict.any()) for known, verdict in zip(found, right, strict=True)]
        if all(found):
            break
    return found[0], found[1]
