"""Parts that interpenetrate become one connected surface: signed distances on a grid, then surface nets.

Surface nets put one vertex into every grid cell that the surface crosses (Gibson, "Constrained elastic surface nets",
1998), so neighbouring parts share vertices along their border.
"""

from collections.abc import Sequence

import numpy as np
from scipy.sparse import coo_matrix
from scipy.spatial import KDTree

from ..oversegmentation import connected_pieces, face_neighbours, without_teeth

REACH = 2.5
SWELL = 0.15
LEAST_SHARE = 0.003
TAUBIN = (0.5, -0.53, 0.5, -0.53)
CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
CELL_EDGES = [(a, b) for a in range(8) for b in range(a + 1, 8) if np.abs(CORNERS[a] - CORNERS[b]).sum() == 1]


def weld(parts: Sequence[tuple[np.ndarray, np.ndarray]], cell: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Union of closed parts (vertices, faces) as one mesh with edges near `cell`.

    Returns vertices (n, 3) float64, faces (m, 3) int64 and the nearest part of each face (m,) int64. A part that
    the others swallow has no faces.
    """
    samples = [KDTree(surface_samples(v, f, cell / 3)) for v, f in parts]
    everything = np.concatenate([v for v, _ in parts])
    origin = everything.min(axis=0) - cell * (3 + np.array([0.317, 0.181, 0.239]))
    shape = np.ceil((everything.max(axis=0) + 3 * cell - origin) / cell).astype(int) + 1
    field = np.full(shape, REACH * cell)
    for (vertices, faces), tree in zip(parts, samples, strict=True):
        low = np.maximum(np.floor((vertices.min(axis=0) - origin) / cell).astype(int) - 3, 0)
        high = np.minimum(np.ceil((vertices.max(axis=0) - origin) / cell).astype(int) + 4, shape)
        window = tuple(slice(a, b) for a, b in zip(low, high, strict=True))
        distance = _signed_distance(vertices, faces, tree, origin + low * cell, high - low, cell)
        field[window] = np.minimum(field[window], distance)
    vertices, faces = surface_nets(field - SWELL * cell)
    vertices, faces = _largest_component(origin + cell * vertices, faces)
    vertices = _smoothed(vertices, faces)
    centroid = vertices[faces].mean(axis=1)
    nearest = np.stack([tree.query(centroid, distance_upper_bound=4 * cell)[0] for tree in samples])
    return vertices, faces, _without_islands(faces, without_teeth(face_neighbours(faces), nearest.argmin(axis=0)))


def surface_samples(vertices: np.ndarray, faces: np.ndarray, spacing: float) -> np.ndarray:
    """Points on every triangle, at most about `spacing` apart: (q, 3)."""
    corner = vertices[faces]
    longest = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).max(axis=1)
    count = np.maximum(1, np.ceil(longest / spacing)).astype(int)
    found = []
    for n in np.unique(count):
        i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
        keep = i + j <= n
        weight = np.c_[i[keep], j[keep], n - i[keep] - j[keep]] / n
        found.append(np.einsum("qc,tcx->tqx", weight, corner[count == n]).reshape(-1, 3))
    return np.concatenate(found)


def surface_nets(field: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The surface where `field` (x, y, z) passes zero (negative inside): vertices in cells, faces outward."""
    inside = field < 0
    corners = [inside[tuple(slice(o, n - 1 + o) for o, n in zip(c, field.shape, strict=True))] for c in CORNERS]
    total = np.sum(corners, axis=0, dtype=np.int8)
    cells = np.argwhere((total > 0) & (total < 8))
    index = np.full(total.shape, -1)
    index[tuple(cells.T)] = np.arange(len(cells))
    value = np.stack([field[tuple((cells + c).T)] for c in CORNERS], axis=1)
    position, count = np.zeros((len(cells), 3)), np.zeros(len(cells))
    for a, b in CELL_EDGES:
        crossing = (value[:, a] < 0) != (value[:, b] < 0)
        t = value[crossing, a] / (value[crossing, a] - value[crossing, b])
        position[crossing] += CORNERS[a] + t[:, None] * (CORNERS[b] - CORNERS[a])
        count[crossing] += 1
    vertices = cells + position / count[:, None]
    return vertices, np.concatenate([_net_faces(inside, index, vertices, axis) for axis in range(3)])


def _net_faces(inside: np.ndarray, index: np.ndarray, vertices: np.ndarray, axis: int) -> np.ndarray:
    """Two triangles around every grid edge along `axis` whose ends lie on different sides."""
    here = np.take(inside, range(inside.shape[axis] - 1), axis=axis)
    there = np.take(inside, range(1, inside.shape[axis]), axis=axis)
    edge = np.argwhere(here != there)
    b, c = np.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3]]
    quad = np.stack([index[tuple((edge - o).T)] for o in (b + c, c, 0 * b, b)], axis=1)
    out = here[tuple(edge.T)]
    quad = np.where(out[:, None], quad, quad[:, ::-1])
    p = vertices[quad]
    short = np.linalg.norm(p[:, 0] - p[:, 2], axis=1) <= np.linalg.norm(p[:, 1] - p[:, 3], axis=1)
    quad = np.where(short[:, None], quad, np.roll(quad, -1, axis=1))
    return np.concatenate([quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]])


