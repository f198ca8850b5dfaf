"""First step of a new study: which results are judged. What the window shows stands there already."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFileDialog, QHBoxLayout, QLabel, QPushButton, QTableWidgetItem, QVBoxLayout, QWidget

from engine.progress import Progress

from ..quiet_table import quiet_table
from .sources import Source, counts_text, read_source, study_source

HEADS = ("results", "set", "holds")
_TIPS = {"set": "Rows of the precision table; click twice to give another name", "results": "Ticked results are judged"}
READ = "Results (matches.json solution.json);;JSON files (*.json)"
STUDIES = "Studies (*.db *.study);;All files (*)"
Reader = Callable[[Callable[[Progress], Source], str], None]
"""Reads a source in a job: the work, and the words of its progress."""


class ResultsStep(QWidget):
    """A list of results with ticks; more from files, folders and studies."""

    changed = Signal()

    def __init__(self, sources: Sequence[Source], reader: Reader, folder: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.reader, self.folder = reader, folder
        self.sources: list[Source] = []
        self.table = quiet_table(HEADS, 3, "holds", self, _TIPS)
        self.table.setEditTriggers(self.table.EditTrigger.DoubleClicked | self.table.EditTrigger.EditKeyPressed)
        self.table.itemChanged.connect(lambda _: self.changed.emit())
        self.table.horizontalHeader().setSectionResizeMode(0, self.table.horizontalHeader().ResizeMode.Interactive)
        self.table.setColumnWidth(0, 230)
        self.empty = QLabel("Nothing is matched or solved in the window yet. Add files that Concord has written, a folder of "
                            "them, or the results of another study.", self, wordWrap=True)  # fmt: skip
        self.empty.setObjectName("soft")
        self.busy = QLabel("", self)
        self.busy.setObjectName("soft")
        row = QHBoxLayout()
        row.setSpacing(8)
        self.buttons = {}
        for name, words, handler in (("files", "Add &files…", self.ask_files), ("folder", "Add a f&older…", self.ask_folder),
                                     ("study", "From another &study…", self.ask_study)):  # fmt: skip
            self.buttons[name] = QPushButton(words, self, autoDefault=False)
            self.buttons[name].clicked.connect(lambda _=False, handler=handler: handler())
            row.addWidget(self.buttons[name])
        row.addWidget(self.busy, 1)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(12)
        column.addWidget(self.empty)
        column.addWidget(self.table, 1)
        column.addLayout(row)
        column.addStretch(0)  # takes the room of the table while there is none
        self.add_all(sources)

    def add_all(self, sources: Sequence[Source]) -> None:
        """Put several results into the list."""
        self.busy.setText("")
        for source in sources:
            self.add(source)
        self._show()

    def add(self, source: Source) -> None:
        """Put results into the list, ticked."""
        before = self.table.blockSignals(True)
        line = self.table.rowCount()
        self.table.setRowCount(line + 1)
        sets = list(dict.fromkeys(run.set_name for run in source.runs))
        for column, text in enumerate((source.title, sets[0] if len(sets) == 1 else f"{len(sets)} sets", "  " + counts_text([source]))):
            item = QTableWidgetItem(text)
            flags = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
            item.setToolTip(text)
            if column == 0:
                flags |= Qt.ItemFlag.ItemIsUserCheckable
                item.setCheckState(Qt.CheckState.Checked)
            elif column == 1 and len(sets) == 1:
                flags |= Qt.ItemFlag.ItemIsEditable
            item.setFlags(flags)
            self.table.setItem(line, column, item)
        self.table.blockSignals(before)
        self.sources.append(source)
        self.busy.setText("")
        self._show()
        self.changed.emit()

    def look(self, words: str) -> None:
        """Say that something is looked for."""
        self.busy.setText(words)
        self._show()

    def _show(self) -> None:
        self.empty.setVisible(not self.sources and not self.busy.text())
        self.table.setVisible(bool(self.sources))

    def chosen(self) -> tuple[Source, ...]:
        """The ticked results, under the sets that they were given."""
        found = []
        for line, source in enumerate(self.sources):
            if self.table.item(line, 0).checkState() == Qt.CheckState.Checked:
                found.append(renamed(source, self.table.item(line, 1)))
        return tuple(found)

    def key(self) -> tuple[tuple[bool, str], ...]:
        """What is chosen, to see whether it has changed."""
        cells = ((self.table.item(line, 0), self.table.item(line, 1)) for line in range(self.table.rowCount()))
        return tuple((tick.checkState() == Qt.CheckState.Checked, name.text()) for tick, name in cells)

    def ask_files(self) -> None:
        """Ask for files of results."""
        paths, _ = QFileDialog.getOpenFileNames(self, "Results to be judged", self.folder, READ)
        for path in paths:
            self.read(Path(path))

    def ask_folder(self) -> None:
        """Ask for a folder that holds files of results, at any depth."""
        path = QFileDialog.getExistingDirectory(self, "Folder of results", self.folder)
        if path:
            self.read(Path(path))

    def ask_study(self) -> None:
        """Ask for another study, whose results may be judged again."""
        path, _ = QFileDialog.getOpenFileName(self, "Study whose results are judged again", self.folder, STUDIES)
        if path:
            self._start(lambda progress: study_source(Path(path), progress), Path(path).name)

    def read(self, path: Path) -> None:
        """Read a file or a folder in a job and put it into the list."""
        self._start(lambda progress: read_source(path, progress), path.name)

    def _start(self, work: Callable[[Progress], Source], name: str) -> None:
        self.look(f"Reading {name} …")
        self.reader(work, f"Reading {name}")


def renamed(source: Source, item: QTableWidgetItem | None) -> Source:
    """A source under the set name that stands in its cell; one of several sets keeps them."""
    if item is None or not item.flags() & Qt.ItemFlag.ItemIsEditable:
        return source
    name = item.text().strip()
    return source._replace(runs=tuple(replace(run, set_name=name) for run in source.runs))


def problem(sources: Sequence[Source]) -> str:
    """Why a study cannot be made of these results, or ''."""
    if not sources:
        return "Tick the results that are to be judged, or add some."
    kinds: set[Any] = {run.kind for source in sources for run in source.runs}
    return "" if kinds else "The ticked results hold no match."
