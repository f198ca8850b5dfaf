"""Votes of the window: the open study file, every answer on the disk before the next match shows, and what they say."""

import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from PySide6.QtCore import QObject, Signal

from annotation import study
from annotation.results.studyruns import unasked
from annotation.storage.blobs import keep_shapes
from engine.errors import BadInput
from engine.shapes.result import MatchResult

from ..folders import default_study
from ..jobs import QUEUE, Jobs
from ..session import Session, State
from .shapes.arrange import listed, next_unanswered

BUSY_SECONDS = 8.0


class Snapshot(NamedTuple):
    """What the study file said when it was last read."""

    answers: Mapping[str, str]
    verdicts: Mapping[str, str]


def read_snapshot(handle: study.StudyHandle, code: str) -> Snapshot:
    """The volunteer's own answers and the majorities, by match id."""
    verdicts = {i: m.verdict for i, m in study.majority(handle).items() if m.verdict != "unjudged"}
    return Snapshot(study.answers(handle, code), verdicts)


def opened(where: Path | str, create: bool) -> study.StudyHandle:
    """Open a study in a file, in a folder or on a server; `create` makes a file if it is missing."""
    if create and not Path(where).exists():
        Path(where).parent.mkdir(parents=True, exist_ok=True)
        return study.create_study(where, name=Path(where).stem)
    return study.open_study(where, busy_seconds=BUSY_SECONDS)


