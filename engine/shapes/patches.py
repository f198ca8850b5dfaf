"""Any mesh in any number of segments: geodesic patches that stop at the creases between parts.

Centres lie as far from each other as they can (Gonzalez 1985; Eldar et al. 1997) and move to the middle of their
patches (Lloyd 1982), by a distance on the surface in which a concave turn is a long way: by the minima rule
(Hoffman & Richards 1984) parts meet where the surface is concave.
"""

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from ..errors import BadParameter
from ..progress import Progress, silent
from .facegraph import FaceGraph, face_graph, pieces
from .mesh import Mesh

CONVEX_TURN = 0.15  # a convex turn counts this much of a concave one
GRAIN = 1e-9
SPECK = 0.002  # of the area: smaller pieces of a surface get no centre of their own
LLOYD, SPREAD = 4, 6


def geodesic_patches(mesh: Mesh, *, count: int, seed: int, crease: float, progress: Progress = silent) -> np.ndarray:
    """Label (m,) int64 in 0..s-1 of each face: s = min(count, m) patches.

    `crease` is the way, in patch radii, that a concave turn of one radian is worth; 0 ignores creases. Each patch is
    connected wherever the mesh is; separate pieces of it share a patch only where there are more of them than
    patches, or they are specks. Turning, moving or scaling the mesh changes nothing. Raises `BadParameter`.
    """
    if count < 1:
        raise BadParameter(f"A mesh has at least 1 segment; {count} were asked for.")
    return patches_of(face_graph(mesh), count=count, seed=seed, crease=crease, progress=progress)


def patches_of(graph: FaceGraph, *, count: int, seed: int, crease: float, progress: Progress = silent) -> np.ndarray:
    """The same for a graph of faces."""
    count = min(count, graph.faces)
    radius = np.sqrt(graph.area.sum() / max(2, count) / np.pi)
    ways = graph.matrix(walking_weights(graph, crease * radius, 20 * radius))
    centres = _far_apart(graph, ways, count, seed, progress)
    label = _nearest(ways, centres)
    for k in range(LLOYD):
        progress(0.5 + 0.5 * k / LLOYD, "moving the patches")
        moved = _middles(graph, ways, label, count)
        if (moved == centres).all():
            break
        centres, label = moved, _nearest(ways, moved)
    return label


def walking_weights(graph: FaceGraph, concave: float, bridge: float) -> np.ndarray:
    """The way (e,) between the faces of each pair: the length, `concave` for each radian of concave turn, and `bridge`.

    Where inside and outside cannot be told, concave and convex turns count half as much each. Ways are rounded to a
    grain, so that rounding errors of a turned mesh decide no tie.
    """
    into, out = (1.0, CONVEX_TURN) if graph.inside else (0.5, 0.5)
    turn = np.where(graph.turn > 0, into * graph.turn, -out * graph.turn)
    return np.maximum(np.round((graph.length + concave * turn + bridge * graph.bridge) / GRAIN), 1) * GRAIN


def _far_apart(graph: FaceGraph, ways: csr_matrix, count: int, seed: int, progress: Progress) -> np.ndarray:
    """Faces (count,): one in each piece of the surface, the largest first, then always the one farthest from all."""
    piece = pieces(graph, bridges=False)
    size = np.bincount(piece, graph.area)
    worth = size[piece] >= SPECK * graph.area.sum()
    worth = worth if worth.sum() >= count else np.ones(graph.faces, bool)
    start = int(np.random.default_rng(seed).integers(graph.faces))
    # the farthest face from any start is an end of the shape; going there twice forgets the start
    walk = dijkstra(ways, indices=start)
    centres: list[int] = []
    for own in np.argsort(-size, kind="stable")[:count]:
        inner = np.flatnonzero(piece == own)
        if worth[inner[0]]:
            centres.append(int(inner[np.argmax(walk[inner])]))
    walk = dijkstra(ways, indices=centres, min_only=True)
    while len(centres) < count:
        progress(0.5 * len(centres) / count, "placing the patches")
        farthest = int(np.argmax(np.where(worth, walk, -1.0)))
        if not walk[farthest] > 0:
            farthest = int(np.setdiff1d(np.arange(graph.faces), centres)[0])
        centres.append(farthest)
        walk = np.minimum(walk, dijkstra(ways, indices=farthest, limit=float(walk.max())))
    return np.array(centres)


def _nearest(ways: csr_matrix, centres: np.ndarray) -> np.ndarray:
    """The number (m,) of the centre nearest to each face; each patch is connected, as its shortest ways are."""
    source = dijkstra(ways, indices=centres, min_only=True, return_predecessors=True)[2]
    row = np.full(ways.shape[0], -1)
    row[centres] = np.arange(len(centres))
    return row[source]


def _middles(graph: FaceGraph, ways: csr_matrix, label: np.ndarray, count: int) -> np.ndarray:
    """The face (count,) of each patch with the least sum of squared ways to a few faces that are spread over it."""
    coo = ways.tocoo()
    same = label[coo.row] == label[coo.col]
    within = type(coo)((coo.data[same], (coo.row[same], coo.col[same])), shape=coo.shape).tocsr()
    order = np.lexsort((np.arange(graph.faces), label))
    at = order[np.searchsorted(label[order], np.arange(count))]
    total, nearest = np.zeros(graph.faces), np.full(graph.faces, np.inf)
    for k in range(SPREAD + 1):
        walk = dijkstra(within, indices=at, min_only=True)
        if k:  # the first was any face: what is farthest from it is an end of the patch
            total += walk**2
            nearest = np.minimum(nearest, walk)
        at = _best(walk if k == 0 else nearest, label, count)
    return _best(-total, label, count)


def _best(value: np.ndarray, label: np.ndarray, count: int) -> np.ndarray:
    """The face (count,) of each patch with the highest value, the first of equal ones."""
    order = np.lexsort((-value, label))
    return order[np.searchsorted(label[order], np.arange(count))]
