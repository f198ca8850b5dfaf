"""Putting a study that was prepared in a file onto a server, as it is."""

from typing import Any

from sqlalchemy import Connection, insert, select

from engine.errors import BadInput

from ..storage import schema
from ..storage.handle import StudyHandle
from .postgres import create_server, is_url


def publish(handle: StudyHandle, address: str) -> None:
    """Copy a study into an empty database, whole or not at all; the two can be merged like any copies afterwards.

    Raises `BadInput` for a packet, for an address that is none, and where the database holds a study already.
    """
    if handle.volunteer is not None:
        raise BadInput(f"{handle.where} is for {handle.volunteer} alone; publish the study itself.")
    if not is_url(address):
        raise BadInput("A study is published on a server; give an address postgresql://USER@HOST:PORT/DATABASE.")
    with handle.reading() as connection:
        create_server(address, lambda fresh: _copy(connection, fresh))


def _copy(connection: Connection, fresh: Connection) -> None:
    """All rows, what others refer to first; shapes one by one, for they are large."""
    for table in schema.metadata.sorted_tables:
        if table is schema.blob:
            continue
        query = select(table).order_by(schema.event.c.clock) if table is schema.event else select(table)
        if rows := [dict(row._mapping) for row in connection.execute(query)]:
            fresh.execute(insert(table), rows)
    for key in connection.scalars(select(schema.blob.c.key)).all():
        content: Any = connection.scalars(select(schema.blob.c.content).where(schema.blob.c.key == key)).one()
        fresh.execute(insert(schema.blob).values(key=key, content=bytes(content)))
