"""Voting: which item comes next for whom, and every answer on the disk before the next one shows.

What a volunteer's screen gets from here names items alone: no method, parameter, score or vote of anybody else.
"""

import statistics
import uuid
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from sqlalchemy import Connection, Row, func, insert, select

from engine.errors import BadInput, BadParameter

from ..design.sampling import draw
from ..records import Item, OpenItem, Practice, Volunteer, Vote, VotingProgress
from ..results.proposals import canonical
from ..storage import schema
from ..storage.handle import StudyHandle
from ..storage.payloads import read_payload
from ..storage.stamps import app_version, now
from .majority import ANSWERS, Majority, majority_of
from .volunteers import (
    checked_code,
    enrolled,
    known_volunteer,
    make_adjudicator,
    own_code,
    settle_seeds,
    volunteer,
    volunteers,
)

__all__ = [
    "answers", "checked_code", "current_votes", "item", "items", "known_volunteer", "majority", "make_adjudicator",
    "next_item", "open_items", "ordered_ids", "own_code", "practice", "progress", "record_vote", "record_votes",
    "seconds_each", "settle_seeds", "sides_swapped", "still_open", "undo_vote", "volunteer", "volunteers",
]  # fmt: skip

_events, _current = schema.event.c, schema.current_vote.c


def record_vote(
    handle: StudyHandle,
    item_id: str,
    volunteer_code: str,
    answer: str,
    *,
    comment: str = "",
    shown_ms: int | None = None,
    active_ms: int | None = None,
    round: int = 1,
    presentation: Mapping[str, Any] | None = None,
) -> Vote:
    """Commit one answer and return it; when this returns, the vote is on the disk.

    An earlier answer of the same volunteer to the same item stays in the log and is superseded. Raises `BadParameter`
    for an unknown answer or a bad code, `BadInput` for an unknown item or a file that cannot be written.
    """
    code = own_code(handle, volunteer_code)
    with handle.writing() as connection:
        enrolled(connection, code)
        return _vote_on(
            connection, item_id, code, answer, comment=comment, round=round, shown_ms=shown_ms, active_ms=active_ms,
            presentation=canonical(presentation or {}),
        )  # fmt: skip


def record_votes(
    handle: StudyHandle, volunteer_code: str, answers: Mapping[str, str], *, round: int = 1
) -> tuple[Vote, ...]:
    """Commit the answers to many items at once, as `record_vote` does one; all are on the disk, or none.

    For answers that no person gives one by one, such as those of a known truth.
    """
    code = own_code(handle, volunteer_code)
    with handle.writing() as connection:
        enrolled(connection, code)
        return tuple(
            _vote_on(connection, item_id, code, answer, comment="", round=round, shown_ms=None, active_ms=None,
                     presentation="{}") for item_id, answer in answers.items()
        )  # fmt: skip


def undo_vote(handle: StudyHandle, volunteer_code: str) -> str | None:
    """Retract the volunteer's last vote that still stands, and return its item; None if there is none.

    The retraction is an event of its own. An answer that the retracted one had replaced stands again. May be called
    as often as there are votes.
    """
    code, standing = own_code(handle, volunteer_code), schema.standing_vote.c
    newest_first = (standing.clock.desc(), standing.created_at.desc(), standing.uuid.desc())
    with handle.writing() as connection:
        last = connection.execute(
            select(schema.standing_vote).where(standing.volunteer == code).order_by(*newest_first).limit(1)
        ).first()
        if last is None:
            return None
        _append(
            connection, kind="retraction", item_id=last.item_id, volunteer=code, round=last.round, answer=None,
            comment="", supersedes=last.uuid, shown_ms=None, active_ms=None, presentation="{}",
        )  # fmt: skip
        return str(last.item_id)


def items(handle: StudyHandle, volunteer_code: str) -> tuple[Item, ...]:
    """All items in this volunteer's own order, which is the same whenever it is asked for."""
    seed = volunteer(handle, volunteer_code).seed
    with handle.reading() as connection:
        rows = connection.execute(select(schema.item)).all()
    return tuple(_item(row) for row in sorted(rows, key=lambda row: draw(seed, "order", row.id)))


def ordered_ids(handle: StudyHandle, volunteer_code: str) -> tuple[str, ...]:
    """The ids of `items` in the same order, without reading what they show."""
    seed = volunteer(handle, volunteer_code).seed
    with handle.reading() as connection:
        ids = connection.scalars(select(schema.item.c.id)).all()
    return tuple(sorted(ids, key=lambda item_id: draw(seed, "order", item_id)))


def item(handle: StudyHandle, item_id: str) -> Item:
    """One item; raises `BadInput` where the study has none of this id."""
    with handle.reading() as connection:
        row = connection.execute(select(schema.item).where(schema.item.c.id == item_id)).first()
    if row is None:
        raise BadInput(f"The study has no item {item_id}; add its result first.")
    return _item(row)


def open_items(handle: StudyHandle, volunteer_code: str) -> tuple[OpenItem, ...]:
    """What this volunteer is still to be asked about, practice first, then in the volunteer's own order.

    What is asked depends on the design of the study: see the view `wanted` in `annotation.storage.schema`.
    """
    voter, view = volunteer(handle, volunteer_code), schema.open_item.c
    with handle.reading() as connection:
        rows = connection.execute(select(view.item_id, view.round).where(view.volunteer == voter.code)).all()
    return tuple(sorted((OpenItem(*row) for row in rows), key=lambda o: (o.round, draw(voter.seed, "order", o.item_id))))


