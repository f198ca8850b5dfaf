"""How the rows of two copies of a study become one set: a union, and the greater of two rows of one key."""

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from sqlalchemy import Connection, Table, and_, insert, select, update

from engine.errors import BadInput

from ..storage import schema
from ..storage.handle import StudyHandle

Cells = dict[str, Any]
_blob = schema.blob.c


def unite(connection: Connection, table: Table, rows: Sequence[Cells], *, only_new: bool = False) -> int:
    """Add the rows whose key is new, and return how many; of two rows with one key what `joined_rows` says stays.

    With `only_new` rows of a known key are left alone.
    """
    keys = [column.name for column in table.primary_key]
    known = {_key(row, keys): row for row in every_row(connection, table)}
    fresh = [row for row in rows if _key(row, keys) not in known]
    for row in () if only_new else rows:
        ours = known.get(_key(row, keys), row)
        if (stays := joined_rows(table, ours, row)) != ours:
            same = and_(*(table.c[key] == row[key] for key in keys))
            connection.execute(update(table).where(same).values(stays))
    if fresh:
        connection.execute(insert(table), fresh)
    return len(fresh)


def joined_rows(table: Table, one: Cells, other: Cells) -> Cells:
    """The row that two of one key make: for a volunteer the greater of every cell, else the whole of the greater row."""
    if table is schema.volunteer:
        return {name: max(one[name], other[name]) for name in one}
    return max(one, other, key=_rank)


def every_row(connection: Connection, table: Table) -> list[Cells]:
    """All rows of a table."""
    return [dict(row._mapping) for row in connection.execute(select(table))]


def unite_blobs(connection: Connection, source: StudyHandle, keys: Iterable[str], *, only_new: bool = False) -> None:
    """Add shapes of the other study, one at a time; of two that are packed differently the longer stays."""
    known = set(connection.scalars(select(_blob.key)))
    with source.reading() as other:
        for key in keys:
            if key not in known:
                connection.execute(insert(schema.blob).values(key=key, content=_content(other, key)))
            elif not only_new and (theirs := _content(other, key)) != (ours := _content(connection, key)):
                stays = max(ours, theirs, key=lambda content: (len(content), content))
                connection.execute(update(schema.blob).where(_blob.key == key).values(content=stays))


def append(connection: Connection, events: Iterable[Cells], where: str) -> int:
    """Add the events that are new, those first that others supersede; raises `BadInput` where histories contradict."""
    known = {row["uuid"]: row for row in every_row(connection, schema.event)}
    fresh = []
    for row in sorted(events, key=lambda row: (row["clock"], row["uuid"])):
        if (ours := known.setdefault(row["uuid"], row)) is row:
            fresh.append(row)
        elif ours != row:
            raise BadInput(f"{where} holds another version of event {row['uuid']}; one of the two files was tampered with.")
        if not _follows(row, known):
            raise BadInput(f"{where} holds a vote in place of one that is not its own ({row['uuid']}); it was tampered with.")
    if fresh:
        connection.execute(insert(schema.event), fresh)
    return len(fresh)


def _follows(row: Cells, known: Mapping[str, Cells]) -> bool:
    """Whether what an event supersedes is there, and of the same volunteer and item."""
    if row["supersedes"] is None:
        return True
    before = known.get(row["supersedes"])
    return before is not None and all(before[name] == row[name] for name in ("volunteer", "item_id", "round"))


def _content(connection: Connection, key: str) -> bytes:
    return bytes(connection.scalars(select(_blob.content).where(_blob.key == key)).one())


def _key(row: Cells, keys: list[str]) -> tuple[Any, ...]:
    return tuple(row[key] for key in keys)


def _rank(row: Cells) -> tuple[Any, ...]:
    """A total order on the rows of one key: the latest of all, the one that tells more of an item, then by content."""
    changed = json.loads(row["settings"]).get("changed_at", "") if "settings" in row else ""
    told = len(row.get("payload", ""))
    return (str(changed), row.get("added_at", ""), told, *((value is not None, value) for value in row.values()))
