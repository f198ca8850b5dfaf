"""Heat kernel signatures of unions of segments (Sun, Ovsjanikov & Guibas 2009), and persistent ones (Dey et al. 2010).

Heat flows on surface points, not on the mesh: the Laplacian of a point cloud (Sharp & Crane 2020) joins parts that
touch without sharing vertices, and needs neither a closed nor a clean mesh. Pieces further apart are joined by their
closest points.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange
from scipy.sparse import coo_array, csr_array, diags_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from .segmentation import SegmentedShape
from .segmentgraph import sample_surface

POINTS = 1500
EIGENVALUES = 120
TIMES = np.geomspace(0.002, 0.5, 16)  # in units of the shape's area
PERSISTENT = (0, 4, 8, 12)  # of TIMES
PEAKS = 4
_DENSER = 6  # times as many points to choose from
_LEAST = (4, 12)  # points of the smallest segment, of many and of few
_NEIGHBOURS = 12


class HeatKernel(NamedTuple):
    """Heat kernel signatures of n surface points of a shape.

    `signature` (n, 16) is k_t(x, x) · area at `TIMES`, at least about 1; `mass` (n,) the area about each point; `owner`
    (n,) its segment; `neighbours` (n, q) rows of points, filled up with the point itself.
    """

    signature: np.ndarray
    mass: np.ndarray
    owner: np.ndarray
    neighbours: np.ndarray


def heat_kernel(shape: SegmentedShape, *, seed: int) -> HeatKernel:
    """k_t(x, x) = Σ exp(-λ t) φ(x)² over the lowest eigenpairs of the Laplacian, times in units of the area."""
    points, owner = _even_points(shape, seed)
    stiffness, mass = point_laplacian(points)
    values, functions = _eigenpairs(stiffness, mass, min(EIGENVALUES, len(points) - 2))
    decay = np.exp(-values[:, None] * mass.sum() * TIMES)
    return HeatKernel(functions**2 @ decay * mass.sum(), mass, owner, _neighbours(stiffness))


def _even_points(shape: SegmentedShape, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """About `POINTS` evenly spaced surface points (n, 3), 4 to 12 or more of each segment, and their segments (n,)."""
    least = int(np.clip(2 * POINTS // shape.segmentation.count, *_LEAST))
    points, owner = sample_surface(shape, _DENSER * POINTS, seed, least=least)
    chosen = np.zeros(len(points), dtype=bool)
    chosen[_farthest(points, min(POINTS, len(points)))] = True
    few = np.bincount(owner[chosen], minlength=shape.segmentation.count) < least
    for segment in np.flatnonzero(few):
        rows = np.flatnonzero(owner == segment)
        chosen[rows[_farthest(points[rows], least)]] = True
    return points[chosen], owner[chosen]


@njit(cache=True, nogil=True)
def _farthest(points, count):  # type: ignore[no-untyped-def]
    """Rows of `count` points, each the farthest from all before it, beginning with the first."""
    rows = np.zeros(count, dtype=np.int64)
    nearest = np.full(len(points), np.inf)
    for k in range(1, count):
        best, last = 0, rows[k - 1]
        for i in range(len(points)):
            x, y, z = points[i, 0] - points[last, 0], points[i, 1] - points[last, 1], points[i, 2] - points[last, 2]
            nearest[i] = min(nearest[i], x * x + y * y + z * z)
            if nearest[i] > nearest[best]:
                best = i
        rows[k] = best
    return rows


def point_laplacian(points: np.ndarray) -> tuple[csr_array, np.ndarray]:
    """Stiffness (n, n), positive semi-definite and connected, and mass (n,) > 0 of a cloud of points (n, 3)."""
    from robust_laplacian import point_cloud_laplacian

    scale = max(float(np.ptp(points, axis=0).max()), 1e-300)
    stiffness, mass = point_cloud_laplacian((points - points.mean(axis=0)) / scale, n_neighbors=_NEIGHBOURS)
    weight = np.asarray(mass.diagonal()) * scale**2
    weight = np.maximum(weight, 1e-3 * weight.mean())
    return _joined(csr_array(stiffness), points), weight


def _joined(stiffness: csr_array, points: np.ndarray) -> csr_array:
    """The same with pieces joined by their closest points, at the median weight."""
    count = len(points)
    edges = stiffness.tocoo()
    off = edges.row != edges.col
    usual = float(np.median(np.abs(edges.data[off]))) if off.any() else 1.0
    while True:
        pieces, piece = connected_components(stiffness, directed=False)
        if pieces == 1:
            return stiffness
        inside = np.flatnonzero(piece == np.argmin(np.bincount(piece)))
        outside = np.flatnonzero(piece != piece[inside[0]])
        near, at = KDTree(points[outside]).query(points[inside])
        a = inside[int(np.argmin(near))]
        b = outside[at[int(np.argmin(near))]]
        link = coo_array((usual * np.array([1.0, 1.0, -1.0, -1.0]), ([a, b, a, b], [a, b, b, a])), shape=(count, count))
        stiffness = csr_array(stiffness + link)


def _eigenpairs(stiffness: csr_array, mass: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The lowest eigenvalues (e,) >= 0 and eigenfunctions (n, e), of unit norm under the mass."""
    from scipy.sparse.linalg import eigsh

    root = diags_array(1 / np.sqrt(mass))
    matrix = (root @ stiffness @ root).tocsc()
    start = np.sqrt(mass) + 1e-3 * np.random.default_rng(0).normal(size=len(mass)) * np.sqrt(mass.mean())
    shift = -1e-6 * float(matrix.diagonal().mean())
    values, vectors = eigsh(matrix, count, sigma=shift, v0=start)
    return np.maximum(values, 0.0), root @ vectors


