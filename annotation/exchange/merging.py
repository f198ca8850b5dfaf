"""Merging: a study takes in another copy of itself, a returned packet or a top-up, in any order, any number of times.

Every table is a set of rows that grows: events are united by their id, and of two rows of one key the greater of a total
order stays, whichever file it came from. Volunteers who were deleted in one file are deleted from what both make.
"""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from sqlalchemy import Connection, Row, select
from sqlalchemy.exc import IntegrityError

from engine.errors import BadInput

from ..design.topup import settle_probabilities
from ..storage import schema
from ..storage.handle import StudyHandle
from ..storage.payloads import read_payload
from ..study import open_study
from .forgetting import bury, clean_backups, lay_to_rest
from .packets import shapes_shown
from .tombstones import Tombstone, family_of, read_tombstones
from .uniting import Cells, append, every_row, unite, unite_blobs

_MERGED = (schema.item, schema.run, schema.run_match, schema.volunteer, schema.asked, schema.assignment)
_OF_A_PACKET = (schema.item, schema.volunteer)


class Merged(NamedTuple):
    """How many rows were new, and how many volunteers were deleted because they are deleted in the other file."""

    items: int
    runs: int
    volunteers: int
    events: int
    forgotten: int = 0


class _Content(NamedTuple):
    """What a study holds, without its shapes."""

    study: Row[Any]
    tables: dict[str, list[Cells]]
    events: list[Cells]
    tombstones: tuple[Tombstone, ...]
    shapes: list[str]

    @property
    def packet(self) -> str | None:
        """The volunteer that the study is a packet of, None for a whole study."""
        found = json.loads(self.study.settings).get("packet")
        return None if found is None else str(found)


def merge(path_into: Path | str, path_from: Path | str, *, other_study: bool = False) -> Merged:
    """Take everything of one study (a file or a server) into another; see `merge_handles`."""
    with open_study(path_from, backup=False, writable=False) as source, open_study(path_into) as target:
        return merge_handles(source, target, other_study=other_study)


def merge_handles(source: StudyHandle, target: StudyHandle, *, other_study: bool = False) -> Merged:
    """Take everything of one study into another, in one transaction; the one taken from is not changed.

    Merging any copies in any order, any number of times, gives the same content. A packet gives its votes alone, and a
    study that tops up another one goes into that. Raises `BadInput`, and changes nothing, for two different studies
    (unless `other_study`), a packet of another study, a packet that is to take something in, and events of one id that
    differ, which no honest history has. Volunteers who are deleted in one are deleted in the other, and in its backups.
    """
    with source.reading() as connection:
        theirs = _read(connection)
    with target.reading() as connection:
        ours = connection.execute(select(schema.study)).one()
    _check_relation(theirs, ours, source.where, target, other_study)
    changes = target.rewriting if theirs.tombstones else target.writing
    try:
        with changes() as connection:
            merged = _take(connection, theirs, source)
    except IntegrityError as error:
        raise BadInput(f"{source.where} does not hold together ({error.orig}); nothing was taken from it.") from None
    if theirs.tombstones:
        clean_backups(target)
        target.purge()
    return merged


def _read(connection: Connection) -> _Content:
    found = _Content(
        connection.execute(select(schema.study)).one(),
        {table.name: every_row(connection, table) for table in _MERGED},
        every_row(connection, schema.event),
        read_tombstones(connection),
        list(connection.scalars(select(schema.blob.c.key).order_by(schema.blob.c.key))),
    )
    return found if found.packet is None else _answered(found)


def _answered(packet: _Content) -> _Content:
    """Of a packet the items that have votes: what they refer to should its study not know it yet."""
    ids = {row["item_id"] for row in packet.events}
    items = [row for row in packet.tables["item"] if row["id"] in ids]
    shown = [read_payload(row["payload"]) for row in items if row["kind"] == "shape"]
    return packet._replace(tables=packet.tables | {"item": items}, shapes=shapes_shown(shown, packet.shapes))


def _check_relation(theirs: _Content, ours: Row[Any], source: str, target: StudyHandle, other_study: bool) -> None:
    """Refuse what does not belong together."""
    if target.volunteer is not None:
        raise BadInput(f"{target.where} is for {target.volunteer} alone and takes nothing in; merge into the study itself.")
    if theirs.study.id == ours.id:
        return
    if theirs.packet is not None:
        raise BadInput(f"{source} is a packet of another study ({theirs.study.name!r}, not {ours.name!r}); merge it into that.")
    if not other_study and not _tops_up(theirs.study, ours):
        raise BadInput(
            f"{source} belongs to another study ({theirs.study.name!r}, not {ours.name!r}); "
            "merge copies of one study, or say that it is meant to be another."
        )


def _take(connection: Connection, theirs: _Content, source: StudyHandle) -> Merged:
    """Take it in, in an open transaction of the study that receives (one that may change votes if tombstones come)."""
    ours = connection.execute(select(schema.study)).one()
    buried = bury(connection, theirs.tombstones)
    gone = lay_to_rest(connection, buried) if theirs.tombstones else 0
    whole, same = theirs.packet is None, theirs.study.id == ours.id
    tables = theirs.tables | {
        "volunteer": _left(_seeded(theirs.tables["volunteer"], whole and same), buried.volunteer),
        "assignment": _left(theirs.tables["assignment"], buried.assignment),
    }
    if whole and same:
        unite(connection, schema.study, [dict(theirs.study._mapping)])
    new = {table.name: unite(connection, table, tables[table.name], only_new=not whole and table is schema.item)
           for table in (_MERGED if whole else _OF_A_PACKET)}  # fmt: skip
    if _tops_up(theirs.study, ours):
        settle_probabilities(connection)
    unite_blobs(connection, source, theirs.shapes, only_new=not whole)
    events = append(connection, _left(_own(theirs, source.where), buried.event), source.where)
    return Merged(new["item"], new.get("run", 0), new["volunteer"], events, gone)


def _tops_up(theirs: Row[Any], ours: Row[Any]) -> bool:
    """Whether a study was made to top up another one, or to top up one that does."""
    return theirs.id != ours.id and ours.id in (json.loads(theirs.settings).get("tops_up"), family_of(theirs))


def _left(rows: list[Cells], what: Callable[[Cells], Cells | None]) -> list[Cells]:
    """What tombstones leave of rows."""
    return [left for row in rows if (left := what(row)) is not None]


def _seeded(volunteers: list[Cells], keep: bool) -> list[Cells]:
    """Volunteers with the seeds that they have in a copy of the same study; those of packets and others say nothing."""
    return volunteers if keep else [row | {"seed": ""} for row in volunteers]


def _own(theirs: _Content, where: str) -> list[Cells]:
    """The events, which in a packet are all of its volunteer."""
    strangers = {row["volunteer"] for row in theirs.events} - {theirs.packet}
    if theirs.packet is not None and strangers:
        raise BadInput(f"{where} is the packet of {theirs.packet} and holds votes of {min(strangers)}; it was tampered with.")
    return theirs.events
