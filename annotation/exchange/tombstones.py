"""Volunteers who asked to be deleted: their codes are known by a hash alone, so that no merge brings them back.

What is left of such a volunteer is a function of the row and the tombstone alone, so it is the same wherever and whenever
a file is merged: another code, no comment, no time of the day; or nothing at all.
"""

import functools
import hashlib
import json
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from sqlalchemy import Connection, Row, select

from engine.errors import BadInput

from ..storage import schema

Cells = dict[str, Any]


class Tombstone(NamedTuple):
    """One row of `forgotten`: the code by which the votes go on, and whether there are any."""

    code_hash: str
    pseudonym: str
    votes_kept: int
    at: str


@functools.lru_cache(maxsize=4096)
def code_hash(family: str, code: str) -> str:
    """A slow hash of a code (scrypt, salted with the study), for codes are short and would be found by trying."""
    return hashlib.scrypt(code.encode(), salt=family.encode(), n=2**14, r=8, p=1, dklen=24).hex()


def family_of(row: Row[Any]) -> str:
    """The family of a row of `study`."""
    return family(row.id, json.loads(row.settings))


def family(study_id: str, settings: Mapping[str, Any]) -> str:
    """The id of a study, or of the first of those of which each tops up the one before: all votes may go there."""
    return str(settings.get("family") or settings.get("tops_up") or study_id)


class Tombstones:
    """All of a study, to be asked about any row that names a volunteer."""

    def __init__(self, family: str, rows: Iterable[Tombstone]) -> None:
        self.family = family
        self.by_hash = {row.code_hash: row for row in rows}
        self.by_pseudonym = {row.pseudonym: row for row in self.by_hash.values()}

    def of(self, code: str) -> Tombstone | None:
        """The tombstone of a volunteer, by the old code or by the new one."""
        if not self.by_hash:
            return None
        return self.by_pseudonym.get(code) or self.by_hash.get(code_hash(self.family, code))

    def event(self, row: Cells) -> Cells | None:
        """What is left of an event."""
        found = self.of(row["volunteer"])
        if found is None or not found.votes_kept:
            return row if found is None else None
        shown = "{}" if row["volunteer"] in row["presentation"] else row["presentation"]
        kept = {"volunteer": found.pseudonym, "comment": "", "presentation": shown, "created_at": day(row["created_at"])}
        return row | kept

    def volunteer(self, row: Cells) -> Cells | None:
        """What is left of a volunteer; the seed of a new code is drawn from it alone (the old one would tell it)."""
        found = self.of(row["code"])
        if found is None or not found.votes_kept:
            return row if found is None else None
        seed = hashlib.sha256(found.code_hash.encode()).hexdigest()
        return row | {"code": found.pseudonym, "seed": seed, "created_at": day(row["created_at"])}

    def assignment(self, row: Cells) -> Cells | None:
        """Who is deleted holds no packet."""
        return row if self.of(row["volunteer"]) is None else None


def tombstone(family: str, code: str, *, votes_kept: bool, at: str) -> Tombstone:
    """The one of a code; the day it was made is all that it says of time."""
    found = code_hash(family, code)
    return Tombstone(found, f"deleted-{found[:12]}", int(votes_kept), day(at))


def joined(one: Tombstone, other: Tombstone) -> Tombstone:
    """Of two of one code: votes stay only where both let them."""
    return Tombstone(one.code_hash, one.pseudonym, min(one.votes_kept, other.votes_kept), min(one.at, other.at))


def day(stamp: str) -> str:
    """A time cut to its day, still in ISO 8601."""
    return f"{stamp[:10]}T00:00:00.000000+00:00"


def read_tombstones(connection: Connection) -> tuple[Tombstone, ...]:
    """Those of an open study."""
    return tuple(Tombstone(*row) for row in connection.execute(select(schema.forgotten)))


def refuse_forgotten(connection: Connection, code: str) -> None:
    """Say that a code belonged to somebody who was deleted: a new volunteer needs another one."""
    rows = read_tombstones(connection)
    if not rows:
        return
    if Tombstones(family_of(connection.execute(select(schema.study)).one()), rows).of(code):
        raise BadInput("The volunteer of this code was deleted from the study; take another code.")

