"""What only a person can know of a heap of pieces: whether they may be turned, and how many pictures they make."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QHBoxLayout, QLabel, QSpinBox, QVBoxLayout, QWidget

from engine.puzzles.pieces import Puzzle

MOST_PICTURES = 20


class PuzzleFacts(QWidget):
    """Says what a hand declared; displays what it is told."""

    declared = Signal(bool, int)
    """whether pieces may be turned, and the number of pictures"""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        head = QLabel("Pieces", self)
        head.setObjectName("group-heading")
        self.turned = QCheckBox("may be turned by quarter turns", self)
        self.turned.toggled.connect(lambda _: self._say())
        self.pictures = QSpinBox(self, keyboardTracking=False)
        self.pictures.setRange(1, MOST_PICTURES)
        self.pictures.setToolTip("How many pictures are mixed in this heap of pieces")
        self.pictures.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.pictures.lineEdit().returnPressed.connect(self.pictures.clearFocus)
        self.pictures.valueChanged.connect(lambda _: self._say())
        words = QLabel("make", self)
        self.after = QLabel("picture", self)
        row = QHBoxLayout()
        row.setSpacing(8)
        for widget in (words, self.pictures, self.after):
            row.addWidget(widget)
        row.addStretch(1)
        column = QVBoxLayout(self)
        column.setContentsMargins(8, 8, 8, 4)
        column.setSpacing(4)
        column.addWidget(head)
        for line in (self.turned, row):
            inner = QHBoxLayout()
            inner.setContentsMargins(14, 0, 0, 0)
            inner.addWidget(line) if isinstance(line, QWidget) else inner.addLayout(line)
            column.addLayout(inner)

    def _say(self) -> None:
        self.declared.emit(self.turned.isChecked(), self.pictures.value())

    def show_puzzle(self, puzzle: Puzzle | None) -> None:
        """Display what is declared of a puzzle, without telling anybody."""
        self.setEnabled(puzzle is not None)
        for widget, show in ((self.turned, lambda: self.turned.setChecked(puzzle is not None and puzzle.turned)),
                             (self.pictures, lambda: self.pictures.setValue(1 if puzzle is None else puzzle.pictures))):  # fmt: skip
            before = widget.blockSignals(True)
            show()
            widget.blockSignals(before)
        self.after.setText("picture" if self.pictures.value() == 1 else "pictures")
