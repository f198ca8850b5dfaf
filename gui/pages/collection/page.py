"""The page of a collection: all shapes in the colours of their parts, the parts, the pairs, the parameters."""

import math

from PySide6.QtCore import QEvent, QObject, QSize, Qt, Signal
from PySide6.QtGui import QColor, QIcon, QPixmap
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QFrame,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QStackedWidget,
    QTableWidget,
    QTableWidgetItem,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from engine.shapes.collection_parameters import CollectionParameters
from engine.shapes.collection_result import KINDS

from ...palette import segment_colours, theme
from ...parameter_form import ParameterForm
from ...session import Session
from ...views.collection_grid import CollectionGrid
from ...views.collection_layout import next_part
from ..shapes.arrange import share_text, short_notes
from ..shapes.support import LeastSupport
from .state import CollectionState, pair_rows, part_rows

PANEL_WIDTH = 340
EMPTY = "Drop three or more meshes here, or a folder that holds them"
HEAD_TIPS = {
    "shapes": "How many shapes have the part", "area": "Its share of the surface, on average over these shapes",
    "matches": "Matches of the pair; with a least support, how many of them have it",
    "support": "Mean support of the matches by the other shapes, from 0 to 1",
}  # fmt: skip
KIND_WORDS = {"cycles": "Ways around by third shapes", "matchlift": "MatchLift on all segments"}


