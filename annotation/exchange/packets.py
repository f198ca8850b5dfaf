"""Packets: a study file that holds what one volunteer is to be asked, and nothing else.

Everything in it is the same whether a match is judged or checks attention: rows lie in the order of their hashes, bear one
stamp, and say nothing of runs, files, samples, known answers (but those of practice) or anybody else. What the volunteer
adds to it is merged into the study (see `annotation.exchange.merging`).
"""

import json
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from sqlalchemy import Connection, Row, delete, exists, insert, select

from engine.errors import BadInput, BadParameter

from ..records import OpenItem
from ..results.proposals import canonical
from ..results.shownitems import shown_parts
from ..storage import schema
from ..storage.blobs import keep_shapes, shape_key
from ..storage.database import create_file
from ..storage.handle import StudyHandle
from ..storage.payloads import DAMAGED, read_payload, two_sides
from ..storage.stamps import now
from ..voting.answering import checked_code, item, open_items, settle_seeds
from .uniting import Cells

STAMP = "1970-01-01T00:00:00.000000+00:00"  # of every row that a packet would otherwise tell apart by its time
_assigned, _events = schema.assignment.c, schema.event.c


class Packet(NamedTuple):
    """What was put in a packet: matches to be judged (gold among them), and those to practise on."""

    path: Path
    items: int
    practice: int


def make_packet(handle: StudyHandle, code: str, out: Path | str, items: int | None = None) -> Packet:
    """Make the packet of a volunteer: all that is open, or the first `items` of it, with what there is to practise on.

    The study remembers what was handed out, so that others are asked less about it. A packet that got lost is made again
    with the same contents; once it has come back, the next one holds new matches. Raises `BadParameter` for less than one
    item, `BadInput` where nothing is open, where shapes are not to be found, or where the file cannot be made.
    """
    code, path = checked_code(code), Path(out).absolute()
    if handle.volunteer is not None:
        raise BadInput(f"{handle.where} is for {handle.volunteer} alone; make packets from the study itself.")
    if items is not None and items < 1:
        raise BadParameter(f"A packet of {items} matches holds nothing; ask for at least 1.")
    _take_back(handle, code)
    order = open_items(handle, code)
    chosen = [one for one in order if one.round == 0] + [one for one in order if one.round > 0][:items]
    if all(one.round == 0 for one in chosen):
        raise BadInput(f"Nothing is open for {code}; add results or votes that are wanted first.")
    _embed(handle, chosen)
    new = _hand_out(handle, code, [one.item_id for one in chosen if one.round > 0])
    try:
        with handle.reading() as connection:
            contents = _contents(connection, code, chosen)
            create_file(path, lambda fresh: _fill(fresh, contents, connection))
    except BaseException:
        _withdraw(handle, code, new)
        raise
    return Packet(path, sum(one.round > 0 for one in chosen), sum(one.round == 0 for one in chosen))


def blinded(payload: dict[str, Any]) -> dict[str, Any]:
    """What an item shows and nothing else: files may be named after methods."""
    if "pieces" in payload:
        pieces = [{name: piece[name] for name in ("piece", "x", "y", "png")} for piece in payload["pieces"]]
        return {"size": payload["size"], "pieces": pieces}
    shown = ("sha256", "segments", "segmentation")
    return {
        side: {"file": ""} | {name: payload[side][name] for name in shown if name in payload[side]}
        for side in ("source", "target")
    }


def _take_back(handle: StudyHandle, code: str) -> None:
    """Forget what a volunteer was handed out, once every match of it has come back with an answer."""
    mine = _assigned.volunteer == code
    answered = exists().where(_events.item_id == _assigned.item_id, _events.volunteer == code, _events.round == 1)
    with handle.writing() as connection:
        if connection.scalar(select(_assigned.item_id).where(mine, ~answered).limit(1)) is None:
            connection.execute(delete(schema.assignment).where(mine))


def _embed(handle: StudyHandle, chosen: Sequence[OpenItem]) -> None:
    """Put the shapes of items into the study, of those that are not there yet; raises `BadInput` for what is lost."""
    with handle.reading() as connection:
        kept = set(connection.scalars(select(schema.blob.c.key)))
    lost: set[str] = set()
    for one in chosen:
        shown = item(handle, one.item_id)
        sides = two_sides(shown.payload) if shown.kind == "shape" else ()
        if all(_keys_of(side, kept) for side in sides):
            continue
        try:
            keep_shapes(handle, shown_parts(handle, shown)[:2])
            kept |= {shape_key(side) for side in sides}
        except BadInput:
            lost |= {Path(side["file"]).name or side["sha256"][:12] for side in sides}
    if lost:
        names = ", ".join(sorted(lost)[:5]) + (" and others" if len(lost) > 5 else "")
        raise BadInput(f"The shapes that matches show are neither in the study nor in their files ({names}); put these beside "
                       "the study as they were matched.")  # fmt: skip


