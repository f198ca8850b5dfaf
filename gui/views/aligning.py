"""Turning the shapes of a collection alike, by where their common parts lie. Numbers only: no Qt and no VTK here."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .scene import Scene

_FLAT = 0.08  # parts in a line say nothing of the turn about it: least ratio of their second spread to their first
_ABOUT, _OVER, _LEANING = 0.85, 0.75, 0.3  # how much nearer common parts must come: about the upright axis, over, leaning
_LEANS = np.cos(np.radians(35.0))  # a shape that leans less than this is taken to stand, unless it is a leaning copy


def aligned(scenes: Sequence[Scene], parts: Sequence[np.ndarray]) -> tuple[Scene, ...]:
    """The scenes turned so that common parts lie alike, upright as most of them were; `parts` (s,) int64, -1 for none.

    A shape with too few common parts, or one that lies right already, stays as it is.
    """
    turns = rotations(scenes, parts)
    return tuple(scene if np.array_equal(turn, np.eye(3)) else turned_scene(scene, turn)
                 for scene, turn in zip(scenes, turns, strict=True))  # fmt: skip


def rotations(scenes: Sequence[Scene], parts: Sequence[np.ndarray]) -> list[np.ndarray]:
    """A rotation (3, 3) for each scene, to be applied to its points as p ↦ R p."""
    count = 1 + max((int(part.max(initial=-1)) for part in parts), default=-1)
    places, shares = zip(*(_parts_of(scene, part, count) for scene, part in zip(scenes, parts, strict=True)), strict=True)
    common = np.minimum(np.array(shares)[:, None], np.array(shares)[None])  # (n, n, parts)
    first = int(common.sum(axis=(1, 2)).argmax()) if count else 0
    turns = [_best_turn(places[row], places[first], common[row, first]) for row in range(len(scenes))]
    turns[first] = np.eye(3)
    return _upright([np.eye(3) if turn is None else turn for turn in turns], [turn is not None for turn in turns])


def turned_scene(scene: Scene, turn: np.ndarray) -> Scene:
    """The scene with all its points turned about the origin."""
    return replace(scene, points=scene.points @ turn.T, centroid=scene.centroid @ turn.T, spots=scene.spots @ turn.T,
                   samples=scene.samples @ turn.T)  # fmt: skip


def _parts_of(scene: Scene, part: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Centre (parts, 3) and share of the area (parts,) of each part of a shape."""
    own = part[scene.labels]
    area, inside = scene.area[own >= 0], own[own >= 0]
    total = np.bincount(inside, area, count)[:count]
    sums = np.stack([np.bincount(inside, area * scene.centroid[own >= 0, k], count)[:count] for k in range(3)], axis=1)
    return sums / np.maximum(total, 1e-300)[:, None], total / max(scene.area.sum(), 1e-300)


def _best_turn(a: np.ndarray, b: np.ndarray, weight: np.ndarray) -> np.ndarray | None:
    """The rotation of a (parts, 3) that brings it nearest to b (Kabsch 1976); None where that is not known.

    A shape that stands upright keeps standing: it is turned about the upright axis alone.
    """
    if (weight > 0).sum() < 3:
        return None
    w = np.sqrt(weight / weight.sum())[:, None]  # small parts count, too
    x, y = (p - (w * p).sum(axis=0) / w.sum() for p in (a, b))
    for spread in (np.linalg.svd(w * p, compute_uv=False) for p in (x, y)):
        if spread[1] < _FLAT * spread[0]:
            return None
    chosen, left = np.eye(3), np.linalg.norm(w * (x - y))
    both = (w * x).T @ (w * y)
    over = _any_turn(both)
    for turn, gain in ((_about_upright(both), _ABOUT), (over, _LEANING if over[1, 1] > _LEANS else _OVER)):
        after = np.linalg.norm(w * (x @ turn.T - y))
        if after < gain * left:
            chosen, left = turn, after
    return chosen


def _any_turn(both: np.ndarray) -> np.ndarray:
    u, _, v = np.linalg.svd(both)
    return v.T @ np.diag([1.0, 1.0, np.sign(np.linalg.det(v.T @ u.T)) or 1.0]) @ u.T


def _about_upright(both: np.ndarray) -> np.ndarray:
    """The best turn about y alone, by the covariance (3, 3) of the two."""
    angle = np.arctan2(both[2, 0] - both[0, 2], both[0, 0] + both[2, 2])
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def _upright(turns: list[np.ndarray], known: list[bool]) -> list[np.ndarray]:
    """All turned once more together, so that the upright axis is that of the shape which most others agree with."""
    ups = np.array([turn[:, 1] for turn, ok in zip(turns, known, strict=True) if ok])
    agree = np.clip(ups @ ups.T, 0, None) ** 4 @ np.ones(len(ups))
    up = ups[int(agree.argmax())]
    if up[1] > 0.999:
        return turns
    axis = np.cross(up, [0.0, 1.0, 0.0])
    length = np.linalg.norm(axis)
    axis = axis / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    extra = np.eye(3) + length * cross + (1 - up[1]) * cross @ cross  # Rodrigues, by the sine and cosine of the angle
    return [extra @ turn if ok else turn for turn, ok in zip(turns, known, strict=True)]
