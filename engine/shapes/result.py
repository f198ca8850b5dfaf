"""What shape matching gives back: matches between nodes of two multi-layer graphs."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..arrays import frozen_array
from .parameters import MatchParameters
from .wishes import NO_WISHES, Wishes


class ShapeRecord(NamedTuple):
    """What a result remembers of an input."""

    file: str
    sha256: str
    segments: tuple[int | str, ...]
    faces: int
    segmentation: str = ""  # hash of the hashes of all segments: two segmentations of one mesh are two inputs


class Match(NamedTuple):
    """One match, for a person to read. Segments are indices 0..s-1 into the shape's names."""

    id: str
    source: tuple[int, ...]
    target: tuple[int, ...]
    score: float
    votes: int
    source_layer: int
    target_layer: int
    similarity: float
    pinned: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class MatchResult:
    """The p accepted matches of a pair, best first.

    `pairs` (p, 2) int64 are node rows of the two graphs; `source_members` (p, s) and `target_members` (p, t) bool the
    segments they unite; `score` (p,) float64 in [0, 1] is the probability that a match is right in the learned
    method, π of Eq 3.4 relative to the best candidate in the thesis's, the mean agreement with the other matches top-down,
    else what the method's own docstring says; `similarity` (p,) in [0, 1] the geometric one, `votes` (p,) int64 those of
    Algorithm 1; `ids` are content hashes of the matches (see `identity`); `wishes` are those that were honoured, and
    `pinned` (p,) bool marks the matches that people had pinned.
    """

    method: str
    preset: str
    parameters: MatchParameters
    source: ShapeRecord
    target: ShapeRecord
    pairs: np.ndarray
    score: np.ndarray
    similarity: np.ndarray
    votes: np.ndarray
    source_members: np.ndarray
    target_members: np.ndarray
    source_layer: np.ndarray
    target_layer: np.ndarray
    ids: tuple[str, ...]
    source_nodes: int
    target_nodes: int
    seconds: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    wishes: Wishes = NO_WISHES
    pinned: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        p = len(self.ids)
        wanted = set(self.wishes.pinned)
        sides = zip(self.source_members, self.target_members, strict=True)
        marks = [tuple(tuple(np.flatnonzero(m).tolist()) for m in pair) in wanted for pair in sides] if wanted else [False] * p
        object.__setattr__(self, "pinned", marks)
        for name, dtype, shape in (
            ("pairs", np.int64, (p, 2)), ("score", np.float64, (p,)), ("similarity", np.float64, (p,)),
            ("votes", np.int64, (p,)), ("source_layer", np.int64, (p,)), ("target_layer", np.int64, (p,)),
            ("source_members", bool, (p, len(self.source.segments))),
            ("target_members", bool, (p, len(self.target.segments))), ("pinned", bool, (p,)),
        ):  # fmt: skip
            object.__setattr__(self, name, frozen_array(getattr(self, name), dtype, shape, f"The {name} of a result"))

    def matches(self) -> list[Match]:
        """The matches as rows to read, best first."""
        return [
            Match(self.ids[a], tuple(np.flatnonzero(self.source_members[a]).tolist()),
                  tuple(np.flatnonzero(self.target_members[a]).tolist()), float(self.score[a]), int(self.votes[a]),
                  int(self.source_layer[a]), int(self.target_layer[a]), float(self.similarity[a]), bool(self.pinned[a]))
            for a in range(len(self.ids))
        ]  # fmt: skip