def _signed_distance(
    vertices: np.ndarray, faces: np.ndarray, tree: KDTree, origin: np.ndarray, shape: np.ndarray, cell: float
) -> np.ndarray:
    """Distance to the samples on the grid (x, y, z), negative inside, cut at `REACH` cells."""
    grid = np.stack(np.meshgrid(*(np.arange(n) for n in shape), indexing="ij"), axis=-1).reshape(-1, 3)
    distance = tree.query(origin + grid * cell, distance_upper_bound=REACH * cell)[0].reshape(shape)
    inside = _inside((vertices - origin) / cell, faces, shape)
    return np.where(inside, -1, 1) * np.minimum(distance, REACH * cell)


def _inside(vertices: np.ndarray, faces: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Parity of the surface crossings below each grid point, column by column; vertices in grid units."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    low = np.ceil(np.minimum(np.minimum(a, b), c)[:, :2]).astype(int)
    size = np.maximum(np.floor(np.maximum(np.maximum(a, b), c)[:, :2]).astype(int) - low + 1, 0)
    per = size[:, 0] * size[:, 1]
    row = np.repeat(np.arange(len(faces)), per)
    k = np.arange(len(row)) - np.repeat(np.cumsum(per) - per, per)
    x, y = low[row, 0] + k // np.maximum(size[row, 1], 1), low[row, 1] + k % np.maximum(size[row, 1], 1)
    area = _cross2(b - a, c - a)[row]
    p = np.c_[x, y].astype(float)
    wb = _cross2(p - a[row, :2], (c - a)[row, :2])
    wc = _cross2((b - a)[row, :2], p - a[row, :2])
    with np.errstate(divide="ignore", invalid="ignore"):  # upright faces have no extent across a column
        s, t = wb / area, wc / area
        hit = (s >= 0) & (t >= 0) & (s + t <= 1) & (area != 0)
    at = row[hit]
    z = a[at, 2] + s[hit] * (b - a)[at, 2] + t[hit] * (c - a)[at, 2]
    first = np.clip(np.ceil(z).astype(int), 0, shape[2])
    crossings = np.zeros((shape[0], shape[1], shape[2] + 1), dtype=np.int32)
    np.add.at(crossings, (x[hit], y[hit], first), 1)
    return np.cumsum(crossings, axis=2)[:, :, :-1] % 2 == 1


def _cross2(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _largest_component(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Drop crumbs that the grid tore off a thin tip, and bubbles enclosed between parts."""
    component = connected_pieces(face_neighbours(faces), len(faces))
    faces = faces[component == np.bincount(component).argmax()]
    used, faces = np.unique(faces, return_inverse=True)
    return vertices[used], faces.reshape(-1, 3)


def _smoothed(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Two rounds of smoothing that keep the volume (Taubin, "A signal processing approach to fair surfaces", 1995)."""
    n = len(vertices)
    ends = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    link = coo_matrix((np.ones(2 * len(ends)), (ends.ravel(), ends[:, ::-1].ravel())), shape=(n, n)).tocsr()
    degree = np.asarray(link.sum(axis=1))
    for weight in TAUBIN:
        vertices = vertices + weight * (link @ vertices / degree - vertices)
    return vertices


def _without_islands(faces: np.ndarray, label: np.ndarray) -> np.ndarray:
    """Give every piece of a label but its largest, and what little shows of a swallowed part, to its surroundings."""
    label = label.copy()
    pairs = face_neighbours(faces)
    for _ in range(6):
        same = label[pairs[:, 0]] == label[pairs[:, 1]]
        piece = connected_pieces(pairs[same], len(faces))
        size = np.bincount(piece)
        owner = label[np.unique(piece, return_index=True)[1]]
        order = np.lexsort((size, owner))
        largest = order[np.r_[owner[order][1:] != owner[order][:-1], True]]
        islands = np.setdiff1d(np.arange(len(size)), largest[size[largest] >= LEAST_SHARE * len(faces)])
        if not len(islands):
            break
        both = np.vstack([pairs[~same], pairs[~same][:, ::-1]])
        for island in islands:
            around = label[both[piece[both[:, 0]] == island, 1]]
            label[piece == island] = np.bincount(around).argmax()
    return label
