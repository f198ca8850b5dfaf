"""Desk and floor lamps: base, stem, joint, arm, shade, and sometimes bulb, knob, crossbeam with a loop."""

import numpy as np

from .solids import Solid, ellipsoid, heading, torus, tube, turned

LABELS = ("base", "stem", "knob", "joint", "arm", "shade", "bulb", "crossbeam", "loop")
WALL = 0.052


def lamp(rng: np.random.Generator) -> list[Solid]:
    """The parts of a lamp that stands on z = 0."""
    solids, foot = _base(rng)
    height, lean = rng.uniform(0.5, 1.0), rng.normal(0, 0.06, 2)
    top = np.array([lean[0], lean[1], foot + height])
    solids += _stem(rng, np.array([0, 0, foot - 0.02]), top)
    ball = rng.uniform(0.05, 0.08)
    solids.append(ellipsoid("joint", top, (ball, ball, ball)))
    azimuth, rise = rng.uniform(-0.2, 0.2), rng.uniform(-0.15, 0.8)
    end = top + rng.uniform(0.35, 0.65) * heading(azimuth, rise)
    middle = (top + end) / 2 + [0, 0, rng.choice([0, 0, rng.uniform(0.03, 0.1)])]
    solids.append(tube("arm", [top, middle, end], rng.uniform(0.026, 0.04), power=rng.choice([2, 5])))
    solids += _shade(rng, end, heading(azimuth, -rng.uniform(0.75, 1.5)))
    if rng.uniform() < 0.45:
        solids += _crossbeam(rng, top, foot, azimuth)
    return solids


def _base(rng: np.random.Generator) -> tuple[list[Solid], float]:
    radius, height = rng.uniform(0.2, 0.34), rng.uniform(0.05, 0.1)
    kind = rng.integers(3)
    if kind == 0:
        return [turned("base", [(radius, 0), (radius, height)])], height
    if kind == 1:
        return [turned("base", [(radius, 0), (radius, height)], power=6)], height
    dome = [(radius, 0), (0.95 * radius, 0.5 * height), (0.6 * radius, 1.1 * height), (0.2 * radius, 1.6 * height)]
    return [turned("base", dome, smooth=16)], 1.6 * height


def _stem(rng: np.random.Generator, foot: np.ndarray, top: np.ndarray) -> list[Solid]:
    """One to three pieces that grow thinner, sometimes with knobs between them."""
    pieces = rng.integers(1, 4)
    cuts = np.r_[0, np.sort(rng.uniform(0.25, 0.75, pieces - 1)), 1]
    radius = rng.uniform(0.036, 0.055)
    knobs = rng.uniform() < 0.5
    solids = []
    for k in range(pieces):
        a, b = (foot + t * (top - foot) for t in cuts[k : k + 2])
        solids.append(tube("stem", [a, b + 0.01 * (top - foot)], radius, round_ends=False))
        if knobs and k:
            solids.append(ellipsoid("knob", a, (0.7 * radius, 1.9 * radius, 1.9 * radius), top - foot))
        radius *= rng.uniform(0.78, 0.95)
    return solids


def _shade(rng: np.random.Generator, end: np.ndarray, axis: np.ndarray) -> list[Solid]:
    """A bowl or cone with a wall, open along `axis`, and perhaps a bulb in it."""
    length, small, large = rng.uniform(0.24, 0.4), rng.uniform(0.085, 0.14), rng.uniform(0.2, 0.31)
    bell = rng.uniform(-0.03, 0.06)
    out = np.array([(small, 0), ((small + large) / 2 + bell, 0.5 * length), (large, length)])
    inner = np.array([(large - WALL, length), ((small + large) / 2 + bell - WALL, 0.5 * length), (small - WALL, WALL)])
    origin = end - 0.02 * axis
    solids = [turned("shade", np.vstack([out, inner]), origin, axis)]
    if rng.uniform() < 0.5:
        size = 0.32 * (small + large) / 2
        solids.append(ellipsoid("bulb", origin + (WALL + 1.2 * size) * axis, (1.3 * size, size, size), axis))
    return solids


def _crossbeam(rng: np.random.Generator, top: np.ndarray, foot: float, azimuth: float) -> list[Solid]:
    """A second arm on the other side that carries a hanging loop."""
    start = np.array([0, 0, foot]) + rng.uniform(0.8, 1.0) * (top - [0, 0, foot])
    end = start + rng.uniform(0.22, 0.4) * heading(azimuth + np.pi + rng.uniform(-0.6, 0.6), rng.uniform(-0.1, 0.5))
    ring, thick = rng.uniform(0.075, 0.11), rng.uniform(0.026, 0.032)
    centre = end - [0, 0, ring + 0.005]
    across = np.cross(end - start, [0, 0, 1])
    return [tube("crossbeam", [start, end], rng.uniform(0.028, 0.036)),
            torus("loop", centre, across, ring, thick)]  # fmt: skip
