"""Closed solids swept by a ring: the building material of all shape families.

A solid is a row of rings. Ring j is the closed curve c_j + r_j0·cosθ·u_j + r_j1·sinθ·v_j; a first or last ring of
radius 0 closes the surface. Bodies of revolution, tubes, wings and tori are all rows of rings.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator

ROUND_STEPS = 6


class Solid(NamedTuple):
    """A part before it is meshed.

    `centres`, `u`, `v` (k, 3) and `radii` (k, 2) describe the rings, in order; `power` is the exponent of the
    superellipse (2 a circle or ellipse, 6 nearly a rectangle); `closed` joins the last ring to the first.
    """

    name: str
    centres: np.ndarray
    u: np.ndarray
    v: np.ndarray
    radii: np.ndarray
    power: float = 2.0
    closed: bool = False


def unit(vector: Any) -> np.ndarray:
    """The vector(s) (..., 3) divided by the length."""
    array = np.asarray(vector, dtype=float)
    return array / np.linalg.norm(array, axis=-1, keepdims=True)


def heading(azimuth: float, elevation: float) -> np.ndarray:
    """Unit vector (3,) at `azimuth` about z from x and `elevation` above the floor, both in radians."""
    return np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])


def smooth_curve(points: Any, steps: int = 24) -> np.ndarray:
    """A curve (steps, d) through the points (k, d), monotone between them, spaced by the chord length."""
    points = np.asarray(points, dtype=float)
    chord = np.r_[0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]
    return PchipInterpolator(chord, points)(np.linspace(0, chord[-1], steps))


def turned(
    name: str, profile: Any, origin: Any = (0, 0, 0), axis: Any = (0, 0, 1), *, power: float = 2.0, smooth: int = 0
) -> Solid:
    """A body of revolution: `profile` (k, 2) holds radius and height along `axis`; `smooth` > 0 rounds it.

    A profile may run up outside and down inside, which gives a bowl or a shade with a wall.
    """
    rows = np.asarray(profile, dtype=float)
    rows = np.vstack([[0, rows[0, 1]], smooth_curve(rows, smooth) if smooth else rows, [0, rows[-1, 1]]])
    w = unit(axis)
    u, v = _cross_axes(w)
    k = len(rows)
    radius = np.maximum(rows[:, :1], 0)
    return Solid(name, np.asarray(origin, float) + rows[:, 1:] * w, np.tile(u, (k, 1)), np.tile(v, (k, 1)),
                 np.repeat(radius, 2, axis=1), power)  # fmt: skip


def tube(
    name: str, path: Any, radii: Any, *, up: Any = None, power: float = 2.0, round_ends: bool = True, steps: int = 24
) -> Solid:
    """A tube along the smoothed `path` (k, 3). `radii` is a number, (k,) or (k, 2): across and along `up`.

    Without `up` the rings are carried along without twist. Round ends reach beyond the path by the smaller radius.
    """
    path = np.asarray(path, dtype=float)
    radius = np.asarray(radii, dtype=float)
    columns = np.broadcast_to(radius.reshape(-1, 1) if radius.ndim < 2 else radius, (len(path), 2))
    curve = smooth_curve(np.hstack([path, columns]), steps) if len(path) > 2 else np.hstack([path, columns])
    centres, ring = curve[:, :3], np.maximum(curve[:, 3:], 1e-4)
    tangent = unit(np.gradient(centres, axis=0))
    u, v = _fixed_frames(tangent, up) if up is not None else _carried_frames(tangent)
    centres, u, v, ring = _with_ends(centres, u, v, ring, tangent, round_ends)
    return Solid(name, centres, u, v, ring, power)


def ellipsoid(name: str, centre: Any, radii: Sequence[float], axis: Any = (0, 0, 1), up: Any = None) -> Solid:
    """An ellipsoid with half-lengths `radii`: along `axis`, across, and along `up`."""
    w = unit(axis)
    angle = np.linspace(-np.pi / 2, np.pi / 2, 17)
    u, v = _cross_axes(w) if up is None else (x[0] for x in _fixed_frames(w[None], up))
    k = len(angle)
    ring = np.maximum(np.cos(angle), 0)[:, None] * np.array([radii[1], radii[2]])
    ring[[0, -1]] = 0
    centres = np.asarray(centre, float) + radii[0] * np.sin(angle)[:, None] * w
    return Solid(name, centres, np.tile(u, (k, 1)), np.tile(v, (k, 1)), ring)


def torus(name: str, centre: Any, normal: Any, radius: float, thickness: float, stretch: float = 1.0) -> Solid:
    """A ring of the given mean radius and half-thickness about `normal`; `stretch` lengthens it along one axis."""
    a, b = _cross_axes(unit(normal))
    angle = np.linspace(0, 2 * np.pi, 32, endpoint=False)[:, None]
    out = np.cos(angle) * a + stretch * np.sin(angle) * b
    across = unit(np.cos(angle) * stretch * a + np.sin(angle) * b)
    k = len(angle)
    return Solid(name, np.asarray(centre, float) + radius * out, across, np.tile(unit(normal), (k, 1)),
                 np.full((k, 2), thickness), closed=True)  # fmt: skip


def _cross_axes(w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors that complete w to a right-handed frame."""
    aside = np.eye(3)[int(np.argmin(np.abs(w)))]
    u = unit(np.cross(aside, w))
    return u, np.cross(w, u)


def _fixed_frames(tangent: np.ndarray, up: Any) -> tuple[np.ndarray, np.ndarray]:
    u = unit(np.cross(np.asarray(up, float), tangent))
    return u, np.cross(tangent, u)


def _carried_frames(tangent: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    u = np.empty_like(tangent)
    u[0] = _cross_axes(tangent[0])[0]
    for j in range(1, len(tangent)):
        u[j] = unit(u[j - 1] - (u[j - 1] @ tangent[j]) * tangent[j])
    return u, np.cross(tangent, u)


def _with_ends(
    centres: np.ndarray, u: np.ndarray, v: np.ndarray, ring: np.ndarray, tangent: np.ndarray, round_ends: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Add the rings that close both ends: quarter ellipses, or flat lids."""
    angle = np.linspace(0, np.pi / 2, ROUND_STEPS + 1)[1:, None] if round_ends else np.array([[np.pi / 2]])
    reach = (lambda j: ring[j].min() * np.sin(angle)) if round_ends else (lambda j: 0 * angle)
    shrink = np.maximum(np.cos(angle), 0)
    shrink[-1] = 0
    head, tail = centres[0] - reach(0) * tangent[0], centres[-1] + reach(-1) * tangent[-1]
    k = len(angle)
    repeat = [np.vstack([np.tile(x[0], (k, 1)), x, np.tile(x[-1], (k, 1))]) for x in (u, v)]
    return (np.vstack([head[::-1], centres, tail]), repeat[0], repeat[1],
            np.vstack([(shrink * ring[0])[::-1], ring, shrink * ring[-1]]))  # fmt: skip
