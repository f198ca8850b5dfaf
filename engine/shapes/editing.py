"""Segments changed by hand: pure functions from labels (m,) to labels (m,).

A label is a number that a segment keeps while others come and go, so that its colour and name stay; `compacted` makes
a segmentation of them in the end.
"""

from collections.abc import Iterable, Mapping

import numpy as np
from scipy.sparse.csgraph import dijkstra

from ..errors import BadInput
from .facegraph import FaceGraph, pieces
from .regions import numbered
from .segmentation import Segmentation
from .segmentationparameters import DEFAULT
from .segmenting import surface_patches

MOST_PARTS = 20
SPECK = 0.01  # of the area of a segment that is cut


def merged(labels: np.ndarray, chosen: Iterable[int]) -> np.ndarray:
    """The chosen segments as one, under the lowest of their labels. Raises `BadInput` where fewer than two are chosen."""
    wanted = sorted({int(k) for k in chosen} & set(np.unique(labels).tolist()))
    if len(wanted) < 2:
        raise BadInput("Choose at least two segments to merge: click one, then others with Shift.")
    return np.where(np.isin(labels, wanted), wanted[0], labels)


def split_by_patches(graph: FaceGraph, labels: np.ndarray, segment: int, parts: int, seed: int = 0) -> np.ndarray:
    """The segment in `parts` geodesic patches; the largest keeps its label. Raises `BadInput` where that cannot be."""
    if not 2 <= parts <= MOST_PARTS:
        raise BadInput(f"A segment can be split into 2 to {MOST_PARTS} parts, not {parts}.")
    faces = _faces_of(labels, segment)
    if len(faces) < parts:
        raise BadInput(f"The segment has {len(faces)} faces, too few for {parts} parts.")
    return _cut(graph, labels, faces, surface_patches(graph.restricted(faces), count=parts, seed=seed, crease=DEFAULT.crease))


def split_by_plane(graph: FaceGraph, labels: np.ndarray, segment: int, height: np.ndarray) -> np.ndarray:
    """The segment in the pieces that a plane cuts it into; the largest keeps its label.

    `height` (m,) is the signed distance of each face from the plane. Pieces are connected, and specks go to what they
    border on. Raises `BadInput` where all lies on one side.
    """
    faces = _faces_of(labels, segment)
    inner = graph.restricted(faces)
    side = (height[faces] > 0).astype(np.int64)
    found = side if pieces(inner).max() else _pieces_of_sides(inner, side)  # what was apart before is cut as one
    if found.max() == 0:
        raise BadInput("The cut leaves the segment in one piece; draw the line across it.")
    return _cut(graph, labels, faces, found)


def _pieces_of_sides(inner: FaceGraph, side: np.ndarray) -> np.ndarray:
    """The connected pieces (q,) of both sides; specks go to their neighbours."""
    piece = pieces(inner, side)
    size = np.bincount(piece, inner.area)
    speck = size < SPECK * size.sum()
    neighbour = np.arange(len(size))
    for i, j in piece[inner.pairs][(piece[inner.pairs][:, 0] != piece[inner.pairs][:, 1])]:
        for small, other in ((i, j), (j, i)):
            if speck[small] and not speck[other]:
                neighbour[small] = other
    return numbered(neighbour[piece])


def _cut(graph: FaceGraph, labels: np.ndarray, faces: np.ndarray, part: np.ndarray) -> np.ndarray:
    """Give the parts (q,) of some faces (q,) labels of their own, all but the largest."""
    size = np.bincount(part, graph.area[faces])
    number = int(labels.max()) + np.cumsum(np.arange(len(size)) != size.argmax())
    number[size.argmax()] = labels[faces[0]]
    changed = labels.copy()
    changed[faces] = number[part]
    return changed


def repainted(labels: np.ndarray, faces: np.ndarray, segment: int) -> np.ndarray:
    """The faces (q,) in another segment; one that loses its last face is gone."""
    changed = labels.copy()
    changed[faces] = segment
    return changed


def next_label(labels: np.ndarray) -> int:
    """A label that no segment has."""
    return int(labels.max()) + 1


def grown(graph: FaceGraph, face: int, radius: float) -> np.ndarray:
    """Faces (q,) within a way on the surface, in diagonals, of a face, itself the first; never across a gap."""
    here = np.linalg.norm(graph.centre - graph.centre[face], axis=1) <= radius
    here[face] = True
    near = np.flatnonzero(here)
    part = graph.restricted(near)
    ways = part.matrix(np.where(part.bridge, np.inf, np.maximum(part.length, 1e-12)))
    walk = dijkstra(ways, indices=int(np.searchsorted(near, face)), limit=max(radius, 1e-12))
    found = near[np.isfinite(walk)]
    return np.r_[face, found[found != face]]


def names_of(labels: np.ndarray, names: Mapping[int, int | str]) -> dict[int, int | str]:
    """A name for each label that is there: its own, or the next free number where it has none."""
    taken = {name for label, name in names.items() if isinstance(name, int)}
    free = max(taken, default=-1) + 1
    found: dict[int, int | str] = {}
    for label in np.unique(labels).tolist():
        if label not in names:
            found[label], free = free, free + 1
        else:
            found[label] = names[label]
    return found


def compacted(labels: np.ndarray, names: Mapping[int, int | str]) -> Segmentation:
    """The segments as a segmentation: numbered 0..s-1 in the order of their labels, with their names."""
    present, rows = np.unique(labels, return_inverse=True)
    known = names_of(labels, names)
    return Segmentation(rows.ravel(), tuple(known[int(k)] for k in present))


def _faces_of(labels: np.ndarray, segment: int) -> np.ndarray:
    faces = np.flatnonzero(labels == segment)
    if not len(faces):
        raise BadInput("Choose a segment first: click it.")
    return faces
