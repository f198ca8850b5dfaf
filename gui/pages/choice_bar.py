"""A quiet choice of one among a few words, at the top of a page: what is chosen is underlined."""

from collections.abc import Sequence

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QButtonGroup, QHBoxLayout, QPushButton, QWidget


class ChoiceBar(QWidget):
    """Says which of its (name, words) was chosen."""

    chosen = Signal(str)

    def __init__(self, choices: Sequence[tuple[str, str]], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.buttons: dict[str, QPushButton] = {}
        self._group = QButtonGroup(self)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(4)
        for name, words in choices:
            button = QPushButton(words, self, checkable=True)
            button.setObjectName("choice")
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.clicked.connect(lambda _=False, name=name: self.chosen.emit(name))
            self._group.addButton(button)
            row.addWidget(button)
            self.buttons[name] = button
        row.addStretch(1)
        self.check(choices[0][0])

    @property
    def choice(self) -> str:
        """The name that is chosen."""
        return next(name for name, button in self.buttons.items() if button.isChecked())

    def check(self, name: str) -> None:
        """Mark one as chosen; tells nobody."""
        self.buttons[name].setChecked(True)
