"""How well two candidate matches agree: by hops in the two graphs (thesis), or by overlap and geodesic distance."""

import numpy as np
from numba import njit, prange

from .hops import UNREACHABLE
from .measures import Measures


def isometry(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """m of Eq 3.3: min(p/q, q/p) of distances; 0 where either is zero or unreachable."""
    p, q = np.asarray(p, dtype=np.float64), np.asarray(q, dtype=np.float64)
    apart = (p > 0) & (q > 0) & (p < UNREACHABLE) & (q < UNREACHABLE)
    return np.where(apart, np.minimum(p, q) / np.maximum(np.maximum(p, q), 1), 0.0)


def affinity_table(reach_source: int, reach_target: int, c_0: float) -> np.ndarray:
    """Off-diagonal affinity of Eq 3.3 by the two distances: (m - c₀)/(1 - c₀) where m >= c₀, else 0.

    (reach_source + 1, reach_target + 1) float64; row and column 0 are zero, distances beyond are outside the regions.
    """
    m = isometry(np.arange(reach_source + 1)[:, None], np.arange(reach_target + 1)[None])
    return np.where(m >= c_0, (m - c_0) / (1 - c_0), 0.0) * (m > 0)


def affinity_degrees(
    pairs: np.ndarray, similarity: np.ndarray, d_source: np.ndarray, d_target: np.ndarray, table: np.ndarray
) -> np.ndarray:
    """Row sums (c,) of the affinity matrix of Eq 3.3, without building it.

    For each target node j the candidates are counted by their target's distance to j, which turns the sum over all
    candidates into one look-up for each source node: 2·N² steps for each candidate a node has, instead of K²·N².
    `table` is that of `affinity_table`; the diagonal is `similarity` (c,).
    """
    order = np.argsort(pairs[:, 1], kind="stable")
    starts = np.searchsorted(pairs[order, 1], np.arange(d_target.shape[0] + 1))
    return similarity + _degrees(pairs[order], starts, d_source, d_target, table)[np.argsort(order, kind="stable")]


@njit(cache=True, nogil=True, parallel=True)
def _degrees(pairs, starts, d_source, d_target, table):  # type: ignore[no-untyped-def]
    out = np.zeros(len(pairs))
    n = d_source.shape[0]
    reach_s, reach_t = table.shape[0] - 1, table.shape[1] - 1
    for j in prange(len(starts) - 1):
        if starts[j] == starts[j + 1]:
            continue
        count = np.zeros((reach_t + 1, n))
        for b in range(len(pairs)):
            q = d_target[j, pairs[b, 1]]
            if 1 <= q <= reach_t:
                count[q, pairs[b, 0]] += 1
        support = np.zeros((n, reach_s + 2))  # the last column stays zero, for all that is beyond the reach
        for p in range(1, reach_s + 1):
            for q in range(1, reach_t + 1):
                if table[p, q] > 0:
                    for x in range(n):
                        support[x, p] += table[p, q] * count[q, x]
        for a in range(starts[j], starts[j + 1]):
            i = pairs[a, 0]
            total = 0.0
            for x in range(n):
                total += support[x, min(d_source[i, x], reach_s + 1)]
            out[a] = total
    return out


@njit(cache=True, nogil=True)
def affinity_total(pairs, d_source, d_target, table):  # type: ignore[no-untyped-def]
    """Sum of all affinities between the matches `pairs` (p, 2), each with each, without the diagonal."""
    total = 0.0
    for a in range(len(pairs)):
        for b in range(len(pairs)):
            p, q = d_source[pairs[a, 0], pairs[b, 0]], d_target[pairs[a, 1], pairs[b, 1]]
            if p < table.shape[0] and q < table.shape[1]:
                total += table[p, q]
    return total


@njit(cache=True, nogil=True)
def hop_clashes(i, j, pairs, others, d_source, d_target, clash):  # type: ignore[no-untyped-def]
    """Which candidates `others` (rows of `pairs`) clash with the match (i, j): `clash` by the hops on either side."""
    out = np.empty(len(others), dtype=np.bool_)
    for k in range(len(others)):
        out[k] = clash[d_source[i, pairs[others[k], 0]], d_target[j, pairs[others[k], 1]]]
    return out


def pack(measures: Measures) -> np.ndarray:
    """What `overlap_scores` reads of one shape, (k, k, 3) float32: overlap of i in x, of x in i, geodesic distance."""
    return np.stack([measures.overlap, measures.overlap.T, measures.geodesic], axis=-1)


def overlap_agreement(
    source: np.ndarray, target: np.ndarray, a: np.ndarray, b: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Agreement of matches a and b (each (..., 2)) by two numbers in [0, 1].

    r = 1 - max(|O_S(i,x) - O_T(j,y)|, |O_S(x,i) - O_T(y,j)|) compares how the nodes overlap on the two sides; the
    ratio of the geodesic distances compares how far they are apart. `source` and `target` come from `pack`.
    """
    s, t = source[a[..., 0], b[..., 0]], target[a[..., 1], b[..., 1]]
    r = 1 - np.maximum(np.abs(s[..., 0] - t[..., 0]), np.abs(s[..., 1] - t[..., 1]))
    low, high = np.minimum(s[..., 2], t[..., 2]), np.maximum(s[..., 2], t[..., 2])
    return r, (low + 1e-6) / (high + 1e-6)


@njit(cache=True, nogil=True)
def overlap_clashes(i, j, pairs, others, source, target, overlap_min, ratio_min):  # type: ignore[no-untyped-def]
    """Which candidates `others` (rows of `pairs`) agree less with the match (i, j), by r or the ratio, than is asked."""
    out = np.empty(len(others), dtype=np.bool_)
    tiny = np.float32(1e-6)
    for k in range(len(others)):
        s, t = source[i, pairs[others[k], 0]], target[j, pairs[others[k], 1]]
        r = np.float32(1) - max(abs(s[0] - t[0]), abs(s[1] - t[1]))
        ratio = (min(s[2], t[2]) + tiny) / (max(s[2], t[2]) + tiny)
        out[k] = r < overlap_min or ratio < ratio_min
    return out


def overlap_scores(
    pairs: np.ndarray, g: np.ndarray, source: np.ndarray, target: np.ndarray, agree_from: float
) -> np.ndarray:
    """score(a) = g_a Σ_b relu((m_ab - from)/(1 - from)) g_b with m = r · ratio, over all other candidates b, (c,).

    `pairs` (c, 2), `g` (c,); `source` and `target` come from `pack`. In float32. The sum does not depend on the number
    of threads.
    """
    rows, columns = (np.ascontiguousarray(pairs[:, side], dtype=np.int32) for side in (0, 1))
    total = _overlap_sums(rows, columns, g.astype(np.float32), source, target, np.float32(agree_from))
    return g * total.sum(axis=0) / (1 - agree_from)


@njit(cache=True, nogil=True, parallel=True, fastmath=True)
def _overlap_sums(rows, columns, g, source, target, floor):  # type: ignore[no-untyped-def]
    """Σ_b relu(m_ab - from) g_b over all b but a itself, in parts (parts, c) that are to be added up.

    m is symmetric, so each pair is looked at once. The candidates b come in blocks, for which all that is read of either
    shape is first laid out in straight rows, one for each node; within a block all look at all.
    """
    count, parts, width = len(rows), 8, 256
    out = np.zeros((parts, count))
    for part in prange(parts):
        s, t = np.empty((len(source), 3, width), np.float32), np.empty((len(target), 3, width), np.float32)
        sums, unused = np.zeros(width, np.float32), np.zeros(width, np.float32)
        for first in range(part * width, count, parts * width):
            size = min(width, count - first)
            _spread(source[: rows[: first + size].max() + 1], rows[first : first + size], s)
            _spread(target, columns[first : first + size], t)
            weight = g[first : first + size].copy()
            sums[:] = 0
            for a in range(first):
                out[part, a] += _support(s[rows[a]], t[columns[a]], g[a], weight, floor, sums)
            for b in range(size):
                a, weight[b] = first + b, 0  # nothing supports itself
                out[part, a] += sums[b] + _support(s[rows[a]], t[columns[a]], g[a], weight, floor, unused)
                weight[b] = g[a]
    return out


@njit(cache=True, nogil=True)
def _spread(packed, nodes, out):  # type: ignore[no-untyped-def]
    """For every node i, what `pack` says of it and each of `nodes`: out[i, 0..2, k]."""
    for i in range(len(packed)):
        for k in range(len(nodes)):
            x = nodes[k]
            out[i, 0, k], out[i, 1, k], out[i, 2, k] = packed[i, x, 0], packed[i, x, 1], packed[i, x, 2]


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _support(s, t, g, weight, floor, sums):  # type: ignore[no-untyped-def]
    """What the candidates of a block give to one of weight g; `sums` takes what it gives to them."""
    total, one, zero, tiny = np.float32(0), np.float32(1), np.float32(0), np.float32(1e-6)
    for b in range(len(weight)):
        r = one - max(abs(s[0, b] - t[0, b]), abs(s[1, b] - t[1, b]))
        ratio = (min(s[2, b], t[2, b]) + tiny) / (max(s[2, b], t[2, b]) + tiny)
        m = max(r * ratio - floor, zero)
        total += m * weight[b]
        sums[b] += m * g
    return total
