"""One volunteer's voting: what comes next, ready before it is wanted, and every answer on the disk before that shows."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from PySide6.QtCore import QObject, QTimer, Signal

from annotation import study
from annotation.records import OpenItem, VotingProgress
from annotation.storage.handle import StudyHandle
from annotation.voting.asking import Needless, Opening, last_comment, needless_in_front, opening, own_answer
from engine.shapes.segmentation import SegmentedShape

from ...jobs import QUEUE, Jobs
from .faults import fault_report, unforeseen, unknown_trouble
from .questions import JoinQuestion, Question, Shapes, Unshowable, keep, load
from .queue import Queue
from .words import Feedback, feedback

AHEAD, CHECKED = 2, 16  # items made ready before they are wanted, and those asked whether they are answered elsewhere
READ_AGAIN = 20_000  # ms between two looks at the study

Asked = Question | JoinQuestion


class Given(NamedTuple):
    """An answer as it goes to the study."""

    asked: OpenItem
    answer: str
    comment: str
    shown_ms: int
    active_ms: int
    presentation: Mapping[str, Any]


class VotingDesk(QObject):
    """Asks one volunteer about an open study. What it emits names nothing but what is to be seen."""

    began = Signal()
    """the study was read: `guideline`, `unsure` and `progress` are known"""
    asked = Signal(object, str, str)
    """a `Question` or `JoinQuestion` to be shown, the answer that stands, and the comment that was taken back with another"""
    coming = Signal(object)
    """the one that will probably follow"""
    practised = Signal(object)
    """`Feedback` on a practice answer; `go_on` shows what follows"""
    finished = Signal()
    saved = Signal(str)
    failed = Signal(str)
    """one sentence; nothing is lost, `retry` does it again, and `details` are for whoever looks into it"""
    refused = Signal(str)
    """one sentence that says why this volunteer cannot begin"""

    def __init__(self, votes: Jobs | None = None, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._votes, self._looking = votes or Jobs(self), Jobs(self)
        self._shared = votes is not None
        self.details = ""
        self._again: Callable[[], None] | None = None
        self._kept: Shapes = {}
        self._timer = QTimer(self, interval=READ_AGAIN)
        self._timer.timeout.connect(self.refresh)
        self._reset(None, "")

    def _reset(self, handle: StudyHandle | None, code: str) -> None:
        self.handle, self.code = handle, code
        self.question: Asked | None = None
        self.saving = self.unsaved = False
        self.guideline, self.words, self.unsure = "", "", True
        self.reasons: dict[OpenItem, str] = {}
        self._queue, self._practice = Queue(), {}
        self._ready: dict[OpenItem, Asked] = {}
        self._loading: set[OpenItem] = set()
        self._wanted = self._looked = False
        self._given = ""

    # --- beginning

    def open(self, handle: StudyHandle, code: str, *, new: bool = True) -> None:
        """Read what this volunteer is to be asked; `new` lets a designed study take a code that it does not know."""
        self._timer.stop()
        skipped = self._queue.skipped if (handle, code) == (self.handle, self.code) else ()
        self._reset(handle, code)

        def done(found: Opening) -> None:
            self.guideline, self.words, self.unsure = found.study.guideline, found.study.question, found.study.unsure
            self._practice = found.practice
            self._queue = Queue(open=found.open, spent=found.spent, skipped=skipped)
            self._timer.start()
            self.began.emit()
            self._prepare()

        self._look(lambda: opening(handle, code, new=new), done,
                   lambda *said: self.refused.emit(self.plainly(*said)))  # fmt: skip

    def offer(self, shapes: Iterable[tuple[str, SegmentedShape]]) -> None:
        """Shapes that are at hand anyway, with the hashes of their meshes."""
        given = list(shapes)
        self._look(lambda: [keep(self._kept, *one) for one in given], lambda _: None, lambda *_: None)

    def close(self) -> bool:
        """Let what is being saved reach the disk; whether nothing is left unsaved."""
        self._timer.stop()
        if not self._shared:
            self._votes.finish()
        self._looking.close()
        return not self.unsaved

    # --- what is shown

    @property
    def busy(self) -> bool:
        """Whether anything is being saved or read."""
        return self.saving or self._votes.busy() or self._looking.busy()

    @property
    def progress(self) -> VotingProgress:
        """How far the volunteer is."""
        return self._queue.progress()

    @property
    def hidden(self) -> int:
        """How many items cannot be shown here."""
        return len(self._queue.hidden)

    @property
    def anything(self) -> bool:
        """Whether there is something to be asked, as far as this window knows."""
        return bool(self._queue.upcoming(1))

    @property
    def practised_any(self) -> bool:
        """Whether something was answered in this window, to practise on or for real."""
        return bool(self._queue.answered)

    @property
    def practising(self) -> tuple[int, int] | None:
        """Which practice item of how many is shown, or None."""
        one = self.question.asked if self.question is not None else None
        return self._queue.practising(one) if one is not None and one.round == 0 else None

    @property
    def left_to_practise(self) -> int:
        """How many practice items are still open."""
        return sum(one.round == 0 for one in self._queue.open if one not in self._queue.answered)

    def go_on(self) -> None:
        """Show the next question, as soon as it can be."""
        if self.handle is None:
            return
        following = self._queue.upcoming(AHEAD)
        self.question, self._wanted = None, True
        if not following:
            self._finish()
        elif following[0] in self._ready:
            self._show(self._ready[following[0]])
        else:
            self._prepare()

    def _show(self, question: Asked, given: str = "", comment: str = "") -> None:
        self.question, self._wanted, self._looked = question, False, False
        self.asked.emit(question, given, comment)
        self._prepare()

    def _finish(self) -> None:
        """Nothing is left: look once more at the study, where others may have disagreed meanwhile."""
        if self._looked:
            self._wanted = self._looked = False
            self.finished.emit()
            return
        self._looked = True
        self.refresh()

    # --- making ready

    def _prepare(self) -> None:
        """Load what comes next, and forget what was made ready and is no longer near."""
        shown = self.question.asked if self.question is not None else None
        near = [one for one in self._queue.upcoming(AHEAD + 1) if one != shown][:AHEAD]
        self._ready = {one: question for one, question in self._ready.items() if one in near or one == shown}
        for one in near:
            if one not in self._ready and one not in self._loading:
                self._load(one)
        if near and near[0] in self._ready and shown is not None:
            self.coming.emit(self._ready[near[0]])

    def _load(self, one: OpenItem, given: str | None = None, comment: str = "") -> None:
        """Make an item ready; `given`, the answer that stands, where it is to be shown in any case."""
        handle, code, words, kept = self.handle, self.code, self.words, self._kept
        self._loading.add(one)

        def done(found: Asked | Unshowable) -> None:
            self._loading.discard(one)
            if isinstance(found, Unshowable):
                hide(found.reason)
                return
            self._ready[one] = found
            if given is not None:
                self._show(found, given, comment)
            else:
                self.go_on() if self._wanted else self._prepare()

        def hide(reason: str) -> None:
            self.reasons[one] = reason if self._shared else ""  # they name files: for the researcher alone
            self._queue = self._queue.hide(one)
            self.go_on() if self._wanted or given is not None else self._prepare()

        def failed(sentence: str, details: str) -> None:
            self._loading.discard(one)
            if unforeseen(sentence):  # whatever is wrong with this match, the others can be asked
                hide(sentence)
            elif self._wanted or given is not None:
                self._trouble(sentence, details, lambda: self._load(one, given, comment))

        self._look(lambda: load(handle, code, one, words, kept), done, failed)

    def refresh(self) -> None:
        """Read again what is open: other volunteers and other windows vote, too."""
        handle, code, step = self.handle, self.code, self._queue.step
        if handle is None:
            return

        def done(found: tuple[OpenItem, ...]) -> None:
            self._queue = self._queue.refresh(found, step)
            self.go_on() if self._wanted else self._prepare()
            self.recheck()

        def failed(sentence: str, details: str) -> None:
            if self._wanted:
                self._looked = False
                self._trouble(sentence, details, self.go_on)

        self._look(lambda: study.open_items(handle, code), done, failed)

    def recheck(self) -> None:
        """See whether what is asked has been answered meanwhile in another window of the same volunteer; go on if so."""
        handle, code, question, step = self.handle, self.code, self.question, self._queue.step
        if handle is None or question is None or self._given or self.unsaved or question.asked in self._queue.answered:
            return

        def done(found: str) -> None:
            if found and self.question is question and self._queue.step == step and not self.saving:
                self._queue = self._queue.elsewhere([question.asked])
                self.go_on()

        self._look(lambda: own_answer(handle, code, question.asked), done, lambda *_: None)

    def _look(self, work: Callable[[], Any], done: Callable[[Any], None], failed: Callable[[str, str], None]) -> None:
        """Read in the thread for reading; an answer about a study or volunteer of before is dropped."""
        handle, code = self.handle, self.code

        def current(act: Callable[..., None]) -> Callable[..., None]:
            return lambda *values: act(*values) if (self.handle, self.code) == (handle, code) else None

        self._looking.start("look", lambda _: work(), current(done), policy=QUEUE, failed=current(failed))

    # --- answering

    def answer(self, answer: str, comment: str = "", shown_ms: int = 0, active_ms: int = 0,
               presentation: Mapping[str, Any] | None = None) -> None:  # fmt: skip
        """Commit an answer to the question that is shown; what follows shows after it has reached the disk."""
        if self.question is not None and not self.saving and (answer != "unsure" or self.unsure):
            self._give(Given(self.question.asked, answer, comment, shown_ms, active_ms, presentation or {}))

    def _give(self, given: Given) -> None:
        one, code, again = given.asked, self.code, bool(self._given)

        def work(handle: StudyHandle) -> None:
            study.record_vote(
                handle, one.item_id, code, given.answer, comment=given.comment, shown_ms=given.shown_ms,
                active_ms=given.active_ms, round=one.round, presentation=given.presentation,
            )  # fmt: skip

        def done(_: None) -> None:
            self.unsaved, self._given = False, ""
            self._queue = self._queue.answer(one, given.active_ms, again=again)
            self.saved.emit("saved ✓")

        def follow() -> None:
            known = self._practice.get(one.item_id) if one.round == 0 else None
            if known is None:
                self.go_on()
            else:
                told: Feedback = feedback(given.answer, known)
                self.practised.emit(told)
                self._prepare()

        self.unsaved = True
        self._commit(work, done, follow, lambda: self._give(given), given.asked)

    def undo(self) -> None:
        """Take back the last answer, as often as there are any, and show its question again."""
        if self.handle is None or self.saving or self.unsaved:
            return
        code, practice = self.code, self._practice

        def work(handle: StudyHandle) -> tuple[OpenItem, str, str] | None:
            item_id = study.undo_vote(handle, code)
            if item_id is None:
                return None
            one = OpenItem(item_id, 0 if item_id in practice else 1)
            return one, own_answer(handle, code, one), last_comment(handle, code, one)

        def done(found: tuple[OpenItem, str, str] | None) -> None:
            if found is None:
                self.saved.emit("no answer to take back")
                return
            one, self._given, comment = found
            self._queue = self._queue.reopen(one, standing=bool(self._given))
            self.saved.emit("taken back ✓")
            self._load(one, self._given, comment)

        self._commit(work, done, lambda: None, self.undo)

    def skip(self) -> None:
        """Leave this question for the end; where it is the only one left, it stays."""
        if self.question is None or self.saving or self.unsaved:
            return
        one = self.question.asked
        if self._queue.upcoming(2) in ((one,), ()):
            self.saved.emit("this is the last one")
            return
        self._queue = self._queue.skip(one)
        self._given = ""
        self._commit(lambda _: None, lambda _: self.saved.emit("left for the end"), self.go_on, self.skip)

    def retry(self) -> None:
        """Do once more what failed."""
        again, self._again = self._again, None
        if again is not None:
            again()
        elif self.question is None:
            self.go_on()

    def _commit(self, work: Callable[[StudyHandle], Any], done: Callable[[Any], None], follow: Callable[[], None],
                again: Callable[[], None], answered: OpenItem | None = None) -> None:  # fmt: skip
        """Write to the study in the thread for votes, and see in passing which of the next ones need no asking any more."""
        handle, code = self.handle, self.code
        following = [one for one in self._queue.upcoming(CHECKED) if one != answered]
        self.saving, self._again = True, None

        def run(_: Any) -> tuple[Any, Needless]:
            return work(handle), needless_in_front(handle, code, following)

        def finished(found: tuple[Any, Needless]) -> None:
            if (self.handle, self.code) != (handle, code):
                return
            self.saving = False
            done(found[0])
            self._queue = self._queue.elsewhere(found[1].answered).settle(found[1].settled)
            follow()

        def failed(sentence: str, details: str) -> None:
            if (self.handle, self.code) == (handle, code):
                self.saving = False
                self._trouble(sentence, details, again)

        self._votes.start("vote", run, finished, policy=QUEUE, failed=failed)

    def _trouble(self, sentence: str, details: str, again: Callable[[], None]) -> None:
        self._again = again
        self.tell(sentence, details)

    def tell(self, sentence: str, details: str) -> None:
        """Say what went wrong."""
        self.failed.emit(self.plainly(sentence, details))

    def plainly(self, sentence: str, details: str) -> str:
        """What to say of a fault: of one that nobody foresaw without its technical part, which can be copied."""
        self.details = "" if not unforeseen(sentence) else details if self._shared else fault_report(details)
        return unknown_trouble(sentence)
