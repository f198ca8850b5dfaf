"""The researcher's overview: who has done how much, how fast, and how well. Nothing is ever removed for what it shows."""

import statistics
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from sqlalchemy import func, select

from ..design.flags import GoldRecord, gold_failures
from ..storage import schema
from ..storage.handle import StudyHandle
from .agreement import VolunteerAgreement, volunteer_agreement
from .ballots import Ballot

LONGEST_MS = 60_000  # a pause is cut there
FAST = 3.0  # so many times faster than the median of the others is told
LEAST_TIMED = 10
LEAST_SAME = 10  # so many equal answers and no other one are told


class VolunteerRow(NamedTuple):
    """One volunteer. `judged` and `open` are items, without practice; shares are in [0, 1], None where unknown.

    `seconds` is the median of the time spent on a vote, pauses cut at 60 s; `first` and `last` are times in ISO 8601, ""
    before the first vote; `agreement` is the share of votes that are those of the majority of the others. `flags` are
    sentences for the researcher to think about, never a reason to remove anything by itself.
    """

    code: str
    adjudicates: bool
    judged: int
    open: int
    comments: int
    unsure: float | None
    seconds: float | None
    first: str
    last: str
    agreement: float | None
    gold_right: int
    gold_wrong: int
    flags: tuple[str, ...]


def overview(handle: StudyHandle) -> tuple[VolunteerRow, ...]:
    """Everybody who has a code, in its order."""
    vote, open_ = schema.current_vote.c, schema.open_item.c
    with handle.reading() as connection:
        people = connection.execute(select(schema.volunteer).order_by(schema.volunteer.c.code)).all()
        votes = connection.execute(
            select(vote.item_id, vote.volunteer, vote.answer, vote.comment, vote.shown_ms, vote.active_ms, vote.created_at)
            .where(vote.round == 1).order_by(vote.volunteer, vote.clock)
        ).all()  # fmt: skip
        left = connection.execute(
            select(open_.volunteer, func.count()).where(open_.round == 1).group_by(open_.volunteer)
        ).all()
    gold = {record.volunteer: record for record in gold_failures(handle)}
    return overview_rows(people, votes, gold, {row[0]: row[1] for row in left})


def overview_rows(
    people: Sequence[Any], votes: Sequence[Any], gold: Mapping[str, GoldRecord], left: Mapping[str, int]
) -> tuple[VolunteerRow, ...]:
    """The rows of volunteers under their current votes; pure."""
    own: dict[str, list[Any]] = {person.code: [] for person in people}
    for vote in votes:
        own[vote.volunteer].append(vote)
    beside = {row.volunteer: row for row in volunteer_agreement(Ballot(v.item_id, v.volunteer, v.answer) for v in votes)}
    paces = {code: _times(given) for code, given in own.items()}
    medians = {code: statistics.median(times) for code, times in paces.items() if len(times) >= LEAST_TIMED}
    return tuple(
        _row(person, own[code], paces[code], medians, left.get(code, 0), gold.get(code), beside.get(code))
        for person in people
        if (code := person.code)
    )


def _row(
    person: Any, votes: Sequence[Any], times: Sequence[int], medians: Mapping[str, float], left: int,
    gold: GoldRecord | None, beside: VolunteerAgreement | None,
) -> VolunteerRow:  # fmt: skip
    count, stamps = Counter(vote.answer for vote in votes), sorted(vote.created_at for vote in votes)
    others = [pace for code, pace in medians.items() if code != person.code]
    flags = (*_failed(gold), *_fast(medians.get(person.code), others), *_same(count))
    return VolunteerRow(
        person.code, bool(person.adjudicates), len(votes), left, sum(bool(vote.comment) for vote in votes),
        count["unsure"] / len(votes) if votes else None, statistics.median(times) / 1000 if times else None,
        stamps[0] if stamps else "", stamps[-1] if stamps else "", beside.with_majority if beside else None,
        gold.right if gold else 0, gold.wrong if gold else 0, flags,
    )  # fmt: skip


def _times(votes: Iterable[Any]) -> list[int]:
    spent = (vote.active_ms if vote.active_ms is not None else vote.shown_ms for vote in votes)
    return [min(ms, LONGEST_MS) for ms in spent if ms is not None]


def _failed(gold: GoldRecord | None) -> tuple[str, ...]:
    return (f"fails gold items: {gold.wrong} of {gold.judged} wrong",) if gold and gold.flagged else ()


def _fast(pace: float | None, others: Sequence[float]) -> tuple[str, ...]:
    if pace is None or not others:
        return ()
    usual = statistics.median(others)
    if pace * FAST >= usual:
        return ()
    return (f"much faster than others: {pace / 1000:.1f} s a vote beside {usual / 1000:.1f} s",)


def _same(count: Counter[str]) -> tuple[str, ...]:
    if len(count) != 1 or count.total() < LEAST_SAME:
        return ()
    return (f"always the same answer: {next(iter(count))}, {count.total()} times",)
