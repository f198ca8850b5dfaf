"""The page of results: precision of each method and set by the votes of the open study, with intervals."""

from pathlib import Path
from typing import NamedTuple

from PySide6.QtCore import QModelIndex, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QPainter, QPen
from PySide6.QtWidgets import (
    QAbstractItemView,
    QFileDialog,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QPushButton,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from annotation.precision import Ballot, PrecisionRow, ballots, precision_table
from annotation.tabletext import agreement_line, render
from engine.errors import ConcordError
from engine.store import write_atomically

from ..palette import theme
from ..session import Session, State
from .arrange import share_text
from .judging import Judging

HEADS = ("method", "preset", "set", "pairs", "judged", "✓", "✗", "tie", "precision", "95 % interval", "volunteers")
_TIPS = {
    "preset": "The preset of shapes, the measure of puzzles", "pairs": "Pairs of shapes, or puzzles",
    "judged": "Matches with a vote for or against, of all matches", "✓": "Correct by majority", "✗": "Wrong by majority",
    "tie": "As many for as against; a tie stays a tie", "precision": "Correct of those decided",
    "95 % interval": "The pair, or the puzzle, is the unit of sampling; the paler line takes all undecided ones as wrong or right",
}  # fmt: skip
_ROW = Qt.ItemDataRole.UserRole


class Table(NamedTuple):
    """The rows and the votes that they come from."""

    rows: tuple[PrecisionRow, ...]
    votes: tuple[Ballot, ...]


def cells(row: PrecisionRow) -> tuple[str, ...]:
    """The texts of a row, in the order of `HEADS`; the interval is drawn."""
    preset = (row.preset or "–") + ("*" if row.parameter_sets > 1 else "")
    micro = "–" if row.micro is None else share_text(row.micro)
    return (row.method, preset, row.set_name or "–", str(row.pairs), f"{row.judged} of {row.matches}", str(row.correct),
            str(row.wrong), str(row.tie), micro, "", str(row.volunteers))  # fmt: skip


def interval_text(row: PrecisionRow) -> str:
    """'[.52, .96]', or a dash."""
    return "–" if row.interval is None else f"[{share_text(row.interval.low)}, {share_text(row.interval.high)}]"


class IntervalDelegate(QStyledItemDelegate):
    """Draws precision as a dot on 0..1 with its interval, the bounds of the undecided behind it, and the numbers."""

    dark = False

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: QModelIndex) -> None:
        super().paint(painter, option, index)
        row: PrecisionRow | None = index.data(_ROW)
        if row is None:
            return
        colours = theme(self.dark)
        box = QRectF(option.rect).adjusted(8, 0, -96, 0)
        middle = box.center().y()

        def at(share: float) -> QPointF:
            return QPointF(box.left() + share * box.width(), middle)

        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(QColor(colours.line), 1))
        painter.drawLine(at(0), at(1))
        if row.bound_low is not None and row.bound_high is not None:
            painter.setPen(QPen(QColor(colours.line), 7))
            painter.drawLine(at(row.bound_low), at(row.bound_high))
        if row.interval is not None and row.micro is not None:
            painter.setPen(QPen(QColor(colours.accent), 2))
            painter.drawLine(at(row.interval.low), at(row.interval.high))
            painter.setBrush(QColor(colours.accent))
            painter.drawEllipse(at(row.micro), 4, 4)
        painter.setPen(QColor(colours.ink))
        numbers = QRectF(option.rect).adjusted(option.rect.width() - 90, 0, -4, 0)
        painter.drawText(numbers, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, interval_text(row))
        painter.restore()


