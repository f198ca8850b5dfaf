"""Vases and jugs: foot, body, neck, lip, no to two handles, sometimes a spout."""

import numpy as np

from .solids import Solid, torus, tube, turned

LABELS = ("foot", "body", "neck", "lip", "handle", "spout")
WALL = 0.052


def vase(rng: np.random.Generator) -> list[Solid]:
    """The parts of a vase that stands on z = 0."""
    height, belly, waist = rng.uniform(0.5, 0.95), rng.uniform(0.24, 0.42), rng.uniform(0.1, 0.17)
    foot, tall = rng.uniform(0.05, 0.12), rng.uniform(0.15, 0.4)
    at = rng.uniform(0.35, 0.7)
    bottom = rng.uniform(0.4, 0.65) * belly
    profile = np.array([(0.8 * bottom, 0), (bottom, 0.08 * height), (0.5 * (bottom + belly) + 0.04, 0.5 * at * height),
                        (belly, at * height), (0.5 * (belly + waist) + 0.03, (0.5 + 0.5 * at) * height),
                        (waist, height)])  # fmt: skip
    base = bottom * rng.uniform(0.95, 1.3)
    solids = [turned("foot", [(base, 0), (0.85 * bottom, foot)], smooth=0),
              turned("body", profile, (0, 0, foot - 0.015), smooth=30)]  # fmt: skip
    shoulder = foot - 0.015 + height
    mouth = waist * rng.uniform(0.95, 1.5)
    solids += _neck(shoulder - 0.02, tall, waist, mouth)
    kind = rng.choice(["plain", "two handles", "two handles", "jug", "one handle"])
    if kind != "plain":
        low = np.array([np.interp((at + 0.1) * height, profile[:, 1], profile[:, 0]), (at + 0.1) * height + foot])
        high = np.array([np.interp(0.75, [0, 1], [waist, mouth]), shoulder + 0.75 * tall])
        out, thick = rng.uniform(0.1, 0.22), rng.uniform(0.032, 0.042)
        for side in (1, -1)[: 2 if kind == "two handles" else 1]:
            solids.append(_handle(low, high, out, thick, side))
    if kind == "jug":
        solids.append(_spout(rng, low, shoulder + tall))
    return solids


def _neck(z: float, tall: float, waist: float, mouth: float) -> list[Solid]:
    """A tube with a wall, open above, and a lip around its mouth."""
    outer = np.array([(waist, 0), (0.5 * waist + 0.5 * mouth - 0.012, 0.5 * tall), (mouth, tall)])
    inner = (outer - [WALL, 0])[::-1]
    inner[-1, 1] = WALL
    return [turned("neck", np.vstack([outer, inner]), (0, 0, z)),
            torus("lip", (0, 0, z + tall), (0, 0, 1), mouth - 0.5 * WALL, 0.75 * WALL)]  # fmt: skip


def _handle(low: np.ndarray, high: np.ndarray, out: float, thick: float, side: int) -> Solid:
    """An ear from the shoulder to the neck, in the plane y = 0; `low` and `high` are (radius, height)."""
    far = max(low[0], high[0]) + out
    path = [(low[0] - 0.02, low[1]), (low[0] + 0.7 * out, low[1] + 0.02), (far, 0.5 * (low[1] + high[1]) + 0.05),
            (0.5 * (far + high[0]), high[1] + 0.04), (high[0] - 0.01, high[1])]  # fmt: skip
    return tube("handle", [(side * r, 0, z) for r, z in path], [(thick, thick)] * len(path), up=(0, 1, 0), steps=30)


def _spout(rng: np.random.Generator, low: np.ndarray, top: float) -> Solid:
    """A tapering beak opposite the handle."""
    reach, rise = rng.uniform(0.22, 0.34), rng.uniform(0.6, 0.95)
    z = low[1] + rise * (top - low[1])
    path = [(-low[0] + 0.05, 0, low[1] - 0.03), (-low[0] - 0.45 * reach, 0, low[1] + 0.25 * (z - low[1])),
            (-low[0] - 0.75 * reach, 0, z - 0.08), (-low[0] - reach, 0, z)]  # fmt: skip
    return tube("spout", path, [0.085, 0.06, 0.045, 0.038], round_ends=False)
