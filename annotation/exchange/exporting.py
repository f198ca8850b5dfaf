"""Exports for other programs: votes, matches, proposals, runs, volunteers and majorities as CSV, JSON Lines and Parquet.

Beside the tables lies a data dictionary, made from the same declaration (`annotation.exchange.exporttables`).
"""

import io
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from sqlalchemy import Connection, func, select

from engine.errors import BadInput, BadParameter
from engine.store import output_folder, write_together

from ..results.proposals import canonical
from ..storage import schema
from ..storage.handle import StudyHandle
from ..voting.majority import majorities
from .csvtext import csv_text
from .exporttables import TABLES, dictionary, dictionary_text, names

Format = Literal["csv", "jsonl", "parquet"]
FORMATS: tuple[Format, ...] = ("csv", "jsonl", "parquet")
Row = Sequence[Any]


def export(
    handle: StudyHandle, folder: Path | str, formats: Sequence[str] = ("csv",), *, gold: bool = False
) -> tuple[Path, ...]:
    """Write every table of a study and the data dictionary into a folder, all or none; returns the files.

    `gold` adds the table of known answers, which nobody may see who is still to vote. Raises `BadParameter` for an
    unknown format, `BadInput` where the folder cannot be written or Parquet cannot be made.
    """
    files = contents(handle, formats, gold=gold)
    place = output_folder(folder)
    write_together({place / name: content for name, content in files.items()})
    return tuple(place / name for name in files)


def contents(handle: StudyHandle, formats: Sequence[str], *, gold: bool = False) -> dict[str, bytes]:
    """The files of an export by name, each whole, all of one moment of the study."""
    unknown = [name for name in formats if name not in FORMATS]
    if unknown or not formats:
        raise BadParameter(f"{', '.join(unknown) or 'Nothing'} is no format to export to; choose of {', '.join(FORMATS)}.")
    tables = tuple(name for name in TABLES if gold or name != "gold")
    with handle.reading() as connection:
        rows = {table: _rows(connection, table) for table in tables}
    files = {f"{table}.{format}": _WRITERS[format](table, rows[table]) for table in tables for format in dict.fromkeys(formats)}
    files["dictionary.md"] = dictionary_text(tables).encode()
    files["dictionary.json"] = (json.dumps(dictionary(tables), indent=1, ensure_ascii=False) + "\n").encode()
    return files


def votes_csv(handle: StudyHandle) -> str:
    """Every vote ever given, one a row; `state` says whether it counts ("current"), was replaced or retracted."""
    return _csv("votes", table_rows(handle, "votes")).decode()


def table_rows(handle: StudyHandle, table: str) -> list[Row]:
    """The rows of one table, in the order of its columns and in an order that is always the same."""
    with handle.reading() as connection:
        return _rows(connection, table)


def _rows(connection: Connection, table: str) -> list[Row]:
    return [tuple(row) for row in _READERS[table](connection)]


def _votes(connection: Connection) -> Iterator[Row]:
    event, item = schema.event, schema.item
    query = (
        select(event, item.c.kind.label("item_kind"), item.c.payload)
        .join_from(event, item, event.c.item_id == item.c.id)
        .where(event.c.kind == "vote")
        .order_by(event.c.volunteer, event.c.clock, event.c.uuid)
    )
    standing = set(connection.scalars(select(schema.standing_vote.c.uuid)))
    current = set(connection.scalars(select(schema.current_vote.c.uuid)))
    for row in connection.execute(query):
        state = "current" if row.uuid in current else "replaced" if row.uuid in standing else "retracted"
        yield (
            row.item_id, row.item_kind, row.volunteer, row.round, row.answer, state, row.comment, row.clock, row.shown_ms,
            row.active_ms, row.created_at, row.uuid, row.supersedes, _without_pictures(row.payload),
        )  # fmt: skip


def _items(connection: Connection) -> Iterator[Row]:
    item, asked = schema.item, schema.asked
    everything = not connection.scalar(select(func.count()).select_from(asked))
    query = (
        select(item, asked.c.role, asked.c.stratum, asked.c.probability, asked.c.overlapped)
        .join_from(item, asked, asked.c.item_id == item.c.id, isouter=True)
        .order_by(item.c.id)
    )
    for row in connection.execute(query):
        yield (
            row.id, row.kind, everything or row.role is not None, row.stratum or "", row.probability, bool(row.overlapped),
            row.created_at, _without_pictures(row.payload),
        )  # fmt: skip


def _proposals(connection: Connection) -> Iterable[Row]:
    run, match = schema.run.c, schema.run_match.c
    return connection.execute(
        select(
            match.run_id, match.item_id, run.method, run.preset, run.set_name, run.pair, match.rank, match.score, match.votes,
            match.source_layer, match.target_layer,
        )
        .join_from(schema.run_match, schema.run, match.run_id == run.id)
        .order_by(match.run_id, match.rank, match.item_id)
    ).all()  # fmt: skip


