"""Volunteers of a study: their codes, their seeds, and who adjudicates."""

import heapq
import re
import unicodedata
from collections.abc import Collection, Sequence
from typing import Any

from sqlalchemy import Connection, Row, insert, select, update

from engine.errors import BadInput, BadParameter

from ..design.sampling import draw
from ..exchange.tombstones import refuse_forgotten
from ..records import Volunteer
from ..storage import schema
from ..storage.handle import StudyHandle
from ..storage.stamps import now

LEAD = 5  # of the first items of a volunteer none is gold


def checked_code(code: str) -> str:
    """The code of a volunteer, 1 to 40 letters, digits, - and _; raises `BadParameter` otherwise."""
    found = unicodedata.normalize("NFC", code.strip())
    if not re.fullmatch(r"[\w-]{1,40}", found):
        raise BadParameter(f"{code!r} is no volunteer code; use 1 to 40 letters, digits, - and _.")
    return found


def own_code(handle: StudyHandle, code: str) -> str:
    """The code as `checked_code` gives it; raises `BadInput` where the study is open for another volunteer alone."""
    found = checked_code(code)
    if handle.volunteer not in (None, found):
        raise BadInput(f"{handle.where} is for volunteer {handle.volunteer} alone, not for {found}; open it with that code.")
    return found


def volunteer(handle: StudyHandle, code: str) -> Volunteer:
    """The volunteer of that code, made on first use; who came in by a merge gets an order and sides on first use."""
    code = own_code(handle, code)
    with handle.reading() as connection:
        row = connection.execute(select(schema.volunteer).where(schema.volunteer.c.code == code)).first()
    if row is not None and (row.seed or handle.volunteer is not None):
        return _voter(row)
    with handle.writing() as connection:
        return enrolled(connection, code)


def beginner(handle: StudyHandle, code: str) -> Volunteer:
    """The volunteer of that code, about to begin or go on: for who has not voted yet the seed is settled once more.

    For others may have settled so much in the meantime that a gold item came first. A login or a packet keeps its own.
    """
    voter = volunteer(handle, code)
    if handle.volunteer is not None:
        return voter
    with handle.reading() as connection:
        seed = _settled(connection, voter)
    if seed == voter.seed:
        return voter
    with handle.writing() as connection:
        seed = _settled(connection, voter)
        connection.execute(update(schema.volunteer).where(schema.volunteer.c.code == voter.code).values(seed=seed))
    return Volunteer(voter.code, seed, voter.adjudicates)


def _settled(connection: Connection, voter: Volunteer) -> str:
    """The seed that a volunteer who has not voted is to have now."""
    if connection.scalar(select(schema.event.c.uuid).where(schema.event.c.volunteer == voter.code).limit(1)) is not None:
        return voter.seed
    return _fresh_seed(connection, voter.code, *_queue(connection, voter.code, *_asked(connection)))


def known_volunteer(handle: StudyHandle, code: str) -> Volunteer:
    """The volunteer of a code that must be there; raises `BadInput` with those that are."""
    code, known = checked_code(code), volunteers(handle)
    for one in known:
        if one.code == code:
            return one
    raise BadInput(f"{handle.where} has no volunteer {code!r}; it has {_named(known)}.")


def check_known(handle: StudyHandle, code: str) -> None:
    """Raise `BadInput` for a code that is not known where it should be (see `is_strange`), and name those that are."""
    if is_strange(handle, code):
        with handle.reading() as connection:
            refuse_forgotten(connection, checked_code(code))
        raise BadInput(f"{handle.where} knows no volunteer {checked_code(code)} (it has {_named(volunteers(handle))}); check the code, "
                       "or give --new for somebody who is new.")  # fmt: skip


def is_strange(handle: StudyHandle, code: str) -> bool:
    """Whether a code is one that the study does not know although it should: it may be mistyped.

    Where everybody is asked everything whoever comes first may come unknown, and so may the volunteer of a packet.
    """
    code = checked_code(code)
    if handle.volunteer is not None:
        return False
    known = {one.code for one in volunteers(handle)}
    with handle.reading() as connection:
        counted = connection.scalar(select(schema.study.c.votes))
    return code not in known and bool(known or counted)


def _named(known: Sequence[Volunteer]) -> str:
    return (", ".join(one.code for one in known[:10]) + (", …" if len(known) > 10 else "")) or "none yet"


