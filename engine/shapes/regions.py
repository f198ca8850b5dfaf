"""Regions of a surface: keeping them whole, and joining them in an order that leaves nearly convex parts.

Two regions are joined first where their union stays convex and is small, and where they meet at no concave crease
(the criterion of approximate convex decomposition: Lien & Amato 2007; the order: Mamou & Ghorbel 2009).
"""

import heapq
from collections.abc import Iterator

import numpy as np
from scipy.sparse import csr_array, diags_array

from ..progress import Progress, silent
from .facegraph import FaceGraph, pieces

# Found on labelled shapes: how much a concave crease of one radian, and the size of the union, weigh beside the cube
# root of the volume that a union adds to the two hulls.
CREASE, SIZE, MOST_CONVEX = 0.2, 0.05, -0.3
APART = np.pi / 2  # pieces of a surface that share no edge meet as at a right angle
TEETH_ROUNDS = 6
EVEN_STEPS, EVEN_TURN = 30, 0.3  # steps over which borders are evened, and the turn (radians) that holds them

MOST_POINTS, MOST_CORNERS = 1000, 100  # of a hull: more only cost time

Hull = tuple[np.ndarray, float]


def tidied(graph: FaceGraph, labels: np.ndarray) -> np.ndarray:
    """Labels (m,) with even borders and one connected piece each, numbered 0..s-1.

    A face whose edges lie mostly against one other region goes to it, and borders are straightened; then every piece
    of a region but its largest goes to the region that it shares the longest border with.
    """
    return whole(graph, _evened(graph, _without_teeth(graph, numbered(labels))))


def numbered(labels: np.ndarray) -> np.ndarray:
    """Labels (m,) renumbered 0..s-1 in their order."""
    return np.unique(labels, return_inverse=True)[1].ravel().astype(np.int64)


def _without_teeth(graph: FaceGraph, labels: np.ndarray) -> np.ndarray:
    labels = labels.copy()
    for _ in range(TEETH_ROUNDS):
        face, other, length = _shared_borders(graph, np.arange(graph.faces), labels)
        own = np.zeros(graph.faces)
        mine = other == labels[face]
        own[face[mine]] = length[mine]
        tooth = ~mine & (length > own[face] * 1.0001)
        if not tooth.any():
            break
        order = np.lexsort((length[tooth], face[tooth]))  # the longest of each face is written last
        labels[face[tooth][order]] = other[tooth][order]
    return labels


def _evened(graph: FaceGraph, labels: np.ndarray) -> np.ndarray:
    """Labels that win where each flows to its neighbours for a few steps, hardly across creases; small regions stay."""
    flow = graph.matrix(np.maximum(graph.border * np.exp(-np.abs(graph.turn) / EVEN_TURN), 1e-12))
    step = flow + diags_array(np.asarray(flow.sum(axis=1)).ravel())
    step = diags_array(1 / np.maximum(np.asarray(step.sum(axis=1)).ravel(), 1e-300)) @ step
    count = int(labels.max()) + 1
    share = csr_array((np.ones(graph.faces), (np.arange(graph.faces), labels)), shape=(graph.faces, count))
    for _ in range(EVEN_STEPS):
        share = step @ share
    found = np.asarray(share.argmax(axis=1)).ravel()
    before, kept = np.bincount(labels, minlength=count), np.bincount(labels[found == labels], minlength=count)
    shrunk = 2 * kept < before
    return np.where(shrunk[labels], labels, found)


