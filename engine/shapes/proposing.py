"""Which pairs of nodes are worth looking at, and how far apart they are: the slow part of a pair."""

from dataclasses import dataclass, field

import numpy as np

from ..progress import Progress, silent
from ..store import Cache, cache_key
from .agreement import pack
from .describing import DescribedShape, Stopwatch
from .lightfield import light_field_distances, signature_distances
from .parameters import MatchParameters


@dataclass(frozen=True, slots=True, eq=False)
class Proposals:
    """A pair of described shapes and the pairs of nodes that the live parameters choose from.

    `pairs` (c, 2) int64 sorted, with exact light field distances `lfd` (c,) float64 and the differences `size`,
    `extent` and `centrality` (c,) = |Δ log| of the measures; `bottom` (c,) bool where both nodes are segments. All
    pairs of segments are there; the whole shapes are not. `packed_source`, `packed_target`: see `agreement.pack`.
    `pinned` and `barred` (c,) bool are the pairs that people have judged: every method takes all pinned pairs, before
    anything else, and never a barred one.
    """

    source: DescribedShape
    target: DescribedShape
    pairs: np.ndarray
    lfd: np.ndarray
    size: np.ndarray
    extent: np.ndarray
    centrality: np.ndarray
    bottom: np.ndarray
    packed_source: np.ndarray
    packed_target: np.ndarray
    pinned: np.ndarray
    barred: np.ndarray
    seconds: dict[str, float] = field(default_factory=dict)


def propose(
    source: DescribedShape,
    target: DescribedShape,
    parameters: MatchParameters,
    *,
    progress: Progress = silent,
    cache: Cache | None = None,
) -> Proposals:
    """Exact light field distances of the pairs that can matter.

    A pair is kept if it is among the `pool` nearest of either node by the quantile signature alone, with size, with
    extent and centrality, with much size, or with much centrality; and all pairs of bottom segments are. So the K best
    under any weights of the live parameters are nearly always among them.
    """
    watch = Stopwatch()
    progress(0.0, "candidate pairs")
    with watch("candidates"):
        pairs = _pool(source, target, parameters.pool)
    progress(0.2, "light field distances")
    with watch("distances"):
        lfd = _distances(source, target, pairs, progress, cache)
    return _measured(source, target, pairs, lfd, (pack(source.measures), pack(target.measures)), watch.seconds)


def with_pairs(proposals: Proposals, source: DescribedShape, target: DescribedShape, extra: np.ndarray) -> Proposals:
    """The proposals and further pairs `extra` (e, 2), with exact distances.

    `source` and `target` are those of the proposals, or the same with nodes added (see `extending.with_nodes`).
    """
    lfd = light_field_distances(source.descriptors, target.descriptors, extra)
    pairs, lfd = np.concatenate([proposals.pairs, extra]), np.concatenate([proposals.lfd, lfd])
    order = np.lexsort((pairs[:, 1], pairs[:, 0]))
    packed = (proposals.packed_source if source is proposals.source else pack(source.measures),
              proposals.packed_target if target is proposals.target else pack(target.measures))  # fmt: skip
    return _measured(source, target, pairs[order], lfd[order], packed, proposals.seconds)


def open_rows(proposals: Proposals) -> np.ndarray:
    """Rows that a one-to-one method may choose from, (c,) bool: not barred, and at a pinned node its pin alone."""
    pairs, pinned = proposals.pairs, proposals.pinned
    taken = [np.isin(pairs[:, side], pairs[pinned, side]) for side in (0, 1)]
    return pinned | ~(proposals.barred | taken[0] | taken[1])


def _measured(
    source: DescribedShape, target: DescribedShape, pairs: np.ndarray, lfd: np.ndarray,
    packed: tuple[np.ndarray, np.ndarray], seconds: dict[str, float],
) -> Proposals:  # fmt: skip
    """Proposals of sorted pairs (c, 2) with their light field distances (c,): all else that is known of a pair."""
    s, t = source.measures, target.measures
    i, j = pairs.T
    bottom = (pairs[:, 0] < len(source.graph.area)) & (pairs[:, 1] < len(target.graph.area))
    return Proposals(
        source, target, pairs, lfd, _apart(s.size[i], t.size[j]), _apart(s.extent[i], t.extent[j]),
        _apart(s.centrality[i], t.centrality[j]), bottom, *packed,
        np.zeros(len(pairs), dtype=bool), np.zeros(len(pairs), dtype=bool), seconds)  # fmt: skip


def _apart(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """|Δ log| of two measures."""
    return np.abs(np.log(x) - np.log(y))


def _pool(source: DescribedShape, target: DescribedShape, pool: int) -> np.ndarray:
    n, m = (len(shape.layers.members) - 1 for shape in (source, target))  # the last node is the whole shape
    near = signature_distances(source.signatures[:n], target.signatures[:m]).astype(np.float64)
    s, t = source.measures, target.measures
    size = _apart(s.size[:n, None], t.size[None, :m])
    extent = _apart(s.extent[:n, None], t.extent[None, :m])
    centrality = _apart(s.centrality[:n, None], t.centrality[None, :m])
    kept = np.zeros((n, m), dtype=bool)
    kept[: len(source.graph.area), : len(target.graph.area)] = True
    for extra in (0.0, size, 0.5 * extent + 2 * centrality, 5 * size, 2 * extent + 10 * centrality):
        distance = near + extra
        for axis in (0, 1):
            most = min(pool, distance.shape[axis])
            rows = np.argpartition(distance, most - 1, axis=axis)
            np.put_along_axis(kept, rows[:most] if axis == 0 else rows[:, :most], True, axis=axis)
    return np.argwhere(kept)


def _distances(
    source: DescribedShape, target: DescribedShape, pairs: np.ndarray, progress: Progress, cache: Cache | None
) -> np.ndarray:
    def make() -> dict[str, np.ndarray]:
        parts = np.array_split(pairs, max(1, len(pairs) // 20_000))
        found = []
        for number, part in enumerate(parts):
            found.append(light_field_distances(source.descriptors, target.descriptors, part))
            progress(0.2 + 0.8 * (number + 1) / len(parts), "light field distances")
        return {"distances": np.concatenate(found)}

    if cache is None:
        return make()["distances"]
    key = cache_key("distances/1", source.descriptors, target.descriptors, pairs)
    return cache.arrays(key, make)["distances"]
