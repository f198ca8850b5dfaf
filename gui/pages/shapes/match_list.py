"""The list of matches: state, segments, score, votes, layers; the selected row is the session's selected match."""

from typing import Any

from PySide6.QtCore import QAbstractTableModel, QItemSelectionModel, QModelIndex, Qt, Signal
from PySide6.QtGui import QColor, QIcon, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableView, QWidget

from engine.shapes.result import Match

from ...actions import icon
from ...palette import theme
from ...session import State
from .arrange import (
    ORDERS,
    SYMBOLS,
    any_known,
    empty_words,
    forbidden,
    listed,
    match_text,
    score_help,
    share_text,
    short_text,
    state_of,
    support_text,
)

_HEADS = ("", "match", "score", "votes", "layers", "support")
_SUPPORT, _LAYERS = 5, 4
_TIPS = ("What the majority of volunteers says", "Segments of the source → segments of the target",
         "", "Votes: how many other matches contain it on both sides",
         "Layer of the source's node – layer of the target's",
         "How far the other shapes of the collection agree")  # fmt: skip


class MatchModel(QAbstractTableModel):
    """The listed matches of a state, as rows."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.state = State()
        self.rows: list[Match] = []

    def show_state(self, state: State, structure: bool) -> None:
        """Take over a state; `structure` says that rows come, go or move, else only their texts change."""
        if structure:
            self.beginResetModel()
        self.state = state
        self.rows = listed(state) if structure else self.rows
        if structure:
            self.endResetModel()
        elif self.rows:
            self.dataChanged.emit(self.index(0, 0), self.index(len(self.rows) - 1, len(_HEADS) - 1))

    def rowCount(self, parent: QModelIndex | None = None) -> int:
        return 0 if parent is not None and parent.isValid() else len(self.rows)

    def columnCount(self, parent: QModelIndex | None = None) -> int:
        return 0 if parent is not None and parent.isValid() else len(_HEADS)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if orientation != Qt.Orientation.Horizontal:
            return None
        if role == Qt.ItemDataRole.ToolTipRole:
            method = self.state.parameters.method if self.state.result is None else self.state.result.method
            return (_TIPS[section] or score_help(method)) + "; click to sort"
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _alignment(section)
        return _HEADS[section] if role == Qt.ItemDataRole.DisplayRole else None

    def data(self, index: QModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        match = self.rows[index.row()]
        judged = state_of(match.id, self.state.verdicts)
        if role == Qt.ItemDataRole.DisplayRole:
            return self._text(match, index.column(), judged)
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _alignment(index.column())
        if role == Qt.ItemDataRole.DecorationRole and index.column() == 1:
            return self._wish_icon(match)
        if role == Qt.ItemDataRole.ForegroundRole and forbidden(match) and index.column():
            return QColor(theme(self.state.dark).soft_ink)
        if role == Qt.ItemDataRole.ForegroundRole and index.column() == 0:
            return QColor(theme(self.state.dark).state(judged))
        if role == Qt.ItemDataRole.ToolTipRole:
            own = self.state.answers.get(match.id, "not judged yet")
            wish = "\npinned: it comes in any case" if match.pinned else "\nforbidden: it does not come" if forbidden(match) else ""
            return f"{match_text(match, self.state.result)}\nmajority: {judged} · you: {own}{wish}"
        return None

    def _wish_icon(self, match: Match) -> QIcon | None:
        colours = theme(self.state.dark)
        if match.pinned:
            return icon("mdi6.pin", colours.ink)
        return icon("mdi6.cancel", colours.state("wrong")) if forbidden(match) else None

    def _text(self, match: Match, column: int, judged: str) -> str:
        symbol = SYMBOLS[judged]
        if judged == "undecided" and self.state.answers.get(match.id) == "unsure":
            symbol = SYMBOLS["unsure"]
        if forbidden(match):
            return (symbol, short_text(match, self.state.result), "", "", "", "")[column]
        layers = f"{match.source_layer}–{match.target_layer}"
        return (symbol, short_text(match, self.state.result), share_text(match.score), str(match.votes), layers,
                support_text(match.id, self.state.support))[column]


def _alignment(column: int) -> Qt.AlignmentFlag:
    flat = Qt.AlignmentFlag.AlignLeft if column == 1 else Qt.AlignmentFlag.AlignHCenter
    return flat | Qt.AlignmentFlag.AlignVCenter


class MatchList(QTableView):
    """Shows a `MatchModel`; says which match was picked and which heading was clicked."""

    picked = Signal(str)
    ordered = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.rows = MatchModel(self)
        self.setModel(self.rows)
        self.setObjectName("matches")
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setShowGrid(False)
        self.setTabKeyNavigation(False)
        self.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(26)
        self._head()
        self.selectionModel().currentRowChanged.connect(self._current)

    def _head(self) -> None:
        head = self.horizontalHeader()
        head.setHighlightSections(False)
        head.setSectionsClickable(True)
        head.setMinimumSectionSize(24)
        for column, width in ((0, 26), (2, 44), (3, 42), (4, 44), (_SUPPORT, 56)):
            head.setSectionResizeMode(column, QHeaderView.ResizeMode.Fixed)
            self.setColumnWidth(column, width)
        head.setSectionResizeMode(1, QHeaderView.ResizeMode.Stretch)
        head.sectionClicked.connect(self._sort)

    def _sort(self, column: int) -> None:
        now, wanted = self.rows.state.order, ORDERS[column]
        self.ordered.emit(f"-{wanted}" if now == wanted else wanted)

    def _current(self, index: QModelIndex, _before: QModelIndex) -> None:
        if index.isValid():
            self.picked.emit(self.rows.rows[index.row()].id)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Keep the selected match in sight when what stands below the list takes more room."""
        super().resizeEvent(event)
        if self.currentIndex().isValid():
            self.scrollTo(self.currentIndex())

    def paintEvent(self, event: QPaintEvent) -> None:
        """An empty list says why."""
        super().paintEvent(event)
        words = "" if self.rows.rows else empty_words(self.rows.state)
        if words:
            painter = QPainter(self.viewport())
            painter.setPen(QColor(theme(self.rows.state.dark).soft_ink))
            room = self.viewport().rect().adjusted(16, 16, -16, -16)
            painter.drawText(room, Qt.AlignmentFlag.AlignHCenter | Qt.TextFlag.TextWordWrap, words)
            painter.end()

    def keyboardSearch(self, search: str) -> None:
        """Letters are for judging here, not for jumping to a row."""

    def show_state(self, state: State, structure: bool) -> None:
        """Display the matches and the selection of a state without telling anybody."""
        model = self.selectionModel()
        before = model.blockSignals(True)
        supported = any_known((m.id for m in state.matches()), state.support)
        self.setColumnHidden(_SUPPORT, not supported)
        self.setColumnHidden(_LAYERS, supported)  # there is room for one of the two; the reasons name the layers
        self.rows.show_state(state, structure)
        row = next((k for k, m in enumerate(self.rows.rows) if m.id == state.selected), -1)
        if row < 0:
            model.clear()
        elif structure or self.currentIndex().row() != row:
            index = self.rows.index(row, 0)
            flags = QItemSelectionModel.SelectionFlag
            model.setCurrentIndex(index, flags.ClearAndSelect | flags.Rows)
            self.scrollTo(index)
        model.blockSignals(before)
        self.viewport().update()