class Judging(QObject):
    """Takes answers for the selected match, one at a time, and keeps the session's votes in step with the file."""

    saved = Signal(str)
    """what happened, in a word or two, after it reached the disk"""
    refreshed = Signal()
    opened = Signal()
    failed = Signal(str, str)

    def __init__(self, session: Session, jobs: Jobs, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.session, self.jobs = session, jobs
        self.handle: study.StudyHandle | None = None
        self.saving = self.advancing = False
        self._own = ""
        self._enrolled: set[int] = set()
        self._kept: list[MatchResult] = []
        self._since = time.monotonic()
        session.changed.connect(self._changed)
        jobs.failed.connect(self._give_up)

    def open(self, path: Path | str | None = None, *, create: bool = False) -> None:
        """Open a study by its path or address (the default one without, made on first use); the open one stays if that
        fails."""
        wanted = path or default_study()
        make = (create or path is None) and not study.is_url(wanted)
        self._follow(lambda: opened(wanted, make))

    def adopt(self, handle: study.StudyHandle) -> None:
        """Go on with a study that is open already (it was just made)."""
        self._follow(lambda: handle)

    def _follow(self, opening: Callable[[], study.StudyHandle]) -> None:
        code = self._own or self.session.state.volunteer

        def work(_: Any) -> tuple[study.StudyHandle, Snapshot]:
            handle = opening()
            try:
                return handle, read_snapshot(handle, handle.volunteer or code)
            except BaseException:
                handle.close()
                raise

        def done(answer: tuple[study.StudyHandle, Snapshot]) -> None:
            before, (self.handle, snapshot) = self.handle, answer
            if before is not None:
                before.close()
            self._enrolled.clear()
            self._kept.clear()
            self._take(snapshot, study=self.handle.where, **self._voter())
            self.opened.emit()
            self._enrol_if_judged(self.session.state)

        self.jobs.start("study", work, done, words="Opening the study", policy=QUEUE)

    def _voter(self) -> dict[str, str]:
        """Whose votes are taken from now on: in a packet or on an invitation that volunteer's, and the own again after it."""
        only, own = self.handle.volunteer, self._own
        self._own = (own or self.session.state.volunteer) if only else ""
        return {"volunteer": only or own} if only or own else {}

    def answer(self, answer: str) -> None:
        """Commit an answer on the selected match, then go to the next without one; without a selection, go there."""
        state = self.session.state
        match_id, result = state.selected, state.result
        if result is None or self.saving:
            return
        if not match_id:  # nothing is asked yet: show the first question instead
            self._advance("")
            return
        shown = int((time.monotonic() - self._since) * 1000)

        def work(handle: study.StudyHandle) -> None:
            self._enrol(handle, result, state.set_name)
            study.record_vote(handle, match_id, state.volunteer, answer, shown_ms=shown)

        self.commit(work, lambda _: self._advance(match_id))

    def undo(self) -> None:
        """Retract the volunteer's last vote and show its match again."""
        if self.saving:
            return
        code = self.session.state.volunteer

        def back(item: str | None) -> None:
            if item is None:
                self.saved.emit("no vote to undo")
            elif self.session.state.match(item) is not None:
                self.session.update(selected=item)
            else:
                self.saved.emit("took back a vote on another pair")

        self.commit(lambda handle: study.undo_vote(handle, code), back)

    def enrol(self) -> None:
        """Put the shown matches and shapes into the study, judged or not, so that volunteers can be asked about them."""
        state = self.session.state
        result = state.result
        if result is None or self.saving:
            return

        def work(handle: study.StudyHandle) -> int:
            self._enrol(handle, result, state.set_name)
            keep_shapes(handle, (state.source, state.target))
            return unasked(handle).matches

        def done(left: int) -> None:
            more = f"; {left} are not asked yet (Study > Top up)" if left else ""
            self.saved.emit(f"{len(result.ids)} matches in the study{more}")

        self.commit(work, done)

    def take_back(self, done: Callable[[str | None], None]) -> None:
        """Retract the last vote (the voting page) and hand its item to `done`."""
        code = self.session.state.volunteer
        self.commit(lambda handle: study.undo_vote(handle, code), done)

    def ask(self, question: Callable[[study.StudyHandle], Any], done: Callable[[Any], None]) -> None:
        """Read something from the study in the worker."""
        handle = self.handle
        if handle is not None:
            self.jobs.start("ask", lambda _: question(handle), done, policy=QUEUE)

    def refresh(self) -> None:
        """Read the votes again: other windows and volunteers write to the same file."""
        code = self.session.state.volunteer
        self.ask(lambda handle: read_snapshot(handle, code), self._take)

    def close(self) -> None:
        """Let what is being saved reach the disk, then close the file."""
        self.jobs.finish()
        if self.handle is not None:
            self.handle.close()
            self.handle = None

    def commit(self, work: Callable[[study.StudyHandle], Any], after: Callable[[Any], None]) -> None:
        """Write something to the study in the worker; when it is on the disk, read the votes and call `after`."""
        handle, code = self.handle, self.session.state.volunteer
        if handle is None:
            self.failed.emit("No study file is open, so the vote was not taken; open or create one (Study > New study).", "")
            return
        self.saving = True

        def run(_: Any) -> tuple[Any, Snapshot]:
            value = work(handle)
            return value, read_snapshot(handle, code)

        def done(answer: tuple[Any, Snapshot]) -> None:
            self.saving = False
            self._take(answer[1])
            self.saved.emit("saved ✓")
            after(answer[0])

        self.jobs.start("vote", run, done, policy=QUEUE)

    def _give_up(self, sentence: str, details: str) -> None:
        self.saving = False
        self.failed.emit(sentence, details)

    def _enrol(self, handle: study.StudyHandle, result: MatchResult, set_name: str) -> None:
        if id(result) not in self._enrolled:
            study.add_result(handle, result, set_name=set_name)
            self._enrolled.add(id(result))
            self._kept.append(result)  # keeps the id from being used again

    def _enrol_if_judged(self, state: State) -> None:
        """A preset's result that shares judged matches with the study counts in its table without further votes."""
        from engine.shapes.parameters import PRESETS

        result = state.result
        plain = result is not None and PRESETS.get(result.preset) == result.parameters and not result.wishes
        if plain and self.handle is not None and any(i in state.verdicts for i in result.ids):
            self.ask(lambda handle: self._enrol(handle, result, state.set_name), lambda _: self.refreshed.emit())

    def _advance(self, match_id: str) -> None:
        state = self.session.state
        following = next_unanswered(listed(state), match_id, state.answers)
        if following:
            self.advancing = True
            self.session.update(selected=following)
            self.advancing = False
        else:
            self.saved.emit("saved ✓ · all of these judged")

    def _take(self, snapshot: Snapshot, **changes: Any) -> None:
        self.session.update(record=False, answers=snapshot.answers, verdicts=snapshot.verdicts, **changes)
        self.refreshed.emit()

    def _changed(self, _old: State, state: State, names: frozenset[str]) -> None:
        if "selected" in names:
            self._since = time.monotonic()
        if "volunteer" in names:
            self.refresh()
        if "result" in names:
            self._enrol_if_judged(state)


def checked_code(text: str) -> str:
    """A volunteer code as the study takes it; raises one sentence otherwise."""
    from annotation.voting.answering import checked_code as check

    if not text.strip():
        raise BadInput("A volunteer needs a code; use 1 to 40 letters, digits, - and _.")
    return check(text)
