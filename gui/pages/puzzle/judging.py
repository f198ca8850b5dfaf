"""Votes on joins: into the open study file, before the next join is shown, by what the two pieces look like."""

import time
from collections.abc import Mapping
from typing import Any

import numpy as np
from PySide6.QtCore import QObject, Signal

from annotation import study
from annotation.results.puzzlejoins import add_solution, join_items
from engine.progress import Progress
from engine.puzzles.identity import join_ids
from engine.puzzles.pieces import Puzzle
from engine.puzzles.solution import Joins, PuzzleSolution

from ...jobs import FOLLOW, Jobs
from ...session import Session
from ...views.puzzle_scene import join_key
from ..judging import Judging
from .edits import one
from .state import PuzzleState, by_worst

MOST_ENROLLED = 2000  # joins of a solution that go into the study with the first vote; more only when asked


class PuzzleJudging(QObject):
    """Takes answers on the selected join and keeps the state's votes in step with the study file."""

    saved = Signal(str)
    """what happened, in a word or two, after it reached the disk"""
    advanced = Signal()

    def __init__(self, session: Session, votes: Session, judging: Judging, jobs: Jobs, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.session, self.votes, self.judging, self.jobs = session, votes, judging, jobs
        self._enrolled: list[PuzzleSolution] = []
        self._since = time.monotonic()
        votes.changed.connect(self._read)
        session.changed.connect(self._changed)
        self._read(None, votes.state, frozenset({"answers", "verdicts", "volunteer", "study"}))

    def answer(self, answer: str) -> None:
        """Commit an answer on the shown join, then go to the next doubtful one without one."""
        state = self.session.state
        joins, row = shown_join(state)
        if joins is None:
            self.advance()
            return
        if self.judging.saving:
            return
        puzzle, solution, code = state.puzzle, state.solution, state.volunteer
        shown, turns = int((time.monotonic() - self._since) * 1000), int(solution.turns[joins.sides[row, 0]])

        def work(handle: study.StudyFile) -> None:
            (item,) = join_items(puzzle, one(joins, row), np.array([turns]))
            study.add_items(handle, [item])
            study.record_vote(handle, item.id, code, answer, shown_ms=shown)

        def after(_: Any) -> None:
            self.saved.emit("saved ✓")
            if self.session.state.preview is None:
                self.advance()
            if len(solution.joins) <= MOST_ENROLLED:
                self.enrol()

        self.judging.commit(work, after)

    def advance(self) -> None:
        """Select the most doubtful join that this volunteer has not judged."""
        state = self.session.state
        if state.solution is None:
            return
        left = [k for k in by_worst(state) if k >= len(state.items) or state.items[k] not in state.answers]
        left = [k for k in left if k != state.row]
        if left:
            self.session.update(selected=join_key(state.solution.joins.sides[left[0]]), preview=None, piece=-1)
            self.advanced.emit()
        else:
            self.saved.emit("saved ✓ · all shown joins judged")

    def undo(self) -> None:
        """Retract the volunteer's last vote and show its join again."""

        def back(item: str | None) -> None:
            items = self.session.state.items
            if item is None:
                self.saved.emit("no vote to undo")
            elif item in items:
                sides = self.session.state.solution.joins.sides[items.index(item)]
                self.session.update(selected=join_key(sides), preview=None)
            else:
                self.saved.emit("took back a vote on something else")

        if not self.judging.saving:
            self.judging.take_back(back)

    def enrol(self, *, told: bool = False) -> None:
        """Put all joins of the solution into the study, so that volunteers are asked about them and tables count them."""
        state = self.session.state
        puzzle, solution, guided = state.puzzle, state.solution, bool(state.wishes)
        if solution is None or not len(solution.joins) or any(solution is known for known in self._enrolled):
            return
        self._enrolled = [*self._enrolled[-7:], solution]

        def done(_: Any) -> None:
            if told:
                self.saved.emit(f"{len(solution.joins)} joins in the study")
            self.judging.refreshed.emit()

        self.judging.ask(lambda handle: add_solution(handle, puzzle, solution, set_name=puzzle.name, guided=guided), done)

    # --- following

    def _read(self, _old: Any, state: Any, names: frozenset[str]) -> None:
        """The votes that the window has read from the study are also those of joins."""
        if names & {"answers", "verdicts", "volunteer"}:
            self.session.update(record=False, answers=state.answers, verdicts=state.verdicts, volunteer=state.volunteer)
        if "study" in names:
            self._enrolled.clear()

    def _changed(self, old: PuzzleState, state: PuzzleState, names: frozenset[str]) -> None:
        if names & {"selected", "preview"}:
            self._since = time.monotonic()
        if names & {"solution", "items"} and state.solution is not None and not state.items and len(state.solution.joins):
            self._name(state.puzzle, state.solution)

    def _name(self, puzzle: Puzzle, solution: PuzzleSolution) -> None:
        """Find the study's names of the joins, in the worker."""

        def work(progress: Progress) -> tuple[str, ...]:
            progress(0.0, "")
            return join_ids(puzzle, solution.joins)

        def done(items: tuple[str, ...]) -> None:
            if self.session.state.solution is solution:
                self.session.update(record=False, items=items)

        self.jobs.start("puzzle-names", work, done, policy=FOLLOW)


def shown_join(state: PuzzleState) -> tuple[Joins | None, int]:
    """The join that is looked at and its row: one that is tried out, or the selected one of the solution."""
    if state.preview is not None and state.solution is not None:
        return state.preview, 0
    return (state.solution.joins, state.row) if state.row >= 0 else (None, -1)


def judged_rows(items: tuple[str, ...], verdicts: Mapping[str, str]) -> dict[int, str]:
    """The verdicts 'correct', 'wrong' and 'tie' by row."""
    kinds = ("correct", "wrong", "tie")
    return {row: verdicts[item] for row, item in enumerate(items) if verdicts.get(item) in kinds}
