"""The rigid motions that lay one shape upon another best: by place, normal and geodesic centrality."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from .surfacepoints import SurfacePoints

NORMAL, CENTRAL = 0.25, 0.6  # weights of normals and of log centrality beside places
POINTS = 120  # points of the source that are followed while rotations are refined
KEPT = (80, 40, 24, 16, 12, 12, 12)  # rotations that stay after each round
ALIKE_TRACE = 2.7  # trace of the rotation between two results that count as one
_STARTS = np.concatenate([Rotation.create_group("O").as_matrix(), Rotation.random(240, rng=0).as_matrix()])


class Alignment(NamedTuple):
    """A rotation (3, 3) of the source, its cost, and the nearest points `onto` (P,) in the target, `back` (Q,)."""

    cost: float
    rotation: np.ndarray
    onto: np.ndarray
    back: np.ndarray


def alignments(source: SurfacePoints, target: SurfacePoints, *, most: int = 4) -> list[Alignment]:
    """Up to `most` different motions, best first, from 264 starts in the frames of the principal axes.

    Each round moves the rotations to the best fit of the nearest points (Besl and McKay 1992) and drops the worst.
    """
    rng = np.random.default_rng(0)
    follow = rng.choice(len(source.weight), POINTS, p=source.weight / source.weight.sum())
    central = np.log(source.centrality)
    goal = _embedded(target.points, target.normals, np.log(target.centrality))
    tree = KDTree(goal)
    places, normals = source.points[follow], source.normals[follow]
    rotations = _frame(target) @ _STARTS @ _frame(source).T
    for keep in KEPT:
        turned = np.concatenate([
            places @ rotations.swapaxes(1, 2), NORMAL * (normals @ rotations.swapaxes(1, 2)),
            np.broadcast_to((CENTRAL * central[follow])[:, None], (len(rotations), POINTS, 1)),
        ], axis=2)  # fmt: skip
        distance, nearest = tree.query(turned.reshape(-1, 7))
        cost = (distance**2).reshape(len(rotations), POINTS).mean(axis=1)
        best = np.argsort(cost, kind="stable")[:keep]
        partner = target.points[nearest.reshape(-1, POINTS)[best]]
        rotations = np.stack([_rotation(places, goal_places) for goal_places in partner])
    found = sorted((_judged(source, target, rotation, tree, goal, central) for rotation in rotations), key=lambda a: a.cost)
    return _different(found, most)


def _judged(
    source: SurfacePoints, target: SurfacePoints, rotation: np.ndarray, tree: KDTree, goal: np.ndarray, central: np.ndarray
) -> Alignment:
    turned = _embedded(source.points @ rotation.T, source.normals @ rotation.T, central)
    there, onto = tree.query(turned)
    here, back = KDTree(turned).query(goal)
    return Alignment(float(source.weight @ there**2 + target.weight @ here**2), rotation, onto, back)


def _different(found: list[Alignment], most: int) -> list[Alignment]:
    kept: list[Alignment] = []
    for one in found:
        if len(kept) < most and all(np.trace(one.rotation @ other.rotation.T) < ALIKE_TRACE for other in kept):
            kept.append(one)
    return kept


def _embedded(points: np.ndarray, normals: np.ndarray, central: np.ndarray) -> np.ndarray:
    return np.concatenate([points, NORMAL * normals, CENTRAL * central[:, None]], axis=1)


def _frame(shape: SurfacePoints) -> np.ndarray:
    """Principal axes as columns, each towards its longer tail, right-handed."""
    axes = np.linalg.eigh((shape.weight * shape.points.T) @ shape.points)[1]
    tail = shape.weight @ (shape.points @ axes) ** 3
    axes = axes * np.where(tail < 0, -1.0, 1.0)
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    return axes


def _rotation(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The rotation R that brings R a nearest to b, both (n, 3) (Kabsch 1976)."""
    u, _, vt = np.linalg.svd(a.T @ b)
    flip = np.diag([1.0, 1.0, np.sign(np.linalg.det(vt.T @ u.T))])
    return vt.T @ flip @ u.T
