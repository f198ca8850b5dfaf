"""Random over-segmentation of labelled parts, seeded, so that two shapes of a pair disagree."""

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import KDTree

from ..errors import BadParameter
from .mesh import Mesh, diagonal, face_areas
from .segmentation import Segmentation, segmentation_from_labels

SLIVER = 0.002
TRIES = 8
TOUCH = 0.03


def oversegment(mesh: Mesh, part: np.ndarray, *, segments: int, seed: int, merge: float = 0.0) -> Segmentation:
    """Cut the parts (m,) of a mesh into connected pieces, `segments` in all where possible.

    Every connected region of a part is at least one piece; the remaining cuts fall on regions at random, more often
    on large ones. `merge` is the chance of each part but the largest to be joined to a neighbour, smaller ones more
    often (under-segmentation); parts are also joined, the smallest first, where there are more of them than
    `segments`. No piece is made below 0.2 % of the area. Raises `BadParameter`.
    """
    if segments < 2:
        raise BadParameter(f"An over-segmentation needs at least 2 segments, not {segments}.")
    if not 0 <= merge <= 1:
        raise BadParameter(f"The chance of merging parts must lie in 0..1, not {merge:g}.")
    rng = np.random.default_rng([seed, 7919])
    area = face_areas(mesh)
    pairs = face_neighbours(mesh.faces)
    label = _merged(mesh, _regions(pairs, np.asarray(part)), area, rng, segments, merge)
    links = _walking_graph(mesh)
    stuck: set[int] = set()
    while label.max() + 1 < segments:
        sizes = np.bincount(label, area)
        weight = np.where([k in stuck for k in range(len(sizes))], 0.0, sizes**1.5) * rng.uniform(0.2, 1, len(sizes))
        if not weight.max() > 0:
            break
        piece = int(rng.choice(len(sizes), p=weight / weight.sum()))
        far = _cut(mesh, np.flatnonzero(label == piece), area, pairs, links, rng)
        if far is None:
            stuck.add(piece)
        else:
            label[far] = label.max() + 1
    return segmentation_from_labels(_in_random_order(label, rng))


def face_neighbours(faces: np.ndarray) -> np.ndarray:
    """Pairs of faces (e, 2) that share an edge, each pair once."""
    ends = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(faces)), 3)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    same = (ends[order[1:]] == ends[order[:-1]]).all(axis=1)
    return np.c_[owner[order[:-1]][same], owner[order[1:]][same]]


