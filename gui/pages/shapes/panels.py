"""The parts of the right panel: why a match was kept, and the strips with the three answers and with the two wishes."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFormLayout, QHBoxLayout, QLabel, QLineEdit, QPushButton, QVBoxLayout, QWidget

from ...palette import Theme, theme
from ...session import State
from .arrange import reasons, score_help, state_of, support_text
from .wishing import count_text, wish_of

ANSWER_WORDS = {"wrong": ("✗  Wrong", "F"), "unsure": ("?  Unsure", "Space"), "correct": ("✓  Correct", "J")}

WISH_WORDS = {
    "pinned": ("Pin", "K", "Keep this match: matching again takes it before all others"),
    "forbidden": ("Forbid", "X", "Never this match; parts of it and unions that hold it may still come"),
}


class WhyPanel(QWidget):
    """Similarity, score, votes and layers of the selected match, and what was said of it."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.heading = QLabel("Why this match", self)
        self.heading.setObjectName("group-heading")
        self.empty = QLabel("Pick a match in the list, or a line or a segment in the view.", self, wordWrap=True)
        self.empty.setObjectName("soft")
        self.values: dict[str, QLabel] = {}
        self.form = QFormLayout()
        self.form.setContentsMargins(0, 0, 0, 0)
        self.form.setHorizontalSpacing(12)
        self.form.setVerticalSpacing(2)
        for name in ("Source", "Target", "Similarity", "Score", "Votes", "Support", "Judged"):
            label, value = QLabel(name, self), QLabel("", self, wordWrap=True)
            label.setObjectName("soft")
            label.setAlignment(Qt.AlignmentFlag.AlignTop)
            value.setTextFormat(Qt.TextFormat.PlainText)
            value.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
            value.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            self.form.addRow(label, value)
            self.values[name] = value
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addWidget(self.heading)
        column.addWidget(self.empty)
        column.addLayout(self.form)

    def show_state(self, state: State) -> None:
        """Explain the selected match of a state, or say how to select one."""
        match = state.match(state.selected)
        self.empty.setVisible(match is None)
        for name, value in self.values.items():
            value.setVisible(match is not None)
            self.form.labelForField(value).setVisible(match is not None)
            value.setText(dict(reasons(match, state.result)).get(name, "") if match else "")
        if match is not None:
            method = state.parameters.method if state.result is None else state.result.method
            for part in (self.values["Score"], self.form.labelForField(self.values["Score"])):
                part.setToolTip(score_help(method))
            own, all_ = state.answers.get(match.id, "not yet"), state_of(match.id, state.verdicts)
            text = support_text(match.id, state.support)
            self.values["Support"].setText(f"{text}  by the other shapes of the collection")
            for part in (self.values["Support"], self.form.labelForField(self.values["Support"])):
                part.setVisible(text != "–")
            self.values["Judged"].setText(f"by you: {own}  ·  majority: {all_}")


class JudgeStrip(QWidget):
    """Three answers with their keys, who answers, and whether it is saved."""

    answered = Signal(str)
    named = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.buttons: dict[str, QPushButton] = {}
        row = QHBoxLayout()
        row.setSpacing(4)
        for answer, (words, key) in ANSWER_WORDS.items():
            button = QPushButton(f"{words}  ({key})", self)
            button.setObjectName(f"answer-{answer}")
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.clicked.connect(lambda _=False, answer=answer: self.answered.emit(answer))
            row.addWidget(button, 1)
            self.buttons[answer] = button
        self.code = QLineEdit(self, maxLength=40, placeholderText="code", toolTip="The code that your votes are kept under")
        self.code.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.code.setMaximumWidth(112)
        self.code.editingFinished.connect(self._named)
        self.state = QLabel("", self)
        self.state.setObjectName("soft")
        who = QLabel("Volunteer", self)
        who.setObjectName("soft")
        low = QHBoxLayout()
        low.setSpacing(8)
        low.addWidget(who)
        low.addWidget(self.code)
        low.addWidget(self.state, 1, Qt.AlignmentFlag.AlignRight)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(8)
        column.addLayout(row)
        column.addLayout(low)

    def _named(self) -> None:
        self.named.emit(self.code.text())
        self.code.clearFocus()

    def show_state(self, state: State) -> None:
        """Enable the answers where a match is selected, and mark the one given."""
        given = state.answers.get(state.selected, "")
        colours = theme(state.dark)
        for answer, button in self.buttons.items():
            button.setEnabled(bool(state.selected))
            button.setStyleSheet(answer_style(answer, colours, answer == given))
        if not self.code.hasFocus():
            self.code.setText(state.volunteer)


class WishStrip(QWidget):
    """Two buttons that pin or forbid the selected match, a menu with more, and how much is wished."""

    wished = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.buttons: dict[str, QPushButton] = {}
        row = QHBoxLayout()
        row.setSpacing(4)
        for wish, (words, key, tip) in WISH_WORDS.items():
            button = QPushButton(f"{words}  ({key})", self, checkable=True, toolTip=tip)
            button.setObjectName(f"wish-{wish}")
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.clicked.connect(lambda _=False, wish=wish: self.wished.emit(wish))
            row.addWidget(button, 1)
            self.buttons[wish] = button
        self.more = QPushButton("More", self, toolTip="Wishes from answers and votes; save, open, forget")
        self.more.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        row.addWidget(self.more, 1)
        self.count = QLabel("", self)
        self.count.setObjectName("soft")
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addLayout(row)
        column.addWidget(self.count)

    def show_state(self, state: State) -> None:
        """Enable the buttons where a match is selected, mark its wish, and count."""
        wish, colours = wish_of(state, state.selected), theme(state.dark)
        for name, button in self.buttons.items():
            button.setEnabled(bool(state.selected))
            button.setChecked(name == wish)
            button.setStyleSheet(wish_style(colours, name == wish))
        self.more.setStyleSheet(wish_style(colours, False))
        self.count.setText(count_text(state.wishes) + ("; my answers pin and forbid" if state.bound else ""))
        self.count.setVisible(bool(state.wishes or state.bound))


def wish_style(colours: Theme, on: bool) -> str:
    """The look of a wish's button: filled with ink while the wish stands."""
    filled = f"background: {colours.ink}; color: {colours.paper};" if on else ""
    return f"QPushButton {{ padding: 4px; {filled} }}"


def answer_style(answer: str, colours: Theme, given: bool, padding: int = 4) -> str:
    """The look of an answer's button: a line in its colour, filled where it is the answer given."""
    colour = colours.state({"unsure": "undecided"}.get(answer, answer))
    filled = f"background: {colour}; color: #FFFFFF;" if given else ""
    return (
        f"QPushButton {{ border: 1px solid {colour}; padding: {padding}px 4px; {filled} }}"
        f"QPushButton:disabled {{ border-color: {colours.line}; }}"
        f"QPushButton:focus, QPushButton:hover {{ border: 2px solid {colour}; padding: {padding - 1}px 3px; }}"
    )
