"""One generated shape: a mesh with the truth of every face."""

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...arrays import frozen_array
from ...errors import BadParameter
from ..mesh import Mesh
from . import aeroplanes, animals, candles, lamps, vases
from .lofting import loft
from .solids import Solid
from .welding import weld

FAMILIES: dict[str, Callable[[np.random.Generator], list[Solid]]] = {
    "lamps": lamps.lamp,
    "candles": candles.candlestick,
    "vases": vases.vase,
    "aeroplanes": aeroplanes.aeroplane,
    "animals": animals.animal,
}
LABELS: dict[str, tuple[str, ...]] = {
    "lamps": lamps.LABELS,
    "candles": candles.LABELS,
    "vases": vases.LABELS,
    "aeroplanes": aeroplanes.LABELS,
    "animals": animals.LABELS,
}
DIGITS = 6  # coordinates are the same in memory and in the file
VARIANTS = ("touching", "welded")
POSES = ("upright", "turned")
TOUCHING_FACES = 4000
WELDED_FACES = 7000
FINEST_CELL, COARSEST_CELL = 0.018, 0.03


@dataclass(frozen=True, slots=True, eq=False)
class GeneratedShape:
    """A mesh with its truth: `label` (m,) int64 is the semantic class of each face, an index into `label_names`
    (left and right share a class); `part` (m,) int64 the instance it belongs to."""

    mesh: Mesh
    label: np.ndarray
    label_names: tuple[str, ...]
    part: np.ndarray

    def __post_init__(self) -> None:
        for name in ("label", "part"):
            array = frozen_array(getattr(self, name), np.int64, (len(self.mesh.faces),), f"The {name} of each face")
            object.__setattr__(self, name, array)


def make_shape(family: str, seed: int, *, variant: str = "touching", pose: str = "upright") -> GeneratedShape:
    """A shape of the family, the same for the same seed.

    `variant` "touching": the parts are closed meshes that touch but share no vertex; "welded": one connected surface
    whose neighbouring parts share vertices. `pose` "turned" rotates it at random. Raises `BadParameter`.
    """
    check_choice("shape family", family, tuple(FAMILIES))
    check_choice("variant", variant, VARIANTS)
    check_choice("pose", pose, POSES)
    if seed < 0:
        raise BadParameter(f"The seed must be 0 or larger, not {seed}.")
    rng = np.random.default_rng([seed, zlib.crc32(family.encode())])
    solids = FAMILIES[family](rng)
    turn = random_rotation(rng)
    vertices, faces, part = welded(solids) if variant == "welded" else touching(solids)
    label = np.array([LABELS[family].index(solid.name) for solid in solids])[part]
    part = np.unique(part, return_inverse=True)[1].ravel()
    if pose == "turned":
        vertices = vertices @ turn.T
    vertices = np.round(vertices, DIGITS)
    return GeneratedShape(Mesh(vertices, faces, f"{family} {seed}"), label, LABELS[family], part)


def check_choice(what: str, value: str, choices: Sequence[str]) -> None:
    """Raise `BadParameter` where the value is none of the choices."""
    if value not in choices:
        raise BadParameter(f"There is no {what} named '{value}'; choose one of: {', '.join(choices)}.")


def random_rotation(rng: np.random.Generator) -> np.ndarray:
    """A rotation matrix (3, 3), uniform over all of them."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.linalg.det(q)


def touching(solids: list[Solid]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All parts side by side in one mesh, about `TOUCHING_FACES` in all."""
    edge = float(np.sqrt(_area(solids) / TOUCHING_FACES * 4 / np.sqrt(3)))
    meshes = [loft(solid, edge) for solid in solids]
    offset = np.cumsum([0, *(len(v) for v, _ in meshes)])
    return (np.concatenate([v for v, _ in meshes]),
            np.concatenate([f + o for (_, f), o in zip(meshes, offset[:-1], strict=True)]),
            np.repeat(np.arange(len(meshes)), [len(f) for _, f in meshes]))  # fmt: skip


def welded(solids: list[Solid]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One surface, about `WELDED_FACES` of it; the cell stays below the thinnest part."""
    cell = float(np.clip(np.sqrt(3 * _area(solids) / WELDED_FACES), FINEST_CELL, COARSEST_CELL))
    return weld([loft(solid, 0.03) for solid in solids], cell)


def _area(solids: list[Solid]) -> float:
    total = 0.0
    for vertices, faces in (loft(solid, 0.06) for solid in solids):
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        total += 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
    return total