def shapes_shown(payloads: Iterable[Mapping[str, Any]], keys: Collection[str]) -> list[str]:
    """Those of `keys` whose shapes are shown by items of shapes with these payloads, in order."""
    return sorted({key for payload in payloads for side in two_sides(payload) for key in _keys_of(side, keys)})


def _keys_of(side: Mapping[str, Any], keys: Collection[str]) -> list[str]:
    """The keys of the shapes that a side may mean (see `annotation.storage.blobs.kept_shapes`)."""
    if side.get("segmentation"):
        return [key for key in (shape_key(side),) if key in keys]
    return [key for key in keys if key.startswith(f"{side['sha256']}:")]


def _hand_out(handle: StudyHandle, code: str, ids: Iterable[str]) -> list[str]:
    """Note what a volunteer gets, and return what is new; raises `BadInput` where somebody else got ahead."""
    view = schema.open_item.c
    with handle.writing() as connection:
        still = set(connection.scalars(select(view.item_id).where(view.volunteer == code)))
        if not set(ids) <= still:
            raise BadInput(f"{handle.where} was changed while the packet was made; make it again.")
        known = set(connection.scalars(select(_assigned.item_id).where(_assigned.volunteer == code)))
        new = [found for found in ids if found not in known]
        if new:
            made = now()
            rows = [{"item_id": found, "volunteer": code, "made_at": made} for found in new]
            connection.execute(insert(schema.assignment), rows)
        settle_seeds(connection)
    return new


def _withdraw(handle: StudyHandle, code: str, ids: Sequence[str]) -> None:
    with handle.writing() as connection:
        for found in ids:
            connection.execute(delete(schema.assignment).where(_assigned.volunteer == code, _assigned.item_id == found))


def _contents(connection: Connection, code: str, chosen: Sequence[OpenItem]) -> dict[str, list[Cells]]:
    """The rows of a packet by table, without shapes."""
    ids = {one.item_id for one in chosen}
    practice = {row.item_id: row for row in connection.execute(select(schema.practice)) if row.item_id in ids}
    items = [row for row in connection.execute(select(schema.item).order_by(schema.item.c.id)) if row.id in ids]
    study = connection.execute(select(schema.study)).one()
    voter = connection.execute(select(schema.volunteer).where(schema.volunteer.c.code == code)).one()
    own = select(schema.event).where(_events.volunteer == code).order_by(_events.clock, _events.uuid)
    return {
        "study": [dict(study._mapping) | {"seed": "", "settings": canonical({"packet": code}), "votes": 0, "adaptive": 0}],
        "item": [_blind_item(row) for row in items],
        "volunteer": [dict(voter._mapping) | {"adjudicates": 0}],
        "asked": [_blind_asked(row.id, practice.get(row.id)) for row in items],
        "event": [dict(row._mapping) for row in connection.execute(own) if row.item_id in ids],
    }


def _blind_item(row: Row[Any]) -> Cells:
    try:
        shown = canonical(blinded(read_payload(row.payload)))
    except (KeyError, TypeError):
        raise BadInput(DAMAGED) from None
    return {"id": row.id, "kind": row.kind, "payload": shown, "created_at": STAMP}


def _blind_asked(item_id: str, told: Row[Any] | None) -> Cells:
    cells = {"item_id": item_id, "stratum": "", "probability": None, "overlapped": 0, "added_at": STAMP}
    if told is None:
        return cells | {"role": "judged", "answer": None, "reason": ""}
    return cells | {"role": "practice", "answer": told.answer, "reason": told.reason}


def _fill(fresh: Connection, contents: dict[str, list[Cells]], study: Connection) -> None:
    """Write the rows, and the shapes that the items show, by key."""
    for name, rows in contents.items():
        if rows:
            fresh.execute(insert(schema.metadata.tables[name]), rows)
    kept = set(study.scalars(select(schema.blob.c.key)))
    shown = [json.loads(row["payload"]) for row in contents["item"] if row["kind"] == "shape"]
    for key in shapes_shown(shown, kept):
        content = study.scalars(select(schema.blob.c.content).where(schema.blob.c.key == key)).one()
        fresh.execute(insert(schema.blob).values(key=key, content=bytes(content)))
