"""The faces of a surface as a graph: which faces meet, how far it is from one to the next, and how the surface turns."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from .mesh import Mesh, diagonal, face_areas

WELD = 1e-7  # of the diagonal: vertices nearer than about this are one
FLAT = 0.02  # |volume| / area^1.5 below which a surface has no inside to tell concave from convex
CLOSED = 0.9  # share of the edges that two faces must share, the other way around, for a surface to have an inside
MOST_POINTS = 20_000


@dataclass(frozen=True, slots=True, eq=False)
class FaceGraph:
    """Faces that meet, in units in which the diagonal of the mesh is 1.

    `area` (m,), `centre` (m, 3) and `normal` (m, 3) of the faces; `pairs` (e, 2) of faces; `length` (e,) the way from
    centre to centre; `border` (e,) the length of the edge that both share; `turn` (e,) radians by which the surface
    turns there, positive where it is concave; `bridge` (e,) bool marks pairs that share no edge but join pieces of
    the surface that are near each other; `inside` says whether concave can be told from convex, and `outward` whether
    the normals point out.
    """

    area: np.ndarray
    centre: np.ndarray
    normal: np.ndarray
    pairs: np.ndarray
    length: np.ndarray
    border: np.ndarray
    turn: np.ndarray
    bridge: np.ndarray
    inside: bool
    outward: bool = True

    @property
    def faces(self) -> int:
        """Number of faces, m."""
        return len(self.area)

    def matrix(self, weight: np.ndarray) -> csr_matrix:
        """Symmetric sparse (m, m) matrix of weights (e,), which must be positive; the least of repeated pairs."""
        key = np.sort(self.pairs, axis=1) @ np.array([self.faces, 1])
        order = np.lexsort((weight, key))
        first = order[np.r_[True, np.diff(key[order]) > 0]] if len(order) else order
        i, j = self.pairs[first].T if len(first) else np.zeros((2, 0), np.int64)
        both = np.r_[i, j], np.r_[j, i]
        return csr_matrix((np.r_[weight[first], weight[first]], both), shape=(self.faces, self.faces))

    def restricted(self, faces: np.ndarray) -> "FaceGraph":
        """The graph of some faces (q,) alone, numbered in their order."""
        row = np.full(self.faces, -1)
        row[faces] = np.arange(len(faces))
        kept = (row[self.pairs] >= 0).all(axis=1)
        return FaceGraph(self.area[faces], self.centre[faces], self.normal[faces], row[self.pairs[kept]], self.length[kept],
                         self.border[kept], self.turn[kept], self.bridge[kept], self.inside, self.outward)  # fmt: skip


def pieces(graph: FaceGraph, labels: np.ndarray | None = None, *, bridges: bool = True) -> np.ndarray:
    """Number (m,) of each face's connected piece: of the surface, or of the regions of equal label."""
    kept = np.ones(len(graph.pairs), bool) if bridges else ~graph.bridge
    if labels is not None:
        kept &= labels[graph.pairs[:, 0]] == labels[graph.pairs[:, 1]]
    i, j = graph.pairs[kept].T
    link = csr_matrix((np.ones(len(i), bool), (i, j)), shape=(graph.faces, graph.faces))
    return connected_components(link, directed=False)[1].astype(np.int64)


def face_graph(mesh: Mesh) -> FaceGraph:
    """The graph of a mesh; vertices at one place count as one, and separate pieces are bridged where they are nearest.

    Neither position nor scale matters. Degenerate faces have no area and turn nowhere; a mesh whose faces are wound
    differently is read as if they were not.
    """
    size = diagonal(mesh)
    points = (mesh.vertices - mesh.vertices[mesh.faces.ravel()].mean(axis=0)) / size
    used = np.unique(mesh.faces)
    points[np.setdiff1d(np.arange(len(points)), used)] = 0.0  # whatever unused vertices hold
    welded = np.unique(np.round(points / WELD), axis=0, return_inverse=True)[1].ravel()
    pairs, ends, same_way = _meeting(welded[mesh.faces], mesh.faces)
    corners = points[mesh.faces]
    centre, area = corners.mean(axis=1), face_areas(mesh) / size**2
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal = cross / np.maximum(np.linalg.norm(cross, axis=1, keepdims=True), 1e-300)
    volume = float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))) / 6
    closed = 2 * len(pairs) > CLOSED * 3 * len(mesh.faces) and same_way.mean() < 1 - CLOSED
    inside = bool(closed and abs(volume) > FLAT * float(area.sum()) ** 1.5)
    outward = volume > 0 or not inside
    turn = _turning(pairs, centre, normal if outward else -normal, same_way)
    along = points[ends[:, 1]] - points[ends[:, 0]]
    over = points[ends].mean(axis=1) if len(ends) else np.zeros((0, 3))
    length = sum((np.linalg.norm(over - centre[pairs[:, k]], axis=1) for k in range(2)), np.zeros(len(pairs)))
    graph = FaceGraph(area, centre, normal, pairs, length, np.linalg.norm(along, axis=1), turn,
                      np.zeros(len(pairs), bool), inside, outward)  # fmt: skip
    return _bridged(graph, corners)


