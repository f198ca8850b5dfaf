"""The ceiling of a pair: what choosing by the truth itself would score on the same nodes.

Where nodes mix classes no method can be perfect. Every segment is given that node of the other shape which serves it
best, one node to as many segments as it likes; no set of matches of these nodes transfers more. That is the ceiling of
recall. For that of precision, segments that even so get more wrong than right are left out, as parts without a counterpart
are. Lenient and strict precision can be 1 as soon as one right pair of nodes exists: a method may match that pair alone.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import frozen_array
from .correspondence import WHOLE, verdicts


class Ceiling(NamedTuple):
    """Whether a right pair exists, and areas: of the best label transfer to all segments, `right` of `total` (classes that
    both shapes have), to those worth it, `kept_right` of `kept`; and of all, `area`."""

    lenient: bool
    strict: bool
    right: float
    total: float
    kept_right: float
    kept: float
    area: float

    @property
    def precision(self) -> float:
        """What label transfer reaches by the truth where segments that get more wrong than right are left out."""
        return self.kept_right / self.kept if self.kept else float("nan")

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
    right, kept_right, kept = (_best(source, g) + _best(target, h)).tolist()
    return Ceiling(lenient, strict, right, float((all_h + all_g)[both].sum()), kept_right, kept, float(all_h.sum() + all_g.sum()))


def _partial(table: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Area per class of the nodes that are neither empty nor (nearly) the whole shape."""
    h = np.asarray(nodes, dtype=np.float64) @ table
    return h[(h.sum(axis=1) > 0) & (h.sum(axis=1) <= WHOLE * table.sum())]


def _best(table: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Area that gets its own class when each segment takes the classes of the node that serves it best; the same of the
    segments of which at least half does, and the area of these: (3,)."""
    right = (table @ (other / other.sum(axis=1, keepdims=True)).T).max(axis=1, initial=0.0)
    area = table.sum(axis=1)
    worth = (right >= 0.5 * area) & (area > 0)
    return np.array([right.sum(), right[worth].sum(), area[worth].sum()])


def _exists(h: np.ndarray, g: np.ndarray, all_h: np.ndarray, all_g: np.ndarray) -> tuple[bool, bool]:
    """Whether any pair of nodes is right by the lenient and by the strict rule."""
    found = [False, False]
    for row in range(len(h) if len(g) else 0):
        right = verdicts(h[row : row + 1], g, all_h, all_g)
        found = [known or bool(verdict.any()) for known, verdict in zip(found, right, strict=True)]
        if all(found):
            break
    return found[0], found[1]
