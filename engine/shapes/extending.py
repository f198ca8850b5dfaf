"""Further unions of segments as nodes of a shape that is described already, in milliseconds."""

from dataclasses import replace

import numpy as np

from .describing import DescribedShape, light_fields_of
from .hops import UNREACHABLE
from .lightfield import quantile_signatures
from .measures import measure
from .multilayer import ADJACENT, PART_OF, MultiLayerGraph, layer_of


def with_nodes(described: DescribedShape, members: np.ndarray) -> DescribedShape:
    """The shape with the unions `members` (q, s) bool as further nodes, before the last node, the whole shape.

    Rows of all other nodes stay. A new node is joined as Eq 3.2 has it: to nodes of its layer that overlap or touch it,
    to nodes of one segment more, and to nodes of one segment less and that segment; else to its own segments. Hops
    between the other nodes stay as they are.
    """
    members = members[~(members[:, None] == described.layers.members[None]).all(axis=2).any(axis=1)]
    members = np.unique(members, axis=0)
    if not len(members):
        return described
    count = len(described.layers.members)
    order = np.concatenate([np.arange(count - 1), count + np.arange(len(members)), [count - 1]])
    layers, joined = _layers(described, members, order)
    new = _light_fields(described, members)
    measures = measure(described.shape, described.graph, layers.members, described.measures.between)
    return replace(described, layers=layers, hops=_hops(described.hops, joined)[np.ix_(order, order)], measures=measures,
                   descriptors=np.concatenate([described.descriptors, new])[order],
                   signatures=np.concatenate([described.signatures, quantile_signatures(new)])[order])  # fmt: skip


def _light_fields(described: DescribedShape, members: np.ndarray) -> np.ndarray:
    """Descriptors of the unions, drawn when first asked for."""
    keys = ["light field " + row.tobytes().hex() for row in np.packbits(members, axis=1)]
    missing = np.array([key not in described.kept for key in keys])
    if missing.any():
        found = light_fields_of(described.shape, members[missing], described.parameters)
        described.kept.update(zip((key for key, new in zip(keys, missing, strict=True) if new), found, strict=True))
    return np.stack([described.kept[key] for key in keys])


def _layers(described: DescribedShape, new: np.ndarray, order: np.ndarray) -> tuple[MultiLayerGraph, np.ndarray]:
    """The graph with the new nodes in their order, and the kind of edge (q, k + q) of each to all, -1 for none.

    The columns of the latter are in the order of before, new nodes last.
    """
    old, count = described.layers, len(described.layers.members)
    members = np.concatenate([old.members, new])
    layer = np.concatenate([old.layer, layer_of(new, described.graph, described.parameters)])
    m, n = members.astype(np.float32), new.astype(np.float32)
    near = described.graph.adjacency() | np.eye(members.shape[1], dtype=bool)
    kind = np.where((n @ near.astype(np.float32) @ m.T > 0) & (layer[count:, None] == layer), ADJACENT, -1)
    size, mine, shared = m.sum(axis=1), n.sum(axis=1)[:, None], n @ m.T
    below, above = (shared == size) & (size == mine - 1), (shared == mine) & (size == mine + 1)
    kind[below | above] = PART_OF
    segments = new & (below.astype(np.float32) @ ~members > 0)  # those that lead from such a node to the new one
    kind[:, : new.shape[1]][np.where(segments.any(axis=1, keepdims=True), segments, new)] = PART_OF
    held = (shared == mine) & (size > mine)
    kind[~np.delete(held, count - 1, axis=1).any(axis=1), count - 1] = PART_OF  # what nothing else holds, the top does
    kind[np.arange(len(new)), count + np.arange(len(new))] = -1
    place = np.argsort(order)
    a, b = np.nonzero(kind >= 0)
    ends = np.sort(np.stack([place[count + a], place[b]], axis=1), axis=1)
    ends, first = np.unique(ends, axis=0, return_index=True)
    edges = np.concatenate([np.sort(place[old.edges], axis=1), ends])
    kinds = np.concatenate([old.kind, kind[a, b][first]])
    graph = replace(old, members=members[order], layer=layer[order], edges=edges, kind=kinds)
    return graph, kind


def _hops(hops: np.ndarray, joined: np.ndarray) -> np.ndarray:
    """Hop distances (k + q, k + q) uint8 with new nodes whose edges are `joined` >= 0; those among the k stay."""
    count, new = len(hops), len(joined)
    far = np.full((count + new, count + new), UNREACHABLE, dtype=np.uint8)
    far[:count, :count] = hops
    for a in range(count, count + new):
        ends = np.flatnonzero(joined[a - count, :a] >= 0)
        nearest = far[ends, :a].min(axis=0, initial=UNREACHABLE)
        far[a, :a] = far[:a, a] = np.where(nearest < UNREACHABLE, nearest, UNREACHABLE - 1) + 1
        far[a, a] = 0
    return far