class CollectionPage(QWidget):
    """Draws the state of the collection's session, and says what a hand does."""

    failed = Signal(str, str)
    folder_wanted = Signal()
    meshes_wanted = Signal()
    example_wanted = Signal()
    pair_wanted = Signal(int)
    shape_clicked = Signal(int)
    least_moved = Signal(float)
    edited = Signal(str, object, bool)

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session = session
        self.view = CollectionGrid(self)
        self.scroll = QScrollArea(self, widgetResizable=True)
        self.scroll.setFrameShape(QFrame.Shape.NoFrame)
        self.scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.scroll.setWidget(self.view)
        self.scroll.viewport().installEventFilter(self)
        self.stack = QStackedWidget(self)
        self.stack.addWidget(self._invitation())
        self.stack.addWidget(self.scroll)
        self.kind, self.least = QComboBox(self), LeastSupport(self)
        self.parts, self.pairs = self._table(("", "part", "shapes", "area")), self._table(("pair", "matches", "support"))
        self.form = ParameterForm(CollectionParameters, self)
        self.notes = QLabel("", self, wordWrap=True)
        self.panel = self._panel()
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(0)
        row.addWidget(self.stack, 1)
        row.addWidget(self.panel)
        self._connect()
        self.apply(CollectionState(), session.state, frozenset(CollectionState.__slots__))

    # --- how it is laid out

    def _invitation(self) -> QWidget:
        """What stands there as long as there is no collection."""
        box = QWidget(self)
        words = QLabel(EMPTY, box, alignment=Qt.AlignmentFlag.AlignCenter, wordWrap=True)
        words.setObjectName("placeholder")
        row = QHBoxLayout()
        row.setSpacing(12)
        row.addStretch(1)
        for text, signal in (("Open a folder of shapes…", self.folder_wanted), ("Open meshes…", self.meshes_wanted),
                             ("Try the example", self.example_wanted)):  # fmt: skip
            button = QPushButton(text, box)
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.clicked.connect(lambda _=False, signal=signal: signal.emit())
            row.addWidget(button)
        row.addStretch(1)
        column = QVBoxLayout(box)
        column.setSpacing(16)
        column.addStretch(1)
        column.addWidget(words)
        column.addLayout(row)
        column.addStretch(1)
        return box

    def _table(self, heads: tuple[str, ...]) -> QTableWidget:
        table = QTableWidget(0, len(heads), self)
        table.setObjectName("matches")
        table.setHorizontalHeaderLabels(heads)
        table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        table.setShowGrid(False)
        table.setTabKeyNavigation(False)
        table.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        table.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        table.verticalHeader().hide()
        table.verticalHeader().setDefaultSectionSize(26)
        head = table.horizontalHeader()
        head.setHighlightSections(False)
        wide = heads.index("part" if "part" in heads else "pair")
        for column in range(len(heads)):
            stretched = column == wide
            head.setSectionResizeMode(column, QHeaderView.ResizeMode.Stretch if stretched else QHeaderView.ResizeMode.Fixed)
            table.setColumnWidth(column, 30 if heads[column] == "" else 84 if heads[column] == "matches" else 64)
            table.horizontalHeaderItem(column).setToolTip(HEAD_TIPS.get(heads[column], ""))
        table.horizontalHeaderItem(wide).setTextAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        return table

    def _panel(self) -> QTabWidget:
        tabs = QTabWidget(self)
        tabs.setFixedWidth(PANEL_WIDTH)
        tabs.setDocumentMode(True)
        tabs.tabBar().setDrawBase(False)
        tabs.tabBar().setFocusPolicy(Qt.FocusPolicy.TabFocus)
        tabs.addTab(self._filled("Click a part, here or on a shape, to see it in all shapes.", self.parts), "Parts")
        tabs.addTab(self._pairs_tab(), "Pairs")
        area = QScrollArea(self, widgetResizable=True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        area.setWidget(self.form)
        tabs.addTab(area, "Parameters")
        return tabs

    def _pairs_tab(self) -> QWidget:
        self.kind.addItems([KIND_WORDS[kind] for kind in KINDS])
        self.kind.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        row = QHBoxLayout()
        row.setSpacing(8)
        row.addWidget(QLabel("Support by", self))
        row.addWidget(self.kind, 1)
        tab = self._filled("Double-click a pair, or click the names of two shapes, to see their matches.", self.pairs)
        tab.layout().insertLayout(0, row)
        tab.layout().insertWidget(1, self.least)
        return tab

    def _filled(self, words: str, table: QTableWidget) -> QWidget:
        hint = QLabel(words, self, wordWrap=True)
        hint.setObjectName("soft")
        tab = QWidget(self)
        column = QVBoxLayout(tab)
        column.setContentsMargins(8, 8, 8, 8)
        column.setSpacing(8)
        column.addWidget(hint)
        column.addWidget(table, 1)
        if table is self.parts:
            self.notes.setObjectName("soft")
            self.notes.setTextFormat(Qt.TextFormat.PlainText)
            self.notes.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Minimum)
            column.addWidget(self.notes)
        return tab

    def _connect(self) -> None:
        self.session.changed.connect(self.apply)
        self.view.part_clicked.connect(lambda part: self.session.update(part=part))
        self.view.shape_clicked.connect(self.shape_clicked)
        self.parts.currentCellChanged.connect(lambda row, *_: self.session.update(part=row) if row >= 0 else None)
        self.pairs.cellActivated.connect(lambda row, _: self.pair_wanted.emit(row))
        self.kind.activated.connect(lambda row: self.edited.emit("support", KINDS[row], True))
        self.least.moved.connect(self.least_moved)
        self.form.edited.connect(self.edited)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Tell the grid how much of it is seen at once."""
        if event.type() == QEvent.Type.Resize:
            self.view.fit_into(QSize(event.size()))
        return False

    # --- what the state says

    def step_part(self, by: int) -> None:
        """Light up the next or previous part, and none between the last and the first."""
        state = self.session.state
        if state.found is not None:
            import numpy as np

            self.session.update(part=next_part(np.arange(state.found.part_count), state.part, by))

    def apply(self, old: CollectionState, state: CollectionState, names: frozenset[str]) -> None:
        """Draw the difference between two states."""
        found = state.found
        self.stack.setCurrentIndex(1 if state.scenes else 0)
        if "found" in names and (found is None or old.found is None):
            self.panel.setVisible(found is not None)
        if "dark" in names:
            self.view.set_theme(theme(state.dark))
        if names & {"scenes", "names"}:
            self.view.set_collection(state.scenes, state.names, state.parts)
        elif "found" in names:
            self.view.set_parts(state.parts)
        if "found" in names:
            self._show_parts(state)
            self._show_notes(state)
        if names & {"found", "least"}:
            self._show_pairs(state)
        if "parameters" in names:
            self.form.show_values(state.parameters, CollectionParameters())
            self.kind.setCurrentIndex(KINDS.index(state.parameters.support))
        if names & {"part", "found"}:
            self.view.set_lit(state.part)
            self._select(self.parts, state.part)
        if names & {"chosen", "found"}:
            self.view.set_chosen(state.chosen)

    def _show_parts(self, state: CollectionState) -> None:
        before = self.parts.blockSignals(True)
        rows = part_rows(state.found) if state.found is not None else []
        self.parts.setRowCount(len(rows))
        for row, (part, shapes, share) in enumerate(rows):
            swatch = QPixmap(16, 16)
            swatch.fill(QColor(*map(int, segment_colours(part + 1)[part])))
            first = QTableWidgetItem(QIcon(swatch), "")
            self.parts.setItem(row, 0, first)
            for column, text in enumerate((f"Part {part + 1}", str(shapes), share_text(share)), start=1):
                self.parts.setItem(row, column, _item(text, centred=column > 1))
        self.parts.blockSignals(before)

    def _show_pairs(self, state: CollectionState) -> None:
        rows = pair_rows(state.found, state.least) if state.found is not None else []
        before = self.pairs.blockSignals(True)
        self.pairs.setRowCount(len(rows))
        for row, (name, kept, total, mean) in enumerate(rows):
            matches = str(total) if kept == total else f"{kept} of {total}"
            for column, text in enumerate((name, matches, "–" if math.isnan(mean) else share_text(mean))):
                self.pairs.setItem(row, column, _item(text, centred=column > 0))
            self.pairs.item(row, 0).setToolTip(name)
        self.pairs.blockSignals(before)
        self.least.show_value(state.least)

    def _show_notes(self, state: CollectionState) -> None:
        lines = () if state.found is None else (*state.found.failures, *state.found.notes)
        metrics = self.notes.fontMetrics()
        self.notes.setText(short_notes(lines, lambda line: metrics.elidedText(line, Qt.TextElideMode.ElideRight, PANEL_WIDTH - 16)))
        self.notes.setToolTip("\n".join(lines))
        self.notes.setVisible(bool(lines))

    def _select(self, table: QTableWidget, row: int) -> None:
        before = table.blockSignals(True)
        if row < 0:
            table.clearSelection()
            table.setCurrentCell(-1, -1)
        else:
            table.setCurrentCell(row, 1)
            table.selectRow(row)
        table.blockSignals(before)

    def shutdown(self) -> None:
        """Give back what the view holds of the graphics system."""
        self.view.shutdown()


def _item(text: str, centred: bool) -> QTableWidgetItem:
    item = QTableWidgetItem(text)
    flat = Qt.AlignmentFlag.AlignHCenter if centred else Qt.AlignmentFlag.AlignLeft
    item.setTextAlignment(flat | Qt.AlignmentFlag.AlignVCenter)
    return item
