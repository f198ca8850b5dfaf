"""Which unions of segments become nodes: the four modes of the multi-layer graph.

A union is a Python integer whose bit i says that segment i belongs to it. All modes go breadth first and cap each
size or layer by itself, so that no region of the shape is dropped.
"""

from collections.abc import Callable, Sequence

import numpy as np

Unions = list[int]
Around = dict[int, int]  # union -> the segments adjacent to any of its own
Pairs = dict[int, list[tuple[int, int]]]  # union -> the pairs of smaller nodes that generate it


def bits(union: int) -> list[int]:
    """The segments of a union, ascending."""
    found = []
    while union:
        low = union & -union
        found.append(low.bit_length() - 1)
        union ^= low
    return found


def grown(unions: Around, neighbours: Sequence[int]) -> Around:
    """All distinct unions with one adjacent segment more, and what lies around each."""
    found: Around = {}
    for union, around in unions.items():
        for i in bits(around & ~union):
            larger = union | (1 << i)
            if larger not in found:
                found[larger] = around | neighbours[i]
    return found


def members_of(unions: Sequence[int], count: int) -> np.ndarray:
    """Membership (k, s) bool of unions over s segments."""
    width = (count + 7) // 8
    packed = np.frombuffer(b"".join(u.to_bytes(width, "little") for u in unions), dtype=np.uint8)
    return np.unpackbits(packed.reshape(len(unions), width), axis=1, count=count, bitorder="little").astype(bool)


def normalised_cuts(members: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Normalised cut (Shi & Malik 2000) of each union (k,) under symmetric edge weights (s, s)."""
    m = members.astype(np.float64)
    degree = weights.sum(axis=1)
    volume = m @ degree
    cut = volume - np.einsum("ks,ks->k", m @ weights, m)
    rest = degree.sum() - volume
    tiny = 1e-12 * max(float(degree.sum()), 1e-300)
    return cut / np.maximum(volume, tiny) + cut / np.maximum(rest, tiny)


def spread_best(members: np.ndarray, cost: np.ndarray, most: int) -> np.ndarray:
    """Rows of the `most` cheapest unions, dealt out so that every segment has its own best among them.

    A union ranks by the best place that it takes in the list of any segment it holds, then by its cost.
    """
    if len(members) <= most:
        return np.arange(len(members))
    order = np.lexsort((np.arange(len(cost)), cost))
    sorted_members = members[order]
    place = np.where(sorted_members, np.cumsum(sorted_members, axis=0), len(members) + 1).min(axis=1)
    return np.sort(order[np.argsort(place, kind="stable")[:most]])


def connected_sets(neighbours: Sequence[int], weights: np.ndarray, *, largest: int, most: int) -> tuple[Unions, bool]:
    """All connected unions of 2..`largest` segments; each size is capped by its share of `most`.

    Returns the unions by size, and whether the cap was met.
    """
    count = len(neighbours)
    sizes = range(2, min(largest, count - 1) + 1)
    level: Around = {1 << i: neighbours[i] for i in range(count)}
    result: Unions = []
    capped = False
    for position, _ in enumerate(sizes):
        level = grown(level, neighbours)
        quota = (most - len(result)) // (len(sizes) - position)
        capped |= len(level) > quota
        level = _best(level, weights, quota)
        result += level
    return result, capped


def beam_sets(
    neighbours: Sequence[int],
    weights: np.ndarray,
    *,
    largest: int,
    most: int,
    tell: Callable[[float], None] = lambda share: None,
) -> tuple[Unions, bool]:
    """Connected unions of 2..`largest` segments, the best by normalised cut, at most `most` of them.

    Sizes grow one by one, but beyond 6 segments only about every fifth larger size is kept, as neighbouring sizes
    hold nearly the same unions. `tell` is called with the share of the sizes done.
    """
    count = len(neighbours)
    largest = min(largest, count - 1)
    kept_sizes = _kept_sizes(largest)
    level: Around = {1 << i: neighbours[i] for i in range(count)}
    result: Unions = []
    capped, position = False, 0
    for size in range(2, largest + 1):
        tell(size / count)
        level = grown(level, neighbours)
        quota = (most - len(result)) // max(1, len(kept_sizes) - position)
        if size in kept_sizes:
            position += 1
            capped |= len(level) > quota
            level = _best(level, weights, max(quota, count))
            result += _best(level, weights, quota)
        else:
            level = _best(level, weights, max(quota, count))
    return result, capped


def _best(level: Around, weights: np.ndarray, most: int) -> Around:
    """At most `most` unions of a level, by `spread_best` on their normalised cuts."""
    if len(level) <= most:
        return level
    unions = list(level)
    members = members_of(unions, len(weights))
    rows = spread_best(members, normalised_cuts(members, weights), most)
    return {unions[row]: level[unions[row]] for row in rows}


def _kept_sizes(largest: int) -> set[int]:
    sizes, size = set(), 2
    while size <= largest:
        sizes.add(size)
        size = max(size + 1, int(size * 1.2)) if size >= 6 else size + 1
    return sizes


def layered_unions(
    neighbours: Sequence[int],
    layer_of: Callable[[int], int],
    *,
    layers: int,
    largest: int,
    most: int,
    relaxed: bool,
) -> tuple[Unions, Pairs, bool]:
    """The recursion of Eq 3.1: unions of two adjacent or overlapping nodes of one layer m, placed by their size.

    `layer_of` gives the layer of a union of at most `largest` segments; it must lie above m, or for `relaxed` and
    m >= 2 may be m itself.

    Returns the unions in order of discovery, the pairs that generate each, and whether a layer met its cap.
    """
    bottom: Unions = [1 << i for i in range(len(neighbours))]
    known: dict[int, int] = dict.fromkeys(bottom, 1)
    by_layer: list[Unions] = [[], bottom, *([] for _ in range(layers - 1))]
    touch = {union: neighbours[i] | union for i, union in enumerate(bottom)}
    pairs: Pairs = {}
    quota, capped = most // max(1, layers - 1), False
    for m in range(1, layers + 1):
        nodes = by_layer[m]
        done = 0
        while done < len(nodes):  # a relaxed layer grows while it is walked
            b, done = nodes[done], done + 1
            for a in nodes[: done - 1]:
                union = a | b
                if not touch[a] & b or union in (a, b) or union.bit_count() > largest:
                    continue
                layer = known.get(union) or layer_of(union)
                if layer < m or (layer == m and not (relaxed and m >= 2)):
                    continue
                if union not in known:
                    if len(by_layer[layer]) >= quota:
                        capped = True
                        continue
                    known[union] = layer
                    by_layer[layer].append(union)
                    touch[union] = touch[a] | touch[b]
                pairs.setdefault(union, []).append((a, b))
    return [union for unions in by_layer[2:] for union in unions], pairs, capped
