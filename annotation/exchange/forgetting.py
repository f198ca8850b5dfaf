"""Delete me: a volunteer's code leaves a study for good, and no later merge brings it back.

The votes stay under another code, without comments and with their times cut to the day, or go too. The file is rewritten
so that nothing of what was removed can be read from it, and so are its backups.
"""

import contextlib
import json
import sqlite3
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

from sqlalchemy import Connection, Row, delete, func, insert, or_, select, update

from engine.errors import BadInput

from ..results.proposals import canonical
from ..storage import schema
from ..storage.backup import every_backup
from ..storage.database import StudyFile
from ..storage.filecheck import check_inside
from ..storage.handle import StudyHandle
from ..storage.stamps import now
from ..voting.answering import checked_code
from .tombstones import Cells, Tombstone, Tombstones, family_of, joined, read_tombstones, tombstone
from .uniting import every_row, joined_rows

_events, _volunteers, _tombs = schema.event.c, schema.volunteer.c, schema.forgotten.c


class Cleaned(NamedTuple):
    """The backups that were rewritten, and those that had to be removed."""

    rewritten: tuple[Path, ...]
    removed: tuple[Path, ...]


class Forgotten(NamedTuple):
    """What became of a volunteer: the new code, the votes and undos under it, those removed, the texts of others
    (comments, the question) in which the old code still stands, and what became of the backups."""

    pseudonym: str
    kept: int
    removed: int
    mentions: int
    backups: Cleaned


def forget(handle: StudyHandle, code: str, *, votes_too: bool = False) -> Forgotten:
    """Delete a volunteer from an open study and its backups, for good; asking again cleans the files again.

    Raises `BadInput` where the study never heard of the volunteer, is a packet, or is read by another program just now.
    """
    code = checked_code(code)
    if handle.volunteer is not None:
        raise BadInput(f"{handle.where} is for one volunteer alone; delete that file, and the volunteer from its study.")
    with handle.rewriting() as connection:
        study = connection.execute(select(schema.study)).one()
        found = Tombstones(family_of(study), read_tombstones(connection)).of(code)
        if found is None and connection.scalar(select(_volunteers.code).where(_volunteers.code == code)) is None:
            raise BadInput(f"The study has no volunteer {code}; check the code.")
        before = connection.scalar(select(func.count()).select_from(schema.event)) or 0
        made = tombstone(family_of(study), code, votes_kept=not votes_too, at=now())
        if found is not None and found.pseudonym == code:
            made = found._replace(votes_kept=made.votes_kept)
        buried = bury(connection, [made])
        lay_to_rest(connection, buried)
        _rename_in_settings(connection, study, buried)
        after = connection.scalar(select(func.count()).select_from(schema.event)) or 0
        kept = connection.scalar(select(func.count()).where(_events.volunteer == made.pseudonym)) or 0
        mentions = _mentions(connection, code)
    backups = clean_backups(handle)
    handle.purge()
    return Forgotten(made.pseudonym, kept, before - after, mentions, backups)


def bury(connection: Connection, rows: Iterable[Tombstone]) -> Tombstones:
    """Add tombstones to an open study, and return all that it then has."""
    known = {row.code_hash: row for row in read_tombstones(connection)}
    for row in rows:
        ours = known.get(row.code_hash)
        known[row.code_hash] = stays = row if ours is None else joined(ours, row)
        if ours is None:
            connection.execute(insert(schema.forgotten).values(stays._asdict()))
        elif stays != ours:
            connection.execute(update(schema.forgotten).where(_tombs.code_hash == row.code_hash).values(stays._asdict()))
    return Tombstones(family_of(connection.execute(select(schema.study)).one()), known.values())


def lay_to_rest(connection: Connection, buried: Tombstones) -> int:
    """Leave of every deleted volunteer what the tombstones allow, and return how many of them were still there.

    The transaction must be one that may change events.
    """
    gone = 0
    for row in every_row(connection, schema.volunteer):
        left = buried.volunteer(row)
        if left == row:
            continue
        gone += 1
        if left is not None:
            _take_name(connection, left)
        for event in connection.execute(select(schema.event).where(_events.volunteer == row["code"])).all():
            if (cells := buried.event(dict(event._mapping))) is not None:
                connection.execute(update(schema.event).where(_events.uuid == event.uuid).values(cells))
        connection.execute(delete(schema.event).where(_events.volunteer == row["code"]))
        connection.execute(delete(schema.assignment).where(schema.assignment.c.volunteer == row["code"]))
        connection.execute(delete(schema.volunteer).where(_volunteers.code == row["code"]))
    return gone


