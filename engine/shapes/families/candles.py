"""Candlesticks: a foot, a stem of repeated rings and spindles, a dish, one or more candles with flames."""

import numpy as np

from .solids import Solid, ellipsoid, heading, torus, tube, turned

LABELS = ("foot", "ring", "spindle", "dish", "candle", "flame", "handle", "branch")


def candlestick(rng: np.random.Generator) -> list[Solid]:
    """The parts of a candlestick that stands on z = 0."""
    radius, z = rng.uniform(0.2, 0.32), rng.uniform(0.07, 0.14)
    steps = [(radius, 0), (radius, 0.3 * z), (0.6 * radius, 0.6 * z), (0.3 * radius, z)]
    solids = [turned("foot", steps, smooth=rng.choice([0, 18]))]
    slim = rng.uniform(0.04, 0.06)
    count = rng.integers(1, 5)
    lengths = rng.uniform(0.1, 0.26, count) * (1.6 / (0.6 + 0.4 * count))
    for length in lengths:
        z = _ring(rng, solids, z, slim)
        bulge = slim * rng.uniform(1.0, 1.7)
        solids.append(turned("spindle", [(slim, 0), (bulge, length / 2), (slim, length)], (0, 0, z), smooth=14))
        z += length
    z = _ring(rng, solids, z, slim)
    if rng.uniform() < 0.35:
        solids += _branches(rng, z - 0.5 * lengths[-1], slim)
    solids += _holder(rng, np.array([0, 0, z]), rng.uniform(0.13, 0.22))
    if rng.uniform() < 0.3:
        loop = rng.uniform(0.07, 0.1)
        solids.append(torus("handle", (0.85 * radius + loop, 0, 0.05), (0, 1, 0), loop, 0.03))
    return solids


def _ring(rng: np.random.Generator, solids: list[Solid], z: float, slim: float) -> float:
    """Add a bead at height z; gives the height above it."""
    height, width = rng.uniform(0.045, 0.07), slim * rng.uniform(1.7, 2.5)
    solids.append(ellipsoid("ring", (0, 0, z + height / 2 - 0.008), (height / 2 + 0.008, width, width)))
    return z + height - 0.016


def _holder(rng: np.random.Generator, foot: np.ndarray, width: float) -> list[Solid]:
    """Dish, candle and flame above a point."""
    deep, wall = rng.uniform(0.065, 0.1), 0.042
    bowl = [(0.35 * width, 0), (width, 0.7 * deep), (width, deep), (width - wall, deep), (0.35 * width, wall)]
    thick, tall = 0.45 * width * rng.uniform(0.7, 1.15), rng.uniform(0.25, 0.55)
    wick = np.add(foot, [0, 0, wall - 0.024 + tall])
    flame = rng.uniform(0.09, 0.13)
    drop = [(0.2 * flame, 0), (0.42 * flame, 0.3 * flame), (0.25 * flame, 0.75 * flame), (0.05 * flame, 1.2 * flame)]
    return [turned("dish", bowl, foot - [0, 0, 0.012]),
            turned("candle", [(thick, 0), (thick, tall)], np.add(foot, [0, 0, wall - 0.04])),
            turned("flame", drop, wick - [0, 0, 0.02], smooth=14)]  # fmt: skip


def _branches(rng: np.random.Generator, z: float, slim: float) -> list[Solid]:
    """Two or three curved arms around the stem, each with its own holder."""
    count, reach, rise = rng.integers(2, 4), rng.uniform(0.34, 0.46), rng.uniform(0.1, 0.2)
    turn = rng.uniform(0, 2 * np.pi)
    solids = []
    for k in range(count):
        out = heading(turn + 2 * np.pi * k / count, 0)
        end = np.array([0, 0, z + rise]) + reach * out
        path = [[0, 0, z], [*(0.55 * reach * out[:2]), z - 0.05], [*(0.95 * reach * out[:2]), z + 0.3 * rise], end]
        solids.append(tube("branch", path, max(0.03, 0.6 * slim)))
        solids += _holder(rng, end, rng.uniform(0.11, 0.14))
    return solids
