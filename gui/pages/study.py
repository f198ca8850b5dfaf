"""The voting page: one question, two shapes or pieces, three answers, a counter. Nothing says who proposed them, or why."""

import time

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QInputDialog, QLabel, QPushButton, QStackedLayout, QVBoxLayout, QWidget

from ..palette import rgb, theme
from ..session import Session, State
from ..views.join import JoinView
from ..views.mesh_pair import MeshPairView
from .judging import Judging
from .panels import ANSWER_WORDS, answer_style
from .questions import Asked, JoinQuestion, Question, Shapes, ask_next, empty_text, keep, progress_text

SHAPES_HINT = "Backspace takes back · C comments · R resets the view · T turns the shapes · ? help"
JOIN_HINT = "Backspace takes back · C comments · N leaves it for the end · ? help"


class StudyPage(QWidget):
    """Asks the session's volunteer about the items of the open study, in the volunteer's own order."""

    failed = Signal(str, str)

    def __init__(self, session: Session, judging: Judging, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session, self.judging = session, judging
        self.question: Question | JoinQuestion | None = None
        self._kept: Shapes = {}
        self._skipped: list[str] = []
        self._guideline = ""
        self._given = self._comment = ""
        self._since = time.monotonic()
        self.words = QLabel("", self)
        self.words.setObjectName("question")
        self.words.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.words.setWordWrap(True)
        self.view = MeshPairView(self)
        self.view.setAcceptDrops(False)
        self.view.set_captions(False)  # a name can tell where a shape came from
        self.join_view = JoinView(self)
        self.stage = QStackedLayout()
        self.stage.addWidget(self.view)
        self.stage.addWidget(self.join_view)
        self.counter, self.saved = QLabel("", self), QLabel("", self)
        self.buttons: dict[str, QPushButton] = {}
        column = QVBoxLayout(self)
        column.setContentsMargins(16, 16, 16, 12)
        column.setSpacing(12)
        column.addWidget(self.words)
        column.addLayout(self.stage, 1)
        column.addLayout(self._answers())
        column.addLayout(self._small_print())
        session.changed.connect(self.apply)
        judging.saved.connect(self._saved)
        self.apply(State(), session.state, frozenset(State.__slots__))

    def _answers(self) -> QHBoxLayout:
        row = QHBoxLayout()
        row.setSpacing(16)
        for answer, (words, key) in ANSWER_WORDS.items():
            button = QPushButton(f"{words}\n{key}", self)
            button.setObjectName(f"vote-{answer}")
            button.setMinimumHeight(60)
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.clicked.connect(lambda _=False, answer=answer: self.answer(answer))
            row.addWidget(button, 1)
            self.buttons[answer] = button
        return row

    def _small_print(self) -> QHBoxLayout:
        row = QHBoxLayout()
        row.setSpacing(4)
        self.who = QPushButton("", self, flat=True, toolTip="Who is voting; click to change")
        self.who.setObjectName("plain")
        self.who.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.hint = QLabel(SHAPES_HINT, self)
        for label in (self.counter, self.hint, self.saved):
            label.setObjectName("soft")
        row.addWidget(self.who)
        row.addWidget(self.counter, 1)
        row.addWidget(self.hint, 0)
        row.addWidget(self.saved, 1, Qt.AlignmentFlag.AlignRight)
        return row

    def begin(self) -> None:
        """Ask the next question (the page was shown, or the study or the volunteer changed)."""
        state = self.session.state
        for proposals in (state.proposals,) if state.proposals is not None else ():
            for shape in (proposals.source, proposals.target):
                keep(self._kept, shape.record.sha256, shape.shape)
        if self.judging.handle is None:
            self._show_empty("No study is open. Open one with Study > Open study, or make one with Study > New study.")
            return
        self._ask()

    def _ask(self, again: str = "") -> None:
        code, skipped, kept = self.session.state.volunteer, tuple(self._skipped), self._kept
        self.judging.ask(lambda handle: ask_next(handle, code, skipped, kept, again), self.show_question)

    def show_question(self, asked: Asked) -> None:
        """Show what is asked, or why nothing is."""
        self._guideline = asked.guideline
        self.words.setText(asked.words if asked.question else "")
        self.counter.setText(progress_text(asked.progress) if asked.progress.total else "")
        if asked.question is None:
            self._show_empty(empty_text(asked))
            return
        before, self.question = self.question, asked.question
        if before is None or before.item.id != asked.question.item.id:
            self._comment = ""
        self._show(asked.question, before)
        self._since, self._given = time.monotonic(), asked.answer
        self._mark(self.session.state)
        if isinstance(asked.question, Question):
            self.view.frame_match(*asked.question.segments)

    def _show(self, question: Question | JoinQuestion, before: Question | JoinQuestion | None) -> None:
        """Bring the view to the front that shows such a question."""
        joined = isinstance(question, JoinQuestion)
        self.stage.setCurrentWidget(self.join_view if joined else self.view)
        self.hint.setText(JOIN_HINT if joined else SHAPES_HINT)
        if isinstance(question, JoinQuestion):
            self.join_view.set_picture(question.picture)
        elif not (isinstance(before, Question) and self.view.scenes_shown and before.shapes == question.shapes):
            self.view.set_shapes(*question.shapes)

    def _mark(self, state: State) -> None:
        colours = theme(state.dark)
        if isinstance(self.question, Question):
            self.view.set_highlight(*self.question.segments, rgb(colours.accent))
        for answer, button in self.buttons.items():
            button.setEnabled(self.question is not None)
            button.setStyleSheet(answer_style(answer, colours, answer == self._given, padding=8) + "QPushButton { font-size: 15px; }")

    def _show_empty(self, text: str) -> None:
        self.question, self._given = None, ""
        self.words.setText("")
        self.stage.setCurrentWidget(self.view)
        self.view.clear(text)
        self._mark(self.session.state)

    def answer(self, answer: str) -> None:
        """Commit an answer; the next question comes after it has reached the disk."""
        question = self.question
        if question is None or self.judging.saving:
            return
        shown = int((time.monotonic() - self._since) * 1000)
        presentation = {"left": "target" if question.swapped else "source"} if isinstance(question, Question) else {}
        self.judging.vote_on(question.item.id, answer, shown, presentation, self._ask, self._comment)

    def ask_comment(self) -> None:
        """Ask for a line that is kept with the answer to this question."""
        if self.question is None:
            return
        text, given = QInputDialog.getText(self, "Comment", "A comment to keep with your answer:", text=self._comment)
        if given:
            self._comment = text.strip()
            self.saved.setText("comment goes with your answer" if self._comment else "")

    def undo(self) -> None:
        """Take back the last vote and show its match again."""
        if not self.judging.saving:
            self.judging.take_back(lambda item: self._ask(item) if item else self.saved.setText("no vote to take back"))

    def skip(self) -> None:
        """Leave this question for the end."""
        if self.question is not None:
            self._skipped.append(self.question.item.id)
            self._ask()

    def guideline(self) -> str:
        """What the study says to its volunteers."""
        return self._guideline

    def _saved(self, words: str) -> None:
        self.saved.setText(words)

    def apply(self, _old: State, state: State, names: frozenset[str]) -> None:
        """Follow the theme, the study and the volunteer."""
        if "dark" in names:
            self.view.set_theme(theme(state.dark))
            self.join_view.set_theme(theme(state.dark))
            self._mark(state)
        if "volunteer" in names:
            self.who.setText(f"Volunteer {state.volunteer}")
        if names & {"study", "volunteer"}:
            self._skipped.clear()
            self.saved.setText("")
            if self.isVisible():
                self.begin()

    def shutdown(self) -> None:
        """Give back what the view holds of the graphics system."""
        self.view.shutdown()
