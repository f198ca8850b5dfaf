"""A triangle mesh, checked once."""

from dataclasses import dataclass

import numpy as np

from ..arrays import frozen_array
from ..errors import BadInput

LARGEST_COORDINATE = 1e12
MOST_FACES = 20_000_000


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


def face_areas(mesh: Mesh) -> np.ndarray:
    """Area of each face, (m,) float64, in squared units of the file."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def diagonal(mesh: Mesh) -> float:
    """Length of the bounding box's diagonal over the vertices that are used."""
    return float(np.linalg.norm(np.ptp(mesh.vertices[mesh.faces.ravel()], axis=0)))
