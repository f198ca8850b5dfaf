"""Sizes and distances of unions of segments, by matrix products over the bottom segments."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import KDTree

from .mesh import face_areas
from .segmentation import SegmentedShape, SegmentGraph
from .segmentgraph import sample_surface

_NEIGHBOURS = 8


@dataclass(frozen=True, slots=True, eq=False)
class Measures:
    """Measures of the k nodes of a graph, all relative to the whole shape.

    `size` (k,) share of the surface area; `extent` (k,) root mean square distance of the surface from its own centroid;
    `centrality` (k,) mean geodesic distance from the node to all of the shape; `geodesic` (k, k) float32 mean geodesic
    distance between two nodes, in units of the shape's mean distance; `overlap` (k, k) float32, row i: the share of
    node i's area that lies in node x; `between` (s, s) float64 is that of `segment_geodesics`.
    """

    size: np.ndarray
    extent: np.ndarray
    centrality: np.ndarray
    geodesic: np.ndarray
    overlap: np.ndarray
    between: np.ndarray


def measure(shape: SegmentedShape, graph: SegmentGraph, members: np.ndarray, between: np.ndarray) -> Measures:
    """The measures of the unions `members` (k, s) of a shape's segments, given `between` of `segment_geodesics`."""
    m = members.astype(np.float64)
    area = np.maximum(graph.area / max(graph.area.sum(), 1e-300), 1e-9)
    size = m @ area
    weight = m * area / size[:, None]
    geodesic = weight @ between @ weight.T
    overlap = np.minimum(m * area @ m.T / size[:, None], 1.0)
    centrality = weight @ between @ (area / area.sum())
    return Measures(size, _extents(shape, m), centrality, geodesic.astype(np.float32), overlap.astype(np.float32), between)


def _extents(shape: SegmentedShape, m: np.ndarray) -> np.ndarray:
    """Root mean square distance of each union's surface from its centroid, relative to the whole shape's, (k,).

    Exact for triangles: second moments of a triangle are those of its three edge midpoints.
    """
    mesh, labels, count = shape.mesh, shape.segmentation.labels, shape.segmentation.count
    corners = mesh.vertices[mesh.faces]
    corners = corners - corners.reshape(-1, 3).mean(axis=0)
    middles = (corners + np.roll(corners, -1, axis=1)) / 2
    area = face_areas(mesh) + 1e-300
    mass = np.bincount(labels, area, minlength=count)
    first = np.stack([np.bincount(labels, area * middles[:, :, d].mean(axis=1), minlength=count) for d in range(3)], axis=1)
    second = np.bincount(labels, area * (middles**2).sum(axis=2).mean(axis=1), minlength=count)

    def rms(w: np.ndarray) -> np.ndarray:
        total = np.maximum(w @ mass, 1e-300)
        return np.sqrt(np.maximum(w @ second / total - ((w @ first / total[:, None]) ** 2).sum(axis=1), 0))

    whole = rms(np.ones((1, count)))[0]
    return np.maximum(rms(m) / max(whole, 1e-300), 1e-6)


def segment_geodesics(shape: SegmentedShape, *, points: int, seed: int) -> np.ndarray:
    """Mean geodesic distance between the surfaces of two segments, (s, s) float64, symmetric, mean of all points 1.

    Shortest paths on a neighbour graph of about `points` surface points (at least 3 a segment); pieces of the graph are
    joined by their closest points, so parts that only touch are near each other.
    """
    count = shape.segmentation.count
    places, owner = sample_surface(shape, max(points, 3 * count), seed, least=3)
    between = dijkstra(neighbour_graph(places), directed=False)
    of = np.zeros((count, len(places)))
    of[owner, np.arange(len(places))] = 1.0
    of /= of.sum(axis=1, keepdims=True)
    mean = of @ between @ of.T
    share = np.bincount(shape.segmentation.labels, face_areas(shape.mesh), minlength=count)
    share = share / max(share.sum(), 1e-300)
    return mean / max(float(share @ mean @ share), 1e-300)


def neighbour_graph(points: np.ndarray) -> coo_array:
    """Each point joined to its nearest 8, and leftover pieces joined by their closest points."""
    count = len(points)
    distance, index = KDTree(points).query(points, min(_NEIGHBOURS + 1, count))
    rows = np.repeat(np.arange(count), distance.shape[1])
    columns, values = index.ravel(), distance.ravel()
    while True:
        graph = coo_array((np.maximum(values, 1e-12), (rows, columns)), shape=(count, count)).tocsr()
        pieces, piece = connected_components(graph, directed=False)
        if pieces == 1:
            return graph
        inside = np.flatnonzero(piece == np.argmin(np.bincount(piece)))
        outside = np.setdiff1d(np.arange(count), inside)
        near, at = KDTree(points[outside]).query(points[inside])
        best = int(np.argmin(near))
        rows, columns = np.append(rows, inside[best]), np.append(columns, outside[at[best]])
        values = np.append(values, near[best])