def without_teeth(pairs: np.ndarray, label: np.ndarray, rounds: int = 4) -> np.ndarray:
    """Give each face (m,) that has two neighbours of one other label that label: borders lose their teeth."""
    label = label.copy()
    both = np.vstack([pairs, pairs[:, ::-1]])
    for _ in range(rounds):
        across = both[label[both[:, 0]] != label[both[:, 1]]]
        key = across[:, 0] * (label.max() + 1) + label[across[:, 1]]
        value, count = np.unique(key, return_counts=True)
        teeth = value[count >= 2]
        if not len(teeth):
            break
        label[teeth // (label.max() + 1)] = teeth % (label.max() + 1)
    return label


def connected_pieces(pairs: np.ndarray, count: int) -> np.ndarray:
    """Component (count,) int of each of `count` faces, joined by pairs (e, 2)."""
    link = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return connected_components(link, directed=False)[1]


def _regions(pairs: np.ndarray, part: np.ndarray) -> np.ndarray:
    """Connected regions of equal part."""
    return connected_pieces(pairs[part[pairs[:, 0]] == part[pairs[:, 1]]], len(part))


def _walking_graph(mesh: Mesh) -> csr_matrix:
    """Faces that share a vertex, weighted by the distance of their centres."""
    m, n = len(mesh.faces), len(mesh.vertices)
    centre = mesh.vertices[mesh.faces].mean(axis=1)
    incidence = csr_matrix((np.ones(3 * m), (np.repeat(np.arange(m), 3), mesh.faces.ravel())), shape=(m, n))
    near = (incidence @ incidence.T).tocoo()
    i, j = near.row, near.col
    keep = i != j
    length = np.linalg.norm(centre[i[keep]] - centre[j[keep]], axis=1) + 1e-12
    return csr_matrix((length, (i[keep], j[keep])), shape=(m, m))


def _merged(
    mesh: Mesh, region: np.ndarray, area: np.ndarray, rng: np.random.Generator, segments: int, merge: float
) -> np.ndarray:
    """Join regions to a neighbour: by chance, and until there are at most `segments`."""
    touching = _touching(mesh, region)
    group = np.arange(region.max() + 1)
    sizes = np.bincount(region, area)
    order = np.argsort(sizes)
    wanted = [k for k in order[:-1] if rng.uniform() < merge * min(1.0, 2 * sizes.mean() / (sizes.mean() + sizes[k]))]
    for k in wanted:
        _join(group, k, touching, sizes, rng)
    for k in order:
        if len(np.unique(group)) <= segments:
            break
        _join(group, k, touching, sizes, rng)
    return np.unique(group[region], return_inverse=True)[1].ravel()


def _join(group: np.ndarray, k: int, touching: np.ndarray, sizes: np.ndarray, rng: np.random.Generator) -> None:
    """Put the group of region k into the group of one of its neighbours, a small one rather than a large one."""
    mine = group == group[k]
    others = np.unique(group[(touching[mine].any(axis=0)) & ~mine])
    if len(others):
        weight = np.array([1 / sizes[group == g].sum() for g in others])
        group[mine] = rng.choice(others, p=weight / weight.sum())


def _touching(mesh: Mesh, region: np.ndarray) -> np.ndarray:
    """(r, r) bool: regions whose vertices come within 3 % of the diagonal of each other."""
    count = int(region.max()) + 1
    trees = [KDTree(mesh.vertices[np.unique(mesh.faces[region == k])]) for k in range(count)]
    reach = TOUCH * diagonal(mesh)
    result = np.zeros((count, count), dtype=bool)
    for i in range(count):
        for j in range(i + 1, count):
            near = trees[i].query(trees[j].data, distance_upper_bound=reach)[0].min() < reach
            result[i, j] = result[j, i] = near
    return result


def _cut(
    mesh: Mesh, faces: np.ndarray, area: np.ndarray, pairs: np.ndarray, links: csr_matrix, rng: np.random.Generator
) -> np.ndarray | None:
    """The faces of one of two connected halves of a piece, or None where every cut leaves a sliver."""
    row = np.full(len(mesh.faces), -1)
    row[faces] = np.arange(len(faces))
    inner = row[pairs]
    inner = inner[(inner >= 0).all(axis=1)]
    least = SLIVER * area.sum()
    for _ in range(TRIES):
        height = _height(mesh, faces, links, rng)
        order = np.argsort(height, kind="stable")
        share = np.cumsum(area[faces][order]) / area[faces].sum()
        side = np.zeros(len(faces), dtype=bool)
        side[order[share > rng.uniform(0.28, 0.72)]] = True
        side = _both_connected(inner, without_teeth(inner, side.astype(np.int64)) == 1, area[faces])
        if min(area[faces[side]].sum(), area[faces[~side]].sum()) >= 2 * least:
            return faces[side]
    return None


def _height(mesh: Mesh, faces: np.ndarray, links: csr_matrix, rng: np.random.Generator) -> np.ndarray:
    """A function to cut at: walking distance from one end of the piece, or height along its longest axis."""
    centre = mesh.vertices[mesh.faces[faces]].mean(axis=1)
    if rng.uniform() < 0.5:
        axis = np.linalg.svd(centre - centre.mean(axis=0), full_matrices=False)[2][0]
        tilt = axis + 0.15 * rng.normal(size=3)
        return centre @ tilt
    local = links[faces][:, faces]
    start = int(rng.integers(len(faces)))
    for _ in range(2):
        walk = dijkstra(local, indices=start)
        walk[~np.isfinite(walk)] = walk[np.isfinite(walk)].max()
        start = int(np.argmax(walk))
    return walk


def _both_connected(pairs: np.ndarray, side: np.ndarray, area: np.ndarray) -> np.ndarray:
    """Move all but the largest piece of each side across, first from True to False, then back."""
    side = side.copy()
    for value in (True, False):
        piece = connected_pieces(pairs[side[pairs[:, 0]] == side[pairs[:, 1]]], len(side))
        size = np.bincount(piece, np.where(side == value, area, 0.0))
        side[(side == value) & (piece != size.argmax())] = not value
    return side


def _in_random_order(label: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Number the pieces at random: nothing about the truth can be read from the numbers."""
    return rng.permutation(label.max() + 1)[label]
