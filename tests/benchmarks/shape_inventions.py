"""Invented species of shapes, to fit the learned matcher to: no two alike, so that nothing can be learned by heart.

A species is a body with one to four kinds of limbs: single, in mirrored pairs or around an axis, of one to three pieces
that may end in a knob. Two shapes of one species differ in proportions, pose and details, and each kind of piece is a
class of its own.
"""

from dataclasses import dataclass

import numpy as np

from engine.shapes.families.generated import DIGITS, GeneratedShape, random_rotation, touching, welded
from engine.shapes.families.pairs import GeneratedPair, segmented
from engine.shapes.families.solids import Solid, ellipsoid, heading, tube, turned, unit
from engine.shapes.mesh import Mesh

MERGE = 0.12


@dataclass(frozen=True)
class Limb:
    """A kind of limb: how it is repeated, where it starts on the body, where it points and of what pieces it is."""

    name: str
    repeat: str
    count: int
    start: float
    around: float
    rise: float
    lengths: tuple[float, ...]
    thick: float
    flat: float
    bend: float
    power: float
    knob: float
    often: float


@dataclass(frozen=True)
class Species:
    """The body's kind and proportions, and its limbs."""

    body: str
    long: float
    wide: float
    high: float
    power: float
    loose: float
    limbs: tuple[Limb, ...]


def invent(seed: int) -> Species:
    """The species of a seed."""
    rng = np.random.default_rng([seed, 5417])
    body = str(rng.choice(["tube", "ellipsoid", "turned", "box"]))
    long = rng.uniform(0.3, 1.0)
    limbs = tuple(_limb(rng, f"limb {k}", body) for k in range(rng.integers(1, 5)))
    return Species(body, long, rng.uniform(0.1, 0.35), rng.uniform(0.1, 0.35), float(rng.choice([2, 2, 6])),
                   rng.uniform(0.05, 0.3), limbs)  # fmt: skip


def _limb(rng: np.random.Generator, name: str, body: str) -> Limb:
    repeat = str(rng.choice(["single", "mirror", "mirror", "around"]))
    lengths = tuple(rng.uniform(0.12, 0.45, rng.integers(1, 4)).tolist())
    return Limb(name, repeat, int(rng.integers(3, 7)), rng.uniform(-1, 1), rng.uniform(0, np.pi), rng.uniform(-1.3, 1.3),
                lengths, rng.uniform(0.03, 0.09), float(rng.choice([1, 1, rng.uniform(1.5, 4)])), rng.normal(0, 0.6),
                float(rng.choice([2, 2, 6])), float(rng.choice([0, 0, rng.uniform(1.3, 2.2)])), rng.uniform(0.75, 1.0))  # fmt: skip


def individual(species: Species, rng: np.random.Generator) -> list[Solid]:
    """The parts of one shape of the species."""

    def about(value: float) -> float:
        return value * float(np.exp(rng.normal(0, species.loose)))

    long, wide, high = about(species.long), about(species.wide), about(species.high)
    solids = [_body(species, long, wide, high, rng)]
    for limb in species.limbs:
        if rng.uniform() < limb.often:
            solids += _limbs(limb, about, species.loose, long, wide, high, rng)
    return solids


def _body(species: Species, long: float, wide: float, high: float, rng: np.random.Generator) -> Solid:
    if species.body == "ellipsoid":
        return ellipsoid("body", (0, 0, 0), (long / 2, wide, high), (1, 0, 0), (0, 0, 1))
    if species.body == "turned":
        radii = wide * np.exp(rng.normal(0, 0.5 * species.loose, 4)) * np.array([0.7, 1.0, 0.9, 0.6])
        profile = np.c_[radii, np.linspace(-long / 2, long / 2, 4)]
        return turned("body", profile, axis=(1, 0, 0), smooth=14)
    ends = np.c_[np.linspace(-long / 2, long / 2, 3), np.zeros((3, 2))]
    return tube("body", ends, [(0.8 * wide, 0.8 * high), (wide, high), (0.9 * wide, 0.7 * high)], up=(0, 0, 1),
                power=6 if species.body == "box" else species.power, round_ends=species.body != "box")  # fmt: skip


def _limbs(limb, about, loose, long, wide, high, rng) -> list[Solid]:  # type: ignore[no-untyped-def]
    """All copies of a limb, with shared proportions and a pose of their own each."""
    lengths, thick = [about(x) for x in limb.lengths], about(limb.thick)
    start, rise, bend = limb.start + rng.normal(0, 0.3 * loose), limb.rise + rng.normal(0, loose), limb.bend
    if limb.repeat == "single":
        angles = [np.pi / 2 if limb.around < np.pi / 2 else -np.pi / 2]
    elif limb.repeat == "mirror":
        angles = [limb.around - np.pi / 2, 3 * np.pi / 2 - limb.around]
    else:
        angles = (2 * np.pi * np.arange(limb.count) / limb.count).tolist()
    solids = []
    for angle in angles:
        out = np.array([0.0, np.cos(angle), np.sin(angle)])
        along = np.array([1.0, 0, 0])
        if limb.repeat == "single" and abs(limb.start) > 0.7:
            place, out = np.array([np.sign(limb.start) * 0.46 * long, 0, 0]), np.sign(limb.start) * along
            along = np.array([0.0, 0, 1])
        else:
            place = np.array([0.42 * start * long, 0.8 * wide * np.cos(angle), 0.8 * high * np.sin(angle)])
        pose = rise + rng.normal(0, 0.5 * loose)
        direction = unit(np.cos(pose) * out + np.sin(pose) * along)
        point, radius = place - 0.02 * direction, thick
        for k, length in enumerate(lengths):
            end = point + length * direction
            taper = radius * 0.8
            rings = [(radius * limb.flat, radius), (taper * limb.flat, taper)]
            up = unit(np.cross(direction, heading(0.3, 0.4)))
            solids.append(tube(f"{limb.name} {k}", [point, end], rings, up=up, power=limb.power))
            point, radius = end - 0.01 * direction, taper
            direction = unit(direction + np.tan(np.clip(bend + rng.normal(0, loose), -1, 1)) * along)
        if limb.knob:
            size = radius * limb.knob
            solids.append(ellipsoid(f"{limb.name} knob", point, (size, size, size)))
    return solids


def invented_pair(seed: int) -> GeneratedPair:
    """Two shapes of the species `seed`, turned at random, each cut at random into 6 to 20 segments."""
    species, rng = invent(seed), np.random.default_rng([seed, 91])
    variant = touching if seed % 2 else welded
    low, high = ((10, 16), (6, 10), (8, 20))[seed // 2 % 3]
    bodies = [individual(species, rng) for _ in range(2)]
    names = tuple(sorted({solid.name for solids in bodies for solid in solids}))
    shapes = []
    for k, solids in enumerate(bodies):
        vertices, faces, part = variant(solids)
        label = np.array([names.index(solid.name) for solid in solids])[part]
        mesh = Mesh(np.round(vertices @ random_rotation(rng).T, DIGITS), faces, f"invention {seed} {'ab'[k]}")
        shapes.append(GeneratedShape(mesh, label, names, np.unique(part, return_inverse=True)[1].ravel()))
    cut = [segmented(s, int(rng.integers(low, high + 1)), 2 * seed + k, MERGE) for k, s in enumerate(shapes)]
    return GeneratedPair(cut[0], cut[1], shapes[0].label, shapes[1].label, names)
