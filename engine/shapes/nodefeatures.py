"""What a node looks like to the learned matcher: some forty numbers that do not change when the shape is turned."""

from collections.abc import Iterator

import numpy as np

from .segmentation import SegmentGraph
from .surfacepoints import SurfacePoints

CRUMB = 0.005  # share of area below which a piece of the rest is not counted
ALIKE = 0.15
_ALIKE_BY = ("size", "thickness", "within_15", "within_50", "within_90", "axis_0", "axis_1", "axis_2", "reach")


def node_features(points: SurfacePoints, graph: SegmentGraph, members: np.ndarray) -> dict[str, np.ndarray]:
    """Features (k,) float64 of the unions `members` (k, s) by name, all relative to the whole shape."""
    m = members.astype(np.float64)
    own = m[:, points.owner] * points.weight
    total = own.sum(axis=1)
    mean = own / total[:, None]
    found = dict(_distances(points, mean, own > 0))
    found |= {"size": np.log(total), **dict(_form(points, mean)), **dict(_surface(points, graph, m))}
    rest = _rest(graph, members)
    found |= {"rest_pieces": np.log1p(rest[:, 0]), "rest_1": rest[:, 1], "rest_2": rest[:, 2], "rest_3": rest[:, 3],
              "rest_balance": rest[:, 1] / np.maximum(1 - total, 1e-6)}  # fmt: skip
    apart = np.stack([found[name] for name in _ALIKE_BY], axis=1).astype(np.float32)
    found["repeats"] = np.log1p(_repeats(apart, (m * graph.area) @ m.T <= 1e-12 * graph.area.sum(), total))
    return found


def _distances(points: SurfacePoints, mean: np.ndarray, inside: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """Thickness, geodesic distances to all of the shape and within the node, heat."""
    thickness = np.log(points.inner)
    yield "thickness", mean @ thickness
    yield "thickness_spread", _spread(mean, thickness)
    yield "hollow", mean @ np.log(points.outer)
    profile = np.log(points.profile + 0.02)
    for name, column in zip(("5", "15", "30", "50", "70", "90", "100"), profile.T, strict=True):
        yield f"within_{name}", mean @ column
    yield "within_50_spread", _spread(mean, profile[:, 3])
    centrality = points.centrality
    yield "most_central", np.log(np.where(inside, centrality, np.inf).min(axis=1))
    yield "least_central", np.log(np.where(inside, centrality, -np.inf).max(axis=1))
    for k, column in enumerate(points.heat.T):
        yield f"heat_{k}", mean @ column
    yield "inner_distance", np.log(((mean @ points.geodesic) * mean).sum(axis=1) + 0.01)


def _form(points: SurfacePoints, mean: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """Moments of the node, and how they lie to those of the whole shape."""
    yield "reach", mean @ points.radius
    yield "reach_spread", _spread(mean, points.radius)
    centre = mean @ points.points
    away = np.sqrt((centre**2).sum(axis=1))
    yield "centre", away
    products = (points.points[:, :, None] * points.points[:, None]).reshape(-1, 9)
    covariance = (mean @ products).reshape(-1, 3, 3) - centre[:, :, None] * centre[:, None]
    value, axes = np.linalg.eigh(covariance)
    length = np.sqrt(np.maximum(value, 1e-6))
    for k in range(3):
        yield f"axis_{k}", np.log(length[:, k])
    yield "linear", np.log(length[:, 2] / length[:, 1])
    yield "planar", np.log(length[:, 1] / length[:, 0])
    whole_value, whole = np.linalg.eigh((points.weight @ products).reshape(3, 3))
    for name, own in (("long", axes[:, :, 2]), ("thin", axes[:, :, 0])):
        for k, column in enumerate(np.abs(own @ whole).T):
            yield f"{name}_along_{k}", column
    for k, column in enumerate((np.abs(centre @ whole) / np.sqrt(np.maximum(whole_value, 1e-6))).T):
        yield f"centre_along_{k}", column
    yield "points_away", np.abs((axes[:, :, 2] * centre).sum(axis=1)) / (away + 1e-9)


def _surface(points: SurfacePoints, graph: SegmentGraph, m: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """Normals, compactness, and how much of a node's neighbourhood is cut by its border."""
    inside = m[:, points.owner]
    mean = inside * points.weight / (inside * points.weight).sum(axis=1, keepdims=True)
    products = (points.normals[:, :, None] * points.normals[:, None]).reshape(-1, 9)
    value = np.linalg.eigvalsh((mean @ products).reshape(-1, 3, 3))
    yield "normals_least", value[:, 0]
    yield "normals_most", value[:, 2]
    yield "outward", mean @ ((points.normals * points.points).sum(axis=1) / (points.radius + 1e-9))
    volume, area = m @ graph.volume, m @ graph.area
    yield "compact", np.log((volume + 1e-12) / (area + 1e-12) ** 1.5 + 1e-4)
    between = np.zeros((m.shape[1], m.shape[1]))
    np.add.at(between, tuple(points.owner[points.links].T), points.strength)
    touching = m @ (between.sum(axis=0) + between.sum(axis=1))
    cut = np.maximum(touching - 2 * ((m @ between) * m).sum(axis=1), 0)
    yield "border", np.log(cut / np.maximum(touching, 1e-9) + 0.005)


def _rest(graph: SegmentGraph, members: np.ndarray) -> np.ndarray:
    """Number of connected pieces (at most 6) of what a node leaves over, and the shares of the three largest, (k, 4).

    Pieces below `CRUMB` count only where there is no larger one.
    """
    k, s = members.shape
    piece, share = _pieces(graph.edges, ~members), graph.area / graph.area.sum()
    sizes = np.zeros((k, s + 1))
    np.add.at(sizes, (np.arange(k)[:, None], piece), np.broadcast_to(share, (k, s)))
    sizes = -np.sort(-sizes[:, :s], axis=1)
    sizes = np.where((sizes > CRUMB) | (sizes[:, :1] <= CRUMB), sizes, 0.0)
    largest = np.pad(sizes, ((0, 0), (0, 3)))[:, :3]
    return np.column_stack([np.minimum((sizes > 0).sum(axis=1), 6), largest])


def _pieces(edges: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """The least segment that each segment of the sets `inside` (k, s) is joined to within its set, (k, s); s outside."""
    count = inside.shape[1]
    label = np.where(inside, np.arange(count), count)
    while True:
        before = label.copy()
        for i, j in (*edges, *edges[::-1]):
            least = np.minimum(label[:, i], label[:, j])
            both = inside[:, i] & inside[:, j]
            label[both, i] = label[both, j] = least[both]
        if (label == before).all():
            return label


def _repeats(looks: np.ndarray, apart: np.ndarray, size: np.ndarray) -> np.ndarray:
    """How often a node's like is found elsewhere in the shape: Σ exp(-difference) over disjoint nodes by size, (k,)."""
    found = np.zeros(len(looks))
    for k, row in enumerate(looks):
        like = np.exp(-np.abs(looks - row).mean(axis=1) / ALIKE)
        found[k] = (like * apart[k]) @ size / size[k]
    return found


def _spread(mean: np.ndarray, value: np.ndarray) -> np.ndarray:
    return np.sqrt(np.maximum(mean @ value**2 - (mean @ value) ** 2, 0))