def _runs(connection: Connection) -> Iterable[Row]:
    run = schema.run.c
    return connection.execute(
        select(run.id, run.kind, run.method, run.preset, run.set_name, run.pair, run.parameters, run.source, run.target,
               run.seconds, run.app_version, run.added_at).order_by(run.id)
    ).all()  # fmt: skip


def _volunteers(connection: Connection) -> Iterator[Row]:
    event, current = schema.event.c, schema.current_vote.c
    counting = select(current.volunteer, func.count()).where(current.round > 0).group_by(current.volunteer)
    ever = select(event.volunteer, func.count(), func.min(event.created_at), func.max(event.created_at)).where(
        event.kind == "vote", event.round > 0
    )
    count = {row[0]: row[1] for row in connection.execute(counting)}
    given = {row[0]: tuple(row)[1:] for row in connection.execute(ever.group_by(event.volunteer))}
    for row in connection.execute(select(schema.volunteer).order_by(schema.volunteer.c.code)):
        votes, first, last = given.get(row.code, (0, None, None))
        yield row.code, bool(row.adjudicates), count.get(row.code, 0), votes, first, last, row.created_at


def _majority(connection: Connection) -> Iterator[Row]:
    vote = schema.current_vote.c
    ids = connection.scalars(select(schema.item.c.id).order_by(schema.item.c.id)).all()
    given = connection.execute(select(vote.item_id, vote.answer).where(vote.round == 1))
    for item, found in majorities(ids, ((row.item_id, row.answer) for row in given)).items():
        yield item, *found


def _gold(connection: Connection) -> Iterator[Row]:
    asked, current = schema.asked.c, schema.current_vote.c
    votes: dict[str, list[Any]] = {}
    for vote in connection.execute(select(schema.current_vote).order_by(current.volunteer, current.round, current.uuid)):
        votes.setdefault(vote.item_id, []).append(vote)
    for row in connection.execute(select(schema.asked).where(asked.role != "judged").order_by(asked.item_id)):
        known = (row.item_id, row.role, row.answer, row.reason)
        for vote in votes.get(row.item_id, ()):
            agrees = None if vote.answer == "unsure" else vote.answer == row.answer
            yield (*known, vote.volunteer, vote.answer, agrees)
        if row.item_id not in votes:
            yield (*known, None, None, None)


def _without_pictures(payload: str) -> str:
    """A payload as it is, but for the pictures of puzzle pieces: no table takes cells of that size."""
    try:
        content = json.loads(payload)
    except (ValueError, RecursionError):
        return payload  # damaged, and shown as it is
    if not isinstance(content, dict) or "pieces" not in content:
        return payload
    pieces = [{name: value for name, value in piece.items() if name != "png"} for piece in content["pieces"]]
    return canonical(content | {"pieces": pieces})


def _csv(table: str, rows: Sequence[Row]) -> bytes:
    def cell(value: Any) -> Any:
        return str(value).lower() if isinstance(value, bool) else value

    return csv_text(names(table), ([cell(value) for value in row] for row in rows)).encode()


def _jsonl(table: str, rows: Sequence[Row]) -> bytes:
    """One JSON object a line; structured cells are nested."""
    structured = {column.name for column in TABLES[table] if column.type == "json"}

    def line(row: Row) -> str:
        cells = dict(zip(names(table), row, strict=True))
        return canonical({name: json.loads(value) if name in structured else value for name, value in cells.items()})

    return "".join(f"{line(row)}\n" for row in rows).encode()


def _parquet(table: str, rows: Sequence[Row]) -> bytes:
    """A Parquet file whose columns carry their meanings."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise BadInput("Parquet needs pyarrow; install it with pip install 'concord-correspondences[parquet]', or export "
                       "csv or jsonl.") from None  # fmt: skip
    types = {"integer": pyarrow.int64(), "number": pyarrow.float64(), "boolean": pyarrow.bool_()}
    fields = [
        pyarrow.field(c.name, types.get(c.type, pyarrow.string()), metadata={"meaning": c.meaning, "unit": c.unit})
        for c in TABLES[table]
    ]
    columns = [[row[number] for row in rows] for number in range(len(fields))]
    out = io.BytesIO()
    arrays = [pyarrow.array(column, field.type) for column, field in zip(columns, fields, strict=True)]
    pyarrow.parquet.write_table(pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(fields)), out)
    return out.getvalue()


_READERS: Mapping[str, Callable[[Connection], Iterable[Row]]] = {
    "votes": _votes, "items": _items, "proposals": _proposals, "runs": _runs, "volunteers": _volunteers,
    "majority": _majority, "gold": _gold,
}  # fmt: skip
_WRITERS: Mapping[str, Callable[[str, Sequence[Row]], bytes]] = {"csv": _csv, "jsonl": _jsonl, "parquet": _parquet}
