"""The voting page of the researcher's window: the volunteers' own screen, for the open study and the session's code."""

from PySide6.QtCore import QTimer, Signal
from PySide6.QtWidgets import QHBoxLayout, QPushButton, QVBoxLayout, QWidget

from ...palette import theme
from ...session import Session, State
from ..judging import Judging
from .desk import Asked, VotingDesk
from .notice import Choice
from .screen import VotingScreen

NO_STUDY = "No study is open. Open one with Study > Open study, or make one with Study > New study."
NO_MATCHES = "This study has no matches yet. On the page Shapes or Puzzle, choose Study > Add these matches to the study."


class StudyPage(QWidget):
    """Asks the session's volunteer about the items of the open study, in the volunteer's own order."""

    failed = Signal(str, str)

    def __init__(self, session: Session, judging: Judging, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session, self.judging = session, judging
        self.desk = VotingDesk(judging.jobs, self)
        self.screen = VotingScreen(self.desk, self)
        self.who = QPushButton("", self, flat=True, toolTip="Who is voting; click to change")
        self.who.setObjectName("plain")
        self._late = QTimer(self, singleShot=True, interval=600)
        self._late.timeout.connect(judging.refresh)
        head = QHBoxLayout()
        head.setContentsMargins(16, 8, 16, 0)
        head.addStretch(1)
        head.addWidget(self.who)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addLayout(head)
        column.addWidget(self.screen, 1)
        self.desk.saved.connect(lambda _: self._late.start())
        self.desk.refused.connect(self._say)
        self.desk.finished.connect(self._finished)
        session.changed.connect(self.apply)
        self.apply(State(), session.state, frozenset(State.__slots__))

    @property
    def view(self) -> QWidget:
        """The pictures of the shapes."""
        return self.screen.view

    @property
    def question(self) -> Asked | None:
        """What is asked, or None."""
        return self.desk.question

    def begin(self) -> None:
        """Ask the next question (the page was shown, or the study or the volunteer changed)."""
        handle, state = self.judging.handle, self.session.state
        if handle is None:
            self._say(NO_STUDY)
            return
        self.desk.open(handle, state.volunteer)
        if state.proposals is not None:
            shapes = [described.shape for described in (state.proposals.source, state.proposals.target)]
            hashes = [described.record.sha256 for described in (state.proposals.source, state.proposals.target)]
            self.desk.offer(zip(hashes, shapes, strict=True))

    def _say(self, words: str, heading: str = "") -> None:
        self.screen.say(heading, words)

    def _finished(self) -> None:
        """Nothing is left to be asked: why, and which items could not be shown."""
        desk = self.desk
        if desk.progress.total == 0 and not desk.hidden:
            self._say(NO_MATCHES)
        elif desk.reasons:
            reasons = list(dict.fromkeys(desk.reasons.values()))
            more = f" (and {len(desk.reasons) - 1} more)" if len(desk.reasons) > 1 else ""
            back = Choice("Take back the last answer", (), "Backspace", self.undo)
            heading = f"{desk.progress.done} of {desk.progress.done + desk.hidden} answered"
            self.screen.say(heading, f"{reasons[0]}{more}", back)

    def answer(self, answer: str) -> None:
        """Commit an answer; the next question comes after it has reached the disk."""
        self.screen.answer(answer)

    def undo(self) -> None:
        """Take back the last vote and show its match again."""
        self.screen.undo()

    def skip(self) -> None:
        """Leave this question for the end."""
        self.screen.skip()

    def turn(self) -> None:
        """Start or stop turning the shapes."""
        self.screen.turn()

    def ask_comment(self) -> None:
        """Open a line that is kept with the answer to this question."""
        self.screen.open_comment()

    def guideline(self) -> str:
        """What the study says to its volunteers."""
        return self.desk.guideline

    def apply(self, _old: State, state: State, names: frozenset[str]) -> None:
        """Follow the theme, the study and the volunteer."""
        if "dark" in names:
            self.screen.set_theme(theme(state.dark))
        if "volunteer" in names:
            self.who.setText(f"Volunteer {state.volunteer}")
        if names & {"study", "volunteer"} and self.isVisible():
            self.begin()

    def shutdown(self) -> None:
        """Give back what the view holds of the graphics system."""
        self.desk.close()
        self.screen.shutdown()
