"""The multi-layer graph (MLG) of a segmented shape: nodes are unions of segments (thesis section 3.3.1)."""

from dataclasses import dataclass

import numpy as np

from ..arrays import frozen_array
from ..progress import Progress, silent
from .enumeration import Pairs, beam_sets, bits, connected_sets, layered_unions, members_of
from .parameters import MatchParameters
from .segmentation import SegmentGraph

ADJACENT, PART_OF = 0, 1
CONNECTED_LARGEST = 6  # most segments of a connected union where max_segments is 0


@dataclass(frozen=True, slots=True, eq=False)
class MultiLayerGraph:
    """Nodes of all layers: the s bottom segments first (row i is segment i), then the merged nodes.

    `members` (k, s) bool says which bottom segments a node unites, `layer` (k,) int64 in 1..L its layer (Eq 3.1),
    `edges` (e, 2) int64 with i < j and `kind` (e,) int8 the ADJACENT and PART_OF edges of Eq 3.2; `layers` is L;
    `capped` says in one sentence which limit cut the enumeration, or is empty.
    """

    members: np.ndarray
    layer: np.ndarray
    edges: np.ndarray
    kind: np.ndarray
    layers: int
    capped: str = ""

    def __post_init__(self) -> None:
        members = frozen_array(self.members, bool, (None, None), "The members")
        layer = frozen_array(self.layer, np.int64, (len(members),), "The layers")
        edges = frozen_array(np.asarray(self.edges).reshape(-1, 2), np.int64, (None, 2), "The edges")
        kind = frozen_array(self.kind, np.int8, (len(edges),), "The edge kinds")
        for name, value in (("members", members), ("layer", layer), ("edges", edges), ("kind", kind)):
            object.__setattr__(self, name, value)


def build_multilayer_graph(
    graph: SegmentGraph, parameters: MatchParameters, weights: np.ndarray, *, progress: Progress = silent
) -> MultiLayerGraph:
    """Nodes (Eq 3.1) and edges (Eq 3.2) of the multi-layer graph.

    A merged node of relative size v lies in layer clamp(floor(L·v) + 1, 2, L). The bottom segments and the top (the
    whole shape) are always there.

    Parameters
    ----------
    weights
        (s, s) float64 >= 0, symmetric: how strongly two segments hang together, for the normalised cut.
    """
    count, layers = len(graph.area), parameters.layers
    neighbours = [sum(1 << int(j) for j in np.flatnonzero(row)) for row in graph.adjacency()]
    size = _sizes(graph, parameters)
    mode = chosen_mode(parameters, count)
    largest = parameters.max_segments or (CONNECTED_LARGEST if mode == "connected" else count)
    most = max(0, parameters.node_cap - count - 1)
    pairs: Pairs | None = None
    if mode == "connected":
        merged, capped = connected_sets(neighbours, weights, largest=largest, most=most)
    elif mode == "beam":
        merged, capped = beam_sets(
            neighbours, weights, largest=largest, most=most, tell=lambda share: progress(share, "unions of segments"))  # fmt: skip
    else:
        merged, pairs, capped = layered_unions(
            neighbours, lambda union: int(_layers(size[bits(union)].sum(), layers)),
            layers=layers, largest=largest, most=most, relaxed=mode == "relaxed")  # fmt: skip
    top = (1 << count) - 1
    unions = [1 << i for i in range(count)] + [union for union in merged if union != top] + ([top] if count > 1 else [])
    members = members_of(unions, count)
    layer = layer_of(members, graph, parameters)
    edges, kind = _edges(unions, members, layer, graph.adjacency(), pairs)
    return MultiLayerGraph(members, layer, edges, kind, layers, _caps_met(parameters, mode, count, largest, capped))


def layer_of(members: np.ndarray, graph: SegmentGraph, parameters: MatchParameters) -> np.ndarray:
    """The layer (k,) of each union `members` (k, s): 1 for a segment, else by its size (Eq 3.1)."""
    found = _layers(members @ _sizes(graph, parameters), parameters.layers)
    return np.where(members.sum(axis=1) == 1, 1, found)


def _sizes(graph: SegmentGraph, parameters: MatchParameters) -> np.ndarray:
    """Relative size (s,) of each segment by the chosen measure."""
    size = graph.area if parameters.size_measure == "area" else graph.volume
    return size / size.sum() if size.sum() > 0 else np.full(len(size), 1 / len(size))


def chosen_mode(parameters: MatchParameters, count: int) -> str:
    """The mode that "auto" stands for: connected sets up to `auto_segments` segments, the beam above."""
    if parameters.mode != "auto":
        return parameters.mode
    return "connected" if count <= parameters.auto_segments else "beam"


def _caps_met(parameters: MatchParameters, mode: str, count: int, largest: int, capped: bool) -> str:
    """One sentence on the limits that cut the nodes, or nothing."""
    if count + 1 > parameters.node_cap:
        return f"The {count} segments alone exceed the node cap of {parameters.node_cap}, so nothing is merged."
    parts = [f"the node cap of {parameters.node_cap} cut the {mode} unions of {count} segments"] if capped else []
    parts += [f"unions hold at most {largest} of {count} segments (max_segments)"] if largest < count - 1 else []
    text = "; ".join(parts)
    return text[:1].upper() + text[1:] + "." if text else ""


def _layers(relative: np.ndarray | float, layers: int) -> np.ndarray:
    return np.clip(np.floor(layers * np.asarray(relative) + 1e-9).astype(np.int64) + 1, 2, layers)


def _edges(
    unions: list[int], members: np.ndarray, layer: np.ndarray, adjacency: np.ndarray, pairs: Pairs | None
) -> tuple[np.ndarray, np.ndarray]:
    """ADJACENT edges within a layer (overlapping or touching), PART_OF edges to what generates a node, and the top's."""
    m = members.astype(np.float32)
    touching = (m @ (adjacency | np.eye(len(adjacency), dtype=bool)).astype(np.float32) @ m.T) > 0
    adjacent = np.argwhere(np.triu(touching & (layer[:, None] == layer), 1))
    part_of = _generated(unions, pairs) if pairs is not None else _one_less(unions)
    if len(unions) > len(adjacency):
        part_of += _under_top(m, len(unions) - 1)
    found = np.array(sorted({(min(e), max(e)) for e in part_of}), dtype=np.int64).reshape(-1, 2)
    kind = np.repeat([ADJACENT, PART_OF], [len(adjacent), len(found)])
    return np.concatenate([adjacent, found]), kind


def _generated(unions: list[int], pairs: Pairs) -> list[tuple[int, int]]:
    row = {union: k for k, union in enumerate(unions)}
    return [(row[part], row[u]) for u, found in pairs.items() if u in row for pair in found for part in pair if part in row]


def _one_less(unions: list[int]) -> list[tuple[int, int]]:
    """A node of size n is generated by a node of size n - 1 and the segment that is missing there."""
    row = {union: k for k, union in enumerate(unions)}
    found = []
    for k, union in enumerate(unions):
        for i in bits(union):
            less = row.get(union & ~(1 << i))
            if less is not None and less != k:
                found += [(less, k), (i, k)]
    return found


def _under_top(m: np.ndarray, top: int) -> list[tuple[int, int]]:
    """The top is joined to every node that no other node but the top contains."""
    size = m.sum(axis=1)
    inside = (m @ m.T) >= size[:, None]  # inside[i, j]: i is part of j
    np.fill_diagonal(inside, False)
    inside[:, top] = False
    return [(int(i), top) for i in np.flatnonzero(~inside.any(axis=1)) if i != top]
