"""Precision of each method and set by the votes of the open study: a table, and a plot of the same figures."""

from typing import NamedTuple

from PySide6.QtCore import QModelIndex, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QResizeEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QSplitter,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QVBoxLayout,
    QWidget,
)

from annotation.findings.gathering import Findings
from annotation.findings.precision import ALL_SETS, PrecisionRow, ballots, precision_table
from annotation.findings.tables import tables
from annotation.findings.tabletext import agreement_line, row_name
from annotation.study import StudyHandle

from ...palette import theme
from ..plots import IntervalPlot, Mark, legend
from ..quiet_table import fill, quiet_table, still_columns
from ..shapes.arrange import share_text
from .tables import TablesView

HEADS = ("method", "preset", "set", "pairs", "judged", "✓", "✗", "tie", "unresolved", "precision", "95 % interval",
         "volunteers")  # fmt: skip
INTERVAL = HEADS.index("95 % interval")
_TIPS = {
    "preset": "The preset of shapes, the measure of puzzles", "pairs": "Pairs of shapes, or puzzles",
    "judged": "Matches with a vote for or against, of all matches", "✓": "Correct by majority", "✗": "Wrong by majority",
    "tie": "As many for as against; a tie stays a tie", "unresolved": "Of the matches with a vote, those without a majority",
    "precision": "Correct of those decided",
    "95 % interval": "The pair, or the puzzle, is the unit of sampling; the paler line takes all undecided ones as wrong or right",
}  # fmt: skip
_WORDS = 3
PRESET = HEADS.index("preset")
NUMBERS, LINE = 104, 56  # pixels of the numbers of an interval; the shortest line that is worth drawing beside them
DENSE = 26  # height of a row: many sets times many methods
_ROW = Qt.ItemDataRole.UserRole


class Table(NamedTuple):
    """The rows, and a sentence on how far the votes behind them agree."""

    rows: tuple[PrecisionRow, ...]
    agreement: str


def cells(row: PrecisionRow) -> tuple[str, ...]:
    """The texts of a row, in the order of `HEADS`; the interval is drawn."""
    preset = (row.preset or "–") + ("*" if row.parameter_sets > 1 else "")
    micro = "–" if row.micro is None else share_text(row.micro)
    left = "–" if row.unresolved is None else f"{100 * row.unresolved:.0f} %"
    return (row.method, preset, row.set_name or "–", str(row.pairs), f"{row.judged} of {row.matches}", str(row.correct),
            str(row.wrong), str(row.tie), left, micro, "", str(row.volunteers))  # fmt: skip


def interval_text(row: PrecisionRow) -> str:
    """'[.52, .96]', or a dash."""
    return "–" if row.interval is None else f"[{share_text(row.interval.low)}, {share_text(row.interval.high)}]"


def marks(rows: tuple[PrecisionRow, ...]) -> list[Mark]:
    """What is drawn of the rows: sets side by side, in each its methods; nothing where nothing is decided."""
    return [
        Mark(r.set_name or "–", row_name(r), r.micro, r.interval and r.interval.low, r.interval and r.interval.high,
             r.bound_low, r.bound_high) for r in sorted(rows, key=lambda r: r.set_name == ALL_SETS) if r.micro is not None
    ]  # fmt: skip


class IntervalDelegate(QStyledItemDelegate):
    """Draws precision as a dot on 0..1 with its interval, the bounds of the undecided behind it, and the numbers."""

    dark = False

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: QModelIndex) -> None:
        super().paint(painter, option, index)
        row: PrecisionRow | None = index.data(_ROW)
        if row is None:
            return
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if option.rect.width() >= NUMBERS + LINE:
            self._draw(painter, QRectF(option.rect).adjusted(8, 0, -96, 0), row)
        painter.setPen(QColor(theme(self.dark).ink))
        numbers = QRectF(option.rect).adjusted(max(4, option.rect.width() - 90), 0, -4, 0)
        painter.drawText(numbers, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, interval_text(row))
        painter.restore()

    def _draw(self, painter: QPainter, box: QRectF, row: PrecisionRow) -> None:
        colours, middle = theme(self.dark), box.center().y()

        def at(share: float) -> QPointF:
            return QPointF(box.left() + share * box.width(), middle)

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


