"""SHED's matching of segments, one-to-many, as a baseline on the bottom layer alone.

After Kleiman, van Kaick, Sorkine-Hornung & Cohen-Or (2015), "SHED: Shape Edit Distance for fine-grained shape
similarity", sections 4 and 5: own descriptors, own adjacency, adaptive spectral matching.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from ..consistency.candidates import k_best
from ..consistency.spectral import adaptive_rounds
from .describing import DescribedShape
from .hops import UNREACHABLE, hop_distances
from .judged import beside_pins
from .mesh import face_areas
from .parameters import MatchParameters
from .proposing import Proposals
from .segmentation import SHARED

_SAMPLES, _BINS, _SEED = 1024, 64, 0
_FEWEST_FACES = 4
_NEAR = 0.08  # vertex distance of touching parts, where the shape's longest side is 2
_COST_SCALE, _PAIR_WEIGHT = 0.5, 0.3
_MOST_CANDIDATES = 900  # all pairs of 30 and 30 segments
_REMEMBERED = 32

Parts = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True, slots=True, eq=False)
class ShedFeatures:
    """What SHED knows of the s segments of a shape.

    `kept` (s,) bool: segments of more than three faces; `size` (s,) Σ of the principal standard deviations to the power
    of .75; `d1`, `d2` (s, 64) histograms that sum to 1; `hops` (s, s) in the segment graph, s + 1 where unreachable.
    """

    kept: np.ndarray
    size: np.ndarray
    d1: np.ndarray
    d2: np.ndarray
    hops: np.ndarray


def match_shed(proposals: Proposals, p: MatchParameters) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Rows of `proposals.pairs` that are accepted, best first, with score, similarity and votes (each (p,)).

    A segment with several partners has a row for each. Score is the mean affinity with the other matches, relative
    to the highest that two matches can have.
    """
    source, target = features(proposals.source), features(proposals.target)
    pairs = proposals.pairs
    pinned = np.flatnonzero(proposals.pinned)
    rows = np.flatnonzero(proposals.bottom & beside_pins(proposals))
    rows = rows[source.kept[pairs[rows, 0]] & target.kept[pairs[rows, 1]]]
    cost = histogram_cost(source, target)[tuple(pairs[rows].T)]
    few = _few(pairs[rows], cost) | proposals.pinned[rows]
    rows, cost = rows[few], cost[few]
    affinity = shed_affinity(pairs[rows], cost, source, target)
    free = tuple(_free(shape, features, pairs[pinned, side]) for side, (shape, features) in
                 enumerate(((proposals.source, source), (proposals.target, target))))  # fmt: skip
    fixed = np.flatnonzero(proposals.pinned[rows])
    accepted = adaptive_rounds(pairs[rows], affinity, fixed, (free[0], free[1]))
    among = affinity[np.ix_(accepted, accepted)] / _PAIR_WEIGHT
    mean = (among.sum(axis=1) - among.diagonal()) / max(len(accepted) - 1, 1)
    unions = np.setdiff1d(pinned, rows[accepted])
    chosen, score = np.concatenate([unions, rows[accepted]]), np.concatenate([np.ones(len(unions)), mean])
    order = np.lexsort((chosen, -score))
    chosen = chosen[order]
    similarity = np.exp(-proposals.lfd[chosen] / p.sigma)
    return chosen, np.clip(score[order], 0, 1), similarity, np.zeros(len(chosen), dtype=np.int64)


def _free(shape: DescribedShape, features: ShedFeatures, pinned: np.ndarray) -> np.ndarray:
    """Segments that are still to be matched: kept, and in no pinned node."""
    return features.kept & ~shape.layers.members[pinned].any(axis=0)


