"""The parts of the voting screen below the picture: answers, what is said after practice, a comment, small print."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QLineEdit, QPushButton, QVBoxLayout, QWidget

from ...palette import Theme
from ..shapes.panels import answer_style
from .words import ANSWER_KEYS, SPOKEN, TOOLS, Feedback

HIGH = 64
ROOM = 880  # pixels that the small print needs with its keys


class AnswerBar(QWidget):
    """Three wide buttons with their keys."""

    answered = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.buttons: dict[str, QPushButton] = {}
        row = _row(self, 16)
        for answer, (words, key) in ANSWER_KEYS.items():
            button = _large(f"{words}\n{key}", self)
            button.setObjectName(f"vote-{answer}")
            button.setAccessibleName(SPOKEN[answer])
            button.clicked.connect(lambda _=False, answer=answer: self.answered.emit(answer))
            row.addWidget(button, 1)
            self.buttons[answer] = button

    def mark(self, colours: Theme, given: str, *, asking: bool, unsure: bool) -> None:
        """Fill the answer that stands; hide 'unsure' where the study does not take it."""
        for answer, button in self.buttons.items():
            button.setEnabled(asking)
            button.setStyleSheet(answer_style(answer, colours, answer == given, padding=8) + "QPushButton { font-size: 16px; }")
        self.buttons["unsure"].setVisible(unsure)


class FeedbackBar(QWidget):
    """Whether a practice answer was right, why, and a button that goes on."""

    left = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.heading = QLabel("", self, textFormat=Qt.TextFormat.PlainText)
        self.reason = QLabel("", self, textFormat=Qt.TextFormat.PlainText, wordWrap=True)
        self.reason.setStyleSheet("font-size: 15px;")
        self.next = _large("Next\nEnter", self)
        self.next.setObjectName("primary")
        self.next.clicked.connect(self.left)
        self._right = True
        words = QVBoxLayout()
        words.setSpacing(4)
        words.addWidget(self.heading)
        words.addWidget(self.reason)
        row = _row(self, 16)
        row.addLayout(words, 2)
        row.addWidget(self.next, 1)

    def show_feedback(self, told: Feedback, onwards: str, colours: Theme) -> None:
        """Say whether it was right."""
        self._right = told.right
        self.heading.setText(("✓  " if told.right else "✗  ") + told.heading)
        self.reason.setText(told.reason)
        self.reason.setVisible(bool(told.reason))
        self.next.setText(f"{onwards}\nEnter")
        self.next.setAccessibleName(f"{onwards}, key Enter")
        self.restyle(colours)

    def restyle(self, colours: Theme) -> None:
        """Follow the theme."""
        colour = colours.correct if self._right else colours.wrong
        self.heading.setStyleSheet(f"font-size: 16px; font-weight: 600; color: {colour};")


class CommentBar(QWidget):
    """A line that is kept with the answer."""

    kept = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        label, self.line, done = QLabel("Comment", self), QLineEdit(self, maxLength=1000), QPushButton("Keep (Enter)", self)
        label.setStyleSheet("font-size: 14px;")
        done.setStyleSheet("font-size: 14px;")
        self.line.setMinimumHeight(36)
        self.line.setAccessibleName("Comment that is kept with your answer")
        self.line.setPlaceholderText("goes with your answer to this question")
        done.setMinimumHeight(36)
        done.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        done.clicked.connect(self.keep)
        row = _row(self, 8)
        row.addWidget(label)
        row.addWidget(self.line, 1)
        row.addWidget(done)

    def open_up(self, text: str) -> None:
        """Show the line with what it said."""
        self.line.setText(text)
        self.show()
        self.line.setFocus()

    def close_up(self) -> None:
        """Put the line away, and forget what it says."""
        self.line.clear()
        self.hide()

    def keep(self) -> None:
        """Hand the comment on."""
        self.kept.emit(self.line.text().strip())

    def text(self) -> str:
        """What stands in the line while it is open."""
        return self.line.text().strip() if self.isVisible() else ""


class TroubleBar(QWidget):
    """One sentence about what went wrong, and a way to try again."""

    again = Signal()
    copied = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setObjectName("trouble-bar")
        self.words = QLabel("", self, wordWrap=True, textFormat=Qt.TextFormat.PlainText)
        self.button, self.details = QPushButton("Try again", self), QPushButton("Copy details", self)
        row = _row(self, 16)
        row.setContentsMargins(12, 8, 12, 8)
        row.addWidget(self.words, 1)
        for button, signal in ((self.details, self.copied), (self.button, self.again)):
            button.setMinimumHeight(36)
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.clicked.connect(signal)
            row.addWidget(button)

    def show_sentence(self, sentence: str, colours: Theme, *, details: bool = False) -> None:
        """Say what is wrong; `details` that there is more to be copied for whoever looks into it."""
        self.words.setText(sentence)
        self.details.setVisible(details)
        self.restyle(colours)
        self.show()

    def restyle(self, colours: Theme) -> None:
        """Follow the theme."""
        self.setStyleSheet(f"QWidget#trouble-bar {{ background: {colours.raised}; border-left: 4px solid {colours.wrong}; }}")


class SmallPrint(QWidget):
    """The counter, the lesser commands with their keys, and whether it is saved."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.counter, self.saved = QLabel("", self), QLabel("", self)
        for label in (self.counter, self.saved):
            label.setObjectName("soft")
            label.setTextFormat(Qt.TextFormat.PlainText)
        self.tools: dict[str, QPushButton] = {}
        self._narrow = self._written = False
        self.row = _row(self, 4)
        self.row.addWidget(self.counter, 1)
        for name, words, key in TOOLS:
            button = QPushButton("", self, flat=True)
            button.setObjectName("plain")
            button.setAccessibleName(f"{words}, key {key}")
            button.setMinimumHeight(28)
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            self.row.addWidget(button)
            self.tools[name] = button
        self.row.addWidget(self.saved, 1, Qt.AlignmentFlag.AlignRight)
        self._label()

    def show_for(self, *, shapes: bool, asking: bool = True) -> None:
        """Offer what can be done with what is shown: only shapes can be turned, only a question left or commented on."""
        for name in ("reset", "turn"):
            self.tools[name].setVisible(shapes)
        for name in ("skip", "comment"):
            self.tools[name].setVisible(asking)

    def mark_comment(self, written: bool) -> None:
        """Show that a comment will go with the answer."""
        self._written = written
        self._label()

    def _label(self) -> None:
        """The words of the commands; their keys, too, where there is room."""
        for name, words, key in TOOLS:
            mark = " ✓" if name == "comment" and self._written else ""
            self.tools[name].setText(f"{words}{mark}" + ("" if self._narrow else f" ({key})"))

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Leave the keys out on a narrow screen; the help has them."""
        super().resizeEvent(event)
        if self._narrow != (self.width() < ROOM):
            self._narrow = not self._narrow
            self._label()


def screen_style(colours: Theme) -> str:
    """What the voting screen adds to the application's style."""
    return f"""
    QLabel#question {{ font-size: 20px; font-weight: 600; }}
    QLabel#notice-heading {{ font-size: 26px; font-weight: 600; }}
    QLabel#notice-text {{ font-size: 16px; }}
    QLabel#trouble {{ color: {colours.wrong}; font-size: 15px; }}
    QWidget#trouble-bar QLabel, QWidget#trouble-bar QPushButton {{ font-size: 14px; }}
    QLabel#soft {{ color: {colours.soft_ink}; font-size: 13px; }}
    QPushButton#primary {{ background: {colours.accent}; color: {colours.on_accent}; border-color: {colours.accent};
                           font-size: 16px; }}
    QPushButton#primary:focus {{ border: 3px solid {colours.ink}; }}
    QPushButton#secondary {{ font-size: 15px; }}
    QPushButton#secondary:focus {{ border: 2px solid {colours.accent}; }}
    QPushButton#plain {{ border: 1px solid transparent; background: transparent; color: {colours.soft_ink}; padding: 2px 6px;
                         font-size: 13px; }}
    QPushButton#plain:hover {{ color: {colours.ink}; text-decoration: underline; }}
    QPushButton#plain:focus {{ border-color: {colours.accent}; color: {colours.ink}; }}
    QLineEdit {{ font-size: 15px; padding: 4px 8px; }}
    """


def _large(words: str, parent: QWidget) -> QPushButton:
    button = QPushButton(words, parent)
    button.setMinimumHeight(HIGH)
    button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
    return button


def _row(parent: QWidget, spacing: int) -> QHBoxLayout:
    row = QHBoxLayout(parent)
    row.setContentsMargins(0, 0, 0, 0)
    row.setSpacing(spacing)
    return row
