"""Aeroplanes: fuselage, wings, engines, stabilisers, fin, sometimes winglets, a cockpit or a propeller."""

import numpy as np

from .solids import Solid, ellipsoid, tube

LABELS = ("fuselage", "wing", "engine", "stabiliser", "fin", "winglet", "cockpit", "propeller")


def aeroplane(rng: np.random.Generator) -> list[Solid]:
    """The parts of an aeroplane that flies along +x with z up, about two units long."""
    length, radius = rng.uniform(1.7, 2.3), rng.uniform(0.1, 0.15)
    solids = [_fuselage(rng, length, radius)]
    low = rng.choice([-0.5, -0.4, 0.5]) * radius
    root, span = rng.uniform(0.3, 0.46), rng.uniform(0.72, 1.1)
    sweep, rise = rng.uniform(-0.02, 0.5), rng.uniform(0.0, 0.14) * (1 if low < 0 else 0.2)
    at, taper = rng.uniform(-0.02, 0.18) * length, rng.uniform(0.35, 0.65)
    tip = np.array([at - sweep * span, span, low + rise * span])
    middle = np.array([at - 0.5 * sweep * span, 0.5 * span, low + 0.5 * rise * span])
    for side in (1, -1):
        mirror = np.array([1, side, 1])
        start = np.array([at, 0.3 * radius, low])
        solids.append(_plate("wing", [start * mirror, tip * mirror], root, taper * root, 0.045, 0.028, (0, 0, 1)))
    solids += _engines(rng, middle, tip, radius, length)
    if rng.uniform() < 0.25:
        for side in (1, -1):
            end = np.add(tip, [-0.05, 0.02, 0.14]) * [1, side, 1]
            solids.append(_plate("winglet", [(tip - [0, 0.01, 0]) * [1, side, 1], end], taper * root * 0.9,
                                 taper * root * 0.5, 0.03, 0.026, (0, 1, 0)))  # fmt: skip
    solids += _tail(rng, length, radius)
    if rng.uniform() < 0.35:
        solids.append(ellipsoid("cockpit", (0.33 * length, 0, 0.75 * radius), (0.2, 0.6 * radius, 0.55 * radius),
                                (1, 0, 0), (0, 0, 1)))  # fmt: skip
    return solids


def _fuselage(rng: np.random.Generator, length: float, radius: float) -> Solid:
    nose, flat = rng.uniform(0.4, 0.7), rng.uniform(0.9, 1.15)
    x = np.array([0.5, 0.47, 0.4, 0.28, -0.15, -0.35, -0.5]) * length
    r = np.array([0.5 * nose, 0.95 * nose, 0.9, 1.0, 1.0, 0.72, 0.22]) * radius
    z = np.array([-0.2, -0.1, 0, 0, 0, 0.15, 0.45]) * radius
    return tube("fuselage", np.c_[x, 0 * x, z], np.c_[r, flat * r], up=(0, 0, 1), steps=40)


def _plate(name: str, path: list, root: float, tip: float, thick: float, thin: float, up: tuple) -> Solid:
    """A flat tapering wing: chords `root` and `tip` across, half-thicknesses along `up`."""
    return tube(name, path, [(root / 2, thick), (tip / 2, thin)], up=up, power=2.4)


def _engines(
    rng: np.random.Generator, middle: np.ndarray, tip: np.ndarray, radius: float, length: float
) -> list[Solid]:
    """Two or four under the wings, two at the tail, or a propeller at the nose."""
    size, long = rng.uniform(0.06, 0.085), rng.uniform(0.2, 0.32)
    kind = rng.choice(["two", "two", "four", "tail", "propeller"])
    if kind == "propeller":
        blade = rng.uniform(0.22, 0.32)
        nose = np.array([0.5 * length + 0.015, 0, -0.2 * radius])
        return [
            tube("propeller", [nose - [0, blade, 0], np.add(nose, [0, blade, 0])], [(0.045, 0.028)] * 2, up=(1, 0, 0))
        ]
    if kind == "tail":
        spots = [np.array([-0.3 * length, radius * 0.75 + 0.8 * size, 0.35 * radius])]
    else:
        drop = np.array([0.1, 0, -0.75 * size])
        spots = [middle * [1, 0.8, 1] + drop]
        if kind == "four":
            spots.append(middle + 0.5 * (tip - middle) + drop)
    solids = []
    for spot in spots:
        for side in (1, -1):
            x, y, z = spot * [1, side, 1]
            path = [(x + long / 2, y, z), (x + 0.2 * long, y, z), (x - long / 2, y, z)]
            solids.append(tube("engine", path, [0.85 * size, size, 0.6 * size], round_ends=False))
    return solids


def _tail(rng: np.random.Generator, length: float, radius: float) -> list[Solid]:
    """The fin and two stabilisers, low or on top of the fin."""
    back, z = -0.43 * length, 0.3 * radius
    high, chord, lean = rng.uniform(0.3, 0.45), rng.uniform(0.2, 0.3), rng.uniform(0.08, 0.25)
    end = np.array([back - lean, 0, z + high])
    solids = [_plate("fin", [(back, 0, z), tuple(end)], chord, 0.6 * chord, 0.036, 0.028, (0, 1, 0))]
    start = np.array([back - 0.85 * lean, 0, z + 0.88 * high]) if rng.uniform() < 0.3 else np.array([back, 0, z])
    reach, sweep, size = rng.uniform(0.28, 0.42), rng.uniform(0.03, 0.16), chord * rng.uniform(0.75, 1.0)
    for side in (1, -1):
        tip = np.add(start, [-sweep, side * reach, 0.03])
        root = np.add(start, [0, side * 0.012, 0])
        solids.append(_plate("stabiliser", [tuple(root), tuple(tip)], size, 0.55 * size, 0.034, 0.027, (0, 0, 1)))
    return solids
