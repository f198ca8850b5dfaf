"""Identity by content, so that one vote serves every method and survives a re-run (study rules, storage).

mesh = sha256 of the arrays; segment = sha256(mesh, sorted faces); node = sha256 of its sorted segments;
match = sha256 of its kind and its two nodes, in sorted order: a match is the same from either side.
"""

from collections.abc import Iterable

import numpy as np

from ..store import digest
from .mesh import Mesh
from .segmentation import Segmentation


def mesh_id(mesh: Mesh) -> str:
    """Hash of the vertices (little-endian float64) and faces (little-endian int64)."""
    return digest(b"mesh", mesh.vertices.astype("<f8").tobytes(), mesh.faces.astype("<i8").tobytes())


def segment_ids(mesh: Mesh, segmentation: Segmentation) -> tuple[str, ...]:
    """One hash a segment: of the mesh and the sorted rows of its faces."""
    mesh_hash = mesh_id(mesh).encode()
    order = np.argsort(segmentation.labels, kind="stable").astype("<i8")
    bounds = np.cumsum(np.bincount(segmentation.labels))[:-1]
    return tuple(digest(b"segment", mesh_hash, rows.tobytes()) for rows in np.split(order, bounds))


def node_id(segments: Iterable[str]) -> str:
    """Hash of the sorted hashes of the segments that a node unites."""
    return digest(b"node", *(s.encode() for s in sorted(segments)))


def match_id(source_node: str, target_node: str, kind: str = "shape") -> str:
    """Hash of the kind of match and its two nodes."""
    return digest(b"match", kind.encode(), *(n.encode() for n in sorted((source_node, target_node))))
