"""The matches on which volunteers are divided, most divided first: a list, and the picture of the chosen one."""

from pathlib import Path

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QSplitter, QVBoxLayout, QWidget

from annotation.findings.gathering import Disputed, Findings

from ..quiet_table import fill, quiet_table, still_columns
from .match_preview import PICK, MatchPreview

HEADS = ("pair", "set", "✓", "✗", "?", "majority")
_TIPS = {"✓": "Votes for correct", "✗": "Votes for wrong", "?": "Unsure", "majority": "A tie stays a tie"}
_WORDS = 2
ENDINGS = (".off", ".obj", ".ply", ".stl", ".vtp")


def short_pair(pair: str) -> str:
    """'vase1.off – vase2.off' without the endings of the files, which say nothing in a list."""
    return " – ".join(name[: -len(Path(name).suffix)] if Path(name).suffix in ENDINGS else name for name in pair.split(" – "))


def disputed_cells(row: Disputed) -> tuple[str, ...]:
    """The texts of a row, in the order of `HEADS`."""
    correct, wrong, unsure, verdict = row.majority
    return short_pair(row.pair) or "–", ", ".join(row.sets) or "–", str(correct), str(wrong), str(unsure), verdict


class DisputedSection(QWidget):
    """Says which match was picked (`picked`) and which is wanted on its own page (`opened`); shows what it is given."""

    picked = Signal(str)
    opened = Signal(str)

    empty = "Nobody disagrees yet: no match has votes for and against."

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.rows: tuple[Disputed, ...] = ()
        self.table = quiet_table(HEADS, _WORDS, "pair", self, _TIPS)
        self.table.itemSelectionChanged.connect(self._pick)
        self.preview = MatchPreview(self)
        self.comments = QLabel("", self, wordWrap=True)
        self.comments.setTextFormat(Qt.TextFormat.PlainText)
        self.open_button = QPushButton("Open the pair on the page Shapes", self)
        self.open_button.clicked.connect(lambda: self.opened.emit(self.chosen))
        below = QHBoxLayout()
        below.addWidget(self.comments, 1)
        below.addWidget(self.open_button, 0, Qt.AlignmentFlag.AlignTop)
        right = QWidget(self)
        column = QVBoxLayout(right)
        column.setContentsMargins(12, 0, 0, 0)
        column.setSpacing(8)
        column.addWidget(self.preview, 1)
        column.addLayout(below)
        self.splitter = QSplitter(Qt.Orientation.Horizontal, self)
        self.splitter.addWidget(self.table)
        self.splitter.addWidget(right)
        self.splitter.setSizes([600, 620])
        self.splitter.setChildrenCollapsible(False)
        whole = QVBoxLayout(self)
        whole.setContentsMargins(0, 0, 0, 0)
        whole.addWidget(self.splitter)
        self._tell()

    @property
    def chosen(self) -> str:
        """The id of the picked match, or ''."""
        lines = {index.row() for index in self.table.selectionModel().selectedRows()}
        return self.rows[min(lines)].item if lines and min(lines) < len(self.rows) else ""

    def show_content(self, found: Findings) -> bool:
        """Show the list, with the same match picked as before where it is still there."""
        before, self.rows = self.chosen, found.disputed
        blocked = self.table.blockSignals(True)
        fill(self.table, [disputed_cells(row) for row in self.rows], _WORDS, fitted=False)
        with still_columns(self.table):
            for line, row in enumerate(self.rows):
                self.table.item(line, 0).setToolTip(row.pair)
        self.table.clearSelection()
        again = next((line for line, row in enumerate(self.rows) if row.item == before), -1)
        if again >= 0:
            self.table.selectRow(again)
        self.table.blockSignals(blocked)
        if before and again < 0:
            self.preview.show_match(PICK)
        self._tell()
        if self.rows and not self.chosen:
            self.table.selectRow(0)
        return bool(self.rows)

    def _pick(self) -> None:
        self._tell()
        if self.chosen:
            self.picked.emit(self.chosen)

    def _tell(self) -> None:
        row = next((row for row in self.rows if row.item == self.chosen), None)
        self.comments.setText("\n".join(f"“{text}”" for text in row.comments) if row else "")
        self.open_button.setVisible(row is not None and row.kind == "shape")

    def set_dark(self, dark: bool) -> None:
        """Follow the theme."""
        self.preview.set_dark(dark)

    def shutdown(self) -> None:
        """Give back what the picture holds."""
        self.preview.shutdown()
