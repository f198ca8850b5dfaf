"""Which way is up: files disagree whether that is y or z, and a shape that lies on its side is hard to read.

Three cues: a standing shape rests stably on its lowest part, its top differs from its
bottom (the mirror plane of animals, chairs and aeroplanes is upright), and of two such ways the taller one is likelier.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from .planar import contains, convex_hull, polygon_area

_CELLS, _SLAB, _UNSTABLE = 20, 0.05, 0.35


def up_axis(samples: np.ndarray) -> Literal["y", "z"]:
    """The likelier up axis of a shape, given points (q, 3) spread over its surface; y if both are as likely."""
    return "y" if uprightness(samples, 1) >= uprightness(samples, 2) else "z"


def upright(points: np.ndarray, axis: str) -> np.ndarray:
    """Points (n, 3) turned so that the given axis, 'y' or 'z', points along y."""
    return points if axis == "y" else points[:, [0, 2, 1]] * [1.0, 1.0, -1.0]


def uprightness(samples: np.ndarray, axis: int) -> float:
    """How likely a shape stands along an axis (0, 1 or 2): higher is likelier, 0 for a shape that is flat there."""
    extent = np.ptp(samples, axis=0)
    steady = 1.0 if rests(samples, axis) else _UNSTABLE
    return steady * asymmetry(samples, axis) * float(np.sqrt(extent[axis] / extent.max()))


def rests(samples: np.ndarray, axis: int) -> bool:
    """Whether the middle of the shape lies above the part that it would stand on, and that part is no mere point."""
    ground = [k for k in range(3) if k != axis]
    height, extent = samples[:, axis], np.ptp(samples, axis=0)
    foot = convex_hull(samples[height <= height.min() + _SLAB * extent[axis]][:, ground])
    if len(foot) < 3 or polygon_area(foot) < 0.01 * extent[ground].prod():
        return False
    middle = foot.mean(axis=0)
    return contains(middle + 1.15 * (foot - middle), samples[:, ground].mean(axis=0))


def asymmetry(samples: np.ndarray, axis: int) -> float:
    """How much of the shape changes when it is mirrored along an axis, in [0, 1]."""
    low, extent = samples.min(axis=0), np.ptp(samples, axis=0)
    mirrored = samples.copy()
    mirrored[:, axis] = 2 * low[axis] + extent[axis] - samples[:, axis]
    here, there = (_occupied((p - low) / extent.max()) for p in (samples, mirrored))
    return 1.0 - float((here & there).sum() / (here | there).sum())


def _occupied(points: np.ndarray) -> np.ndarray:
    grid = np.zeros((_CELLS,) * 3, bool)
    grid[tuple(np.clip((points * _CELLS).astype(int), 0, _CELLS - 1).T)] = True
    return grid
