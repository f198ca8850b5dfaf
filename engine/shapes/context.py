"""What the rest of a pair says about each candidate: rivals, agreement with likely matches, and a transport of segments."""

from dataclasses import dataclass

import numpy as np
from numba import njit, prange

from ..consistency.candidates import k_best
from ..consistency.diffusion import greedy
from .agreement import overlap_agreement, overlap_clashes, overlap_scores, pack
from .describing import DescribedShape

FEATURES, OF_HYPOTHESIS = 19, 18
LIKELY, MOST = 0.15, 500  # matches that are asked: at least so likely, and so many
SMALL = 0.25  # share of area below which a node is small
ROUNDS, DAMPING = 8, 0.8
NEAREST, AGREE_FROM, OVERLAP_MIN, RATIO_MIN = 7, 0.7, 0.6, 0.5  # of a hypothesis, as the top-down method has them


@dataclass(frozen=True, slots=True, eq=False)
class Neighbourhood:
    """Two shapes as candidates see each other: `packed_*` (k, k, 3) see `agreement.pack`, `members_*` (k, s) bool,
    `area_*` (s,) shares of area, above 0."""

    packed_source: np.ndarray
    packed_target: np.ndarray
    members_source: np.ndarray
    members_target: np.ndarray
    area_source: np.ndarray
    area_target: np.ndarray


def neighbourhood(source: DescribedShape, target: DescribedShape) -> Neighbourhood:
    """Of two described shapes."""
    return neighbourhood_of(source, target, pack(source.measures), pack(target.measures))


def neighbourhood_of(
    source: DescribedShape, target: DescribedShape, packed_source: np.ndarray, packed_target: np.ndarray
) -> Neighbourhood:
    """The same where the nodes are packed already."""
    areas = (np.maximum(shape.graph.area / shape.graph.area.sum(), 1e-9) for shape in (source, target))
    return Neighbourhood(packed_source, packed_target, source.layers.members, target.layers.members, *areas)


def context_features(pairs: np.ndarray, probability: np.ndarray, around: Neighbourhood) -> np.ndarray:
    """Features (c, 19) float32 of candidates (c, 2) that have a `probability` (c,) in [0, 1].

    Log odds; lead over the best rival at either node; means over the likely matches, weighted by their probability, of
    how well they agree in overlap and distance, all of them, those apart, those nested and the small ones; their
    number; and what a transport between the segments, fed by all candidates, says of the two nodes.
    """
    p = probability.astype(np.float64)
    rivals = [np.log((p + 0.01) / (_rival(pairs[:, side], p) + 0.01)) for side in (0, 1)]
    asked = _asked(pairs, p)
    means, total = _heard(pairs, asked, p[asked], around)
    votes = p**2 * (p > 0.2)
    columns = [np.log((p + 1e-4) / (1 - p + 1e-4)), *rivals, *means, np.log1p(total), *_transported(pairs, votes, around)]
    return np.stack(columns, axis=1).astype(np.float32)


def hypothesis_features(pairs: np.ndarray, weight: np.ndarray, around: Neighbourhood) -> np.ndarray:
    """What the set of matches that support each other most says of each candidate, (c, 18) float32.

    The set is found as in the top-down method: the nearest candidates of each node by `weight` (c,), each scored by the
    agreement of all others, then taken greedily. Features: agreement with the set as in `context_features`, a transport
    fed by it alone, whether a candidate is in it, the logarithm of its score, and how well the set agrees in itself.
    """
    rows = np.flatnonzero(k_best(pairs, -weight, NEAREST, side=0) | k_best(pairs, -weight, NEAREST, side=1))
    near = np.ascontiguousarray(pairs[rows])
    score = overlap_scores(near, weight[rows], around.packed_source, around.packed_target, AGREE_FROM)

    def conflicts(a: int, others: np.ndarray) -> np.ndarray:
        i, j = near[a]
        return overlap_clashes(i, j, near, others, around.packed_source, around.packed_target, OVERLAP_MIN, RATIO_MIN)

    chosen = rows[greedy(near, score, conflicts)]
    inside, strength = np.zeros(len(pairs)), np.zeros(len(pairs))
    inside[chosen] = 1.0
    strength[rows] = score / max(float(score.max(initial=0.0)), 1e-300)
    means, _ = _heard(pairs, chosen, strength[chosen], around)
    r, ratio = overlap_agreement(around.packed_source, around.packed_target, pairs[chosen][:, None], pairs[chosen][None])
    within = float((r * ratio).mean()) if len(chosen) else 0.0
    columns = [*means, *_transported(pairs, inside * strength, around), inside, np.log(strength + 1e-4), np.full(len(pairs), within)]
    return np.stack(columns, axis=1).astype(np.float32)


