"""Segments of a mesh, and the graph of which segments touch."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import frozen_array
from ..errors import BadInput
from .mesh import Mesh

SHARED, PROXIMITY, JOINED = 0, 1, 2
EDGE_KINDS = ("shared vertices", "proximity", "closest pair")


@dataclass(frozen=True, slots=True, eq=False)
class Segmentation:
    """Label of each face, `labels` (m,) int64 in 0..s-1, and the label that each segment has in the input.

    `names` holds s entries in sorted order: whole numbers from a label file, or texts such as OBJ group names.
    """

    labels: np.ndarray
    names: tuple[int | str, ...]

    def __post_init__(self) -> None:
        labels = frozen_array(self.labels, np.int64, (None,), "The labels")
        counts = np.bincount(labels, minlength=len(self.names)) if len(labels) and labels.min() >= 0 else np.zeros(0)
        if len(counts) != len(self.names) or not (counts > 0).all():
            raise BadInput("The labels must be 0..s-1 with at least one face each, and one name for each segment.")
        object.__setattr__(self, "labels", labels)

    @property
    def count(self) -> int:
        """Number of segments, s."""
        return len(self.names)


def segmentation_from_labels(labels: Any) -> Segmentation:
    """Number arbitrary integer labels (m,) by their sorted order and keep them as names."""
    values, inverse = np.unique(np.asarray(labels).ravel(), return_inverse=True)
    return Segmentation(inverse.ravel(), tuple(int(v) for v in values))


@dataclass(frozen=True, slots=True, eq=False)
class SegmentedShape:
    """A mesh with its segments, as it came from a file or a generator.

    `file` is what the user named, `notes` says in sentences what was assumed (for instance where labels came from);
    `automatic` says that nobody has given the segments: they were computed from the mesh.
    """

    mesh: Mesh
    segmentation: Segmentation
    file: str = ""
    notes: tuple[str, ...] = ()
    automatic: bool = False

    def __post_init__(self) -> None:
        have, want = len(self.segmentation.labels), len(self.mesh.faces)
        if have != want:
            raise BadInput(f"{self.mesh.name} has {want} faces but {have} labels; give one label a face, in face order.")


@dataclass(frozen=True, slots=True, eq=False)
class SegmentGraph:
    """Segments and which of them are adjacent.

    `area` (s,) and `volume` (s,) float64; `edges` (e, 2) int64 with i < j, sorted; `kind` (e,) int8 says how each
    adjacency was found (index into `EDGE_KINDS`).
    """

    area: np.ndarray
    volume: np.ndarray
    edges: np.ndarray
    kind: np.ndarray

    def __post_init__(self) -> None:
        area = frozen_array(self.area, np.float64, (None,), "The segment areas")
        volume = frozen_array(self.volume, np.float64, (len(area),), "The segment volumes")
        edges = frozen_array(np.asarray(self.edges).reshape(-1, 2), np.int64, (None, 2), "The segment edges")
        kind = frozen_array(self.kind, np.int8, (len(edges),), "The edge kinds")
        if len(edges) and not ((edges[:, 0] < edges[:, 1]).all() and edges.min() >= 0 and edges.max() < len(area)):
            raise BadInput("Segment edges must satisfy 0 <= i < j < s.")
        for name, value in (("area", area), ("volume", volume), ("edges", edges), ("kind", kind)):
            object.__setattr__(self, name, value)

    def adjacency(self) -> np.ndarray:
        """Symmetric (s, s) bool matrix of adjacent segments, False on the diagonal."""
        matrix = np.zeros((len(self.area),) * 2, dtype=bool)
        matrix[self.edges[:, 0], self.edges[:, 1]] = True
        return matrix | matrix.T
