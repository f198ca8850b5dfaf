"""Which pairs of nodes are worth looking at, and how far apart they are: the slow part of a pair."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..consistency.candidates import keep_nearest
from ..progress import Progress, share, silent
from ..store import Cache, cache_key
from .agreement import pack
from .describing import DescribedShape, Stopwatch
from .features import FEATURES, SCALES, FeatureDistances, row_distances
from .learned import Judged, judge
from .lightfield import VIEWS, light_field_distances, signature_distances
from .parameters import LEARNED, MatchParameters

SIGNATURE, EXACT = "signature", "exact"
SIGNATURE_SCALE = 1.35  # exact distances of true pairs are about so much larger than those of their signatures
TRUE_DISTANCE = 1.8  # light field distance that is usual for true pairs
_REMEMBERED = 4  # sets of descriptors whose pairs are kept
_MEASURES = ("size", "extent", "centrality")


@dataclass(frozen=True, slots=True, eq=False)
class Proposals:
    """A pair of described shapes and the pairs of nodes that the live parameters choose from.

    `pairs` (c, 2) int64 sorted, with exact light field distances `lfd` (c,) float64 and the differences `size`,
    `extent` and `centrality` (c,) = |Δ log| of the measures; `bottom` (c,) bool where both nodes are segments. All
    pairs of segments are there; the whole shapes are not. `packed_source`, `packed_target`: see `agreement.pack`.
    `pinned` and `barred` (c,) bool are the pairs that people have judged: every method takes all pinned pairs, before
    anything else, and never a barred one. `kind` says whether `lfd` is exact or that of the quantile signatures. `judged`
    are the probabilities of those pairs that the learned method chooses from, once it has been asked for.
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
    kind: str = EXACT
    judged: Judged | None = None
    _memory: dict[object, object] = field(default_factory=dict, init=False)  # of these very pairs: not for `replace`

    @property
    def apart(self) -> FeatureDistances:
        """Distances (c,) of the pairs by each descriptor of `FEATURES`, about 1 for true pairs; made when asked for."""
        if "apart" not in self._memory:
            self._memory["apart"] = FeatureDistances(self.source.features, self.target.features, self.pairs)
        return self._memory["apart"]  # type: ignore[return-value]


def geometric_distance(proposals: Proposals, p: MatchParameters) -> np.ndarray:
    """How unlike the nodes of each pair are, (c,) float64: the weighted sum of all distances, light field first."""
    total = p.lfd_weight * proposals.lfd
    for name in _MEASURES:
        weight = getattr(p, f"{name}_weight")
        total = total + weight * getattr(proposals, name) if weight else total
    for name in active(p):
        total = total + getattr(p, f"{name}_weight") * proposals.apart[name]
    return total


def looks_distance(proposals: Proposals, p: MatchParameters) -> np.ndarray:
    """The weighted mean of the descriptors' distances alone, on the scale of the light field distance, (c,) float64.

    It is the light field distance where no other descriptor has a weight, and where none has any.
    """
    names = active(p)
    weights = p.lfd_weight + sum(getattr(p, f"{name}_weight") for name in names)
    if not names or not weights:
        return proposals.lfd
    others = sum(getattr(p, f"{name}_weight") * proposals.apart[name] for name in names)
    return (p.lfd_weight * proposals.lfd + TRUE_DISTANCE * others) / weights


def active(p: MatchParameters) -> tuple[str, ...]:
    """The descriptors beside the light field that have a weight."""
    return tuple(name for name in FEATURES if getattr(p, f"{name}_weight") > 0)


def propose(
    source: DescribedShape,
    target: DescribedShape,
    parameters: MatchParameters,
    *,
    progress: Progress = silent,
    cache: Cache | None = None,
) -> Proposals:
    """Light field distances of the pairs that can matter, exact or by the signatures alone as `lfd` says.

    A pair is kept if it is among the `pool` nearest of either node by the quantile signature alone, with size, with
    extent and centrality, with much size, or with much centrality; and all pairs of bottom segments are. So the K best
    under any weights of these are nearly always among them; see `widened` for the other descriptors.
    """
    watch = Stopwatch()
    progress(0.0, "candidate pairs")
    with watch("candidates"):
        pairs = _pooled(source, target, parameters.pool, cache)
    progress(0.2, "light field distances")
    with watch("distances"):
        lfd = _distances(source, target, pairs, parameters.lfd, share(progress, 0.0, 0.4), cache)
    packed = pack(source.measures), pack(target.measures)
    found = _measured(source, target, pairs, lfd, packed, watch.seconds, parameters.lfd)
    with watch("further descriptors"):
        widened(found, parameters)
    if parameters.method == LEARNED:
        with watch("judging pairs"):
            with_judgement(found, progress=share(progress, 0.4, 1.0))
    return found


