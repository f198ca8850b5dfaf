"""The voting screen: one question, two shapes or pieces, three answers, a counter, and nothing that tells more."""

from collections.abc import Callable

from PySide6.QtCore import QEvent, QObject, Qt, QTimer, Signal
from PySide6.QtGui import QGuiApplication, QKeyEvent
from PySide6.QtWidgets import QLabel, QStackedLayout, QVBoxLayout, QWidget

from ...palette import LIGHT, Theme
from ...views.join import JoinView
from ...views.voting_pair import VotingPairView
from . import sayings
from .bars import AnswerBar, CommentBar, FeedbackBar, SmallPrint, TroubleBar, screen_style
from .desk import Asked, VotingDesk
from .notice import Choice, Notice
from .questions import JoinQuestion, Question
from .sayings import ENTER, NEXT, Saying
from .watch import Watch
from .words import progress_text

K = Qt.Key
SLOW = 400  # ms of saving after which that is said
_INPUT = frozenset({QEvent.Type.MouseMove, QEvent.Type.MouseButtonPress, QEvent.Type.Wheel, QEvent.Type.KeyPress})


class VotingScreen(QWidget):
    """Shows what a desk asks and hands it the answers. Keys work wherever the focus is."""

    left = Signal()
    """the volunteer wants to stop"""
    given_up = Signal()
    """the volunteer wants to stop, although the last answer is not saved"""

    def __init__(self, desk: VotingDesk, parent: QWidget | None = None, *, own_window: bool = False) -> None:
        super().__init__(parent)
        self.desk, self.own_window = desk, own_window
        self.watch = Watch()
        self._theme = LIGHT
        self._given = self._comment = ""
        self._slow = QTimer(self, singleShot=True, interval=SLOW)
        self._slow.timeout.connect(lambda: self.small.saved.setText("saving …") if desk.saving else None)
        self._build()
        self._lay_out()
        desk.began.connect(self._began)
        desk.asked.connect(self.show_question)
        desk.coming.connect(self._draw_ahead)
        desk.practised.connect(self._practised)
        desk.finished.connect(self.show_done)
        desk.saved.connect(self._saved)
        desk.failed.connect(self._failed)
        self.set_theme(LIGHT)

    def _build(self) -> None:
        self.words = QLabel("", self, wordWrap=True, textFormat=Qt.TextFormat.PlainText)
        self.words.setObjectName("question")
        self.words.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.view, self.join_view = VotingPairView(self), JoinView(self)
        self.view.setAccessibleName("Two shapes; the part in question is coloured in each")
        self.join_view.setAccessibleName("Two pieces, put together and pulled apart")
        self.answers, self.told = AnswerBar(self), FeedbackBar(self)
        self.comment, self.trouble, self.small = CommentBar(self), TroubleBar(self), SmallPrint(self)
        self.notice = Notice(self)
        self.answers.answered.connect(self.answer)
        self.told.left.connect(self.go_on)
        self.comment.kept.connect(self._keep_comment)
        self.trouble.again.connect(self._retry)
        self.trouble.copied.connect(self.copy_details)
        for name, act in self._tools().items():
            self.small.tools[name].clicked.connect(act)
        for watched in (self.view, self.join_view):
            watched.setMouseTracking(True)
            watched.installEventFilter(self)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def _tools(self) -> dict[str, Callable[[], object]]:
        return {
            "undo": self.undo, "skip": self.skip, "comment": self.open_comment, "reset": self.view.reset_view,
            "turn": self.turn, "guide": self.show_guideline,
        }  # fmt: skip

    def _lay_out(self) -> None:
        self.stage, self.low, self.whole = QStackedLayout(), QStackedLayout(), QStackedLayout(self)
        for view in (self.view, self.join_view):
            self.stage.addWidget(view)
        for bar in (self.answers, self.told):
            self.low.addWidget(bar)
        page = QWidget(self)
        column = QVBoxLayout(page)
        column.setContentsMargins(16, 12, 16, 8)
        column.setSpacing(8)
        column.addWidget(self.words)
        column.addLayout(self.stage, 1)
        for bar in (self.comment, self.trouble):
            column.addWidget(bar)
            bar.hide()
        column.addLayout(self.low)
        column.addWidget(self.small)
        self.page = page
        self.whole.addWidget(page)
        holder = QWidget(self)
        around = QVBoxLayout(holder)
        around.setContentsMargins(16, 16, 16, 24)
        around.addWidget(self.notice)
        self.whole.addWidget(holder)

    # --- what is shown

    @property
    def asking(self) -> bool:
        """Whether a question is shown and can be answered."""
        seen = not isinstance(self.desk.question, Question) or self.view.scenes_shown
        return self.desk.question is not None and seen and self.whole.currentWidget() is self.page and not self.practised

    @property
    def practised(self) -> bool:
        """Whether what was said after a practice answer is shown."""
        return self.low.currentWidget() is self.told

    def say(self, heading: str, text: str, *choices: Choice, more: str = "", field: str = "", trouble: str = "") -> None:
        """Show words instead of a question."""
        self.watch.leave()
        self.notice.fill(heading, text, choices, more=more, field=field, trouble=trouble)
        self.whole.setCurrentIndex(1)
        if not field:
            self.setFocus()

    def _read(self, saying: Saying) -> None:
        self.say(saying.heading, saying.text, *saying.choices, more=saying.more, trouble=saying.trouble)

    def show_question(self, question: Asked, given: str, comment: str = "") -> None:
        """Ask something, with the answer that stands and a comment that was taken back."""
        self.words.setText(question.words)
        joined = isinstance(question, JoinQuestion)
        self._given, self._comment = given, comment
        self.comment.close_up()
        self.trouble.hide()
        self.low.setCurrentWidget(self.answers)
        self._mark()
        self._count()
        self.small.mark_comment(bool(comment))
        self.small.show_for(shapes=not joined)
        self._return()
        self.stage.setCurrentWidget(self.join_view if joined else self.view)
        self.page.layout().activate()  # the views are chosen for the size that the shapes will have
        if isinstance(question, JoinQuestion):
            self.join_view.set_picture(question.picture)
        else:
            self.view.present(question.pair)
        self.watch.start()

    def _return(self) -> None:
        self.whole.setCurrentIndex(0)
        self.watch.come_back()
        self.setFocus()

    def _mark(self) -> None:
        self.answers.mark(self._theme, self._given, asking=self.desk.question is not None, unsure=self.desk.unsure)

    def _count(self) -> None:
        practising = self.desk.practising
        practice = f"practice {practising[0]} of {practising[1]}" if practising else ""
        self.small.counter.setText(practice or progress_text(self.desk.progress))

    def _draw_ahead(self, question: Asked) -> None:
        if isinstance(question, Question):
            if not self.view.isVisible():  # hidden by a join: as large as it will be
                self.view.resize(self.join_view.size())
            self.view.draw_ahead(question.pair)

    def _practised(self, told: object) -> None:
        last = self.desk.left_to_practise == 0
        self.told.show_feedback(told, "Now for real" if last else "Next", self._theme)
        self.low.setCurrentWidget(self.told)
        self.small.show_for(shapes=self.stage.currentWidget() is self.view, asking=False)
        self.setFocus()

    def go_on(self) -> None:
        """From what was said after a practice answer to the next question."""
        if self.practised and not self.desk.saving:
            self.desk.go_on()

    def _began(self) -> None:
        if self.own_window and self.desk.anything:
            self.show_welcome()
        else:
            self.desk.go_on()

    def show_welcome(self) -> None:
        """Greet, with how much there is to do."""
        self._read(sayings.welcome(self.desk, self._start))

    def _start(self) -> None:
        self.say("One moment", "")
        self.desk.go_on()

    def show_guideline(self) -> None:
        """What the study says to its volunteers, and the keys; the question stays and its time stands still."""
        if self.whole.currentIndex() == 0 or self.desk.question is not None or self.practised:
            self._read(sayings.help_page(self.desk, self._return))

    def show_done(self) -> None:
        """Thank, and let the last answer be taken back."""
        self._read(sayings.done(self.desk, self.undo, self.left.emit if self.own_window else None))

    def leave(self) -> None:
        """Say that everything is saved before the window closes, or that it is not."""
        if not self.own_window:
            return
        if self.desk.unsaved and not self.desk.saving:
            self._read(sayings.unsaved(self.trouble.words.text(), self._retry, self.given_up.emit))
        elif self.desk.question is None and not self.practised:
            self.left.emit()
        else:
            self._read(sayings.leaving(self.desk, self.left.emit, self._return))

    # --- what the volunteer does

    def answer(self, answer: str) -> None:
        """Commit an answer; the next question comes after it has reached the disk."""
        if self.practised:
            if answer == "unsure":  # its key says "next" here
                self.go_on()
            return
        if not self.asking or self.desk.saving:
            return
        self._comment = self.comment.text() or self._comment
        shown, active = self.watch.read()
        self._given = answer if answer != "unsure" or self.desk.unsure else self._given
        self._slow.start()
        self.desk.answer(answer, self._comment, shown, active, self._presentation())

    def _presentation(self) -> dict[str, object]:
        question = self.desk.question
        if not isinstance(question, Question):
            return {}
        return {"left": "target" if question.swapped else "source", "view": self.view.looking_from()}

    def undo(self) -> None:
        """Take back the last answer and show its question again."""
        self._slow.start()
        self.desk.undo()

    def skip(self) -> None:
        """Leave this question for the end."""
        if self.asking:
            self.desk.skip()

    def turn(self) -> None:
        """Start or stop turning the shapes."""
        if self.stage.currentWidget() is self.view and self.desk.question is not None:
            self.view.turn()

    def open_comment(self) -> None:
        """Open a line for a comment that goes with the answer."""
        if self.asking:
            self.comment.open_up(self._comment)

    def _keep_comment(self, text: str) -> None:
        self._comment = text
        self.comment.hide()
        self.setFocus()
        self.small.mark_comment(bool(text))
        self.small.saved.setText("comment kept" if text else "")

    def _saved(self, words: str) -> None:
        self.trouble.hide()
        self.small.saved.setText(words)
        self._count()

    def _failed(self, sentence: str) -> None:
        self.trouble.show_sentence(sentence, self._theme, details=bool(self.desk.details))
        self.small.saved.setText("not saved yet" if self.desk.unsaved else "")
        if self.desk.question is None and not self.practised:
            copy = self.copy_details if self.desk.details else None
            self._read(sayings.stuck(sentence, self._retry, self.left.emit, copy))
        else:
            self._mark()

    def _retry(self) -> None:
        self.trouble.hide()
        if self.desk.question is not None:
            self._return()
        self._slow.start()
        self.desk.retry()

    def copy_details(self) -> None:
        """Put where the fault happened on the clipboard, for whoever looks into it."""
        QGuiApplication.clipboard().setText(self.desk.details)
        self.small.saved.setText("details copied")

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """The keys of the screen; a key that is held down counts once."""
        plain = not event.modifiers() & (Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.AltModifier)
        if event.isAutoRepeat() or not plain or not self._press(event.key()):
            super().keyPressEvent(event)

    def _press(self, key: int) -> bool:
        self.watch.touch()
        if self.whole.currentIndex() == 1:
            return self.notice.press(key)
        if key in ENTER and self.comment.isVisible():
            self.comment.keep()
        elif key == K.Key_Escape:
            self.comment.close_up() if self.comment.isVisible() else self.leave()
            self.setFocus()
        elif self.practised and key in NEXT:
            self.go_on()
        elif key in (K.Key_G, K.Key_Question):
            self.show_guideline()
        else:
            keys: dict[int, Callable[[], object]] = {
                K.Key_J: lambda: self.answer("correct"), K.Key_F: lambda: self.answer("wrong"),
                K.Key_Space: lambda: self.answer("unsure"), K.Key_Backspace: self.undo, K.Key_N: self.skip,
                K.Key_R: self.view.reset_view, K.Key_T: self.turn, K.Key_C: self.open_comment,
            }  # fmt: skip
            act = keys.get(key)
            if act is not None:
                act()
            return act is not None
        return True

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """See that somebody is there."""
        if event.type() in _INPUT:
            self.watch.touch()
        return super().eventFilter(watched, event)

    def event(self, event: QEvent) -> bool:
        """Count no time while another window is in front, and see then whether it answered the same question."""
        if event.type() == QEvent.Type.WindowDeactivate:
            self.watch.leave()
        elif event.type() == QEvent.Type.WindowActivate:
            if self.whole.currentIndex() == 0:
                self.watch.come_back()
            self.desk.recheck()
        return super().event(event)

    def set_theme(self, theme: Theme) -> None:
        """Change between light and dark."""
        self._theme = theme
        self.view.set_theme(theme)
        self.join_view.set_theme(theme)
        self.setStyleSheet(screen_style(theme))
        self.told.restyle(theme)
        self.trouble.restyle(theme)
        self._mark()

    def shutdown(self) -> None:
        """Give back what the view holds of the graphics system."""
        self.view.shutdown()
