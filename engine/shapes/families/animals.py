"""Four-legged animals in poses: torso, neck, head, legs of two or three pieces, ears, tail, sometimes muzzle, horns."""

import numpy as np

from .solids import Solid, ellipsoid, heading, tube, unit

LABELS = ("torso", "neck", "head", "muzzle", "ear", "horn", "upper leg", "lower leg", "foot", "tail")


def animal(rng: np.random.Generator) -> list[Solid]:
    """The parts of an animal that stands near z = 0 and looks along +x."""
    length, girth, tall = rng.uniform(0.65, 0.95), rng.uniform(0.15, 0.23), rng.uniform(0.36, 0.66)
    chest, hip = girth * rng.uniform(0.95, 1.1), girth * rng.uniform(0.85, 1.05)
    z = tall + girth * 0.6
    x = np.array([0.5, 0.3, 0, -0.3, -0.5]) * length
    radii = np.array([0.6 * chest, chest, rng.uniform(0.82, 1.0) * girth, hip, 0.6 * hip])
    back = np.array([0, 0, rng.uniform(-0.03, 0.02), 0, 0]) + z
    solids = [tube("torso", np.c_[x, 0 * x, back], np.c_[0.88 * radii, radii], up=(0, 0, 1), steps=28)]
    solids += _front(rng, np.array([0.45 * length, 0, z + 0.35 * chest]), girth)
    solids += _legs(rng, length, girth, tall, z)
    solids.append(_tail(rng, np.array([-0.5 * length - 0.3 * hip, 0, z + 0.3 * hip]), girth))
    return solids


def _front(rng: np.random.Generator, shoulder: np.ndarray, girth: float) -> list[Solid]:
    """Neck, head, muzzle, ears and horns; the neck bends and the head turns aside."""
    rise, aside = rng.uniform(0.3, 1.2), rng.uniform(-0.35, 0.35)
    poll = shoulder + rng.uniform(0.24, 0.6) * heading(aside, rise)
    middle = 0.5 * (shoulder + poll) + 0.04 * heading(aside, rise + np.pi / 2)
    thick = girth * rng.uniform(0.5, 0.62)
    solids = [tube("neck", [shoulder - [0.05, 0, 0.03], middle, poll], [1.2 * thick, 0.85 * thick, 0.75 * thick])]
    forward = heading(aside + rng.uniform(-0.4, 0.4), rng.uniform(-0.7, 0.05))
    left = unit(np.cross([0, 0, 1], forward))
    crown = np.cross(forward, left)
    size, long = girth * rng.uniform(0.52, 0.68), rng.uniform(0.12, 0.17)
    head = poll + 0.5 * long * forward
    solids.append(ellipsoid("head", head, (long, 0.85 * size, size), forward, crown))
    if rng.uniform() < 0.6:
        end = head + (long + rng.uniform(0.06, 0.15)) * forward - 0.15 * size * crown
        start = head + 0.65 * long * forward - 0.15 * size * crown
        solids.append(tube("muzzle", [start, end], [0.58 * size, 0.42 * size]))
    top = head + 0.78 * size * crown - 0.3 * long * forward
    high, droop = rng.uniform(0.09, 0.2), rng.uniform(0.1, 1.0)
    horned = rng.uniform() < 0.25
    for side in (1, -1):
        out = unit(side * left * (0.45 + droop) + crown * (1 - 0.7 * droop) - 0.15 * forward)
        root = top + 0.45 * side * size * left - 0.1 * size * crown
        solids.append(tube("ear", [root, root + 0.5 * high * out, root + high * out],
                           [(0.044, 0.03), (0.052, 0.029), (0.03, 0.026)], up=forward))  # fmt: skip
        if horned:
            foot = top + 0.25 * side * size * left + 0.35 * long * forward
            bend = foot + 0.1 * crown + 0.05 * side * left
            solids.append(tube("horn", [foot, bend, bend + 0.1 * crown - 0.05 * forward], [0.036, 0.03, 0.022]))
    return solids


def _legs(rng: np.random.Generator, length: float, girth: float, tall: float, z: float) -> list[Solid]:
    """Four legs, each swung and bent at random, of an upper and a lower piece and perhaps a foot."""
    thick, knee_at, footed = girth * rng.uniform(0.36, 0.5), rng.uniform(0.42, 0.58), rng.uniform() < 0.6
    stride = rng.uniform(0.05, 0.3)
    solids = []
    for place in (0.34, -0.36):
        for side in (1, -1):
            hip = np.array([place * length, side * 0.55 * girth, z - 0.25 * girth])
            swing = rng.uniform(-stride, stride)
            bend = rng.uniform(0.0, 0.3) * (-1 if place > 0 else 1)
            down = np.array([np.sin(swing), 0.06 * side, -np.cos(swing)])
            low = np.array([np.sin(swing + bend), 0.03 * side, -np.cos(swing + bend)])
            knee = hip + knee_at * tall * unit(down)
            ankle = knee + (1 - knee_at) * tall * unit(low)
            solids.append(tube("upper leg", [hip, knee], [1.25 * thick, 0.72 * thick]))
            solids.append(tube("lower leg", [knee, ankle], [0.72 * thick, 0.5 * thick]))
            if footed:
                toe = np.add(ankle, [1.1 * thick, 0, -0.1 * thick])
                solids.append(tube("foot", [ankle - [0.1 * thick, 0, 0.1 * thick], toe], [0.62 * thick, 0.55 * thick]))
    return solids


def _tail(rng: np.random.Generator, root: np.ndarray, girth: float) -> Solid:
    """A tail that hangs, stands or curls."""
    long, lift, aside = rng.uniform(0.18, 0.6), rng.uniform(-1.0, 0.9), rng.uniform(-0.5, 0.5)
    first = root + 0.45 * long * heading(np.pi + aside, lift)
    last = first + 0.55 * long * heading(np.pi + 1.5 * aside, lift + rng.uniform(-0.7, 0.7))
    thick = girth * rng.uniform(0.17, 0.28)
    return tube("tail", [np.add(root, [0.06, 0, 0]), first, last], [1.15 * thick, thick, max(0.03, 0.7 * thick)])
