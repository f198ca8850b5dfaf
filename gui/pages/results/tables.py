"""Sections of the results that are tables alone: the very tables that are exported, one below the other."""

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFrame, QLabel, QScrollArea, QTableWidget, QVBoxLayout, QWidget

from annotation.findings.gathering import Findings
from annotation.findings.tables import tables
from engine.evaluation.tables import Table

from ..quiet_table import fill, fit_width, quiet_table


class TablesView(QScrollArea):
    """Tables under their headings, each with its remark below; as high as they need, and scrolled where that is too much."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.heads: list[tuple[str, tuple[str, ...]]] = []
        self.tables: list[QTableWidget] = []
        self.remarks: list[QLabel] = []

    def show_tables(self, found: Sequence[Table]) -> None:
        """Show these tables; widgets are made anew only where other columns come."""
        heads = [(table.title, tuple(table.head)) for table in found]
        if heads != self.heads:
            self._build(found)
            self.heads = heads
        for table, widget, remark in zip(found, self.tables, self.remarks, strict=True):
            fill(widget, table.rows, table.words)
            fit_width(widget)
            widget.setMinimumSize(widget.maximumSize())
            remark.setText(table.remark)
            remark.setVisible(bool(table.remark))

    def _build(self, found: Sequence[Table]) -> None:
        whole = QWidget(self)
        column = QVBoxLayout(whole)
        column.setContentsMargins(0, 0, 8, 0)
        column.setSpacing(4)
        self.tables, self.remarks = [], []
        for table in found:
            heading, remark = QLabel(table.title, whole), QLabel("", whole, wordWrap=True)
            heading.setObjectName("group-heading")
            heading.setContentsMargins(0, 12 if self.tables else 0, 0, 0)
            remark.setObjectName("soft")
            remark.setTextFormat(Qt.TextFormat.PlainText)
            widget = quiet_table(table.head, table.words, "", whole)
            widget.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)  # the view scrolls, with bars that are in sight
            widget.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
            for part in (heading, widget, remark):
                column.addWidget(part)
            self.tables.append(widget)
            self.remarks.append(remark)
        column.addStretch(1)
        before = self.takeWidget()
        if before is not None:
            before.deleteLater()
        self.setWidget(whole)


class TablesSection(QWidget):
    """Some sections of the findings as tables."""

    def __init__(self, sections: Sequence[str], empty: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.names, self.empty = tuple(sections), empty
        self.view = TablesView(self)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.view)

    def show_content(self, found: Findings) -> bool:
        """Show the tables that have rows; whether the first one has any."""
        some = [table for name in self.names for table in tables(found, name) if table.rows]
        if not tells(found, self.names[0]):
            return False
        self.view.show_tables(some)
        return True

    def set_dark(self, dark: bool) -> None:
        """Tables follow the application."""

    def shutdown(self) -> None:
        """Nothing to give back."""


def tells(found: Findings, section: str) -> bool:
    """Whether a section has anything to say: agreement needs a match of two volunteers, a comparison a pair of both."""
    if section == "agreement":
        return any(row.items for row in found.agreement)
    return any(table.rows for table in tables(found, section))