class PrecisionSection(QWidget):
    """The table of precision with its notes, and the plot below; a hand between them gives either more room."""

    empty = ("No match has been judged in this study yet. Judge some on the page Shapes with J and F, "
             "or let volunteers vote (Ctrl+4).")  # fmt: skip

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.content = Table((), "")
        self.dark = False
        self.table = quiet_table(HEADS, _WORDS, "", self, _TIPS)
        self.table.horizontalHeader().setSectionResizeMode(INTERVAL, QHeaderView.ResizeMode.Fixed)
        self.delegate = IntervalDelegate(self.table)
        self.table.setItemDelegateForColumn(INTERVAL, self.delegate)
        self.notes = QLabel("", self, wordWrap=True)
        self.notes.setObjectName("soft")
        self.notes.setTextFormat(Qt.TextFormat.PlainText)
        self.plot = IntervalPlot("precision, %", self)
        self.plot.setMinimumHeight(150)
        self.thesis = QCheckBox("as in Tables 3.1/3.2", self)
        self.thesis.setToolTip("The mean weighted by pairs, and the standard deviation of the sets")
        self.as_thesis = TablesView(self)
        self.legend = QLabel("", self, textFormat=Qt.TextFormat.RichText, wordWrap=True)
        self._lay_out()

    def _lay_out(self) -> None:
        self.table.verticalHeader().setDefaultSectionSize(DENSE)
        self.above, below = QWidget(self), QWidget(self)
        column = QVBoxLayout(self.above)
        column.setContentsMargins(0, 0, 0, 4)
        column.setSpacing(8)
        for widget, stretch in ((self.table, 1), (self.as_thesis, 1), (self.notes, 0)):
            column.addWidget(widget, stretch)
        column.addStretch(0)
        row = QHBoxLayout()
        row.addWidget(self.legend, 1)
        row.addWidget(self.thesis, 0, Qt.AlignmentFlag.AlignTop)
        column = QVBoxLayout(below)
        column.setContentsMargins(0, 4, 0, 0)
        column.setSpacing(8)
        column.addLayout(row)
        column.addWidget(self.plot, 1)
        self.splitter = QSplitter(Qt.Orientation.Vertical, self)
        for part in (self.above, below):
            self.splitter.addWidget(part)
        self.splitter.setSizes([620, 380])
        self.splitter.setStretchFactor(0, 62)
        self.splitter.setStretchFactor(1, 38)
        self.splitter.handle(1).setToolTip("Drag for more of the table, or of the plot")
        whole = QVBoxLayout(self)
        whole.setContentsMargins(0, 0, 0, 0)
        whole.addWidget(self.splitter)

    @staticmethod
    def read(handle: StudyHandle) -> Table:
        """The rows of a study and the agreement of its votes, in a thread: with many votes that takes a moment."""
        return Table(precision_table(handle), agreement_line(ballots(handle)))

    def show_content(self, content: Table | Findings) -> bool:
        """Show rows, notes and plot, or the table of the thesis; whether there is anything to show."""
        thesis = isinstance(content, Findings)
        for widget in (self.table, self.notes):
            widget.setVisible(not thesis)
        self.as_thesis.setVisible(thesis)
        if isinstance(content, Findings):
            self.as_thesis.show_tables(tables(content, "precision"))
            self.above.setMaximumHeight(self.as_thesis.widget().sizeHint().height() + 16)
            self._plot((*content.rows, *content.chosen))
            return bool(content.rows or content.chosen)
        self.content = content
        fill(self.table, [cells(row) for row in content.rows], _WORDS)
        self.table.setColumnHidden(PRESET, all(row.preset in ("", row.method) for row in content.rows))
        self._fit()
        with still_columns(self.table):
            for line, row in enumerate(content.rows):
                item = self.table.item(line, INTERVAL)
                item.setData(_ROW, row)
                item.setToolTip(row.interval.method if row.interval else "Nothing is decided yet.")
        starred = "* Pairs of this row were matched with different parameters. " if any(
            row.parameter_sets > 1 for row in content.rows) else ""  # fmt: skip
        legend = "The dot is the precision, the line its 95 % interval, the band what the undecided could make of it.\n"
        self.notes.setText(legend + starred + content.agreement)
        self.above.setMaximumHeight(self.table.maximumHeight() + self.notes.sizeHint().height() + 24)  # few rows leave the rest
        self._plot(content.rows)
        return bool(content.rows)

    def _plot(self, rows: tuple[PrecisionRow, ...]) -> None:
        drawn = marks(rows)
        self.plot.setVisible(bool(drawn))
        self.legend.setText(legend(drawn))
        self.plot.show_marks(drawn, self.dark)

    def _fit(self) -> None:
        """The interval takes the room that is left, and never less than its numbers."""
        head = self.table.horizontalHeader()
        others = sum(head.sectionSize(k) for k in range(head.count()) if k != INTERVAL and not head.isSectionHidden(k))
        self.table.setColumnWidth(INTERVAL, max(NUMBERS, self.table.viewport().width() - others))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def set_dark(self, dark: bool) -> None:
        """Follow the theme."""
        self.dark = self.delegate.dark = dark
        self.table.viewport().update()
        self.plot.show_marks(self.plot.marks, dark)

    def shutdown(self) -> None:
        """Give the plot back."""
        self.plot.shutdown()
