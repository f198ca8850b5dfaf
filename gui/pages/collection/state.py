"""What the page of a collection draws from, and what it says: no widget here."""

from dataclasses import dataclass, field
from typing import Any, ClassVar, Self

import numpy as np

from engine.shapes.collection_parameters import CollectionParameters
from engine.shapes.collection_result import CollectionResult

from ...views.scene import Scene


@dataclass(frozen=True, slots=True, eq=False)
class CollectionState:
    """A collection as it was found, the part that is lit up (-1: none), the shapes chosen for a pair, and the look.

    `names` and `scenes` are of the shapes that are shown; until they are matched `found` is None. `parameters` are those
    asked for; `found` may be older for the moment that a job takes.
    """

    UNDOABLE: ClassVar[tuple[str, ...]] = ()

    found: CollectionResult | None = None
    names: tuple[str, ...] = ()
    scenes: tuple[Scene, ...] = ()
    parameters: CollectionParameters = field(default_factory=CollectionParameters)
    part: int = -1
    chosen: tuple[int, ...] = ()
    least: float = 0.0
    dark: bool = False

    @property
    def parts(self) -> tuple[np.ndarray, ...]:
        """The part of each segment of each shape that is shown, -1 for none."""
        if self.found is not None:
            return self.found.parts
        return tuple(np.full(scene.count, -1) for scene in self.scenes)

    def settled(self) -> Self:
        """The state as it is: nothing here is undone."""
        return self


def support_by_id(found: CollectionResult) -> dict[str, float]:
    """The support of every match of every pair, by the ids of the matches."""
    return {match_id: float(value) for row, result in enumerate(found.results)
            for match_id, value in zip(result.ids, found.support(row), strict=True)}  # fmt: skip


def kept_count(values: np.ndarray, least: float) -> int:
    """How many matches are shown; those that nothing is known of are, until a support is asked for at all."""
    return len(values) if least <= 0 else int((values >= least).sum())


def pair_rows(found: CollectionResult, least: float) -> list[tuple[str, int, int, float]]:
    """For each pair its name, how many matches are kept and how many there are, and their mean support (or NaN)."""
    rows = []
    for row, (a, b) in enumerate(found.pairs):
        values = found.support(row)
        known = values[np.isfinite(values)]
        mean = float(known.mean()) if len(known) else float("nan")
        rows.append((f"{found.names[a]} – {found.names[b]}", kept_count(values, least), len(values), mean))
    return rows


def part_rows(found: CollectionResult) -> list[tuple[int, int, float]]:
    """For each part its number, in how many shapes it is, and its mean share of their area."""
    shares = found.shares()
    return [(part, int((shares[:, part] > 0).sum()), float(shares[:, part].mean())) for part in range(found.part_count)]


def row_of(found: CollectionResult, chosen: tuple[int, ...]) -> int:
    """The row of the pair of two chosen shapes, or -1 where they were not matched with each other."""
    wanted = tuple(sorted(chosen))
    return found.pairs.index(wanted) if wanted in found.pairs else -1  # type: ignore[arg-type]


def status_text(state: CollectionState, busy: bool = False) -> str:
    """'5 shapes · 10 pairs · 412 of 633 matches · part 3 is in 4 of 5 shapes'."""
    found = state.found
    if found is None and not state.scenes:
        return ""
    if found is None:
        return f"{len(state.scenes)} shapes · " + ("matching …" if busy else "not matched; choose Edit > Match the collection again")
    total = sum(len(result.ids) for result in found.results)
    kept = sum(kept_count(found.support(row), state.least) for row in range(len(found.pairs)))
    matches = f"{total} matches" if kept == total else f"{kept} of {total} matches"
    pairs = "1 pair" if len(found.pairs) == 1 else f"{len(found.pairs)} pairs"
    text = f"{len(found.shapes)} shapes · {pairs} · {matches} · {found.part_count} parts"
    if state.part >= 0:
        shapes = sum(bool((part == state.part).any()) for part in found.parts)
        text += f" · part {state.part + 1} is in {shapes} of {len(found.shapes)} shapes"
    elif len(state.chosen) == 1:
        text += f" · {found.names[state.chosen[0]]} is chosen; click another shape's name to see their matches"
    return text


def changed_values(old: Any, new: Any) -> tuple[str, ...]:
    """Names of the parameters in which two groups differ."""
    return tuple(new.differences(old))
