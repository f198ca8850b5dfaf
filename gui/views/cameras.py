"""Where to look from: a camera as plain numbers, turning between two of them, and the best view of some segments."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from .scene import Scene

VIEW_ANGLE = 28.0
_GRID = 56


class Camera(NamedTuple):
    """Position, focal point and up, each (3,)."""

    position: np.ndarray
    focal: np.ndarray
    up: np.ndarray


def look_from(direction: Iterable[float], distance: float, up: Iterable[float] = (0.0, 1.0, 0.0)) -> Camera:
    """A camera at the given direction and distance that looks at the origin."""
    towards = _unit(np.asarray(tuple(direction), float))
    return Camera(towards * distance, np.zeros(3), np.asarray(tuple(up), float))


def fitting_distance(scene: Scene, towards: np.ndarray, aspect: float) -> float:
    """How far away in a direction (3,) the shape fills a picture of this aspect (width / height) with some margin.

    It is at least so far that a shape turned to its longest side is cut off a little, not by half.
    """
    frame = np.stack(_frame(towards))
    x, y, z = (scene.samples @ frame.T).T
    slope = np.tan(np.radians(VIEW_ANGLE / 2))
    fits = max((np.abs(y) / slope + z).max(), (np.abs(x) / (slope * aspect) + z).max())
    radius = float(np.linalg.norm(scene.samples, axis=1).max())
    return max(1.16 * float(fits), 0.9 * radius / np.sin(np.arctan(slope * min(1.0, aspect))))


def narrowed(camera: Camera, before: float, after: float) -> Camera:
    """The camera moved so that a picture of another aspect (width / height) shows what it showed before, as large.

    Only pictures that are or were higher than wide need that; going there and back changes nothing.
    """
    return camera._replace(position=camera.focal + (camera.position - camera.focal) * min(1.0, before) / min(1.0, after))


def between(start: Camera, end: Camera, share: float) -> Camera:
    """The camera at a share in [0, 1] of the way, on an arc around the focal point."""
    arm_0, arm_1 = start.position - start.focal, end.position - end.focal
    length_0, length_1 = np.linalg.norm(arm_0), np.linalg.norm(arm_1)
    focal = (1 - share) * start.focal + share * end.focal
    arm = _slerp(arm_0 / length_0, arm_1 / length_1, start.up, share) * (length_0 * (1 - share) + length_1 * share)
    up = _slerp(_unit(start.up), _unit(end.up), arm_0, share)
    return Camera(focal + arm, focal, up)


def turned(camera: Camera, degrees: float) -> Camera:
    """The camera walked around the focal point about its own up axis."""
    angle, axis = np.radians(degrees), _unit(camera.up)
    arm = camera.position - camera.focal
    arm = arm * np.cos(angle) + np.cross(axis, arm) * np.sin(angle) + axis * (axis @ arm) * (1 - np.cos(angle))
    return camera._replace(position=camera.focal + arm)


def candidate_directions() -> np.ndarray:
    """The small set of directions that a view is chosen from, (42, 3): rings at four heights, the usual one first."""
    rings = [(20.0, 14), (-15.0, 10), (45.0, 10), (75.0, 4), (-60.0, 4)]
    angles = [(height, 30.0 + 360.0 * k / n) for height, n in rings for k in range(n)]
    return np.array([direction(height, turn) for height, turn in angles])


def direction(height: float, turn: float) -> np.ndarray:
    """Unit vector (3,) `height` degrees above the horizon and `turn` degrees from the front (z) to the right (x)."""
    h, t = np.radians(height), np.radians(turn)
    return np.array([np.cos(h) * np.sin(t), np.sin(h), np.cos(h) * np.cos(t)])


def visibility(scene: Scene, segments: Iterable[int], directions: np.ndarray) -> np.ndarray:
    """Share of the picture in which each segment is seen, (directions, segments) float64, by a coarse depth buffer."""
    wanted = np.asarray(list(segments), np.int64)
    return np.array([_seen(scene, towards, wanted) for towards in directions]).reshape(len(directions), len(wanted))


def best_direction(scene: Scene, segments: Iterable[int], directions: np.ndarray | None = None) -> np.ndarray:
    """The candidate direction (3,) in which the segments are best seen together."""
    candidates = candidate_directions() if directions is None else directions
    return candidates[int(np.argmax(view_scores(scene, segments, candidates)))]


def view_scores(scene: Scene, segments: Iterable[int], directions: np.ndarray) -> np.ndarray:
    """How well all segments are seen from each direction, (directions,): mean and least of their visibility relative
    to their best one, with a small preference for the usual view."""
    wanted = list(segments)
    if not wanted:
        return 0.08 * directions @ candidate_directions()[0]
    seen = visibility(scene, wanted, directions)
    relative = seen / np.maximum(seen.max(axis=0), 1e-12)
    return 0.5 * relative.mean(axis=1) + 0.5 * relative.min(axis=1) + 0.08 * directions @ candidate_directions()[0]


def _seen(scene: Scene, towards: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    right, up, towards = _frame(towards)
    cell = np.clip(((scene.samples @ np.stack([right, up]).T + 0.87) / 1.74 * _GRID).astype(np.int64), 0, _GRID - 1)
    index, depth = cell[:, 0] * _GRID + cell[:, 1], scene.samples @ towards
    nearest = np.full(_GRID * _GRID, -np.inf)
    np.maximum.at(nearest, index, depth)
    front = depth > nearest[index] - 0.03
    seen = np.zeros((scene.count, _GRID * _GRID), bool)
    seen[scene.sample_labels[front], index[front]] = True
    return seen[wanted].mean(axis=1)


def _frame(towards: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    towards = _unit(towards)
    right = _unit(np.cross([0.0, 1.0, 0.0] if abs(towards[1]) < 0.99 else [0.0, 0.0, -1.0], towards))
    return right, np.cross(towards, right), towards


def _slerp(a: np.ndarray, b: np.ndarray, spare: np.ndarray, share: float) -> np.ndarray:
    """Unit vector on the arc from a to b; opposite vectors turn about `spare`."""
    angle = np.arccos(np.clip(a @ b, -1.0, 1.0))
    if angle < 1e-6:
        return b
    side = b - (a @ b) * a
    if np.linalg.norm(side) < 1e-6:
        side = np.cross(_unit(spare), a)
    return a * np.cos(angle * share) + _unit(side) * np.sin(angle * share)


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / max(float(np.linalg.norm(vector)), 1e-12)
