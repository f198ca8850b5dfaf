"""What the matching of a collection gives back: matches of its pairs with their support, and parts that agree."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ..consistency.lifting import LiftedAtoms
from ..consistency.parts import consistent_parts
from .collection_parameters import CollectionParameters
from .parameters import MatchParameters
from .result import MatchResult
from .segmentation import SegmentedShape

KINDS = ("cycles", "matchlift")
SUPPORTED = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class CollectionResult:
    """The n shapes of a collection, its matched pairs and its parts.

    `names` are unique; `pairs` (a, b) with a < b and their `results`; `supports` hold for each kind one (p,) float64 a
    pair, in [0, 1] or NaN where nothing can be said; `areas` (s,) those of the segments of each shape; `parts` (s,)
    int64 the part of each segment, -1 for none; `failures` say in a sentence each which shapes were left out.
    """

    shapes: tuple[SegmentedShape, ...]
    names: tuple[str, ...]
    pairs: tuple[tuple[int, int], ...]
    results: tuple[MatchResult, ...]
    supports: Mapping[str, tuple[np.ndarray, ...]]
    atoms: LiftedAtoms
    areas: tuple[np.ndarray, ...]
    parts: tuple[np.ndarray, ...]
    parameters: CollectionParameters
    match_parameters: MatchParameters
    preset: str
    failures: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    seconds: dict[str, float] = field(default_factory=dict)

    def support(self, row: int) -> np.ndarray:
        """The support (p,) of the matches of a pair, of the kind that the parameters choose."""
        return self.supports[self.parameters.support][row]

    @property
    def part_count(self) -> int:
        """Number of parts that at least two shapes have."""
        return 1 + max((int(part.max()) for part in self.parts), default=-1)

    def shares(self) -> np.ndarray:
        """Share of each shape's area in each part, (shapes, parts)."""
        out = np.zeros((len(self.shapes), self.part_count))
        for row, (part, area) in enumerate(zip(self.parts, self.areas, strict=True)):
            np.add.at(out[row], part[part >= 0], area[part >= 0] / max(area.sum(), 1e-300))
        return out

    def changed(self, parameters: CollectionParameters) -> "CollectionResult":
        """The same under other live parameters: the kind of support, and how fine the parts are."""
        return replace(self, parameters=parameters, parts=parts_of(self.atoms, self.areas, parameters))


def parts_of(
    atoms: LiftedAtoms, areas: tuple[np.ndarray, ...], parameters: CollectionParameters
) -> tuple[np.ndarray, ...]:
    """The part of each segment of each shape, (s,) int64; -1 for none."""
    size = np.concatenate([area / max(area.sum(), 1e-300) for area in areas])
    found = consistent_parts(atoms.matches, atoms.objects, size, part_from=parameters.part_from)
    return tuple(np.split(found, atoms.start[1:-1]))
