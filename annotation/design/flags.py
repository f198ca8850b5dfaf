"""What a researcher should look at: failures on gold items, matches that volunteers dispute, matches left unresolved.

Nothing is ever deleted for it: a flag is a hint for a person.
"""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from sqlalchemy import select

from ..records import Vote
from ..storage import schema
from ..storage.handle import StudyHandle
from ..voting.answering import current_votes
from ..voting.majority import Majority, majorities

FEWEST_JUDGED, LEAST_RIGHT = 3, 0.7  # from how many gold answers on, and below which share of right ones


class GoldRecord(NamedTuple):
    """How one volunteer answered the gold items: `judged` = `right` + `wrong` + `unsure`; `failed` are the items of
    `wrong`, in the order of voting, each with the answer that was known."""

    volunteer: str
    judged: int
    right: int
    wrong: int
    unsure: int
    failed: tuple[tuple[str, str], ...]

    @property
    def share_right(self) -> float | None:
        """Of the answers that decide; None without one."""
        decided = self.right + self.wrong
        return self.right / decided if decided else None

    @property
    def flagged(self) -> bool:
        """Whether too few answers are right to trust the others without a look at them."""
        return self.share_right is not None and self.judged >= FEWEST_JUDGED and self.share_right < LEAST_RIGHT


class Disputed(NamedTuple):
    """A match that volunteers answered differently, and whether an adjudicator is to be asked about it now."""

    item: str
    majority: Majority
    for_adjudicator: bool


def gold_failures(handle: StudyHandle) -> tuple[GoldRecord, ...]:
    """The record of everybody who has judged a gold item, those who failed most often first."""
    asked = schema.asked.c
    with handle.reading() as connection:
        rows = connection.execute(select(asked.item_id, asked.answer).where(asked.role == "gold")).all()
    known = {row.item_id: row.answer for row in rows if row.answer is not None}
    return gold_records(current_votes(handle, known), known)


def gold_records(votes: Iterable[Vote], known: Mapping[str, str]) -> tuple[GoldRecord, ...]:
    """The same of votes, in the order of voting, and of the known answers by item; pure."""
    given: dict[str, list[Vote]] = {}
    for vote in votes:
        if vote.item_id in known:
            given.setdefault(vote.volunteer, []).append(vote)
    found = []
    for code, cast in given.items():
        decided = [vote for vote in cast if vote.answer != "unsure"]
        failed = tuple((v.item_id, known[v.item_id]) for v in decided if v.answer != known[v.item_id])
        found.append(GoldRecord(code, len(cast), len(decided) - len(failed), len(failed), len(cast) - len(decided), failed))
    return tuple(sorted(found, key=lambda record: (-record.wrong, record.share_right or 0.0, record.volunteer)))


def disputed(handle: StudyHandle) -> tuple[Disputed, ...]:
    """The matches that volunteers answered both ways, the most evenly divided first (of these the one of most votes)."""
    verdicts, adjudicated = _verdicts(handle)
    both = [Disputed(item, m, item in adjudicated) for item, m in verdicts.items() if m.correct and m.wrong]
    return tuple(sorted(both, key=lambda d: (evenness(d.majority), -d.majority.correct - d.majority.wrong, d.item)))


def evenness(of: Majority) -> float:
    """How far the decisive answers are from half and half, in [0, 0.5]; 0.5 without any."""
    decided = of.correct + of.wrong
    return abs(of.correct / decided - 0.5) if decided else 0.5


def unresolved(handle: StudyHandle) -> tuple[Disputed, ...]:
    """The matches that have votes but no majority, ties and abstentions alone, those for an adjudicator first."""
    verdicts, adjudicated = _verdicts(handle)
    left = [
        Disputed(item, m, item in adjudicated)
        for item, m in verdicts.items()
        if m.verdict not in ("correct", "wrong") and m.correct + m.wrong + m.unsure
    ]
    return tuple(sorted(left, key=lambda d: (not d.for_adjudicator, d.item)))


def _verdicts(handle: StudyHandle) -> tuple[dict[str, Majority], set[str]]:
    """The majority of every match that is asked, practice apart, and which of them adjudicators are asked about."""
    wanted = schema.wanted.c
    with handle.reading() as connection:
        rows = connection.execute(select(wanted.item_id, wanted.role, wanted.disputed)).all()
    counted = [row for row in rows if row.role != "practice"]
    cast = ((vote.item_id, vote.answer) for vote in current_votes(handle))
    adjudicated = {row.item_id for row in counted if row.disputed}
    return majorities(sorted(row.item_id for row in counted), cast), adjudicated
