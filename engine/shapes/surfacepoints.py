"""A few hundred points on a shape's surface and what is known at each: distances, thickness, heat."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from ..consistency.semidefinite import one_thread
from .measures import neighbour_graph
from .mesh import Mesh, face_areas
from .segmentation import SegmentedShape

LEAST = 3  # points on the smallest segment
QUANTILES = (0.05, 0.15, 0.3, 0.5, 0.7, 0.9, 1.0)
TIMES = (0.05, 0.15, 0.5, 1.5)  # of heat diffusion, in units of the slowest mode
WIDEST = 2.0  # largest radius of a touching ball, in units of the shape's root mean square radius
STEEPEST = 0.15  # points that lie flatter than this beside the tangent plane do not limit a ball


@dataclass(frozen=True, slots=True, eq=False)
class SurfacePoints:
    """P points, centred and scaled to a root mean square radius of 1; `weight` (P,) is the share of area, sum 1.

    `points`, `normals` (P, 3); `owner` (P,) the segment; `geodesic` (P, P) float32 distances, mean 1; `inner` and
    `outer` (P,) radii of the largest balls that touch the point from within and from without; `profile` (P, 7) the
    distances within which 5 %, 15 %, … and all of the surface lie; `heat` (P, 4) logarithms of the heat kernel
    signature; `radius` (P,) distance from the centroid; `links` (e, 2) neighbours and their `strength` (e,) in (0, 1].
    """

    points: np.ndarray
    normals: np.ndarray
    owner: np.ndarray
    weight: np.ndarray
    geodesic: np.ndarray
    inner: np.ndarray
    outer: np.ndarray
    profile: np.ndarray
    heat: np.ndarray
    radius: np.ndarray
    links: np.ndarray
    strength: np.ndarray

    @property
    def centrality(self) -> np.ndarray:
        """Mean geodesic distance (P,) from each point to all of the surface."""
        return self.geodesic @ self.weight

    def arrays(self) -> dict[str, np.ndarray]:
        """All fields by name, to be stored."""
        return {name: getattr(self, name) for name in self.__slots__}


def surface_points(shape: SegmentedShape, *, count: int, seed: int) -> SurfacePoints:
    """About `count` points, spread by area with at least three on each segment; the same for equal arrays."""
    points, normals, owner, weight = _sample(shape, count, seed)
    points = points - weight @ points
    points = points / max(np.sqrt(weight @ (points**2).sum(axis=1)), 1e-300)
    normals = -normals if _signed_volume(shape.mesh) < 0 else normals
    graph = neighbour_graph(points).tocoo()
    geodesic = dijkstra(graph.tocsr(), directed=False)
    geodesic = geodesic / max(float(weight @ geodesic @ weight), 1e-300)
    strength = np.exp(-((graph.data / max(1.5 * float(np.median(graph.data)), 1e-300)) ** 2))
    links = np.stack([graph.row, graph.col], axis=1).astype(np.int64)
    inner, outer = _touching_balls(points, normals)
    return SurfacePoints(
        points, normals, owner, weight, geodesic.astype(np.float32), inner, outer, _profile(geodesic, weight),
        _heat(links, strength, weight), np.sqrt((points**2).sum(axis=1)), links, strength)  # fmt: skip


def restored(arrays: dict[str, Any]) -> SurfacePoints:
    """The points that `SurfacePoints.arrays` was called on."""
    return SurfacePoints(**arrays)


def _sample(shape: SegmentedShape, count: int, seed: int) -> tuple[np.ndarray, ...]:
    """Points, normals, owners and weights: each segment's points are spread evenly over its faces by area."""
    mesh, label, segments = shape.mesh, shape.segmentation.labels, shape.segmentation.count
    area = face_areas(mesh)
    total = np.maximum(np.bincount(label, area, minlength=segments), 1e-300)
    numbers = np.maximum(np.round(count * total / total.sum()).astype(np.int64), LEAST)
    rng = np.random.default_rng(seed)
    faces = []
    for k, number in enumerate(numbers):
        own = np.flatnonzero(label == k)
        below = np.cumsum(np.maximum(area[own], 1e-300))
        place = (np.arange(number) + rng.uniform(size=number)) / number * below[-1]
        faces.append(own[np.minimum(np.searchsorted(below, place), len(own) - 1)])
    face, owner = np.concatenate(faces), np.repeat(np.arange(segments), numbers)
    u, v = np.sqrt(rng.uniform(size=len(face)))[:, None], rng.uniform(size=len(face))[:, None]
    a, b, c = (mesh.vertices[mesh.faces[face, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals = normals / np.maximum(np.sqrt((normals**2).sum(axis=1, keepdims=True)), 1e-300)
    return (1 - u) * a + u * (1 - v) * b + u * v * c, normals, owner, (total / numbers)[owner] / total.sum()


def _signed_volume(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, k]] - mesh.vertices.mean(axis=0) for k in range(3))
    return float((a * np.cross(b, c)).sum())


def _touching_balls(points: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Radii of the balls that touch each point's tangent plane and meet no other point: |q-p|² / (2 n·(q-p))."""
    apart = points[None] - points[:, None]
    square = (apart**2).sum(axis=2)
    height = (apart * normals[:, None]).sum(axis=2)
    least = STEEPEST * np.sqrt(square) + 1e-9

    def smallest(h: np.ndarray) -> np.ndarray:
        radius = np.where(h > least, square / (2 * np.maximum(h, 1e-12)), np.inf)
        return np.minimum(np.maximum(radius.min(axis=1), 1e-3), WIDEST)

    return smallest(-height), smallest(height)


def _profile(geodesic: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Distance within which each share of `QUANTILES` of the surface lies, (P, 7)."""
    order = np.argsort(geodesic, axis=1, kind="stable")
    within = np.cumsum(weight[order], axis=1)
    sorted_distance = np.take_along_axis(geodesic, order, axis=1)
    rows = np.arange(len(weight))
    columns = [np.minimum((within < q - 1e-9).sum(axis=1), len(weight) - 1) for q in QUANTILES]
    return np.stack([sorted_distance[rows, column] for column in columns], axis=1)


def _heat(links: np.ndarray, strength: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """log Σ exp(-λ t) φ² of the Laplacian of the neighbour graph (Sun et al. 2009), λ in units of the slowest, (P, 4)."""
    count = len(weight)
    table = coo_array((strength, (links[:, 0], links[:, 1])), shape=(count, count)).toarray()
    table = np.maximum(table, table.T) * np.sqrt(np.outer(weight, weight))
    scale = 1 / np.sqrt(weight)
    with one_thread():
        value, vector = np.linalg.eigh(scale[:, None] * (np.diag(table.sum(axis=1)) - table) * scale)
    value = np.maximum(value, 0) / max(float(value[1]), 1e-12)
    square = (vector * scale[:, None]) ** 2
    kernel = np.stack([square @ np.exp(-np.minimum(value, 1e6) * t) for t in TIMES], axis=1)
    return np.log(np.maximum(kernel, 1e-12))
