"""A new study in six steps with one decision each: results, question, votes, sample, checks, place."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QDialog,
    QFrame,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QScrollArea,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from annotation.design.designing import Design, Plan, draw_design
from annotation.records import Practice
from engine.errors import BadInput, ConcordError
from engine.parameters import checked
from engine.progress import Progress

from .calculator import SampleStep, expected_of
from .sources import Source, counts_text, plan_text, truth_of, truth_text
from .wizard_results import ResultsStep, problem
from .wizard_steps import ChecksStep, FormStep, Place, PlaceStep

STEPS = (
    ("results", "Results", "What is to be judged?",
     "Every distinct match is asked once, whichever methods proposed it."),
    ("question", "Question", "What are volunteers asked?",
     "One sentence, answered by correct or wrong. The guideline is one key away while they vote."),
    ("votes", "Votes", "How many look at each match?",
     "Two votes, and a third only where they differ, settle as much as three always do, with a quarter fewer votes."),
    ("sample", "Sample", "How many matches are needed?",
     "All of them, or a sample in proportion from every pair. Beside it, what the number buys."),
    ("checks", "Checks", "Are some answers known?",
     "Known matches make practice for beginners, and gold matches that show who pays attention. Nobody sees which they are."),
    ("place", "Create", "Where is the study kept?", ""),
)  # fmt: skip


class Wanted(NamedTuple):
    """Everything that a study is made of."""

    sources: tuple[Source, ...]
    design: Design
    gold: dict[str, Practice]
    place: Place


Run = Callable[[Callable[[Progress], Any], Callable[[Any], None], str, Callable[[str, str], None]], None]
"""Does some work in a job: the work, who takes its answer, words, who takes an error."""


class StudyWizard(QDialog):
    """Collects what a study is made of; says `wanted` when all is right, and stays open until it was made."""

    wanted = Signal(object)

    def __init__(self, sources: Sequence[Source], run: Run, own: Callable[[], dict[str, Practice]] | None, folder: str,
                 parent: QWidget | None = None) -> None:  # fmt: skip
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle("New study")
        self.setObjectName("calm")
        self.resize(940, 620)
        self.run, self.own, self.gone = run, own, False
        self.known: dict[str, Practice] = {}
        self.plan: Plan | None = None
        self._counted, self._planned, self._told, self._sources = None, None, None, ()
        self._truth: tuple[Any, dict[str, Practice] | None] = (None, None)  # of which results; nothing while it is read
        self.results = ResultsStep(sources, self._read, folder, self)
        self.question = FormStep(("question", "guideline", "unsure"), self)
        self.votes = FormStep(("votes", "adaptive", "overlap"), self)
        self.sample = SampleStep(self)
        self.checks = ChecksStep(own is not None, folder, self)
        self.place = PlaceStep(folder, self)
        self.steps = (self.results, self.question, self.votes, self.sample, self.checks, self.place)
        self._lay_out()
        for step in self.steps:
            step.changed.connect(self._changed)
        self.finished.connect(self._go)
        self.show_step(0)

    def _lay_out(self) -> None:
        rail = QFrame(self)
        rail.setObjectName("wizard-rail")
        rail.setFixedWidth(168)
        self.marks: list[QPushButton] = []
        column = QVBoxLayout(rail)
        column.setContentsMargins(12, 20, 12, 12)
        column.setSpacing(4)
        for number, (_, words, _, _) in enumerate(STEPS):
            mark = QPushButton(f"{number + 1}   {words}", rail, checkable=True, autoDefault=False)
            mark.setObjectName("wizard-step")
            mark.clicked.connect(lambda _=False, number=number: self.go(number))
            column.addWidget(mark)
            self.marks.append(mark)
        column.addStretch(1)
        self.heading, self.lead = QLabel("", self), QLabel("", self, wordWrap=True)
        self.heading.setObjectName("page-heading")
        self.lead.setObjectName("soft")
        self.stack = QStackedWidget(self)
        for step in self.steps:
            area = QScrollArea(self, widgetResizable=True)
            area.setFrameShape(QFrame.Shape.NoFrame)
            area.setWidget(step)
            self.stack.addWidget(area)
        self.error = QLabel("", self, wordWrap=True)
        self.error.setObjectName("field-error")
        self.error.setTextFormat(Qt.TextFormat.PlainText)
        right = QVBoxLayout()
        right.setContentsMargins(24, 20, 24, 16)
        right.setSpacing(12)
        for widget, stretch in ((self.heading, 0), (self.lead, 0), (self.stack, 1), (self.error, 0)):
            right.addWidget(widget, stretch)
        right.addLayout(self._buttons())
        whole = QHBoxLayout(self)
        whole.setContentsMargins(0, 0, 0, 0)
        whole.setSpacing(0)
        whole.addWidget(rail)
        whole.addLayout(right, 1)

    def _buttons(self) -> QHBoxLayout:
        self.count = QLabel("", self)
        self.count.setObjectName("soft")
        self.cancel, self.back = QPushButton("Cancel", self, autoDefault=False), QPushButton("&Back", self, autoDefault=False)
        self.next = QPushButton("&Next", self, default=True)
        self.cancel.clicked.connect(self.reject)
        self.back.clicked.connect(lambda: self.show_step(self.number - 1))
        self.next.clicked.connect(self.forward)
        row = QHBoxLayout()
        row.setSpacing(8)
        row.addWidget(self.count, 1)
        for button in (self.cancel, self.back, self.next):
            row.addWidget(button)
        return row

    # --- going from step to step

    @property
    def number(self) -> int:
        """The step that is shown."""
        return self.stack.currentIndex()

    def show_step(self, number: int) -> None:
        """Show a step."""
        self.stack.setCurrentIndex(number)
        _, _, heading, lead = STEPS[number]
        self.heading.setText(heading)
        self.lead.setText(lead)
        self.lead.setVisible(bool(lead))
        for k, mark in enumerate(self.marks):
            mark.setChecked(k == number)
        self.back.setEnabled(number > 0)
        self.next.setText("&Create the study" if number == len(STEPS) - 1 else "&Next")
        self._changed()

    def go(self, number: int) -> None:
        """Go to a step by its name; forward only past steps that are in order."""
        while self.number < number:
            before = self.number
            self.forward()
            if self.number == before:
                break
        if self.number > number:
            self.show_step(number)
        for k, mark in enumerate(self.marks):
            mark.setChecked(k == self.number)

    def forward(self) -> None:
        """Go to the next step, or make the study; what is wrong is said at its field."""
        sentence = self._problem()
        self._say(sentence)
        if sentence:
            return
        if self.number < len(STEPS) - 1:
            self.show_step(self.number + 1)
            return
        self.next.setEnabled(False)
        self.count.setText("Making the study …")
        self.wanted.emit(Wanted(self.results.chosen(), self.design(), self.known, self.place.place))

    def _problem(self) -> str:
        """Why the shown step cannot be left, or ''."""
        step = self.steps[self.number]
        try:
            if step is self.results:
                return problem(self.results.chosen())
            if step is self.question and not self.question.values()["question"].strip():
                return "A study asks something; write the 'question'."
            if step is self.checks:
                self.known = self._known()
            if step is self.place:
                return self.place.place.problem()
            self.design()
        except ConcordError as error:
            return str(error)
        return ""

    def _say(self, sentence: str) -> None:
        """Show what is wrong where it is wrong."""
        step = self.steps[self.number]
        form, path = getattr(step, "form", None), getattr(step, "path", None)
        at_field = form is not None and form.show_error(sentence)
        if path is not None:
            path.show_error("" if at_field else sentence)
        self.error.setText("" if at_field or (path is not None and path.isVisible()) else sentence)

    def failed(self, sentence: str) -> None:
        """The study could not be made: say why, and let it be changed."""
        self.next.setEnabled(True)
        self.count.setText(counts_text(self._sources))
        self._say(sentence)

    # --- what was chosen

    def design(self) -> Design:
        """The design, checked; raises `BadParameter` in one sentence."""
        values: dict[str, Any] = {}
        for step in self.steps[1:]:
            values |= step.values()
        return checked(Design, values)

    def _known(self) -> dict[str, Practice]:
        from annotation.design.knownanswers import read_known

        way = self.checks.source.choice
        if way == "truth":
            if self._truth[1] is None:
                raise BadInput("The truth is still being read; go on when it is there.")
            if not self._truth[1]:
                raise BadInput("No truth came along with these results; choose another source of answers, or none.")
            return self._truth[1]
        if way == "csv":
            return read_known(Path(self.checks.path.line.text().strip() or "answers.csv"))
        return self.own() if way == "own" and self.own is not None else {}

    def _changed(self) -> None:
        """Count anew what is chosen, and what it will cost; what is large is gone through only when it has changed."""
        key = self.results.key()
        if key != self._counted:
            self._counted, self._sources = key, self.results.chosen()
            self.count.setText(counts_text(self._sources) if self._sources else "")
        self.error.setText("")
        values = self.votes.values()
        self.votes.form.rows["overlap"].setEnabled(values["adaptive"] and values["votes"] > 2)
        self.votes.form.rows["adaptive"].setEnabled(values["votes"] > 2)
        if self.steps[self.number] is self.checks and self.checks.source.choice == "truth":
            self._read_truth()
        if self.number >= 3:
            self._plan()

    def _read_truth(self) -> None:
        """Read the answers that came along with what is ticked, unless that was done."""
        key, sources = self._counted, self._sources
        if self._truth[0] == key:
            return
        self._truth = key, None
        self.checks.told.setText("Reading the truth …")

        def done(known: dict[str, Practice]) -> None:
            if not self.gone and self._truth[0] == key:
                self._truth = key, known
                self.checks.told.setText(truth_text(known))
                self._say("")

        def failed(sentence: str, _: str) -> None:
            if not self.gone and self._truth[0] == key:
                self._truth = None, None
                self.checks.told.setText(sentence)

        self.run(lambda progress: truth_of(sources, progress), done, "Reading the truth", failed)

    def _plan(self) -> None:
        """Draw what would be asked, and say what that costs."""
        runs = [run for source in self._sources for run in source.runs]
        try:
            design = self.design()
            key = (self._counted, design.changed(name="", question="", guideline=""), id(self.known))
            if key != self._planned:
                self._planned, self.plan = key, draw_design(runs, design, gold=self.known)
                self.sample.show_plan(runs, self.plan, design)
            if self._told == (key, self.sample.expected):
                return
            self._told = key, self.sample.expected
            cost = expected_of(self.plan, design, self.sample.expected)
            self.place.summary.setText(plan_text(self._sources, self.plan, cost))
        except ConcordError:
            return

    def _read(self, work: Callable[[Progress], Source], words: str) -> None:
        def done(source: Source) -> None:
            if not self.gone:
                self.results.add(source)

        def failed(sentence: str, _: str) -> None:
            if not self.gone:
                self.results.look("")
                self.error.setText(sentence)

        self.run(work, done, words, failed)

    def _go(self, _: int) -> None:
        self.gone = True
