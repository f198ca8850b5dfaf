"""The multi-layer graph (MLG) of a segmented shape: nodes are unions of segments (thesis section 3.3.1)."""

from dataclasses import dataclass

import numpy as np

from ..arrays import frozen_array

ADJACENT, PART_OF = 0, 1


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
