"""How many matches to ask, and beside it a calculator: what a wanted interval takes, and what the results at hand give."""

from collections import Counter
from collections.abc import Sequence
from typing import Any, NamedTuple

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from annotation.design.designing import Design, Plan
from annotation.design.planning import Expectations, Needed, interval_of, needed, votes_each
from annotation.records import Run
from engine.errors import ConcordError
from engine.parameters import checked

from ..shapes.arrange import share_text
from .design_form import DesignForm
from .sources import hours_text

CAPTIONS = {
    "half_width": "Half width of the interval", "confidence": "Confidence", "precision": "Precision expected",
    "per_pair": "Matches a pair", "correlation": "Correlation within a pair", "volunteers": "Volunteers",
    "disagreement": "Two volunteers differ on", "abstention": "Votes that are unsure", "seconds": "Time a vote",
}  # fmt: skip
SAMPLE_CAPTIONS = {"most": "Most matches asked (0: all)", "seed": "Seed of all draws"}


class Expected(NamedTuple):
    """What a plan is expected to cost: votes of all together, and hours of each volunteer."""

    votes: float
    hours: float
    volunteers: int


def expected_of(plan: Plan, design: Design, expected: Expectations) -> Expected:
    """The cost of a plan, by the rules of who is asked."""
    roles = Counter(row.role for row in plan.asked)
    people = expected.volunteers
    k = design.votes or people
    every, fewer = (votes_each(k, adaptive, expected.disagreement, expected.abstention, people) for adaptive in (False, True))
    twice = sum(row.overlapped for row in plan.asked if row.role == "judged")
    once = roles["judged"] - twice
    judged = twice * every + once * (fewer if design.adaptive and design.votes else every)
    votes = judged + people * (roles["gold"] + roles["practice"])
    return Expected(votes, votes * expected.seconds / 3600 / people, people)


def needed_text(found: Needed, expected: Expectations) -> str:
    """What a wanted interval takes, in a few lines."""
    return (f"{found.pairs} pairs with {found.matches} matches, expected to give "
            f"[{share_text(found.low)},\u00a0{share_text(found.high)}]\n"
            f"about {found.votes} votes, {hours_text(found.hours_each)} for each of {expected.volunteers}")  # fmt: skip


def given_text(matches: int, pairs: int, expected: Expectations) -> str:
    """What the matches at hand are expected to give."""
    if pairs < 2:
        return "One pair alone tells nothing of others: results of more pairs are needed for an interval."
    low, high = interval_of(pairs, expected.changed(per_pair=max(1.0, min(matches / pairs, 10_000.0))))
    return f"Your {matches} matches on {pairs} pairs are expected to give [{share_text(low)},\u00a0{share_text(high)}]."


class SampleStep(QWidget):
    """The size of the sample, and the calculator."""

    changed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.form = DesignForm(Design, ("most", "seed"), self, SAMPLE_CAPTIONS)
        self.given = QLabel("", self, wordWrap=True)
        self.given.setObjectName("summary")
        self.asked: tuple[int, int] = (0, 0)
        left = QVBoxLayout()
        left.setSpacing(16)
        left.addWidget(self.form)
        left.addWidget(self.given)
        left.addStretch(1)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(24)
        row.addLayout(left, 1)
        row.addWidget(self._calculator(), 0, Qt.AlignmentFlag.AlignTop)
        self.form.edited.connect(lambda _: self.changed.emit())
        self.expectations.edited.connect(lambda _: self._calculate())
        self.use.clicked.connect(self._use)
        self._matches = 0
        self._calculate(tell=False)

    def _calculator(self) -> QWidget:
        box = QFrame(self)
        box.setObjectName("calculator")
        self.expectations = DesignForm(Expectations, tuple(CAPTIONS), box, CAPTIONS, compact=True)
        self.expectations.rows["correlation"].help.show()  # the one that nobody can guess
        head, self.answer = QLabel("What an interval takes", box), QLabel("", box, wordWrap=True)
        head.setObjectName("group-heading")
        self.answer.setObjectName("summary")
        self.use = QPushButton("Ask so many", box, autoDefault=False)
        column = QVBoxLayout(box)
        column.setContentsMargins(16, 12, 16, 12)
        column.setSpacing(8)
        for widget in (head, self.expectations, self.answer):
            column.addWidget(widget)
        column.addWidget(self.use, 0, Qt.AlignmentFlag.AlignLeft)
        box.setFixedWidth(380)
        return box

    @property
    def expected(self) -> Expectations:
        """What is expected, as the rows say; raises `BadParameter`."""
        return checked(Expectations, self.expectations.values())

    def values(self) -> dict[str, Any]:
        """The values by name."""
        return self.form.values()

    def show_plan(self, runs: Sequence[Run], plan: Plan, design: Design) -> None:
        """Say what the plan is expected to give."""
        asked = {row.item_id for row in plan.asked if row.role != "practice"}
        pairs = {(str(run.source.get("sha256")), str(run.target.get("sha256")))
                 for run in runs if any(p.item.id in asked for p in run.proposals)}  # fmt: skip
        self.asked = len(asked), len(pairs)
        self.design = design
        self._calculate(tell=False)

    def show_estimates(self, told: dict[str, Any]) -> None:
        """Begin with what the votes of an open study tell."""
        for name, value in told.items():
            self.expectations.rows[name].show_value(value)

    def _calculate(self, tell: bool = True) -> None:
        try:
            expected = self.expected
            found = needed(expected, getattr(self, "design", None) or Design())
        except ConcordError as error:
            self.answer.setText(str(error))
            self.use.setEnabled(False)
            return
        self._matches = found.matches
        self.use.setEnabled(True)
        self.use.setText(f"Ask {found.matches}")
        self.answer.setText(needed_text(found, expected))
        self.given.setText(given_text(*self.asked, expected))
        if tell:
            self.changed.emit()

    def _use(self) -> None:
        self.form.rows["most"].show_value(self._matches)
