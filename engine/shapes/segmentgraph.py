"""Which segments touch: shared vertices, else surface distance, and leftovers joined by their closest pair."""

from itertools import pairwise

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from .mesh import diagonal, face_areas, merged_vertices
from .segmentation import JOINED, PROXIMITY, SHARED, SegmentedShape, SegmentGraph


def build_segment_graph(
    shape: SegmentedShape, *, adjacency: str, touch_distance: float, touch_samples: int, seed: int
) -> tuple[SegmentGraph, tuple[str, ...]]:
    """The segment graph of a shape, and sentences on what had to be assumed.

    Two segments are adjacent where they share a vertex position. Where that leaves several components (parts that
    touch without sharing vertices), segments of different components are adjacent if their sampled surfaces come
    within `touch_distance` diagonals of each other. Components that are still left are joined by their closest pair.

    Parameters
    ----------
    adjacency
        "shared" (no proximity), "proximity" (surface distance for all pairs), or "auto" as above.
    touch_distance
        In diagonals of the bounding box, in [0, 0.1].
    touch_samples
        Surface points that distances are measured between.
    """
    count = shape.segmentation.count
    edges = _shared(shape) if adjacency != "proximity" else np.zeros((0, 2), dtype=np.int64)
    kind = np.full(len(edges), SHARED)
    points, owner = sample_surface(shape, touch_samples, seed)
    group = _groups(edges, count)
    if adjacency != "shared" and group.max() > 0:
        near = _near(points, owner, group[owner], touch_distance * diagonal(shape.mesh))
        edges, kind = np.concatenate([edges, near]), np.concatenate([kind, np.full(len(near), PROXIMITY)])
    joined = _closest_pairs(points, owner, _groups(edges, count))
    edges, kind = np.concatenate([edges, joined]), np.concatenate([kind, np.full(len(joined), JOINED)])
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    area = np.bincount(shape.segmentation.labels, face_areas(shape.mesh), minlength=count)
    graph = SegmentGraph(area, capped_volumes(shape), edges[order], kind[order])
    return graph, _joined_note(shape, joined)


def _joined_note(shape: SegmentedShape, joined: np.ndarray) -> tuple[str, ...]:
    if not len(joined):
        return ()
    names = shape.segmentation.names
    pairs = ", ".join(f"{names[i]}-{names[j]}" for i, j in joined[:5]) + (", …" if len(joined) > 5 else "")
    return (f"{shape.mesh.name} is in {len(joined) + 1} pieces that do not touch; joined at their closest pairs: {pairs}.",)


def _shared(shape: SegmentedShape) -> np.ndarray:
    """Pairs of segments, (e, 2) sorted, that share a vertex position."""
    vertex = merged_vertices(shape.mesh)[shape.mesh.faces].ravel()
    segment = np.repeat(shape.segmentation.labels, 3)
    count = shape.segmentation.count
    incidence = coo_array((np.ones(len(vertex)), (segment, vertex)), shape=(count, int(vertex.max()) + 1)).tocsr()
    incidence.data[:] = 1.0
    return _pairs(*(incidence @ incidence.T).nonzero())


