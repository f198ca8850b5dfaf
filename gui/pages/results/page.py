"""The page of results: one choice at the top, and below it what the votes of the open study say of that."""

from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QMenu, QPushButton, QStackedWidget, QVBoxLayout, QWidget

from annotation.findings.gathering import Findings, findings
from annotation.study import StudyHandle

from ...jobs import FOLLOW, Jobs
from ...session import Session, State
from ..choice_bar import ChoiceBar
from ..elided import ElidedLabel
from ..judging import Judging
from ..study.volunteers import VolunteersSection
from ..voting.questions import Shapes
from .disputed import DisputedSection
from .match_preview import read_match
from .precision import PrecisionSection
from .tables import TablesSection

NO_STUDY = "No study is open. Make one with Study > New study, or open one with Study > Open study."
ONE_VOLUNTEER = "This is what one volunteer is asked. Results are shown where the whole study is open."
NO_AGREEMENT = "No match has been judged by two volunteers yet; agreement shows once a second one votes."
NO_COMPARISON = ("There are no two methods with judged matches on the same pairs yet. Match the same pairs with another preset, "
                 "and put what it finds into the study with Study > Top up.")  # fmt: skip
READING = "Reading the votes …"
CHOICES = (("precision", "Precision"), ("agreement", "Agreement"), ("compared", "Methods compared"), ("disputed", "Disputed"),
           ("volunteers", "Volunteers"))  # fmt: skip


class ResultsPage(QWidget):
    """Reads what is chosen when it is shown, and again after each vote."""

    failed = Signal(str, str)

    def __init__(self, session: Session, judging: Judging, jobs: Jobs, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session, self.judging, self.jobs = session, judging, jobs
        self.precision = PrecisionSection(self)
        self.agreement = TablesSection(("agreement", "volunteers", "sensitivity"), NO_AGREEMENT, self)
        self.compared = TablesSection(("compared",), NO_COMPARISON, self)
        self.disputed, self.volunteers = DisputedSection(self), VolunteersSection(self)
        self.sections: dict[str, Any] = {name: getattr(self, name) for name, _ in CHOICES}
        self._known: tuple[StudyHandle, Findings] | None = None
        self._kept: Shapes = {}
        self._votes = 0  # counts how often votes were read
        self.stack = QStackedWidget(self)
        for section in self.sections.values():
            self.stack.addWidget(section)
        self.empty = QLabel("", self, wordWrap=True, alignment=Qt.AlignmentFlag.AlignCenter)
        self.empty.setObjectName("placeholder")
        self.empty.setTextFormat(Qt.TextFormat.PlainText)
        self.stack.addWidget(self.empty)
        self.stack.setCurrentWidget(self.empty)
        column = QVBoxLayout(self)
        column.setContentsMargins(16, 12, 16, 12)
        column.setSpacing(12)
        column.addLayout(self._head())
        column.addWidget(self.stack, 1)
        session.changed.connect(self.apply)
        judging.refreshed.connect(self._refresh)
        self.disputed.picked.connect(self._show_match)
        self.precision.thesis.toggled.connect(lambda _: self.begin())
        self.apply(State(), session.state, frozenset(State.__slots__))

    def _head(self) -> QHBoxLayout:
        self.bar = ChoiceBar(CHOICES, self)
        self.bar.chosen.connect(self.choose)
        self.file = ElidedLabel("", self, "soft")
        self.export_button = QPushButton("Export", self)
        self.export_button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.export_menu = QMenu(self.export_button)
        self.export_button.setMenu(self.export_menu)
        row = QHBoxLayout()
        row.setSpacing(16)
        row.addWidget(self.bar)
        row.addWidget(self.file, 1)
        row.addWidget(self.export_button)
        return row

    @property
    def section(self) -> str:
        """The section that is exported alone."""
        return self.bar.choice

    @property
    def preset(self) -> str:
        """The table of precision that was asked for."""
        return "thesis" if self.precision.thesis.isChecked() else "modern"

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
        if handle.volunteer is not None:
            self._show_empty(ONE_VOLUNTEER)
            return
        known = self._known[1] if self._known is not None and self._known[0] is handle else None
        if self.stack.currentWidget() is not section:
            self._show_empty(READING)

        plain, preset = name != "precision" or self.preset == "modern", self.preset

        def work(_: Any) -> tuple[Any, Findings | None]:
            if hasattr(section, "read") and plain:
                return section.read(handle), known
            found = known or findings(handle)
            return found._replace(preset=preset), found

        votes = self._votes

        def done(answer: tuple[Any, Findings | None]) -> None:
            if self.judging.handle is not handle:
                return
            if answer[1] is not None and self._votes == votes:  # otherwise somebody voted meanwhile
                self._known = handle, answer[1]
            if self.bar.choice == name:
                self._show(section, answer[0])

        self.jobs.start("results", work, done, words="Reading the votes", policy=FOLLOW)

    def _show(self, section: Any, content: Any) -> None:
        if section.show_content(content):
            self.stack.setCurrentWidget(section)
        else:
            self._show_empty(section.empty)

    def _show_empty(self, sentence: str) -> None:
        self.empty.setText(sentence)
        self.stack.setCurrentWidget(self.empty)

    def _show_match(self, item: str) -> None:
        """Find the picture of a disputed match in the worker."""
        handle, kept = self.judging.handle, self._kept

        def done(found: Any) -> None:
            if self.disputed.chosen == item:
                self.disputed.preview.show_match(found)

        if handle is not None:
            self.jobs.start("picture", lambda _: read_match(handle, item, kept), done, policy=FOLLOW)

    def _refresh(self) -> None:
        self._known, self._votes = None, self._votes + 1
        if self.isVisible():
            self.begin()

    def apply(self, _old: State, state: State, names: frozenset[str]) -> None:
        """Follow the theme and the study file."""
        if "dark" in names:
            for section in self.sections.values():
                section.set_dark(state.dark)
        if "study" in names:
            self.file.setText(state.study)
            self._refresh()

    def shutdown(self) -> None:
        """Give back what the sections hold of the graphics system."""
        for section in self.sections.values():
            section.shutdown()
