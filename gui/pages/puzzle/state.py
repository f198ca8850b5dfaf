"""What the puzzle page shows, as one frozen state, and what has to run so that its solution is that of its wishes."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

import numpy as np

from engine.parameters import declared
from engine.puzzles.parameters import PuzzleParameters
from engine.puzzles.pieces import Puzzle, Truth
from engine.puzzles.solution import Joins, PuzzleSolution, Wishes

from ...views.puzzle_scene import Key, by_doubt, join_keys
from ..shapes.arrange import share_text
from .edits import NO_WISHES, row_of, rows_of

NOTHING, ASSEMBLE, PREPARE = "nothing", "assemble", "prepare"
_SLOW = tuple(info.name for info in declared(PuzzleParameters) if not info.live)


@dataclass(frozen=True, slots=True, eq=False)
class Marks:
    """A solution beside the truth: its scores, and which pieces (n,) and joins (j,) are right."""

    scores: Any
    places: np.ndarray
    joins: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class PuzzleState:
    """Everything that the puzzle page draws from.

    `truth` is there where the puzzle was cut from a picture; `prepared` was made with `prepared_with` and serves every
    change of a live parameter and of the `wishes`. `asked` says that somebody pressed Solve: from then on the solution
    follows. `solution` honours `solved_with`, or is the work of a hand for the moment that a job takes (None).
    `items` are the study's names of its joins and `marks` what the truth says of it. `selected` names a join, `preview`
    is a join that is not in the assembly but looked at (one row). Joins less certain than `below` are drawn.
    """

    UNDOABLE: ClassVar[tuple[str, ...]] = (
        "puzzle", "truth", "origin", "parameters", "prepared", "prepared_with", "asked", "wishes", "solution",
        "solved_with", "items", "marks")  # fmt: skip

    puzzle: Puzzle | None = None
    truth: Truth | None = None
    origin: str = ""
    parameters: PuzzleParameters = field(default_factory=PuzzleParameters)
    prepared: Any = None
    prepared_with: PuzzleParameters | None = None
    asked: bool = False
    wishes: Wishes = NO_WISHES
    solution: PuzzleSolution | None = None
    solved_with: Wishes | None = None
    items: tuple[str, ...] = ()
    marks: Marks | None = None
    selected: Key | None = None
    preview: Joins | None = None
    piece: int = -1
    below: float = 0.95
    overlay: bool = False
    volunteer: str = "me"
    answers: Mapping[str, str] = field(default_factory=dict)
    verdicts: Mapping[str, str] = field(default_factory=dict)
    dark: bool = False

    @property
    def row(self) -> int:
        """The row of the selected join in the solution, or -1."""
        return -1 if self.solution is None else row_of(self.solution.joins, self.selected)

    @property
    def item(self) -> str:
        """The study's name of the selected join, or nothing."""
        row = self.row
        return self.items[row] if 0 <= row < len(self.items) else ""

    def settled(self) -> Self:
        """The state without a selection that its solution does not have."""
        kept = replace(self, preview=None)
        if kept.row < 0:
            kept = replace(kept, selected=None)
        return replace(kept, piece=-1) if kept.puzzle is None or kept.piece >= kept.puzzle.count else kept


def slow_values(parameters: PuzzleParameters) -> tuple[Any, ...]:
    """The values whose change needs more than assembling again."""
    return tuple(getattr(parameters, name) for name in _SLOW)


def needed(state: PuzzleState) -> str:
    """What has to run so that the solution is that of the puzzle, the parameters and the wishes."""
    if state.puzzle is None or not state.asked:
        return NOTHING
    if state.solution is not None and state.solved_with is state.wishes and state.solution.parameters == state.parameters:
        return NOTHING
    ready = state.prepared is not None and state.prepared_with is not None
    return ASSEMBLE if ready and slow_values(state.prepared_with) == slow_values(state.parameters) else PREPARE


def frame_known(state: PuzzleState) -> bool:
    """Whether the picture's size is known and may be used."""
    return state.puzzle.frame is not None and state.parameters.frame == "known"


def opened(puzzle: Puzzle, truth: Truth | None, origin: str, wishes: Wishes = NO_WISHES) -> dict[str, Any]:
    """The changes of a state that put another puzzle on the table, with what was decided on it before."""
    return {
        "puzzle": puzzle, "truth": truth, "origin": origin, "prepared": None, "prepared_with": None, "asked": False,
        "wishes": wishes, "solution": None, "solved_with": None, "items": (), "marks": None, "selected": None,
        "preview": None, "piece": -1, "overlay": False,
    }  # fmt: skip


def by_worst(state: PuzzleState) -> list[int]:
    """Rows of the drawn joins, the most doubtful first, without those that a person holds."""
    joins = state.solution.joins
    held = rows_of(joins, join_keys(state.wishes.locked))
    certain = np.zeros(len(joins), bool) if state.below >= 1 else joins.confidence >= state.below
    return by_doubt(joins, held | certain).tolist()


def counts_text(state: PuzzleState) -> str:
    """'432 pieces · 431 placed · 23 joins below .95 · 12 of 816 judged · 2 locked', for the status line."""
    if state.puzzle is None:
        return "Open a picture or a folder of pieces."
    n = state.puzzle.count
    parts = [f"{n} pieces"]
    if state.solution is None:
        if state.asked:
            return f"{parts[0]} · looking for their neighbours …"
        return f"{parts[0]} in the tray · press Solve, or drag them together by hand"
    placed = int(state.solution.placed.sum())
    parts.append(f"{placed} placed" if placed < n else "all placed")
    if len(state.solution.joins):
        doubtful = int((state.solution.joins.confidence < state.below).sum())
        total = len(state.solution.joins)
        parts.append(f"{total} joins" if state.below >= 1 else f"{doubtful} of {total} joins below {share_text(state.below)}")
    judged = sum(state.verdicts.get(item) in ("correct", "wrong", "tie") for item in state.items)
    if judged:
        parts.append(f"{judged} of {len(state.items)} judged")
    parts += [f"{len(which)} {word}" for which, word in wishes_counts(state.wishes) if len(which)]
    return " · ".join(parts)


def wishes_counts(wishes: Wishes) -> tuple[tuple[Any, str], ...]:
    """The three kinds of wishes with their words."""
    return (wishes.locked, "locked"), (wishes.forbidden, "rejected"), (wishes.pinned, "pinned")


def scores_text(scores: Any) -> str:
    """'in place 96.2 % · true neighbours 95.8 % · largest part 96.0 %', and what counts equal pieces as equal."""
    text = (f"in place {percent(scores.direct)} · true neighbours {percent(scores.neighbour)} · "
            f"largest part {percent(scores.largest_component)}")  # fmt: skip
    if (scores.direct_tie_aware, scores.neighbour_tie_aware) != (scores.direct, scores.neighbour):
        text += f" · equal pieces exchanged: {percent(scores.direct_tie_aware)}, {percent(scores.neighbour_tie_aware)}"
    return text


def percent(share: float) -> str:
    """'99.7 %'; never 100 where something is missing."""
    return "100 %" if share >= 1 else f"{min(share, 0.999):.1%}".replace("%", " %")