def clean_backups(handle: StudyHandle) -> Cleaned:
    """Delete from the backups beside a study file whoever is deleted from the study.

    Those that this version of Concord cannot rewrite are removed: damaged ones, and older ones with such a volunteer.
    """
    if not isinstance(handle, StudyFile):
        return Cleaned((), ())
    with handle.reading() as connection:
        rows = read_tombstones(connection)
        buried = Tombstones(family_of(connection.execute(select(schema.study)).one()), rows)
    rewritten, removed = [], []
    for copy in every_backup(handle.path):
        try:
            if _older_without(copy, buried):
                continue
            _clean(copy, rows)
            rewritten.append(copy)
        except BadInput:
            _remove(copy)
            removed.append(copy)
    return Cleaned(tuple(rewritten), tuple(removed))


def _remove(copy: Path) -> None:
    try:
        copy.unlink(missing_ok=True)
    except OSError as error:
        raise BadInput(f"{copy} still names the volunteer and cannot be removed ({error.strerror}); make its folder writable "
                       "and do this again.") from None  # fmt: skip


def _older_without(copy: Path, buried: Tombstones) -> bool:
    """Whether a backup is of an older version and has nobody who is deleted; raises `BadInput` if it has, or is damaged."""
    try:
        with contextlib.closing(sqlite3.connect(copy)) as raw:
            version = check_inside(copy, raw)
            codes = [code for (code,) in raw.execute("SELECT code FROM volunteer")]
    except sqlite3.DatabaseError:
        raise BadInput(f"{copy} cannot be read.") from None
    if version < schema.SCHEMA_VERSION and any(buried.of(code) for code in codes):
        raise BadInput(f"{copy} is too old to be rewritten.")
    return version < schema.SCHEMA_VERSION


def _clean(copy: Path, rows: Iterable[Tombstone]) -> None:
    """Lay to rest in one backup."""
    with StudyFile(copy) as handle:
        with handle.rewriting() as connection:
            buried = bury(connection, rows)
            lay_to_rest(connection, buried)
            study = connection.execute(select(schema.study)).one()
            _rename_in_settings(connection, study, buried)
        handle.purge()


def _take_name(connection: Connection, left: Cells) -> None:
    """Put the volunteer of the new code in, or make one of it and the one that is there."""
    row = connection.execute(select(schema.volunteer).where(_volunteers.code == left["code"])).first()
    if row is None:
        connection.execute(insert(schema.volunteer).values(left))
        return
    stays = joined_rows(schema.volunteer, dict(row._mapping), left)
    connection.execute(update(schema.volunteer).where(_volunteers.code == left["code"]).values(stays))


def _rename_in_settings(connection: Connection, study: Row[Any], buried: Tombstones) -> None:
    """Put new codes for old ones wherever the settings name a volunteer; such settings are newer than all others."""
    settings = json.loads(study.settings)
    renamed = _renamed(settings, buried)
    if renamed != settings:
        renamed["changed_at"] = now()
        connection.execute(update(schema.study).values(settings=canonical(renamed)))


def _renamed(value: Any, buried: Tombstones) -> Any:
    if isinstance(value, dict):
        return {name: _renamed(content, buried) for name, content in value.items()}
    if isinstance(value, list):
        return [_renamed(content, buried) for content in value]
    found = buried.of(value) if isinstance(value, str) and len(value) <= 40 else None
    return value if found is None else found.pseudonym


def _mentions(connection: Connection, code: str) -> int:
    """How many texts that people wrote still hold the code."""
    study = connection.execute(select(schema.study)).one()
    written = sum(code in text for text in (study.name, study.question, study.guideline, study.settings))
    holds = or_(_events.comment.contains(code, autoescape=True), _events.presentation.contains(code, autoescape=True))
    return written + (connection.scalar(select(func.count()).select_from(schema.event).where(holds)) or 0)