def every_pair(
    source: DescribedShape, target: DescribedShape, kind: str, *, cache: Cache | None = None
) -> Proposals:
    """All pairs of nodes but the whole shapes, row by row, with light field distances of the kind."""
    n, m = (len(shape.layers.members) - 1 for shape in (source, target))
    pairs = np.indices((n, m)).reshape(2, -1).T
    lfd = _distances(source, target, pairs, kind, silent, cache)
    return _measured(source, target, pairs, lfd, (pack(source.measures), pack(target.measures)), {}, kind)


def widened(proposals: Proposals, p: MatchParameters) -> Proposals:
    """The proposals and the pairs that are near by other descriptors that have a weight, or without the light field.

    Those are the `pool` nearest of either node by each descriptor, by their sum, and by the sum with size and with
    extent and centrality. The same object for the same set of descriptors, so that a slider does not wait twice; the
    proposals themselves where the light field has a weight and none of the others.
    """
    names = active(p)
    if not names and p.lfd_weight:
        return proposals
    key = (names, p.lfd_weight > 0, p.pool)
    if key not in proposals._memory:
        extra = _near_otherwise(proposals, names, p)
        found = _with_more(proposals, extra)
        sets = [known for known in proposals._memory if isinstance(known, tuple)]
        for oldest in sets[: max(0, len(sets) - _REMEMBERED + 1)]:
            proposals._memory.pop(oldest, None)
        proposals._memory[key] = found
        return found
    return proposals._memory[key]  # type: ignore[return-value]


def with_judgement(proposals: Proposals, *, progress: Progress = silent) -> Proposals:
    """The proposals with the probabilities of the learned method, and the pairs that it looks at among them.

    Takes about a second where it was not done before; the same object when asked again.
    """
    if proposals.judged is not None:
        return proposals
    if not is_judged(proposals):
        judged = judge(proposals.source, proposals.target, progress=progress)
        proposals._memory[LEARNED] = replace(_with_more(proposals, judged.pairs), judged=judged)
    return proposals._memory[LEARNED]  # type: ignore[return-value]


def is_judged(proposals: Proposals) -> bool:
    """Whether `with_judgement` answers at once."""
    return proposals.judged is not None or LEARNED in proposals._memory


def codes(pairs: np.ndarray) -> np.ndarray:
    """One number (c,) int64 for each pair (c, 2), ascending where the pairs are sorted."""
    return pairs[:, 0] << 32 | pairs[:, 1]


def _with_more(proposals: Proposals, extra: np.ndarray) -> Proposals:
    """The proposals and those of the pairs `extra` (e, 2) that are not there yet; all marks stay."""
    known = codes(proposals.pairs)
    more = with_pairs(proposals, proposals.source, proposals.target, extra[~np.isin(codes(extra), known)])
    old = np.searchsorted(codes(more.pairs), known)
    marks = [np.zeros(len(more.pairs), dtype=bool) for _ in range(2)]
    marks[0][old], marks[1][old] = proposals.pinned, proposals.barred
    return replace(more, pinned=marks[0], barred=marks[1])


def _near_otherwise(proposals: Proposals, names: Sequence[str], p: MatchParameters) -> np.ndarray:
    """The pairs that `widened` adds, and some that are there already, (e, 2) int64 sorted."""
    source, target = proposals.source, proposals.target
    n, m = (len(shape.layers.members) - 1 for shape in (source, target))
    every = np.indices((n, m)).reshape(2, -1).T
    alone = [(row_distances(source.features[name], target.features[name], every) / SCALES[name]).reshape(n, m)
             for name in names]  # fmt: skip
    total = sum(alone, np.zeros((n, m)))
    if p.lfd_weight:
        total = total + signature_distances(source.signatures[:n], target.signatures[:m])
    size, extent, centrality = _differences(source, target)
    kept = np.zeros((n, m), dtype=bool)
    for distance in (*alone, total, total + size, total + 0.5 * extent + 2 * centrality):
        keep_nearest(kept, distance, p.pool)
    return np.argwhere(kept)


def with_pairs(proposals: Proposals, source: DescribedShape, target: DescribedShape, extra: np.ndarray) -> Proposals:
    """The proposals and further pairs `extra` (e, 2), with their distances.

    `source` and `target` are those of the proposals, or the same with nodes added (see `extending.with_nodes`).
    """
    lfd = _light_field(source, target, extra, proposals.kind)
    pairs, lfd = np.concatenate([proposals.pairs, extra]), np.concatenate([proposals.lfd, lfd])
    order = np.lexsort((pairs[:, 1], pairs[:, 0]))
    packed = (proposals.packed_source if source is proposals.source else pack(source.measures),
              proposals.packed_target if target is proposals.target else pack(target.measures))  # fmt: skip
    found = _measured(source, target, pairs[order], lfd[order], packed, proposals.seconds, proposals.kind)
    return replace(found, judged=proposals.judged)


