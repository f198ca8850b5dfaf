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


def overlap_scores(
    pairs: np.ndarray, g: np.ndarray, source: np.ndarray, target: np.ndarray, agree_from: float
) -> np.ndarray:
    """score(a) = g_a Σ_b relu((m_ab - from)/(1 - from)) g_b with m = r · ratio, over all other candidates b, (c,).

    `pairs` (c, 2) must be sorted by the source, `g` (c,); `source` and `target` come from `pack`. In float32.
    """
    starts = np.searchsorted(pairs[:, 0], np.arange(len(source) + 1))
    columns = np.ascontiguousarray(pairs[:, 1], dtype=np.int32)
    weight = g.astype(np.float32)
    t_in, t_of, t_geo = (np.ascontiguousarray(target[..., k]) for k in range(3))
    total = _overlap_sums(pairs[:, 0], columns, starts, weight, source, t_in, t_of, t_geo, np.float32(agree_from))
    return g * total / (1 - agree_from)


@njit(cache=True, nogil=True, parallel=True, fastmath=True)
def _overlap_sums(rows, columns, starts, g, source, t_in, t_of, t_geo, floor):  # type: ignore[no-untyped-def]
    """Σ_b relu(m_ab - from) g_b over all b but a itself; candidates of one source share what they read of it."""
    count = len(columns)
    out = np.zeros(count)
    tiny, one, zero = np.float32(1e-6), np.float32(1), np.float32(0)
    for i in prange(len(starts) - 1):
        if starts[i] == starts[i + 1]:
            continue
        s_in, s_of, s_geo = np.empty(count, np.float32), np.empty(count, np.float32), np.empty(count, np.float32)
        for b in range(count):
            s_in[b], s_of[b], s_geo[b] = source[i, rows[b], 0], source[i, rows[b], 1], source[i, rows[b], 2]
        for a in range(starts[i], starts[i + 1]):
            inside, of, geo = t_in[columns[a]], t_of[columns[a]], t_geo[columns[a]]
            total = zero
            for b in range(count):
                y = columns[b]
                r = one - max(abs(s_in[b] - inside[y]), abs(s_of[b] - of[y]))
                ratio = (min(s_geo[b], geo[y]) + tiny) / (max(s_geo[b], geo[y]) + tiny)
                total += max(r * ratio - floor, zero) * (g[b] if b != a else zero)
            out[a] = total
    return out