def _few(pairs: np.ndarray, cost: np.ndarray) -> np.ndarray:
    """All pairs where they are few enough for rounds of eigenvectors, else the nearest of each segment."""
    if len(pairs) <= _MOST_CANDIDATES:
        return np.ones(len(pairs), dtype=bool)
    ends = sum(len(np.unique(pairs[:, side])) for side in (0, 1))
    k = max(1, _MOST_CANDIDATES // ends)
    return k_best(pairs, cost, k, side=0) | k_best(pairs, cost, k, side=1)


def histogram_cost(source: ShedFeatures, target: ShedFeatures) -> np.ndarray:
    """½ χ²(D1) + ½ χ²(D2), (s, t) float64 in [0, 2]."""
    return 0.5 * _chi_squared(source.d1, target.d1) + 0.5 * _chi_squared(source.d2, target.d2)


def _chi_squared(h: np.ndarray, g: np.ndarray) -> np.ndarray:
    total = h[:, None] + g[None]
    return ((h[:, None] - g[None]) ** 2 / np.where(total > 0, total, 1.0)).sum(axis=-1)


def shed_affinity(pairs: np.ndarray, cost: np.ndarray, source: ShedFeatures, target: ShedFeatures) -> np.ndarray:
    """Diagonal exp(-cost/.5); of (a, b) and (c, d) .3·exp(-½(adj + scale)), 0 where a = c or b = d; (c, c) float64.

    adj is how far the hops from a to c and from b to d differ, scale how far the size ratios of a:b and of c:d do, both
    as max/min - 1.
    """
    a, b = pairs.T
    same = (a[:, None] == a) | (b[:, None] == b)
    p, q = (np.where(same, 1, f.hops[np.ix_(x, x)]) for f, x in ((source, a), (target, b)))
    ratio = source.size[a] / target.size[b]
    adj, scale = _times(p, q), _times(ratio[:, None], ratio)
    affinity = np.where(same, 0.0, _PAIR_WEIGHT * np.exp(-0.5 * (adj + scale)))
    np.fill_diagonal(affinity, np.exp(-cost / _COST_SCALE))
    return affinity


def _times(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.maximum(x, y) / np.minimum(x, y) - 1.0


_features: dict[tuple[bytes | str, ...], ShedFeatures] = {}


def features(shape: DescribedShape) -> ShedFeatures:
    """The features of a shape, remembered by content for the shapes met last."""
    touching = shape.graph.edges[shape.graph.kind == SHARED]
    key = (*shape.segment_ids, touching.tobytes())
    known = _features.pop(key, None) or _compute(shape, touching)
    _features[key] = known
    for oldest in list(_features)[:-_REMEMBERED]:
        _features.pop(oldest, None)
    return known


def _compute(shape: DescribedShape, touching: np.ndarray) -> ShedFeatures:
    mesh, segmentation = shape.shape.mesh, shape.shape.segmentation
    used = mesh.vertices[np.unique(mesh.faces)]
    low, high = used.min(axis=0), used.max(axis=0)
    vertices = (mesh.vertices - (low + high) / 2) / (np.max(high - low) / 2)
    area, count = face_areas(mesh), segmentation.count
    faces = [np.flatnonzero(segmentation.labels == k) for k in range(count)]
    points = [vertices[np.unique(mesh.faces[rows])] for rows in faces]
    histograms = [_histograms(vertices[mesh.faces[rows]], area[rows], places.mean(axis=0))
                  for rows, places in zip(faces, points, strict=True)]  # fmt: skip
    return ShedFeatures(
        np.array([len(rows) >= _FEWEST_FACES for rows in faces]), np.array([_size(places) for places in points]),
        np.array([h for h, _ in histograms]), np.array([h for _, h in histograms]), _hops(points, touching))  # fmt: skip


def _size(points: np.ndarray) -> float:
    """Σ over the principal axes of the standard deviation to the power of .75."""
    variance = np.linalg.eigvalsh(np.cov(points.T)) if len(points) > 1 else np.zeros(3)
    return max(float((np.maximum(variance, 0.0) ** 0.375).sum()), 1e-9)


def _histograms(triangles: np.ndarray, area: np.ndarray, middle: np.ndarray) -> Parts:
    """D1 (to the mean of the vertices) and D2 (between two points) of a segment, each from its least to its greatest."""
    rng = np.random.default_rng(_SEED)  # the same for every segment: their order does not matter
    first, second = (_sample(triangles, area, rng) for _ in range(2))
    return _histogram(first - middle), _histogram(first - second)


def _sample(triangles: np.ndarray, area: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    heights = np.cumsum(area + 1e-12 * area.max() + 1e-300)
    rows = np.searchsorted(heights, rng.random(_SAMPLES) * heights[-1])
    root, v = np.sqrt(rng.random(_SAMPLES)), rng.random(_SAMPLES)
    weight = np.stack([1 - root, root * (1 - v), root * v], axis=1)
    return np.einsum("nk,nkd->nd", weight, triangles[np.minimum(rows, len(triangles) - 1)])


def _histogram(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=1)
    return np.histogram(length, bins=_BINS, range=(length.min(), length.max()))[0] / len(length)


def _hops(points: list[np.ndarray], touching: np.ndarray) -> np.ndarray:
    """Hops between segments that share vertices; where these fall apart, near ones count as touching, too."""
    count = len(points)
    hops = hop_distances(count, touching)
    if (hops == UNREACHABLE).any():
        trees = [KDTree(places) for places in points]
        near = [(i, j) for i in range(count) for j in range(i + 1, count)
                if trees[i].query(points[j], distance_upper_bound=_NEAR)[0].min() < _NEAR]  # fmt: skip
        hops = hop_distances(count, np.concatenate([touching, np.array(near, dtype=np.int64).reshape(-1, 2)]))
    return np.where(hops == UNREACHABLE, count + 1, hops.astype(np.int64))