def _shared_borders(graph: FaceGraph, part: np.ndarray, labels: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """For the parts (m,) of faces: (part, label that it borders on, length), each pair once; inner pairs left out."""
    i, j = np.r_[graph.pairs, graph.pairs[:, ::-1]].T
    kept = part[i] != part[j]
    many = int(labels.max()) + 1
    key, at = np.unique(part[i[kept]] * many + labels[j[kept]], return_inverse=True)
    length = np.bincount(at, np.r_[graph.border, graph.border][kept] + 1e-9, len(key))
    return key // many, key % many, length


def whole(graph: FaceGraph, labels: np.ndarray) -> np.ndarray:
    """Labels (m,) of which each is one connected piece, its largest; smaller ones join the neighbour they border most."""
    labels = numbered(labels)
    piece = pieces(graph, labels)
    count, owner = int(piece.max()) + 1, labels[np.unique(piece, return_index=True)[1]]
    order = np.lexsort((np.arange(count), -np.bincount(piece, graph.area, count), owner))
    settled = np.zeros(count, bool)
    settled[order[np.r_[True, np.diff(owner[order]) > 0]]] = True
    part, other, length = _shared_borders(graph, piece, piece)
    while (loose := ~settled[part] & settled[other]).any():
        order = np.lexsort((length[loose], part[loose]))  # the longest border of each is written last
        owner[part[loose][order]] = owner[other[loose][order]]
        settled[part[loose]] = True
    return numbered(owner[piece])


def hull_of(points: np.ndarray) -> Hull:
    """Corners (q, 3) and the volume of the convex hull of points (p, 3), nearly; flat sets have no volume."""
    from scipy.spatial import ConvexHull, QhullError

    points = points[:: len(points) // MOST_POINTS + 1]
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return spread(points, MOST_CORNERS), 0.0
    return spread(points[hull.vertices], MOST_CORNERS), float(hull.volume)


def spread(points: np.ndarray, most: int) -> np.ndarray:
    """At most so many of the points (p, 3): those that lie farthest from each other."""
    if len(points) <= most:
        return points
    chosen = np.zeros(most, np.int64)
    away = np.full(len(points), np.inf)
    for k in range(1, most):
        away = np.minimum(away, ((points - points[chosen[k - 1]]) ** 2).sum(axis=1))
        chosen[k] = int(np.argmax(away))
    return points[chosen]


def joining_order(
    graph: FaceGraph, corners: np.ndarray, labels: np.ndarray, *, progress: Progress = silent
) -> np.ndarray:
    """The steps (s - 1, 2) in which s regions (m,) become one: the second of a pair joins the first.

    `corners` (m, 3, 3) are those of the faces. With it any number of segments is a matter of `joined`.
    """
    regions = _Regions(graph, corners, labels)
    count = len(regions.hull)
    heap = [(regions.cost(a, b), a, b, 0, 0) for a in range(count) for b in regions.border[a] if a < b]
    heapq.heapify(heap)
    version = [0] * count
    steps: list[tuple[int, int]] = []
    while heap:
        _, a, b, at_a, at_b = heapq.heappop(heap)
        if (version[a], version[b]) != (at_a, at_b):
            continue
        progress(len(steps) / count, "joining regions")
        regions.join(a, b)
        steps.append((a, b))
        version[a], version[b] = version[a] + 1, -1
        for c in regions.border[a]:
            low, high = min(a, c), max(a, c)
            heapq.heappush(heap, (regions.cost(low, high), low, high, version[low], version[high]))
    return np.array(steps, dtype=np.int64).reshape(-1, 2)


def joined(labels: np.ndarray, steps: np.ndarray, count: int) -> np.ndarray:
    """Labels (m,) of which the first steps are taken until `count` are left, numbered 0..count-1."""
    number = np.arange(int(labels.max()) + 1)
    for first, second in steps[: max(0, len(number) - max(1, count))]:
        number[number == second] = first
    return numbered(number[labels])


class _Regions:
    """Hulls, sizes and common borders of regions while they are joined."""

    def __init__(self, graph: FaceGraph, corners: np.ndarray, labels: np.ndarray) -> None:
        count = int(labels.max()) + 1
        order = np.argsort(labels, kind="stable")
        parts = np.split(order, np.cumsum(np.bincount(labels, minlength=count))[:-1])
        self.hull = [hull_of(np.unique(corners[part].reshape(-1, 3), axis=0)) for part in parts]
        self.size = np.bincount(labels, graph.area, count) / graph.area.sum()
        self.border: list[dict[int, np.ndarray]] = [{} for _ in range(count)]
        for a, b, length, turning in _creases(graph, labels):
            self.border[a][b] = self.border[b][a] = np.array([length, turning])

    def cost(self, a: int, b: int) -> float:
        """What speaks against joining two neighbours."""
        extra = max(0.0, hull_of(np.r_[self.hull[a][0], self.hull[b][0]])[1] - self.hull[a][1] - self.hull[b][1])
        length, turning = self.border[a][b]
        turn = max(turning / length, MOST_CONVEX)
        value = extra ** (1 / 3) + CREASE * turn * min(self.size[a], self.size[b]) ** 0.5 + SIZE * (self.size[a] + self.size[b]) ** 0.5
        return round(float(value), 9)

    def join(self, a: int, b: int) -> None:
        """Make b a part of a."""
        self.hull[a] = hull_of(np.r_[self.hull[a][0], self.hull[b][0]])
        self.size[a] += self.size[b]
        for c, shared in self.border[b].items():
            del self.border[c][b]
            if c != a:
                self.border[a][c] = self.border[c][a] = shared + self.border[a].get(c, np.zeros(2))
        self.border[b] = {}


def _creases(graph: FaceGraph, labels: np.ndarray) -> Iterator[tuple[int, int, float, float]]:
    """(a, b, length, length times turn) of the common border of each two regions that meet, a < b."""
    ends = np.sort(labels[graph.pairs], axis=1)
    across = ends[:, 0] != ends[:, 1]
    length = graph.border[across] + 1e-9
    turn = graph.turn if graph.inside else np.abs(graph.turn) / 2
    many = int(labels.max()) + 1
    key, at = np.unique(ends[across] @ np.array([many, 1]), return_inverse=True)
    total = np.bincount(at, length, len(key))
    turning = np.bincount(at, length * np.where(graph.bridge, APART, turn)[across], len(key))
    for k, border, angle in zip(key, total, turning, strict=True):
        yield int(k) // many, int(k) % many, float(border), float(angle)