def coarsened(graph: FaceGraph, most: int) -> tuple[np.ndarray, FaceGraph]:
    """Connected cells of faces, about `most` at the most, for surfaces too fine to walk: (cell of each face, graph).

    The cells are the connected pieces of the surface inside the boxes of a grid.
    """
    side = np.sqrt(3 * graph.area.sum() / most)
    box = np.unique(np.floor(graph.centre / side).astype(np.int64), axis=0, return_inverse=True)[1].ravel()
    cell = pieces(graph, box, bridges=False)
    count = int(cell.max()) + 1
    weight = graph.area + 1e-300
    area = np.bincount(cell, weight, count)
    centre, normal = (np.stack([np.bincount(cell, weight * rows[:, k], count) / area for k in range(3)], axis=1)
                      for rows in (graph.centre, graph.normal))  # fmt: skip
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    ends = np.sort(cell[graph.pairs], axis=1)
    across = ends[:, 0] != ends[:, 1]
    key, first, at = np.unique(ends[across] @ np.array([count, 1]), return_index=True, return_inverse=True)
    pairs = np.c_[key // count, key % count]
    bridge = graph.bridge[across][first]
    lean = normal if graph.outward else -normal
    turn = np.where(bridge, 0.0, _turning(pairs, centre, lean, np.zeros(len(pairs), bool)))
    length = np.linalg.norm(centre[pairs[:, 0]] - centre[pairs[:, 1]], axis=1)
    border = np.bincount(at, graph.border[across], len(key))
    return cell, FaceGraph(area, centre, normal, pairs, length, border, turn, bridge, graph.inside, graph.outward)


def _meeting(places: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs (e, 2) of faces that share an edge, its two vertices (e, 2), and whether both walk it the same way.

    Where more than two faces meet, each is paired with the next.
    """
    walk = places[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    owner, vertex = np.repeat(np.arange(len(faces)), 3), faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    ends = np.sort(walk, axis=1)
    order = np.lexsort((owner, ends[:, 1], ends[:, 0]))
    first, second = order[:-1], order[1:]
    meet = (ends[first] == ends[second]).all(axis=1) & (ends[first, 0] != ends[first, 1]) & (owner[first] != owner[second])
    first, second = first[meet], second[meet]
    return np.c_[owner[first], owner[second]], vertex[first], walk[first, 0] == walk[second, 0]


def _turning(pairs: np.ndarray, centre: np.ndarray, normal: np.ndarray, same_way: np.ndarray) -> np.ndarray:
    """Angle (e,) between the faces of each pair, negative where the surface is convex."""
    i, j = pairs.T
    theirs = np.where(same_way[:, None], -normal[j], normal[j])
    lean = np.einsum("ij,ij->i", centre[j] - centre[i], normal[i]) - np.einsum("ij,ij->i", centre[j] - centre[i], theirs)
    cosine = np.clip(np.einsum("ij,ij->i", normal[i], theirs), -1, 1)
    known = (np.abs(normal[i]).sum(axis=1) > 0) & (np.abs(normal[j]).sum(axis=1) > 0)
    return np.where(known, np.arccos(cosine) * np.where(lean > 0, 1.0, -1.0), 0.0)


def _bridged(graph: FaceGraph, corners: np.ndarray) -> FaceGraph:
    """The graph with separate pieces joined where they come nearest, so that it is connected."""
    piece = pieces(graph)
    if piece.max() == 0:
        return graph
    step = max(1, 3 * graph.faces // MOST_POINTS)
    face = np.unique(np.r_[np.arange(0, graph.faces, step), np.unique(piece, return_index=True)[1]])
    points = np.concatenate([corners[face].reshape(-1, 3), graph.centre[face]])
    face = np.r_[np.repeat(face, 3), face]
    joins, gaps = _joins(points, piece[face])
    pairs = face[joins]
    zeros = np.zeros(len(pairs))
    return FaceGraph(
        graph.area, graph.centre, graph.normal, np.r_[graph.pairs, pairs], np.r_[graph.length, gaps],
        np.r_[graph.border, zeros], np.r_[graph.turn, zeros], np.r_[graph.bridge, np.ones(len(pairs), bool)],
        graph.inside, graph.outward)  # fmt: skip


def _joins(points: np.ndarray, piece: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (b, 2) of points of different pieces that join all pieces, and their distances (b,).

    First the shortest join of each two pieces among the nearest neighbours of all points, then what is still apart
    by its nearest point, the smallest group first.
    """
    gap, near = KDTree(points).query(points, k=min(12, len(points)))
    rows = np.repeat(np.arange(len(points)), near.shape[1])
    foreign = piece[rows] != piece[near.ravel()]
    pairs, gaps = np.c_[rows, near.ravel()][foreign], gap.ravel()[foreign]
    key = np.sort(piece[pairs], axis=1) @ np.array([piece.max() + 1, 1])
    order = np.lexsort((gaps, key))
    first = order[np.r_[True, np.diff(key[order]) > 0]] if len(order) else order
    pairs, gaps = pairs[first], gaps[first]
    while True:
        count = int(piece.max()) + 1
        link = csr_matrix((np.ones(len(pairs), bool), (piece[pairs[:, 0]], piece[pairs[:, 1]])), shape=(count, count))
        groups, group = connected_components(link, directed=False)
        if groups == 1:
            return pairs, gaps
        added = _nearest_others(points, group[piece])
        pairs, gaps = np.r_[pairs, added], np.r_[gaps, np.linalg.norm(points[added[:, 0]] - points[added[:, 1]], axis=1)]


def _nearest_others(points: np.ndarray, group: np.ndarray) -> np.ndarray:
    """For up to 40 groups, the smallest first, the nearest pair (q, 2) of one of its points and one of another group."""
    sizes = np.bincount(group)
    found = []
    for mine in np.argsort(sizes, kind="stable")[: min(40, len(sizes) - 1)]:
        ours, others = np.flatnonzero(group == mine), np.flatnonzero(group != mine)
        gap, near = KDTree(points[others]).query(points[ours])
        at = int(np.argmin(gap))
        found.append((ours[at], others[near[at]]))
    return np.array(found)