def make_adjudicator(handle: StudyHandle, code: str, *, adjudicates: bool = True) -> Volunteer:
    """The volunteer of that code, made if new, as one who is asked about unresolved items alone (or no longer so).

    Adjudicators see what volunteers see: nothing of who proposed a match or what others answered.
    """
    code = checked_code(code)
    with handle.writing() as connection:
        found = enrolled(connection, code)
        same = schema.volunteer.c.code == code
        connection.execute(update(schema.volunteer).where(same).values(adjudicates=int(adjudicates)))
        return Volunteer(code, found.seed, adjudicates)


def volunteers(handle: StudyHandle) -> tuple[Volunteer, ...]:
    """Everybody who has a code, in its order."""
    with handle.reading() as connection:
        rows = connection.execute(select(schema.volunteer).order_by(schema.volunteer.c.code))
        return tuple(_voter(row) for row in rows)


def enrolled(connection: Connection, code: str) -> Volunteer:
    """The volunteer of a checked code in an open transaction, made if new."""
    found = connection.execute(select(schema.volunteer).where(schema.volunteer.c.code == code)).first()
    if found is None:
        refuse_forgotten(connection, code)
        seed = _fresh_seed(connection, code, *_queue(connection, code, *_asked(connection)))
        connection.execute(insert(schema.volunteer).values(code=code, seed=seed, created_at=now()))
        return Volunteer(code, seed)
    if not found.seed:  # of a volunteer who came in by a packet or another study
        seed = _fresh_seed(connection, code, *_queue(connection, code, *_asked(connection)))
        connection.execute(update(schema.volunteer).where(schema.volunteer.c.code == code).values(seed=seed))
        return Volunteer(code, seed, bool(found.adjudicates))
    return _voter(found)


def settle_seeds(connection: Connection) -> None:
    """Draw the seeds of those who have not voted yet anew, so that no gold item comes first in what they are asked.

    To be called when gold items or packets were added; a volunteer who is new later gets such a seed at once.
    """
    voted = select(schema.event.c.volunteer)
    waiting = connection.execute(select(schema.volunteer).where(schema.volunteer.c.code.not_in(voted))).all()
    asked = _asked(connection) if waiting else (set[str](), set[str]())
    for row in waiting:
        seed = _fresh_seed(connection, row.code, *_queue(connection, row.code, *asked))
        if seed != row.seed:
            connection.execute(update(schema.volunteer).where(schema.volunteer.c.code == row.code).values(seed=seed))


def _asked(connection: Connection) -> tuple[set[str], set[str]]:
    """The items that a new volunteer is asked now, practice apart, and all gold ones; nothing where none is gold."""
    asked, wanted = schema.asked.c, schema.wanted.c
    gold = set(connection.scalars(select(asked.item_id).where(asked.role == "gold")))
    if not gold:
        return set(), set()
    return set(connection.scalars(select(wanted.item_id).where(wanted.open == 1, wanted.role != "practice"))), gold


def _queue(connection: Connection, code: str, items: set[str], gold: set[str]) -> tuple[set[str], set[str]]:
    """What a volunteer is asked, the packet where there is one, and the gold items of that."""
    packet = schema.assignment.c
    handed = set(connection.scalars(select(packet.item_id).where(packet.volunteer == code))) if gold else set()
    return handed or items, gold & (handed or items)


def _fresh_seed(connection: Connection, code: str, items: Collection[str], gold: Collection[str]) -> str:
    """The seed of a volunteer: the first of a sequence under which none of the first `LEAD` items is gold.

    So the first one is not, even where others settle some of them before this volunteer begins. Where there are so many
    gold items that this asks too much, the very first one is not.
    """
    base = str(connection.scalar(select(schema.study.c.seed)))
    for lead, tries in ((LEAD, 50), (1, 1000)) if len(gold) < len(items) else ():
        for count in range(tries):
            seed = draw(base, "volunteer", f"{code}\n{count}" if count else code)
            first = heapq.nsmallest(lead, items, key=lambda item_id: draw(seed, "order", item_id))
            if not any(item_id in gold for item_id in first):
                return seed
    return draw(base, "volunteer", code)


def _voter(row: Row[Any]) -> Volunteer:
    return Volunteer(row.code, row.seed, bool(row.adjudicates))