class ResultsPage(QWidget):
    """Reads the table when it is shown and after each vote."""

    failed = Signal(str, str)

    def __init__(self, session: Session, judging: Judging, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session, self.judging = session, judging
        self.content = Table((), ())
        self.heading, self.empty = QLabel("Precision by majority of votes", self), QLabel("", self, wordWrap=True)
        self.heading.setObjectName("page-heading")
        self.file, self.notes = QLabel("", self), QLabel("", self, wordWrap=True)
        for label in (self.file, self.notes, self.empty):
            label.setObjectName("soft")
            label.setTextFormat(Qt.TextFormat.PlainText)
        self.table = self._table()
        self.csv, self.markdown = QPushButton("Export CSV…", self), QPushButton("Export Markdown…", self)
        self.csv.clicked.connect(lambda: self._export("csv"))
        self.markdown.clicked.connect(lambda: self._export("markdown"))
        head = QHBoxLayout()
        head.setSpacing(8)
        for widget, stretch in ((self.heading, 0), (self.file, 1), (self.csv, 0), (self.markdown, 0)):
            head.addWidget(widget, stretch)
        column = QVBoxLayout(self)
        column.setContentsMargins(16, 16, 16, 12)
        column.setSpacing(12)
        column.addLayout(head)
        column.addWidget(self.table, 10)
        column.addWidget(self.empty)
        column.addWidget(self.notes)
        column.addStretch(1)
        session.changed.connect(self.apply)
        judging.refreshed.connect(self._refresh_if_shown)
        self.show_table(self.content)
        self.apply(State(), session.state, frozenset(State.__slots__))

    def _table(self) -> QTableWidget:
        table = QTableWidget(0, len(HEADS), self)
        table.setHorizontalHeaderLabels([f"  {head}  " for head in HEADS])
        for column, head in enumerate(HEADS):
            table.horizontalHeaderItem(column).setToolTip(_TIPS.get(head, ""))
            if column < 3:
                table.horizontalHeaderItem(column).setTextAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        table.verticalHeader().hide()
        table.verticalHeader().setDefaultSectionSize(32)
        table.setShowGrid(False)
        table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        table.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        head = table.horizontalHeader()
        head.setHighlightSections(False)
        head.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        head.setSectionResizeMode(HEADS.index("95 % interval"), QHeaderView.ResizeMode.Stretch)
        self.delegate = IntervalDelegate(table)
        table.setItemDelegateForColumn(HEADS.index("95 % interval"), self.delegate)
        return table

    def begin(self) -> None:
        """Read the votes and show the table."""
        self.judging.ask(lambda handle: Table(precision_table(handle), ballots(handle)), self.show_table)

    def _refresh_if_shown(self) -> None:
        if self.isVisible():
            self.begin()

    def show_table(self, content: Table) -> None:
        """Show rows, notes and what is missing."""
        self.content = content
        self.table.setRowCount(len(content.rows))
        for line, row in enumerate(content.rows):
            for column, text in enumerate(cells(row)):
                item = QTableWidgetItem(f"  {text}  " if text else "")
                item.setTextAlignment(Qt.AlignmentFlag.AlignVCenter | (
                    Qt.AlignmentFlag.AlignLeft if column < 3 else Qt.AlignmentFlag.AlignHCenter))  # fmt: skip
                if HEADS[column] == "95 % interval":
                    item.setData(_ROW, row)
                    item.setToolTip(row.interval.method if row.interval else "Nothing is decided yet.")
                self.table.setItem(line, column, item)
        some = bool(content.rows)
        self.table.setMaximumHeight(self.table.horizontalHeader().sizeHint().height() + 32 * len(content.rows) + 4)
        self.table.setVisible(some)
        self.empty.setVisible(not some)
        self.empty.setText("No match has been judged in this study yet. Judge some on the page Shapes with J and F.")
        starred = "* Pairs of this row were matched with different parameters. " if any(
            row.parameter_sets > 1 for row in content.rows) else ""  # fmt: skip
        legend = "The dot is the precision, the line its 95 % interval, the band what the undecided could make of it.\n"
        self.notes.setText(legend + starred + agreement_line(content.votes) if some else "")
        self.csv.setEnabled(some)
        self.markdown.setEnabled(some)

    def _export(self, style: str) -> None:
        ending = {"csv": "csv", "markdown": "md"}[style]
        path, _ = QFileDialog.getSaveFileName(self, "Export the table", f"precision.{ending}", f"*.{ending}")
        if path:
            self.export(Path(path), style)

    def export(self, path: Path, style: str) -> None:
        """Write the table as CSV or Markdown; a message where that cannot be."""
        try:
            write_atomically(path, render(self.content.rows, self.content.votes, style))
        except ConcordError as error:
            self.failed.emit(str(error), "")

    def apply(self, _old: State, state: State, names: frozenset[str]) -> None:
        """Follow the theme and the study file."""
        if "dark" in names:
            self.delegate.dark = state.dark
            self.table.viewport().update()
        if "study" in names:
            self.file.setText(state.study)
            self._refresh_if_shown()

    def shutdown(self) -> None:
        """Nothing to give back."""
