"""What the learned matcher is told about a pair of nodes, and which pairs it looks at."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from ..consistency.candidates import keep_nearest
from .alignment import Alignment, alignments
from .lightfield import signature_distances
from .surfacepoints import SurfacePoints

NEAREST = 12  # pairs looked at for each node
NEIGHBOURS = 5
SOFTNESS = 0.05  # of the weights of alignments by their cost
_BOTH = ("size", "within_50", "rest_pieces", "linear", "repeats", "rest_1")  # also as the mean of the two nodes


@dataclass(frozen=True, slots=True, eq=False)
class Side:
    """One shape of a pair without its top node: `members` (k, s), `signatures` (k, 450), `features` name -> (k,)."""

    points: SurfacePoints
    members: np.ndarray
    segments: int
    signatures: np.ndarray
    features: dict[str, np.ndarray]


@dataclass(frozen=True, slots=True, eq=False)
class Looks:
    """The pairs (c, 2) int64 that are looked at, sorted, and what is seen of each without its light field distance.

    `inputs` (c, f) float32 with columns `names`; `near` (c,) float64 distances of the quantile signatures.
    """

    pairs: np.ndarray
    inputs: np.ndarray
    near: np.ndarray
    names: tuple[str, ...]


def look_at_pairs(source: Side, target: Side) -> Looks:
    """The pairs among the nearest of either node by a quick distance, all pairs of segments, and their features."""
    near = signature_distances(source.signatures, target.signatures).astype(np.float64)
    found = alignments(source.points, target.points)
    laid = [_shares(source, target, one.onto[:, None], one.back[:, None]) for one in found]
    intrinsic = _intrinsic_shares(source, target)
    quick, reach = _quick(source, target, near, intrinsic, laid[0])
    kept = np.zeros(near.shape, dtype=bool)
    kept[: source.segments, : target.segments] = True
    for distance in (quick, reach):
        keep_nearest(kept, distance, NEAREST)
    pairs = np.argwhere(kept)
    i, j = pairs.T
    columns = {f"apart_{name}": np.abs(source.features[name][i] - target.features[name][j]) for name in source.features}
    columns |= {f"mean_{name}": (source.features[name][i] + target.features[name][j]) / 2 for name in _BOTH}
    columns |= _shared("intrinsic", *intrinsic, i, j) | _aligned(source, target, found, laid, i, j)
    columns |= _ranks(quick, i, j)
    inputs = np.stack(list(columns.values()), axis=1).astype(np.float32)
    return Looks(pairs, inputs, near[i, j], tuple(columns))


def _quick(
    source: Side, target: Side, near: np.ndarray, intrinsic: tuple[np.ndarray, np.ndarray], laid: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Two quick distances (k, l): by all that is cheap, and by the silhouettes and geodesic distances."""

    def apart(name: str) -> np.ndarray:
        return np.abs(source.features[name][:, None] - target.features[name])

    total = 0.5 * near + 0.5 * apart("size") + 2 * apart("within_50")
    total = total + 0.5 * (apart("axis_0") + apart("axis_1") + apart("axis_2"))
    total = total - np.sqrt(intrinsic[0] * intrinsic[1]) - np.sqrt(laid[0] * laid[1])
    return total, near + 2 * apart("within_50")


def _shares(source: Side, target: Side, onto: np.ndarray, back: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Share of node i's points whose partners `onto` (P, n) lie in node j, and the reverse by `back`, both (k, l)."""
    a, b = source.points, target.points
    s, t = source.members.shape[1], target.members.shape[1]
    there, here = np.zeros((s, t)), np.zeros((t, s))
    for column in onto.T:
        np.add.at(there, (a.owner, b.owner[column]), a.weight / onto.shape[1])
    for column in back.T:
        np.add.at(here, (b.owner, a.owner[column]), b.weight / back.shape[1])
    m, n = source.members.astype(np.float64), target.members.astype(np.float64)
    forward = (m @ there @ n.T) / (m @ np.bincount(a.owner, a.weight, minlength=s))[:, None]
    backward = (n @ here @ m.T) / (n @ np.bincount(b.owner, b.weight, minlength=t))[:, None]
    return forward, backward.T


def _intrinsic_shares(source: Side, target: Side) -> tuple[np.ndarray, np.ndarray]:
    """The same for points that lie alike in their own shapes, whatever the pose."""
    a, b = _intrinsic(source.points), _intrinsic(target.points)
    return _shares(source, target, KDTree(b).query(a, NEIGHBOURS)[1], KDTree(a).query(b, NEIGHBOURS)[1])


def _intrinsic(points: SurfacePoints) -> np.ndarray:
    return np.concatenate([
        np.log(points.profile + 0.02), 0.4 * np.log(points.inner)[:, None], 0.25 * points.heat,
        0.3 * np.log(points.radius + 0.1)[:, None],
    ], axis=1)  # fmt: skip


def _shared(name: str, forward: np.ndarray, backward: np.ndarray, i: np.ndarray, j: np.ndarray) -> dict[str, np.ndarray]:
    f, b = forward[i, j], backward[i, j]
    return {f"{name}_least": np.minimum(f, b), f"{name}_most": np.maximum(f, b)}


def _aligned(
    source: Side, target: Side, found: list[Alignment], laid: list[tuple[np.ndarray, np.ndarray]], i: np.ndarray, j: np.ndarray
) -> dict[str, np.ndarray]:
    """How well two nodes lie upon each other in the best motion, in all by their cost, and in any."""
    cost = np.array([one.cost for one in found])
    weight = np.exp(-(cost - cost[0]) / SOFTNESS)
    weight = weight / weight.sum()
    both = np.stack([np.sqrt(f[i, j] * b[i, j]) for f, b in laid])
    apart = _centres(source)[i] @ found[0].rotation.T - _centres(target)[j]
    return _shared("aligned", *laid[0], i, j) | {
        "aligned_mean": weight @ both, "aligned_any": both.max(axis=0), "alignment_cost": np.full(len(i), cost[0]),
        "alignment_gap": np.full(len(i), cost[1] - cost[0] if len(cost) > 1 else 0.3),
        "aligned_centres": np.sqrt((apart**2).sum(axis=1)),
    }  # fmt: skip


def _centres(side: Side) -> np.ndarray:
    own = side.members.astype(np.float64)[:, side.points.owner] * side.points.weight
    return own @ side.points.points / own.sum(axis=1, keepdims=True)


def _ranks(quick: np.ndarray, i: np.ndarray, j: np.ndarray) -> dict[str, np.ndarray]:
    """Where a pair stands among those of its two nodes by the quick distance."""
    found = {}
    for axis, name in ((1, "source"), (0, "target")):
        order = np.argsort(np.argsort(quick, axis=axis, kind="stable"), axis=axis, kind="stable")
        found[f"rank_{name}"] = np.log1p(order)[i, j]
        found[f"behind_{name}"] = (quick - quick.min(axis=axis, keepdims=True))[i, j]
    return found
