"""A triangle mesh, checked once."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..arrays import frozen_array
from ..errors import BadInput

LARGEST_COORDINATE = 1e12
MOST_FACES = 20_000_000
SMALLEST_AREA = 1e-12  # of the squared diagonal


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """Vertices (n, 3) float64 and triangles (m, 3) int64 of a surface, in the order of the file.

    Raises `BadInput` where there is no face, a coordinate is not finite or beyond 1e12, or an index is out of range.
    """

    vertices: np.ndarray
    faces: np.ndarray
    name: str = "mesh"

    def __post_init__(self) -> None:
        vertices = frozen_array(self.vertices, np.float64, (None, 3), f"The vertices of {self.name}")
        faces = frozen_array(self.faces, np.int64, (None, 3), f"The faces of {self.name}")
        if not len(faces):
            raise BadInput(f"{self.name} has no faces; Concord needs a surface made of triangles.")
        if len(faces) > MOST_FACES:
            raise BadInput(f"{self.name} has {len(faces):,} faces; simplify it to at most {MOST_FACES:,} first.")
        outside = (faces < 0) | (faces >= len(vertices))
        if outside.any():
            row = int(np.argmax(outside.any(axis=1)))
            raise BadInput(f"Face {row} of {self.name} names a vertex outside 0..{len(vertices) - 1}; repair the file.")
        used = vertices[faces.ravel()]
        if not np.isfinite(used).all():
            raise BadInput(f"{self.name} has coordinates that are not finite numbers (NaN or infinity); repair the file.")
        if np.abs(used).max() > LARGEST_COORDINATE:
            raise BadInput(f"{self.name} has coordinates beyond {LARGEST_COORDINATE:g}; scale it down first.")
        if not np.ptp(used, axis=0).max() > 0:
            raise BadInput(f"All vertices of {self.name} lie in one point; there is no surface to match.")
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", faces)
        if not float(face_areas(self).sum()) > SMALLEST_AREA * diagonal(self) ** 2 > 0:
            raise BadInput(f"The faces of {self.name} have no area (its vertices lie on a line, or it is far too small).")


def face_areas(mesh: Mesh) -> np.ndarray:
    """Area of each face, (m,) float64, in squared units of the file."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def diagonal(mesh: Mesh) -> float:
    """Length of the bounding box's diagonal over the vertices that are used."""
    return float(np.linalg.norm(np.ptp(mesh.vertices[mesh.faces.ravel()], axis=0)))


def merged_vertices(mesh: Mesh) -> np.ndarray:
    """For each vertex, (n,) int64, the number of its position: equal positions have equal numbers."""
    return np.unique(mesh.vertices + 0.0, axis=0, return_inverse=True)[1].ravel()


def components(mesh: Mesh, *, merge: bool = False) -> np.ndarray:
    """Connected component of each face, (m,) int64; `merge` joins vertices at equal positions first."""
    faces = merged_vertices(mesh)[mesh.faces] if merge else mesh.faces
    count = len(mesh.vertices)
    rows, columns = faces[:, [0, 1]].ravel(), faces[:, [1, 2]].ravel()
    graph = coo_array((np.ones(len(rows), dtype=bool), (rows, columns)), shape=(count, count))
    return connected_components(graph, directed=False)[1][faces[:, 0]].astype(np.int64)
