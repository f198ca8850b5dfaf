"""Exchange: study files are merged by the union of their events, and votes are exported as CSV."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

from sqlalchemy import Connection, Row, Table, and_, insert, select, update

from engine.errors import BadInput

from . import schema
from .csvtext import csv_text
from .handle import StudyHandle
from .proposals import canonical
from .study import about, open_study

VOTE_COLUMNS = (
    "item", "kind", "volunteer", "round", "answer", "state", "comment", "clock", "shown_ms", "active_ms",
    "created_at", "uuid", "supersedes", "payload",
)  # fmt: skip


class Merged(NamedTuple):
    """How many rows were new."""

    items: int
    runs: int
    volunteers: int
    events: int


def merge(path_into: Path | str, path_from: Path | str, *, other_study: bool = False) -> Merged:
    """Take everything of one study file into another, in one transaction; the file taken from is not changed.

    Merging any files in any order, any number of times, gives the same content. Raises `BadInput` for files of two
    different studies (unless `other_study`), and for events of one id that differ, which no honest history has.
    """
    with open_study(path_from, backup=False) as source, open_study(path_into) as target:
        ours, theirs = about(target), about(source)
        if ours.id != theirs.id and not other_study:
            raise BadInput(
                f"{path_from} belongs to another study ({theirs.name!r}, not {ours.name!r}); "
                "merge copies of one study, or say that it is meant to be another."
            )
        with source.reading() as connection:
            tables = (schema.item, schema.run, schema.volunteer, schema.run_match)
            found = {table.name: connection.execute(select(table)).all() for table in tables}
            events = connection.execute(select(schema.event).order_by(schema.event.c.clock)).all()
        with target.writing() as connection:
            new = {table.name: _unite(connection, table, found[table.name]) for table in tables}
            return Merged(new["item"], new["run"], new["volunteer"], _append(connection, events, path_from))


def _unite(connection: Connection, table: Table, rows: Iterable[Row[Any]]) -> int:
    """Add the rows whose key is new; of two rows with one key the greater stays, whichever file it came from."""
    keys = [column.name for column in table.primary_key]
    known = {_key(row, keys): row for row in connection.execute(select(table))}
    fresh = [dict(row._mapping) for row in rows if _key(row, keys) not in known]
    for row in rows:
        ours = known.get(_key(row, keys))
        if ours is not None and _rank(row) > _rank(ours):
            same = and_(*(table.c[key] == row._mapping[key] for key in keys))
            connection.execute(update(table).where(same).values(dict(row._mapping)))
    if fresh:
        connection.execute(insert(table), fresh)
    return len(fresh)


def _key(row: Row[Any], keys: list[str]) -> tuple[Any, ...]:
    return tuple(row._mapping[key] for key in keys)


def _rank(row: Row[Any]) -> tuple[Any, ...]:
    """A total order on the rows of one key: the latest added first of all, then by content."""
    content = row._mapping
    return (content.get("added_at", ""), *((value is not None, value) for value in content.values()))


def _append(connection: Connection, events: Iterable[Row[Any]], path: Path | str) -> int:
    """Add the events that are new, those first that others supersede."""
    known = {row.uuid: tuple(row) for row in connection.execute(select(schema.event))}
    fresh = [dict(row._mapping) for row in events if row.uuid not in known]
    for row in events:
        if known.get(row.uuid, tuple(row)) != tuple(row):
            raise BadInput(f"{path} holds another version of event {row.uuid}; one of the two files was tampered with.")
    if fresh:
        connection.execute(insert(schema.event), fresh)
    return len(fresh)


def votes_csv(handle: StudyHandle) -> str:
    """Every vote ever given, one a row; `state` says whether it counts ("current"), was replaced or retracted."""
    event, item = schema.event, schema.item
    query = (
        select(event, item.c.kind.label("item_kind"), item.c.payload)
        .join_from(event, item, event.c.item_id == item.c.id)
        .where(event.c.kind == "vote")
        .order_by(event.c.volunteer, event.c.clock, event.c.uuid)
    )
    with handle.reading() as connection:
        standing = set(connection.scalars(select(schema.standing_vote.c.uuid)))
        current = set(connection.scalars(select(schema.current_vote.c.uuid)))
        rows = connection.execute(query).all()
    return csv_text(VOTE_COLUMNS, (_vote_row(row, standing, current) for row in rows))


def _vote_row(row: Row[Any], standing: set[str], current: set[str]) -> tuple[object, ...]:
    state = "current" if row.uuid in current else "replaced" if row.uuid in standing else "retracted"
    return (
        row.item_id, row.item_kind, row.volunteer, row.round, row.answer, state, row.comment, row.clock, row.shown_ms,
        row.active_ms, row.created_at, row.uuid, row.supersedes, _without_pictures(row.payload),
    )  # fmt: skip


def _without_pictures(payload: str) -> str:
    """A payload as it is, but for the pictures of puzzle pieces: no table takes cells of that size."""
    content = json.loads(payload)
    if "pieces" not in content:
        return payload
    pieces = [{name: value for name, value in piece.items() if name != "png"} for piece in content["pieces"]]
    return canonical(content | {"pieces": pieces})
