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
        support = np.zeros((256, n))
        for p in range(1, reach_s + 1):
            for q in range(1, reach_t + 1):
                if table[p, q] > 0:
                    for x in range(n):
                        support[p, x] += table[p, q] * count[q, x]
        for a in range(starts[j], starts[j + 1]):
            i = pairs[a, 0]
            total = 0.0
            for x in range(n):
                total += support[d_source[i, x], x]
            out[a] = total
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


@njit(cache=True, nogil=True, parallel=True, fastmath=True)
def overlap_scores(pairs, g, source, target, agree_from):  # type: ignore[no-untyped-def]
    """score(a) = g_a Σ_b relu((m_ab - from)/(1 - from)) g_b with m = r · ratio, over all other candidates b, (c,)."""
    out = np.zeros(len(pairs))
    slope = np.float32(1.0 / (1.0 - agree_from))
    floor = np.float32(agree_from)
    for a in prange(len(pairs)):
        s, t = source[pairs[a, 0]], target[pairs[a, 1]]
        total = 0.0
        for b in range(len(pairs)):
            x, y = pairs[b, 0], pairs[b, 1]
            r = np.float32(1) - max(abs(s[x, 0] - t[y, 0]), abs(s[x, 1] - t[y, 1]))
            if r <= floor or a == b:
                continue
            low, high = min(s[x, 2], t[y, 2]), max(s[x, 2], t[y, 2])
            m = r * (low + np.float32(1e-6)) / (high + np.float32(1e-6))
            if m > floor:
                total += (m - floor) * slope * g[b]
        out[a] = total * g[a]
    return out