def open_rows(proposals: Proposals) -> np.ndarray:
    """Rows that a one-to-one method may choose from, (c,) bool: not barred, and at a pinned node its pin alone."""
    pairs, pinned = proposals.pairs, proposals.pinned
    taken = [np.isin(pairs[:, side], pairs[pinned, side]) for side in (0, 1)]
    return pinned | ~(proposals.barred | taken[0] | taken[1])


def _measured(
    source: DescribedShape, target: DescribedShape, pairs: np.ndarray, lfd: np.ndarray,
    packed: tuple[np.ndarray, np.ndarray], seconds: dict[str, float], kind: str,
) -> Proposals:  # fmt: skip
    """Proposals of sorted pairs (c, 2) with their light field distances (c,): all else that is known of a pair."""
    s, t = source.measures, target.measures
    i, j = pairs.T
    bottom = (pairs[:, 0] < len(source.graph.area)) & (pairs[:, 1] < len(target.graph.area))
    return Proposals(
        source, target, pairs, lfd, _apart(s.size[i], t.size[j]), _apart(s.extent[i], t.extent[j]),
        _apart(s.centrality[i], t.centrality[j]), bottom, *packed,
        np.zeros(len(pairs), dtype=bool), np.zeros(len(pairs), dtype=bool), seconds, kind)  # fmt: skip


def _apart(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """|Δ log| of two measures."""
    return np.abs(np.log(x) - np.log(y))


def _pooled(source: DescribedShape, target: DescribedShape, pool: int, cache: Cache | None) -> np.ndarray:
    """The pairs of `_pool`, from the cache where they are known."""
    if cache is None:
        return _pool(source, target, pool)
    parts = [x for s in (source, target) for x in (s.signatures, *(getattr(s.measures, name) for name in _MEASURES))]
    key = cache_key("pool/1", *parts, len(source.graph.area), len(target.graph.area), pool)
    return cache.arrays(key, lambda: {"pairs": _pool(source, target, pool)})["pairs"]


def _pool(source: DescribedShape, target: DescribedShape, pool: int) -> np.ndarray:
    n, m = (len(shape.layers.members) - 1 for shape in (source, target))  # the last node is the whole shape
    near = signature_distances(source.signatures[:n], target.signatures[:m]).astype(np.float64)
    size, extent, centrality = _differences(source, target)
    kept = np.zeros((n, m), dtype=bool)
    kept[: len(source.graph.area), : len(target.graph.area)] = True
    for extra in (0.0, size, 0.5 * extent + 2 * centrality, 5 * size, 2 * extent + 10 * centrality):
        keep_nearest(kept, near + extra, pool)
    return np.argwhere(kept)


def _differences(source: DescribedShape, target: DescribedShape) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Differences in size, extent and centrality of all nodes but the whole shapes, each (n, m)."""
    s, t = source.measures, target.measures
    size, extent, centrality = (_apart(getattr(s, x)[:-1, None], getattr(t, x)[None, :-1]) for x in _MEASURES)
    return size, extent, centrality


def _light_field(source: DescribedShape, target: DescribedShape, pairs: np.ndarray, kind: str) -> np.ndarray:
    """Light field distances of pairs (c, 2), float64: exact, or by the signatures on the same scale."""
    if kind == SIGNATURE:
        return SIGNATURE_SCALE * row_distances(source.signatures, target.signatures, pairs) / VIEWS
    return light_field_distances(source.descriptors, target.descriptors, pairs)


def _distances(
    source: DescribedShape, target: DescribedShape, pairs: np.ndarray, kind: str, progress: Progress, cache: Cache | None
) -> np.ndarray:
    """Light field distances of many pairs; exact ones are slow, so the cache keeps them."""

    def make() -> dict[str, np.ndarray]:
        parts = np.array_split(pairs, max(1, len(pairs) // 20_000))
        found = []
        for number, part in enumerate(parts):
            found.append(light_field_distances(source.descriptors, target.descriptors, part))
            progress(0.2 + 0.8 * (number + 1) / len(parts), "light field distances")
        return {"distances": np.concatenate(found)}

    if kind == SIGNATURE:
        return _light_field(source, target, pairs, kind)
    if cache is None:
        return make()["distances"]
    key = cache_key("distances/1", source.descriptors, target.descriptors, pairs)
    return cache.arrays(key, make)["distances"]