def still_open(handle: StudyHandle, volunteer_code: str, one: OpenItem) -> bool:
    """Whether an item of `open_items` is still to be asked: the votes of others may have settled it in the meantime.

    Looks at this item alone, so it may be asked before every question.
    """
    code, view = checked_code(volunteer_code), schema.open_item.c
    same = (view.volunteer == code, view.item_id == one.item_id, view.round == one.round)
    with handle.reading() as connection:
        return connection.execute(select(view.item_id).where(*same)).first() is not None


def practice(handle: StudyHandle) -> dict[str, Practice]:
    """The known answers of the practice items, by item."""
    with handle.reading() as connection:
        rows = connection.execute(select(schema.practice)).all()
    return {row.item_id: Practice(row.answer, row.reason) for row in rows}


def next_item(handle: StudyHandle, volunteer_code: str, *, skipped: Sequence[str] = ()) -> Item | None:
    """The first item to be asked; those `skipped` come back at the end, in the order given; None when done."""
    left, last = open_items(handle, volunteer_code), {item_id: place for place, item_id in enumerate(skipped)}
    chosen = min(left, key=lambda one: last.get(one.item_id, -1), default=None)
    return None if chosen is None else item(handle, chosen.item_id)


def sides_swapped(voter: Volunteer, item_id: str) -> bool:
    """Whether this volunteer sees the target on the left: drawn once by the seed, the same at every showing."""
    return int(draw(voter.seed, "side", item_id), 16) % 2 == 1


def progress(handle: StudyHandle, volunteer_code: str) -> VotingProgress:
    """How many of how many are answered (practice apart), and the time left at the volunteer's own pace."""
    votes = current_votes(handle, volunteer=checked_code(volunteer_code))
    total = len(votes) + sum(one.round > 0 for one in open_items(handle, volunteer_code))
    spent = [vote.active_ms if vote.active_ms is not None else vote.shown_ms for vote in votes]
    pace = seconds_each([ms for ms in spent if ms is not None])
    return VotingProgress(len(votes), total, None if pace is None else pace * (total - len(votes)))


def seconds_each(milliseconds: Sequence[int]) -> float | None:
    """Median of the last 20 times, pauses cut at 60 s; None without any. Less than none, as of a clock that was set
    back, is not known."""
    known = [ms for ms in milliseconds if ms >= 0][-20:]
    return statistics.median(min(ms, 60_000) for ms in known) / 1000 if known else None


def current_votes(
    handle: StudyHandle, item_ids: Iterable[str] | None = None, volunteer: str | None = None, *, round: int = 1
) -> tuple[Vote, ...]:
    """The votes that count, in the order of voting; of all items or some, of all volunteers or one."""
    query = select(schema.current_vote).where(_current.round == round)
    if volunteer is not None:
        query = query.where(_current.volunteer == volunteer)
    with handle.reading() as connection:
        rows = connection.execute(query.order_by(_current.volunteer, _current.clock, _current.uuid)).all()
    wanted = None if item_ids is None else set(item_ids)
    return tuple(_vote(row) for row in rows if wanted is None or row.item_id in wanted)


def answers(handle: StudyHandle, volunteer_code: str, *, round: int = 1) -> dict[str, str]:
    """One volunteer's current answers by item."""
    mine = (_current.volunteer == volunteer_code, _current.round == round)
    with handle.reading() as connection:
        rows = connection.execute(select(_current.item_id, _current.answer).where(*mine).order_by(_current.clock))
        return {row.item_id: row.answer for row in rows}


def majority(handle: StudyHandle, *, round: int = 1) -> dict[str, Majority]:
    """The majority of every item of the study, for the researcher."""
    with handle.reading() as connection:
        ids = connection.scalars(select(schema.item.c.id).order_by(schema.item.c.id)).all()
        given: dict[str, dict[str, int]] = {one: {} for one in ids}
        kinds = (_current.item_id, _current.answer)
        for one, answer, count in connection.execute(
            select(*kinds, func.count()).where(_current.round == round).group_by(*kinds)
        ):
            given[one][answer] = count
    return {one: majority_of(counts) for one, counts in given.items()}


def _vote_on(connection: Connection, item_id: str, code: str, answer: str, *, round: int, **values: Any) -> Vote:
    """Add a vote that supersedes the volunteer's present one, if there is one."""
    if answer not in ANSWERS:
        raise BadParameter(f"{answer!r} is no answer; choose one of {', '.join(ANSWERS)}.")
    if answer == "unsure" and not connection.scalar(select(schema.study.c.unsure)):
        raise BadParameter("This study takes no answer 'unsure'; choose correct or wrong.")
    if connection.scalar(select(schema.item.c.id).where(schema.item.c.id == item_id)) is None:
        raise BadInput(f"The study has no item {item_id}; add its result first.")
    mine = (_current.item_id == item_id, _current.volunteer == code, _current.round == round)
    before = connection.scalar(select(_current.uuid).where(*mine))
    return _append(
        connection, kind="vote", item_id=item_id, volunteer=code, round=round, answer=answer, supersedes=before, **values
    )


def _append(connection: Connection, **values: Any) -> Vote:
    """Add an event, numbered after all events of its volunteer."""
    last = connection.scalar(select(func.max(_events.clock)).where(_events.volunteer == values["volunteer"])) or 0
    stamped = {"uuid": str(uuid.uuid4()), "clock": last + 1, "app_version": app_version(), "created_at": now()}
    row = connection.execute(insert(schema.event).values(**values, **stamped).returning(schema.event)).one()
    return _vote(row)


def _item(row: Row[Any]) -> Item:
    return Item(row.id, row.kind, read_payload(row.payload))


def _vote(row: Row[Any]) -> Vote:
    return Vote(
        row.uuid, row.item_id, row.volunteer, row.round, row.answer, row.comment, row.supersedes, row.clock,
        row.shown_ms, row.active_ms, read_payload(row.presentation), row.created_at,
    )  # fmt: skip
