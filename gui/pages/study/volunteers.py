"""The researcher's overview: who has done how much, how fast and how well, and what to do about it. Nothing is removed."""

from collections.abc import Iterable
from datetime import UTC, datetime
from typing import NamedTuple

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from annotation.design.flags import Disputed, unresolved
from annotation.findings.overview import VolunteerRow, overview
from annotation.study import StudyHandle

from ..quiet_table import fill, quiet_table, still_columns
from ..shapes.arrange import share_text
from .sources import plural

HEADS = ("volunteer", "judged", "left", "time a vote", "with the majority", "gold", "unsure", "last vote", "to look at")
_TIPS = {
    "judged": "Matches answered, practice apart", "left": "Matches this volunteer is still to be asked about",
    "time a vote": "Median; pauses are cut at a minute", "with the majority": "Share of votes that are those of the majority of the others",
    "gold": "Right of the matches whose answer is known", "to look at": "Hints for a person; no vote is ever removed for one",
}  # fmt: skip
_WORDS = 1
BUTTONS = (("packet", "Send a &packet…", "One file with what a volunteer is asked, and nothing else"),
           ("merge", "&Take in a returned file…", "The votes of a packet, or of another copy of this study"),
           ("invite", "&Invite…", "Gives a volunteer a code, and on a server an address of their own"),
           ("adjudicate", "Make ad&judicator", "Is asked about unresolved matches alone"),
           ("forget", "&Delete…", "Takes a volunteer who asks for it out of the study"))  # fmt: skip
OF_ONE = ("adjudicate", "forget")


class People(NamedTuple):
    """Everybody who votes, and the matches that are left without a majority."""

    rows: tuple[VolunteerRow, ...]
    unresolved: tuple[Disputed, ...]


def people_cells(row: VolunteerRow, now: datetime) -> tuple[str, ...]:
    """The texts of a row, in the order of `HEADS`."""
    gold = row.gold_right + row.gold_wrong
    pace = "–" if row.seconds is None else f"{row.seconds:.1f} s" if row.seconds < 10 else f"{row.seconds:.0f} s"
    return (row.code + ("  (adjudicator)" if row.adjudicates else ""), str(row.judged), str(row.open), pace,
            "–" if row.agreement is None else share_text(row.agreement),
            f"{row.gold_right} of {gold}" if gold else "–", "–" if row.unsure is None else f"{100 * row.unsure:.0f} %",
            when(row.last, now), "; ".join(row.flags) or "–")  # fmt: skip


def when(stamp: str, now: datetime) -> str:
    """'today 14:05', 'yesterday', '12 March', from a time in ISO 8601; a dash where there is none."""
    try:
        then = datetime.fromisoformat(stamp).astimezone(now.tzinfo)
    except ValueError:
        return "–"
    days = (now.date() - then.date()).days
    if days == 0:
        return f"today {then:%H:%M}"
    if days == 1:
        return "yesterday"
    return f"{then.day} {then:%B}" + ("" if then.year == now.year else f" {then.year}")


def summary(rows: Iterable[VolunteerRow], left: Iterable[Disputed]) -> str:
    """'3 volunteers · 410 answers · 12 matches unresolved, 3 of them for an adjudicator'."""
    people, open_ = list(rows), list(left)
    words = [plural(len(people), "volunteer"), plural(sum(row.judged for row in people), "answer")]
    if open_:
        waiting = sum(one.for_adjudicator for one in open_)
        text = plural(len(open_), "match", "matches") + " unresolved"
        words.append(text + (f", {waiting} of them for an adjudicator" if waiting else ""))
    return " · ".join(words)


def advice(rows: Iterable[VolunteerRow], left: Iterable[Disputed]) -> str:
    """What a researcher may do next, or ''."""
    people = list(rows)
    if any(one.for_adjudicator for one in left) and not any(row.adjudicates for row in people):
        return "Some matches stay divided after all their votes: pick a volunteer and make them adjudicator to have these settled."
    if any(row.flags for row in people):
        return "Flags are hints: talk to the volunteer, or see what leaving one out changes (Agreement). No vote is removed."
    return ""


class VolunteersSection(QWidget):
    """A table of people, and below it what can be done; says which command was given (`wanted`: command, code)."""

    wanted = Signal(str, str)

    empty = "Nobody has voted in this study yet. Hand it out with Study > Send a packet, or vote yourself on the voting screen (Ctrl+4)."

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.rows: tuple[VolunteerRow, ...] = ()
        self.head, self.advice = QLabel("", self), QLabel("", self, wordWrap=True)
        self.head.setObjectName("group-heading")
        self.advice.setObjectName("soft")
        self.table = quiet_table(HEADS, _WORDS, "to look at", self, _TIPS)
        self.table.horizontalHeaderItem(len(HEADS) - 1).setTextAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        self.table.itemSelectionChanged.connect(self._tell)
        self.buttons: dict[str, QPushButton] = {}
        row = QHBoxLayout()
        row.setSpacing(8)
        for name, words, tip in BUTTONS:
            self.buttons[name] = QPushButton(words, self, toolTip=tip)
            self.buttons[name].clicked.connect(lambda _=False, name=name: self.wanted.emit(name, self.chosen))
            row.addWidget(self.buttons[name])
        row.addStretch(1)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(12)
        column.addWidget(self.head)
        column.addWidget(self.table, 1)
        column.addWidget(self.advice)
        column.addLayout(row)
        column.addStretch(0)
        self._tell()

    @staticmethod
    def read(handle: StudyHandle) -> People:
        """Everybody, and what is unresolved."""
        return People(overview(handle), unresolved(handle))

    @property
    def chosen(self) -> str:
        """The code of the picked volunteer, or ''."""
        lines = {index.row() for index in self.table.selectionModel().selectedRows()}
        return self.rows[min(lines)].code if lines and min(lines) < len(self.rows) else ""

    def show_content(self, found: People) -> bool:
        """Show everybody; the section stays also where nobody has voted, because packets are sent from here."""
        before, self.rows = self.chosen, found.rows
        now = datetime.now(UTC).astimezone()
        fill(self.table, [people_cells(row, now) for row in found.rows], _WORDS)
        with still_columns(self.table):
            for line, row in enumerate(found.rows):
                item = self.table.item(line, HEADS.index("to look at"))
                item.setToolTip("\n".join(row.flags))
                item.setTextAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
                if row.code == before:
                    self.table.selectRow(line)
        self.table.setVisible(bool(found.rows))
        self.head.setText(summary(found.rows, found.unresolved) if found.rows else self.empty)
        self.advice.setText(advice(found.rows, found.unresolved))
        self._tell()
        return True

    def _tell(self) -> None:
        adjudicates = {row.code: row.adjudicates for row in self.rows}.get(self.chosen, False)
        self.buttons["adjudicate"].setText("No longer ad&judicator" if adjudicates else "Make ad&judicator")
        for name in OF_ONE:
            self.buttons[name].setEnabled(bool(self.chosen))

    def set_dark(self, dark: bool) -> None:
        """Tables follow the application."""

    def shutdown(self) -> None:
        """Nothing to give back."""