def _heard(
    pairs: np.ndarray, asked: np.ndarray, weight: np.ndarray, around: Neighbourhood
) -> tuple[list[np.ndarray], np.ndarray]:
    """Ten weighted means over the matches `asked` (rows), each (c,), and the total weight that spoke, (c,)."""
    sums = np.zeros((len(pairs), 14))
    if len(asked):
        sizes = around.members_source.astype(np.float64) @ around.area_source
        x, y = np.ascontiguousarray(pairs[asked].T)
        _sums(np.ascontiguousarray(pairs[:, 0]), np.ascontiguousarray(pairs[:, 1]), x, y, weight, sizes[x] < SMALL,
              around.packed_source, around.packed_target, sums)  # fmt: skip
    means = [np.where(sums[:, d] > 1e-6, sums[:, n] / np.maximum(sums[:, d], 1e-6), 0.5)
             for n, d in ((1, 0), (2, 0), (3, 0), (4, 0), (6, 5), (7, 5), (9, 8), (10, 8), (12, 11), (13, 11))]  # fmt: skip
    return means, sums[:, 0]


def _rival(node: np.ndarray, p: np.ndarray) -> np.ndarray:
    """The highest probability of another candidate at the same node, (c,)."""
    count = int(node.max()) + 1
    best, second = np.zeros(count), np.zeros(count)
    np.maximum.at(best, node, p)
    first = p >= best[node] - 1e-9
    np.maximum.at(second, node, np.where(first, 0, p))
    second = np.where(np.bincount(node, first, minlength=count) > 1, best, second)
    return np.where(first, second[node], best[node])


def _asked(pairs: np.ndarray, p: np.ndarray) -> np.ndarray:
    """The likely candidates that are the best at one of their nodes, best first."""
    order = np.argsort(-p, kind="stable")
    best = np.zeros(len(p), dtype=bool)
    for side in (0, 1):
        best[np.unique(pairs[order, side], return_index=True)[1]] = True
    asked = order[best]
    return asked[p[asked] >= LIKELY][:MOST]


def _transported(pairs: np.ndarray, given: np.ndarray, around: Neighbourhood) -> list[np.ndarray]:
    """Shares of each node's area that a transport between the segments carries into the other node, (5, c).

    Each candidate spreads what it is `given` (c,) over the pairs of its segments; the table is then brought near to the
    areas.
    """
    m, n = around.members_source.astype(np.float64), around.members_target.astype(np.float64)
    a, b = around.area_source, around.area_target
    votes = np.zeros((len(m), len(n)))
    votes[pairs[:, 0], pairs[:, 1]] = given
    flow = ((m / (m @ a)[:, None]).T @ votes @ (n / (n @ b)[:, None]) + 1e-12) * a[:, None] * b
    for _ in range(ROUNDS):
        flow *= ((a / flow.sum(axis=1)) ** DAMPING)[:, None]
        flow *= (b / flow.sum(axis=0)) ** DAMPING
    i, j = pairs.T
    common, left, right = (m @ flow @ n.T)[i, j], (m @ flow.sum(axis=1))[i], (n @ flow.sum(axis=0))[j]
    jaccard = common / (left + right - common)
    behind = []
    for node in (i, j):
        best = np.zeros(int(node.max()) + 1)
        np.maximum.at(best, node, jaccard)
        behind.append(jaccard / (best[node] + 1e-6))
    return [common / np.maximum(left, right), common / np.minimum(left, right), jaccard, *behind]


@njit(cache=True, parallel=True)
def _sums(i, j, x, y, weight, small, source, target, out):  # type: ignore[no-untyped-def]
    """Weighted sums over the matches (x, y) asked, for each candidate (i, j): see `context_features`."""
    tiny = 1e-6
    for a in prange(len(i)):
        for b in range(len(x)):
            if x[b] == i[a] and y[b] == j[a]:
                continue
            s, t, w = source[i[a], x[b]], target[j[a], y[b]], weight[b]
            r = 1 - max(abs(s[0] - t[0]), abs(s[1] - t[1]))
            ratio = (min(s[2], t[2]) + tiny) / (max(s[2], t[2]) + tiny)
            good = max(r * ratio - 0.7, 0.0) / 0.3
            out[a, 0] += w
            out[a, 1] += w * r * ratio
            out[a, 2] += w * good
            out[a, 3] += w * (r < 0.6)
            out[a, 4] += w * (ratio < 0.5)
            if s[0] < 0.02 and t[0] < 0.02:
                out[a, 5] += w
                out[a, 6] += w * ratio
                out[a, 7] += w * ratio**4
            if s[0] > 0.98 or s[1] > 0.98:
                out[a, 8] += w
                out[a, 9] += w * r
                out[a, 10] += w * (r < 0.6)
            if small[b]:
                out[a, 11] += w
                out[a, 12] += w * r * ratio
                out[a, 13] += w * good