def _pairs(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Distinct pairs i < j, sorted, (e, 2) int64."""
    both = np.stack([np.minimum(a, b), np.maximum(a, b)], axis=1)[a != b].astype(np.int64)
    return np.unique(both, axis=0) if len(both) else np.zeros((0, 2), dtype=np.int64)


def _groups(edges: np.ndarray, count: int) -> np.ndarray:
    """Component of each segment, (s,)."""
    graph = coo_array((np.ones(len(edges), dtype=bool), (edges[:, 0], edges[:, 1])), shape=(count, count))
    return connected_components(graph, directed=False)[1]


def sample_surface(shape: SegmentedShape, count: int, seed: int, least: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """About `count` points spread over the surface, at least `least` on each segment.

    Returns points (n, 3) float64 and their segments (n,) int64. Area-weighted and stratified, so the same seed gives
    the same points.
    """
    mesh, labels = shape.mesh, shape.segmentation.labels
    rng = np.random.default_rng(seed)
    area = face_areas(mesh)
    of_segment = np.bincount(labels, area, minlength=shape.segmentation.count)
    wanted = np.maximum(least, np.rint(count * of_segment / max(of_segment.sum(), 1e-300))).astype(np.int64)
    order = np.argsort(labels, kind="stable")
    bounds = np.searchsorted(labels[order], np.arange(len(wanted) + 1))
    faces = np.concatenate([
        _stratified(order[a:b], area[order[a:b]], n, rng) for (a, b), n in zip(pairwise(bounds), wanted, strict=True)
    ])  # fmt: skip
    root, v = np.sqrt(rng.random(len(faces))), rng.random(len(faces))
    weight = np.stack([1 - root, root * (1 - v), root * v], axis=1)
    return np.einsum("nk,nkd->nd", weight, mesh.vertices[mesh.faces[faces]]), labels[faces]


def _stratified(rows: np.ndarray, area: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
    """`count` of the rows, drawn by area at evenly spaced quantiles."""
    heights = np.cumsum(area + 1e-12 * max(float(area.sum()), 1e-300))
    at = (np.arange(count) + rng.random(count)) / count * heights[-1]
    return rows[np.minimum(np.searchsorted(heights, at), len(rows) - 1)]


def _near(points: np.ndarray, owner: np.ndarray, group: np.ndarray, radius: float) -> np.ndarray:
    """Pairs of segments of different groups whose samples come within `radius`."""
    found = [np.zeros((0, 2), dtype=np.int64)]
    for g in range(int(group.max())):
        mine, rest = np.flatnonzero(group == g), np.flatnonzero(group > g)
        lists = KDTree(points[mine]).sparse_distance_matrix(KDTree(points[rest]), radius, output_type="coo_matrix")
        found.append(_pairs(owner[mine[lists.row]], owner[rest[lists.col]]))
    return np.unique(np.concatenate(found), axis=0)


def _closest_pairs(points: np.ndarray, owner: np.ndarray, group: np.ndarray) -> np.ndarray:
    """Segment pairs that join all groups into one, each time the smallest group to its closest neighbour."""
    joined = []
    group = group.copy()
    while group.max() > 0:
        size = np.bincount(group[owner])
        smallest = int(np.argmin(np.where(size > 0, size, size.max() + 1)))
        inside = group[owner] == smallest
        distance, index = KDTree(points[~inside]).query(points[inside])
        best = int(np.argmin(distance))
        a, b = int(owner[inside][best]), int(owner[~inside][index[best]])
        joined.append((min(a, b), max(a, b)))
        group[group == smallest] = group[b]
        group = np.unique(group, return_inverse=True)[1]
    return np.array(joined, dtype=np.int64).reshape(-1, 2)


def capped_volumes(shape: SegmentedShape) -> np.ndarray:
    """Volume of each segment with each of its openings closed by a fan about the opening's middle, (s,) float64 >= 0.

    Zero for flat sheets; exact for convex pieces cut by planes.
    """
    labels, count = shape.segmentation.labels, shape.segmentation.count
    origin = shape.mesh.vertices[shape.mesh.faces[0, 0]]
    points = shape.mesh.vertices - origin
    a, b, c = (points[shape.mesh.faces[:, k]] for k in range(3))
    volume = np.bincount(labels, np.einsum("nd,nd->n", a, np.cross(b, c)), minlength=count)
    owner, start, end, loop = _open_edges(shape)
    if len(owner):
        size = np.bincount(loop)
        middle = np.stack([np.bincount(loop, points[start, d]) / size for d in range(3)], axis=1)[loop]
        volume += np.bincount(owner, np.einsum("nd,nd->n", points[end], np.cross(points[start], middle)), minlength=count)
    return np.abs(volume) / 6.0


def _open_edges(shape: SegmentedShape) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Half edges with no partner in their own segment: segment, first and second vertex, and number of the opening."""
    mesh = shape.mesh
    merged = merged_vertices(mesh)
    half = np.stack([mesh.faces, np.roll(mesh.faces, -1, axis=1)], axis=2).reshape(-1, 2)
    owner = np.repeat(shape.segmentation.labels, 3)
    key = np.concatenate([owner[:, None], np.sort(merged[half], axis=1)], axis=1)
    _, inverse, repeats = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    is_open = repeats[inverse.ravel()] == 1
    owner, half = owner[is_open], half[is_open]
    width = int(merged.max()) + 1
    ends = owner[:, None] * width + merged[half]
    _, node = np.unique(ends, return_inverse=True)
    node = node.reshape(-1, 2)
    total = int(node.max(initial=-1)) + 1
    graph = coo_array((np.ones(len(node), dtype=bool), (node[:, 0], node[:, 1])), shape=(total, total))
    loop = connected_components(graph, directed=False)[1][node[:, 0]] if total else np.zeros(0, dtype=np.int64)
    return owner, half[:, 0], half[:, 1], loop
