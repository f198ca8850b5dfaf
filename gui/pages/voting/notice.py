"""A page of words with one or two large buttons: welcome, guideline, goodbye."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QHBoxLayout, QLabel, QLineEdit, QPushButton, QScrollArea, QVBoxLayout, QWidget

WIDTH, HIGH = 640, 60
SCROLL = {Qt.Key.Key_Up: -0.1, Qt.Key.Key_Down: 0.1, Qt.Key.Key_PageUp: -0.8, Qt.Key.Key_PageDown: 0.8}


class Choice(NamedTuple):
    """A button: its words, the keys that press it, how the first of them is written, and what it does."""

    words: str
    keys: tuple[Qt.Key, ...]
    key: str
    act: Callable[[], object]


class Notice(QWidget):
    """A heading, text, perhaps a line to fill in, and buttons; one page that is filled again and again."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.choices: tuple[Choice, ...] = ()
        self.buttons: list[QPushButton] = []
        self.heading = QLabel("", self, alignment=Qt.AlignmentFlag.AlignCenter, wordWrap=True)
        self.heading.setObjectName("notice-heading")
        self.text = QLabel("", self, wordWrap=True, textFormat=Qt.TextFormat.PlainText)
        self.text.setObjectName("notice-text")
        self.text.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.more = QLabel("", self, wordWrap=True, textFormat=Qt.TextFormat.RichText)
        self.more.setObjectName("notice-text")
        self.field = QLineEdit(self, maxLength=40)
        self.field.setMinimumHeight(44)
        self.trouble = QLabel("", self, wordWrap=True, textFormat=Qt.TextFormat.PlainText)
        self.trouble.setObjectName("trouble")
        self.row = QHBoxLayout()
        self.row.setSpacing(16)
        self._lay_out()

    def _lay_out(self) -> None:
        inside = QWidget(self)
        inside.setMaximumWidth(WIDTH)
        column = QVBoxLayout(inside)
        column.setContentsMargins(16, 16, 16, 16)
        column.setSpacing(16)
        column.addStretch(1)
        for part in (self.heading, self.text, self.more, self.field, self.trouble):
            column.addWidget(part)
        column.addStretch(1)
        area = self.area = QScrollArea(self, widgetResizable=True)
        area.setFrameShape(QScrollArea.Shape.NoFrame)
        area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        area.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        holder = QWidget(area)
        middle = QHBoxLayout(holder)
        middle.setContentsMargins(0, 0, 0, 0)
        middle.addStretch(1)
        middle.addWidget(inside, 100)
        middle.addStretch(1)
        area.setWidget(holder)
        for plain in (holder, area.viewport()):
            plain.setAutoFillBackground(False)
        low = QHBoxLayout()
        low.addStretch(1)
        low.addLayout(self.row, 100)
        low.addStretch(1)
        outer = QVBoxLayout(self)
        outer.setContentsMargins(0, 0, 0, 0)
        outer.addWidget(area, 1)
        outer.addLayout(low)

    def fill(
        self, heading: str, text: str, choices: Sequence[Choice], *, more: str = "", field: str = "", trouble: str = ""
    ) -> None:
        """Say something else; `more` is HTML of the program's own, `field` the placeholder of a line to fill in."""
        self.choices = tuple(choices)
        for label, words in ((self.heading, heading), (self.text, text), (self.more, more), (self.trouble, trouble)):
            label.setText(words)
            label.setVisible(bool(words))
        self.area.verticalScrollBar().setValue(0)
        self.field.setVisible(bool(field))
        self.field.setPlaceholderText(field)
        self.field.setAccessibleName(field)
        across = Qt.AlignmentFlag.AlignLeft if more or field else Qt.AlignmentFlag.AlignHCenter
        self.text.setAlignment(Qt.AlignmentFlag.AlignTop | across)
        for button in self.buttons:
            self.row.removeWidget(button)
            button.hide()
            button.deleteLater()
        self.buttons = [self._button(choice, number) for number, choice in enumerate(choices)]
        if field:
            self.field.setFocus()

    def _button(self, choice: Choice, number: int) -> QPushButton:
        button = QPushButton(f"{choice.words}\n{choice.key}" if choice.key else choice.words, self)
        button.setObjectName("primary" if number == 0 else "secondary")
        button.setMinimumSize(160, HIGH)
        button.setMaximumWidth(320)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        button.setAccessibleName(f"{choice.words}, key {choice.key}" if choice.key else choice.words)
        button.clicked.connect(choice.act)
        self.row.addWidget(button, 1)
        button.show()
        return button

    def press(self, key: int) -> bool:
        """Do what this key is for here, if anything; Enter is for the button that has the focus, arrows scroll."""
        if key in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            focused = next((button for button in self.buttons if button.hasFocus()), None)
            if focused is not None:
                focused.click()
                return True
        if key in SCROLL:
            bar = self.area.verticalScrollBar()
            bar.setValue(bar.value() + round(SCROLL[Qt.Key(key)] * self.area.height()))
            return True
        found = next((choice for choice in self.choices if key in choice.keys), None)
        if found is not None:
            found.act()
        return found is not None
