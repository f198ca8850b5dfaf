"""What the window shows, as one frozen state a page; pages apply only the difference, and undo keeps old states."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, ClassVar, Self

from PySide6.QtCore import QObject, Signal

from engine.shapes.identity import match_id, node_id, segment_ids
from engine.shapes.parameters import DEFAULT_PRESET, PRESETS, MatchParameters
from engine.shapes.result import Match, MatchResult
from engine.shapes.segmentation import SegmentedShape
from engine.shapes.wishes import NO_WISHES, Pair, Wishes

LONGEST_HISTORY = 200


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """Everything that the pages of shapes draw from.

    `proposals` were prepared with `prepared_with` and serve every change of a live parameter; `result` may be older
    than `parameters` for the moment that a job takes, and `main` are the ids of its matches that say something new and
    can be drawn together. `answers` are the volunteer's own current votes and `verdicts`
    the majorities, both by match id, as they stand in the study file. `wishes` are the matches that are pinned or
    forbidden, and where `bound` each answer makes one. `layer` 0 shows the matches, 1..L a layer of
    the multi-layer graph, `node` one node of it (-1: all). `support` holds by match id what the other shapes of a
    collection say of it, as far as that is known; matches with less than `least_support` are hidden.
    """

    UNDOABLE: ClassVar[tuple[str, ...]] = (
        "source", "target", "set_name", "preset", "parameters", "proposals", "prepared_with", "result", "main",
        "wishes")  # fmt: skip

    source: SegmentedShape | None = None
    target: SegmentedShape | None = None
    set_name: str = ""
    preset: str = DEFAULT_PRESET
    parameters: MatchParameters = field(default_factory=lambda: PRESETS[DEFAULT_PRESET])
    proposals: Any = None
    prepared_with: MatchParameters | None = None
    result: MatchResult | None = None
    main: frozenset[str] = frozenset()
    wishes: Wishes = NO_WISHES
    bound: bool = False
    selected: str = ""
    shown: str = "main"
    order: str = "score"
    support: Mapping[str, float] = field(default_factory=dict)
    least_support: float = 0.0
    layer: int = 0
    node: int = -1
    linked: bool = True
    study: str = ""
    volunteer: str = "me"
    answers: Mapping[str, str] = field(default_factory=dict)
    verdicts: Mapping[str, str] = field(default_factory=dict)
    dark: bool = False

    def matches(self) -> list[Match]:
        """The matches of the result, best first."""
        return [] if self.result is None else matches_of(self.result)

    def match(self, match_id: str) -> Match | None:
        """The match of this id, if the result has it."""
        return next((m for m in self.matches() if m.id == match_id), None) or next(
            (m for m in self.forbidden() if m.id == match_id), None)  # fmt: skip

    def forbidden(self) -> list[Match]:
        """The forbidden matches, as if they had been found, without a score."""
        if self.source is None or self.target is None:
            return []
        return forbidden_matches(self.wishes, self.source, self.target)

    def settled(self) -> Self:
        """The state without a selection that its result does not have."""
        return self if self.match(self.selected) is not None else replace(self, selected="")


@lru_cache(maxsize=2)
def matches_of(result: MatchResult) -> list[Match]:
    """The matches of a result, which many parts of the window ask for at each change; not to be changed."""
    return result.matches()


@lru_cache(maxsize=4)
def _hashes(shape: SegmentedShape) -> tuple[str, ...]:
    return segment_ids(shape.mesh, shape.segmentation)


def identity_of(pair: Pair, source: SegmentedShape, target: SegmentedShape) -> str:
    """The id of the match of two unions."""
    sides = zip(pair, (source, target), strict=True)
    return match_id(*(node_id(_hashes(shape)[i] for i in union) for union, shape in sides))


@lru_cache(maxsize=4)
def forbidden_matches(wishes: Wishes, source: SegmentedShape, target: SegmentedShape) -> list[Match]:
    """What is forbidden as matches without score, votes and layers; not to be changed."""
    known = [(s, t) for s, t in wishes.forbidden if s[-1] < source.segmentation.count and t[-1] < target.segmentation.count]
    return [Match(identity_of(pair, source, target), *pair, 0.0, 0, 0, 0, 0.0) for pair in known]


def difference(old: Any, new: Any) -> frozenset[str]:
    """Names of the fields in which two states of one kind differ."""
    pairs = ((name, getattr(old, name), getattr(new, name)) for name in type(old).__slots__)
    return frozenset(name for name, a, b in pairs if a is not b and (a != b) is not False)  # other arrays are a change


class Session(QObject):
    """Holds the one state of a page, tells who listens what changed, and goes back and forth.

    A state is a frozen dataclass that names its `UNDOABLE` fields and drops with `settled()` what such a step leaves
    without an object.
    """

    changed = Signal(object, object, object)
    """old state, new state, frozenset of the names that differ"""

    def __init__(self, state: Any = None, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.state = state or State()
        self._undo: list[Any] = []
        self._redo: list[Any] = []
        self._merging = ""

    def update(self, *, merge: str = "", record: bool = True, **changes: Any) -> frozenset[str]:
        """Replace fields and tell what changed.

        A change of an undoable field is one step of the history; successive changes with the same `merge` word (a
        slider that moves) are one step together, and `record=False` (an answer of a job) amends the present step.
        """
        old, new = self.state, replace(self.state, **changes)
        names = difference(old, new)
        if not names:
            return names
        if record and names & set(new.UNDOABLE):
            if not (merge and merge == self._merging and self._undo):
                self._undo = [*self._undo[-LONGEST_HISTORY + 1 :], old]
            self._merging = merge
            self._redo.clear()
        self.state = new
        self.changed.emit(old, new, names)
        return names

    def restart(self, state: Any) -> None:
        """Begin with another state, without a way back to the one before (another shape is edited)."""
        old, self.state = self.state, state
        self._undo, self._redo, self._merging = [], [], ""
        self.changed.emit(old, state, difference(old, state))

    def settle(self) -> None:
        """End the step that successive changes are merged into (a slider was let go)."""
        self._merging = ""

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to go back to."""
        return bool(self._undo)

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone step to do again."""
        return bool(self._redo)

    def undo(self) -> None:
        """Go one step back (inputs, preset, parameters and their result; never votes)."""
        self._travel(self._undo, self._redo)

    def redo(self) -> None:
        """Do the step again that was undone last."""
        self._travel(self._redo, self._undo)

    def _travel(self, there: list[Any], back: list[Any]) -> None:
        if not there:
            return
        old, goal = self.state, there.pop()
        back.append(old)
        self._merging = ""
        self.state = replace(old, **{name: getattr(goal, name) for name in old.UNDOABLE}).settled()
        names = difference(old, self.state)
        self.changed.emit(old, self.state, names)
