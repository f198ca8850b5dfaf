"""The page of results: one choice at the top, and below it what the votes of the open study say of that."""

from pathlib import Path
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFileDialog, QHBoxLayout, QLabel, QMenu, QPushButton, QStackedWidget, QVBoxLayout, QWidget

from annotation.study import StudyHandle
from annotation.tabletext import render
from engine.errors import ConcordError
from engine.store import write_atomically

from ..jobs import FOLLOW, Jobs
from ..session import Session, State
from .choice_bar import ChoiceBar
from .elided import ElidedLabel
from .judging import Judging
from .results_precision import PrecisionSection

NO_STUDY = "No study is open. Make one with Study > New study, or open one with Study > Open study."
READING = "Reading the votes …"
CHOICES = (("precision", "Precision"),)
EXPORTS = (("csv", "Table as &CSV…", "csv"), ("markdown", "Table as &Markdown…", "md"))


class ResultsPage(QWidget):
    """Reads what is chosen when it is shown, and again after each vote."""

    failed = Signal(str, str)
    said = Signal(str)

    def __init__(self, session: Session, judging: Judging, jobs: Jobs, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session, self.judging, self.jobs = session, judging, jobs
        self.precision = PrecisionSection(self)
        self.sections: dict[str, Any] = {"precision": self.precision}
        self.stack = QStackedWidget(self)
        for section in self.sections.values():
            self.stack.addWidget(section)
        self.empty = QLabel("", self, wordWrap=True, alignment=Qt.AlignmentFlag.AlignCenter)
        self.empty.setObjectName("placeholder")
        self.empty.setTextFormat(Qt.TextFormat.PlainText)
        self.stack.addWidget(self.empty)
        column = QVBoxLayout(self)
        column.setContentsMargins(16, 12, 16, 12)
        column.setSpacing(12)
        column.addLayout(self._head())
        column.addWidget(self.stack, 1)
        session.changed.connect(self.apply)
        judging.refreshed.connect(self._refresh_if_shown)
        self.apply(State(), session.state, frozenset(State.__slots__))

    def _head(self) -> QHBoxLayout:
        self.bar = ChoiceBar(CHOICES, self)
        self.bar.chosen.connect(self.choose)
        self.file = ElidedLabel("", self, "soft")
        self.export_button = QPushButton("Export", self)
        self.export_button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.export_menu = QMenu(self.export_button)
        for style, words, _ in EXPORTS:
            self.export_menu.addAction(words).triggered.connect(lambda _=False, style=style: self.ask_export(style))
        self.export_button.setMenu(self.export_menu)
        row = QHBoxLayout()
        row.setSpacing(16)
        row.addWidget(self.bar)
        row.addWidget(self.file, 1)
        row.addWidget(self.export_button)
        return row

    @property
    def content(self) -> Any:
        """What the table of precision shows."""
        return self.precision.content

    @property
    def delegate(self) -> Any:
        """What draws the intervals of the table of precision."""
        return self.precision.delegate

    def choose(self, name: str) -> None:
        """Show one of the sections."""
        self.bar.check(name)
        self.begin()

    def begin(self) -> None:
        """Read the votes and show what they say of what is chosen."""
        handle, name = self.judging.handle, self.bar.choice
        section = self.sections[name]
        if handle is None:
            self._show_empty(NO_STUDY)
            return
        if self.stack.currentWidget() is not section:
            self._show_empty(READING)

        def work(_: Any) -> Any:
            return read(section, handle)

        def done(content: Any) -> None:
            if self.judging.handle is handle and self.bar.choice == name:
                self._show(section, content)

        self.jobs.start("results", work, done, words="Reading the votes", policy=FOLLOW)

    def _show(self, section: Any, content: Any) -> None:
        if section.show_content(content):
            self.stack.setCurrentWidget(section)
        else:
            self._show_empty(section.empty)

    def _show_empty(self, sentence: str) -> None:
        self.empty.setText(sentence)
        self.stack.setCurrentWidget(self.empty)

    def _refresh_if_shown(self) -> None:
        if self.isVisible():
            self.begin()

    def ask_export(self, style: str) -> None:
        """Ask where to, and write the table."""
        ending = next(ending for name, _, ending in EXPORTS if name == style)
        path, _ = QFileDialog.getSaveFileName(self, "Export the table", f"precision.{ending}", f"*.{ending}")
        if path:
            self.export(Path(path), style)

    def export(self, path: Path, style: str) -> None:
        """Write the table in a style; a message where that cannot be."""
        try:
            write_atomically(path, render(self.content.rows, self.content.votes, style))
        except ConcordError as error:
            self.failed.emit(str(error), "")
        else:
            self.said.emit(f"Table written to {path}")

    def apply(self, _old: State, state: State, names: frozenset[str]) -> None:
        """Follow the theme and the study file."""
        if "dark" in names:
            for section in self.sections.values():
                section.set_dark(state.dark)
        if "study" in names:
            self.file.setText(state.study)
            self._refresh_if_shown()

    def shutdown(self) -> None:
        """Give back what the sections hold of the graphics system."""
        for section in self.sections.values():
            section.shutdown()


def read(section: Any, handle: StudyHandle) -> Any:
    """What a section shows of a study."""
    return section.read(handle)
