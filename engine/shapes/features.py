"""Descriptors of nodes beside the light field, each made when it is first asked for and kept from then on.

D1, D2, D3, D4 and A3 (`distributions`), principal components, volume and area (`shapefeatures`), and heat kernel
signatures (`heatkernel`). All are L1 distances of rows; they are scaled so that true pairs lie about 1 apart.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import njit, prange

from ..store import Cache, cache_key
from .distributions import DISTRIBUTIONS, shape_distributions
from .segmentation import SegmentedShape, SegmentGraph

if TYPE_CHECKING:
    from .heatkernel import HeatKernel

FEATURES = (*DISTRIBUTIONS, "pca", "hks", "phks", "volume")
# Median distance of true pairs (Jaccard of class coverage at least one half), median over 20 generated pairs.
SCALES = {"d1": 0.40, "d2": 0.21, "d3": 0.195, "d4": 0.21, "a3": 0.19, "pca": 0.83, "hks": 1.6, "phks": 7.0,
          "volume": 0.57}  # fmt: skip
_KINDS = {name: "distributions" if name in DISTRIBUTIONS else name for name in FEATURES}
_VERSION = "features/2"


class NodeFeatures(Mapping[str, np.ndarray]):
    """The descriptors (k, dims) float32 of the nodes of a shape, by name.

    `kept` holds what is known of the shape whatever its nodes are, and the rows of unions met before: where nodes are
    added, only theirs are made.
    """

    def __init__(
        self, shape: SegmentedShape, ids: Sequence[str], graph: SegmentGraph, members: np.ndarray, *, seed: int,
        cache: Cache | None, kept: dict[str, Any],
    ) -> None:  # fmt: skip
        self.shape, self.ids, self.graph, self.members = shape, tuple(ids), graph, members
        self.seed, self.cache, self.kept = seed, cache, kept
        self.found: dict[str, np.ndarray] = {}

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.found:
            self.found.update(self._rows(_KINDS[name]))
        return self.found[name]

    def __iter__(self) -> Iterator[str]:
        return iter(FEATURES)

    def __len__(self) -> int:
        return len(FEATURES)

    def _rows(self, kind: str) -> dict[str, np.ndarray]:
        """The descriptors of one kind: rows of unions met before are taken, the others made."""
        known, rows = self.kept.get(kind, (self.members[:0], {}))
        place = {row.tobytes(): k for k, row in enumerate(known)}
        new = self.members[[row.tobytes() not in place for row in self.members]]
        if len(new):
            made = self._made(kind, new)
            place.update({row.tobytes(): len(known) + k for k, row in enumerate(new)})
            known = np.concatenate([known, new])
            rows = {name: np.concatenate([rows[name], part]) if rows else part for name, part in made.items()}
            self.kept[kind] = known, rows
        order = [place[row.tobytes()] for row in self.members]
        return {name: table[order] for name, table in rows.items()}

    def _made(self, kind: str, members: np.ndarray) -> dict[str, np.ndarray]:
        graph = self.graph
        if kind == "distributions":
            return self._stored(kind, lambda: shape_distributions(self.shape, members, graph.area, seed=self.seed), members)
        if kind in ("hks", "phks"):
            from .heatkernel import mean_signatures, persistent_signatures

            if kind == "hks":
                return {kind: mean_signatures(self._heat(), members, graph.area)}
            return self._stored(kind, lambda: {kind: persistent_signatures(self._heat(), members)}, members)
        from .shapefeatures import principal_shape, volume_and_area

        if kind == "pca":
            return {kind: principal_shape(self.shape, members)}
        return {kind: volume_and_area(members, graph.area, graph.volume)}

    def _heat(self) -> "HeatKernel":
        from .heatkernel import HeatKernel, heat_kernel

        def make() -> dict[str, np.ndarray]:
            return heat_kernel(self.shape, seed=self.seed)._asdict()

        if "heat" not in self.kept:
            self.kept["heat"] = HeatKernel(**self._stored("heat", make))
        return self.kept["heat"]

    def _stored(self, kind: str, make: Any, members: np.ndarray | None = None) -> dict[str, np.ndarray]:
        """What `make` returns, from the cache on disk where there is one."""
        if self.cache is None:
            return make()
        packed = np.zeros(0) if members is None else np.packbits(members, axis=1)
        return self.cache.arrays(cache_key(f"{_VERSION}/{kind}", self.ids, self.seed, packed), make)


class FeatureDistances(Mapping[str, np.ndarray]):
    """The distances (c,) float64 of pairs of nodes (c, 2) by each descriptor, 1 being usual for true pairs."""

    def __init__(self, source: Mapping[str, np.ndarray], target: Mapping[str, np.ndarray], pairs: np.ndarray) -> None:
        self.source, self.target, self.pairs = source, target, pairs
        self.found: dict[str, np.ndarray] = {}

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.found:
            apart = row_distances(self.source[name], self.target[name], self.pairs)
            self.found[name] = apart / SCALES[name]
        return self.found[name]

    def __iter__(self) -> Iterator[str]:
        return iter(FEATURES)

    def __len__(self) -> int:
        return len(FEATURES)


@njit(cache=True, nogil=True, parallel=True, fastmath=True)
def row_distances(a: np.ndarray, b: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """L1 distance of each pair (p, 2) of rows of `a` (n, d) and `b` (m, d) float32, (p,) float64."""
    out = np.empty(len(pairs))
    for p in prange(len(pairs)):
        i, j = pairs[p, 0], pairs[p, 1]
        total = np.float32(0)
        for k in range(a.shape[1]):
            total += abs(a[i, k] - b[j, k])
        out[p] = total
    return out