def _neighbours(stiffness: csr_array) -> np.ndarray:
    """Points that heat flows to directly, (n, q) int64."""
    edges = stiffness.tocoo()
    keep = (edges.row != edges.col) & (edges.data != 0)
    row, column = edges.row[keep].astype(np.int64), edges.col[keep].astype(np.int64)
    order = np.lexsort((column, row))
    row, column = row[order], column[order]
    number = np.bincount(row, minlength=stiffness.shape[0])
    found = np.repeat(np.arange(stiffness.shape[0])[:, None], max(int(number.max(initial=1)), 1), axis=1)
    found[row, np.arange(len(row)) - np.repeat(np.cumsum(number) - number, number)] = column
    return found


def mean_signatures(heat: HeatKernel, members: np.ndarray, area: np.ndarray) -> np.ndarray:
    """Log of the area-weighted mean signature of each union `members` (k, s), (k, 16) float32; `area` (s,)."""
    count = members.shape[1]
    mass = np.bincount(heat.owner, heat.mass, minlength=count)
    mean = np.stack([np.bincount(heat.owner, heat.mass * s, minlength=count) for s in heat.signature.T], axis=1)
    weight = members * np.maximum(area / max(float(area.sum()), 1e-300), 1e-9)
    weight /= weight.sum(axis=1, keepdims=True)
    return np.log(np.maximum(weight @ (mean / mass[:, None]), 1e-12)).astype(np.float32)


def persistent_signatures(heat: HeatKernel, members: np.ndarray) -> np.ndarray:
    """The most persistent peaks of the log signature within each union, (k, 32) float32: 4 times, 4 peaks, 2 numbers.

    Peaks are maxima of the superlevel sets among the union's own points; a peak dies where its region meets that of a
    higher one, the highest at the union's lowest point. In order of persistence (birth - death) come, for each time,
    the births and the persistences; where there are fewer peaks, the birth is that of the highest one, with no
    persistence. So a union without branches, too, has a signature.
    """
    values = np.log(np.maximum(heat.signature[:, list(PERSISTENT)], 1e-12))
    order = np.argsort(-values, axis=0, kind="stable")
    inside = members[:, heat.owner]
    return _peaks(np.ascontiguousarray(values.T), np.ascontiguousarray(order.T), heat.neighbours, inside, PEAKS)


@njit(cache=True, nogil=True, parallel=True)
def _peaks(values, order, neighbours, inside, peaks):  # type: ignore[no-untyped-def]
    """Births and persistences (k, times · 2 · peaks) float32 by union-find from the highest point down."""
    times, count = values.shape
    out = np.zeros((len(inside), times * 2 * peaks), dtype=np.float32)
    for node in prange(len(inside)):
        root = np.empty(count, dtype=np.int64)
        birth, persistence = np.empty(peaks), np.empty(peaks)
        for t in range(times):
            root[:] = -1
            persistence[:] = 0.0
            birth[:] = 0.0
            lowest = 0.0
            for p in order[t]:
                if not inside[node, p]:
                    continue
                lowest = values[t, p]
                top = p
                root[p] = p
                for q in neighbours[p]:
                    if root[q] < 0 or q == p:
                        continue
                    while root[q] != q:
                        root[q] = root[root[q]]
                        q = root[q]
                    if q == top:
                        continue
                    high, low = (q, top) if values[t, q] >= values[t, top] else (top, q)
                    _insert(birth, persistence, values[t, low], values[t, low] - lowest)
                    root[low] = high
                    top = high
            for p in order[t]:
                if inside[node, p] and root[p] == p:
                    _insert(birth, persistence, values[t, p], values[t, p] - lowest)
            for k in range(peaks):
                at = t * 2 * peaks + k
                out[node, at] = birth[k] if persistence[k] > 0 else birth[0]
                out[node, at + peaks] = persistence[k]
    return out


@njit(cache=True, nogil=True)
def _insert(birth, persistence, born, lasts):  # type: ignore[no-untyped-def]
    """Put a peak into the list of the most persistent ones, in order."""
    k = len(birth) - 1
    if lasts <= persistence[k]:
        return
    while k > 0 and persistence[k - 1] < lasts:
        birth[k], persistence[k] = birth[k - 1], persistence[k - 1]
        k -= 1
    birth[k], persistence[k] = born, lasts
