"""Tables without lines: words to the left, figures centred under their heads, as high as their rows."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableWidget, QTableWidgetItem, QWidget

ROW_HEIGHT = 32
_LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
_MIDDLE = Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignVCenter


def quiet_table(heads: Sequence[str], words: int, wide: str, parent: QWidget, tips: Mapping[str, str] | None = None) -> QTableWidget:
    """A table to read: its first `words` columns hold words; the column `wide` (none if "") takes the room that is left."""
    table = QTableWidget(0, len(heads), parent)
    table.setHorizontalHeaderLabels([f"  {head}  " for head in heads])
    for column, head in enumerate(heads):
        table.horizontalHeaderItem(column).setToolTip((tips or {}).get(head, ""))
        if column < words:
            table.horizontalHeaderItem(column).setTextAlignment(_LEFT)
    table.verticalHeader().hide()
    table.verticalHeader().setDefaultSectionSize(ROW_HEIGHT)
    table.setShowGrid(False)
    table.setWordWrap(False)
    table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
    table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
    table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
    table.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
    table.setFocusPolicy(Qt.FocusPolicy.TabFocus)
    head = table.horizontalHeader()
    head.setHighlightSections(False)
    head.setMinimumSectionSize(32)
    head.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
    if wide:
        head.setSectionResizeMode(list(heads).index(wide), QHeaderView.ResizeMode.Stretch)
    return table


@contextmanager
def still_columns(table: QTableWidget) -> Iterator[None]:
    """Fit the columns once after many cells are changed; otherwise each change has a whole column measured again."""
    head = table.horizontalHeader()
    modes = [head.sectionResizeMode(column) for column in range(head.count())]
    for column in range(head.count()):
        head.setSectionResizeMode(column, QHeaderView.ResizeMode.Fixed)
    try:
        yield
    finally:
        for column, mode in enumerate(modes):
            head.setSectionResizeMode(column, mode)


def fill(table: QTableWidget, rows: Sequence[Sequence[str]], words: int, *, fitted: bool = True) -> None:
    """Replace the rows by these texts; `fitted` makes the table no higher than they need."""
    table.setRowCount(len(rows))
    with still_columns(table):
        for line, cells in enumerate(rows):
            for column, text in enumerate(cells):
                item = QTableWidgetItem(f"  {text}  " if text else "")
                item.setTextAlignment(_LEFT if column < words else _MIDDLE)
                table.setItem(line, column, item)
    if fitted:
        height = table.verticalHeader().defaultSectionSize()
        table.setMaximumHeight(table.horizontalHeader().sizeHint().height() + height * len(rows) + 4)


def fit_width(table: QTableWidget) -> None:
    """Make a table without a wide column no wider than its columns."""
    table.resizeColumnsToContents()
    table.setMaximumWidth(table.horizontalHeader().length() + 4)


def row_texts(table: QTableWidget, line: int) -> tuple[str, ...]:
    """The texts of one row, as they were filled in."""
    return tuple(table.item(line, column).text().strip() for column in range(table.columnCount()))
