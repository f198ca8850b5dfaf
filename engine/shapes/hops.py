"""Distances in the multi-layer graph: all edges count 1 (thesis section 3.3.1)."""

import numpy as np
from numba import njit, prange

UNREACHABLE = 255


def hop_distances(count: int, edges: np.ndarray) -> np.ndarray:
    """Number of edges on the shortest path between all nodes, (k, k) uint8; `UNREACHABLE` where there is none.

    Breadth-first search from every node on packed bit rows; distances beyond 254 count as unreachable.
    """
    rows = np.zeros((count, (count + 63) // 64), dtype=np.uint64)
    for a, b in (edges.T, edges.T[::-1]):
        np.bitwise_or.at(rows, (a, b // 64), np.uint64(1) << (b % 64).astype(np.uint64))
    return _search(rows, count)


@njit(cache=True, nogil=True, parallel=True)
def _search(rows: np.ndarray, count: int) -> np.ndarray:
    words = rows.shape[1]
    out = np.full((count, count), np.uint8(255))
    for source in prange(count):
        seen = np.zeros(words, dtype=np.uint64)
        front = np.zeros(words, dtype=np.uint64)
        front[source >> 6] = np.uint64(1) << np.uint64(source & 63)
        level = 0
        while level < 255:
            alive = False
            following = np.zeros(words, dtype=np.uint64)
            for w in range(words):
                seen[w] |= front[w]
            for w in range(words):
                word = front[w]
                if word == 0:
                    continue
                alive = True
                for bit in range(64):
                    if word >> np.uint64(bit) & np.uint64(1):
                        node = 64 * w + bit
                        out[source, node] = level
                        for k in range(words):
                            following[k] |= rows[node, k]
            if not alive:
                break
            for w in range(words):
                front[w] = following[w] & ~seen[w]
            level += 1
    return out


def diameter(distances: np.ndarray) -> int:
    """The largest distance D between nodes that reach each other."""
    return max(0, int((distances + np.uint8(1)).max(initial=0)) - 1)  # unreachable ones turn over to zero
