"""What the editor of segments shows, as one frozen state."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

import numpy as np

from engine.shapes.editing import compacted
from engine.shapes.segmentation import Segmentation, SegmentedShape
from engine.shapes.segmentationparameters import DEFAULT, SegmentationParameters


@dataclass(frozen=True, slots=True, eq=False)
class EditState:
    """One shape whose segments are edited.

    `labels` (m,) keep their numbers while segments come and go, `names` gives those that came with the shape;
    `by_hand` says that somebody changed what the automatic segmentation made. `saved` are the labels that are in a
    file or in the pair, `graph` and `scene` belong to the mesh. `active` is the label that the brush paints.
    """

    UNDOABLE: ClassVar[tuple[str, ...]] = ("labels", "names", "parameters", "by_hand")

    shape: SegmentedShape | None = None
    side: int = 0
    graph: Any = None
    scene: Any = None
    labels: np.ndarray | None = None
    names: Mapping[int, int | str] = field(default_factory=dict)
    saved: np.ndarray | None = None
    file: str = ""
    by_hand: bool = False
    parameters: SegmentationParameters = DEFAULT
    selected: tuple[int, ...] = ()
    active: int = -1
    tool: str = "select"
    radius: float = 0.03
    parts: int = 2
    dark: bool = False

    def settled(self) -> Self:
        """The state without selected segments that are gone."""
        there = set() if self.labels is None else set(np.unique(self.labels).tolist())
        return replace(self, selected=tuple(k for k in self.selected if k in there))

    @property
    def unsaved(self) -> bool:
        """Whether there is work that closing would lose: labels that are neither in a file nor as they came."""
        return self.labels is not None and self.saved is not None and not np.array_equal(self.labels, self.saved)

    def segmentation(self) -> Segmentation:
        """The labels as a segmentation, with the names of the file."""
        assert self.labels is not None
        return compacted(self.labels, self.names)
