"""What a voting screen asks of an open study beside the rules: who may vote, and what one volunteer has answered."""

import itertools
from collections.abc import Sequence
from typing import NamedTuple

from sqlalchemy import select

from engine.errors import BadInput

from ..records import Item, OpenItem, Practice, Study
from ..storage import schema
from ..storage.handle import StudyHandle
from ..study import about
from .answering import (
    checked_code,
    current_votes,
    item,
    open_items,
    practice,
    sides_swapped,
    still_open,
    volunteer,
)
from .volunteers import beginner, is_strange

_current, _events = schema.current_vote.c, schema.event.c


class Opening(NamedTuple):
    """What a screen needs to begin: the study, practice, what is open, and the milliseconds of the votes given."""

    study: Study
    practice: dict[str, Practice]
    open: tuple[OpenItem, ...]
    spent: tuple[int | None, ...]


def opening(handle: StudyHandle, code: str, *, new: bool = True) -> Opening:
    """How a volunteer begins or goes on; raises `BadInput` for a code that the study does not know.

    `new` says that somebody new may take part; whoever is invited or holds a packet has a code of their own.
    """
    about_it = about(handle)
    voter = known_volunteer(handle, code, about_it, new)
    given = current_votes(handle, volunteer=voter)
    spent = tuple(vote.active_ms if vote.active_ms is not None else vote.shown_ms for vote in given)
    return Opening(about_it, practice(handle), open_items(handle, voter), spent)


def known_volunteer(handle: StudyHandle, code: str, study: Study, new: bool) -> str:
    """The code as the study has it; one that it does not know only where `new`, or where everybody is asked everything."""
    code, own = checked_code(code), own_code(handle)
    if own is not None and own != code:
        raise BadInput(f"This is for another volunteer than {code}; leave the code out, or check whose file it is.")
    if study.votes and not new and is_strange(handle, code):
        raise BadInput(f"This study knows no volunteer {code}; check the code, or ask whoever gave it to you.")
    return beginner(handle, code).code


def own_code(handle: StudyHandle) -> str | None:
    """The code that this study is voted under: that of the login or of the packet; None where anybody may vote."""
    return handle.volunteer


def own_answer(handle: StudyHandle, code: str, one: OpenItem) -> str:
    """The answer of this volunteer to an item that counts now, or ''."""
    mine = (_current.item_id == one.item_id, _current.volunteer == code, _current.round == one.round)
    with handle.reading() as connection:
        return connection.scalar(select(_current.answer).where(*mine)) or ""


def last_comment(handle: StudyHandle, code: str, one: OpenItem) -> str:
    """What this volunteer wrote with the newest answer to an item, be it taken back or not."""
    mine = (_events.kind == "vote", _events.item_id == one.item_id, _events.volunteer == code, _events.round == one.round)
    with handle.reading() as connection:
        newest = select(_events.comment).where(*mine).order_by(_events.clock.desc()).limit(1)
        return connection.scalar(newest) or ""


class Needless(NamedTuple):
    """Items that need not be asked any more."""

    answered: tuple[OpenItem, ...]
    """by the same volunteer, in another window"""
    settled: tuple[OpenItem, ...]
    """by others"""


def needless_in_front(handle: StudyHandle, code: str, wanted: Sequence[OpenItem]) -> Needless:
    """Of the items in the order in which they come, those before the first that is still to be asked."""
    passed = list(itertools.takewhile(lambda one: not still_open(handle, code, one), wanted))
    answered = tuple(one for one in passed if own_answer(handle, code, one))
    return Needless(answered, tuple(one for one in passed if one not in answered))


def asked_item(handle: StudyHandle, code: str, item_id: str) -> tuple[Item, bool]:
    """An item, and whether this volunteer sees its target on the left."""
    return item(handle, item_id), sides_swapped(volunteer(handle, code), item_id)
