"""Taking results into a study: every distinct match becomes one item, and each run remembers which it proposed."""

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from sqlalchemy import Connection, insert, select, update

from engine.errors import BadInput

from ..records import Item, Proposal, Run
from ..storage import schema
from ..storage.handle import StudyHandle
from ..storage.stamps import app_version, now


def add_items(handle: StudyHandle, items: Iterable[Item]) -> int:
    """Register items that need no run; those already there stay as they are. Returns how many were new."""
    with handle.writing() as connection:
        return _add_items(connection, items)


def add_run(handle: StudyHandle, run: Run) -> str:
    """Register a run and its items in one transaction, and return its id.

    The same outcome of the same method, parameters, pair and set is the same run: adding it again adds nothing but
    makes it the newest of its pair.
    """
    with handle.writing() as connection:
        return insert_run(connection, run)


def insert_run(connection: Connection, run: Run) -> str:
    """The same in an open transaction."""
    found = run_id(run)
    _add_items(connection, (proposal.item for proposal in run.proposals))
    if connection.execute(update(schema.run).where(schema.run.c.id == found).values(added_at=now())).rowcount:
        return found
    connection.execute(insert(schema.run).values(_run_row(found, run)))
    rows = [
        {"run_id": found, "item_id": p.item.id, "rank": rank, "score": p.score, "votes": p.votes,
         "source_layer": p.source_layer, "target_layer": p.target_layer}
        for rank, p in enumerate(run.proposals, start=1)
    ]  # fmt: skip
    if rows:
        connection.execute(insert(schema.run_match), rows)
    return found


def shape_item(match_id: str, source: Mapping[str, Any], target: Mapping[str, Any]) -> Item:
    """The item of a match between two sides, in an order that is the same when the match was found from B to A."""
    first, second = sorted((dict(source), dict(target)), key=lambda side: (side["sha256"], canonical(side)))
    return Item(match_id, "shape", {"source": first, "target": second})


def distinct(proposals: Iterable[Proposal]) -> tuple[Proposal, ...]:
    """The first proposal of each item (a shape against itself finds a match from both sides)."""
    found: dict[str, Proposal] = {}
    for proposal in proposals:
        found.setdefault(proposal.item.id, proposal)
    return tuple(found.values())


def run_id(run: Run) -> str:
    """Hash of what was run on what and which matches came out; seconds and file names do not count."""
    inputs = [_input(run.source), _input(run.target)]
    ids = sorted(proposal.item.id for proposal in run.proposals)
    return _hash([run.kind, run.method, run.preset, run.parameters, run.set_name, inputs, ids])


def pair_id(source: Mapping[str, Any], target: Mapping[str, Any]) -> str:
    """Hash of the two inputs, the same in either direction."""
    return _hash(sorted((_input(source), _input(target))))


def _input(side: Mapping[str, Any]) -> str:
    """What an input is known by: a mesh and how it was cut up, or a puzzle (which has no second input)."""
    if not side or "pieces" in side:
        return canonical([side.get("sha256", "")])
    return canonical([side["sha256"], side["segments"], side["faces"], side.get("segmentation", "")])


def canonical(value: Any) -> str:
    """JSON with sorted keys and no spaces: equal values give equal text."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)


def _hash(value: Any) -> str:
    return hashlib.sha256(canonical(value).encode()).hexdigest()


def _add_items(connection: Connection, items: Iterable[Item]) -> int:
    given = {item.id: item for item in items}
    known = {found for part in batched(given, 5000) for found in connection.scalars(
        select(schema.item.c.id).where(schema.item.c.id.in_(part)))}  # fmt: skip
    new = {key: item for key, item in given.items() if key not in known}
    for item in new.values():
        if not item.id or item.kind not in ("shape", "puzzle"):
            raise BadInput(f"An item of kind {item.kind!r} with id {item.id!r} cannot be judged; give both.")
    if new:
        rows = [
            {"id": i.id, "kind": i.kind, "payload": canonical(i.payload), "created_at": now()} for i in new.values()
        ]
        connection.execute(insert(schema.item), rows)
    return len(new)


def batched(keys: Iterable[str], size: int) -> Iterator[list[str]]:
    """Keys in lists of at most `size`: a query takes no more than so many."""
    left = list(keys)
    return (left[at : at + size] for at in range(0, len(left), size))


def _run_row(found: str, run: Run) -> dict[str, str]:
    return {
        "id": found, "kind": run.kind, "method": run.method, "preset": run.preset, "set_name": run.set_name,
        "parameters": canonical(run.parameters), "pair": pair_id(run.source, run.target),
        "source": canonical(run.source), "target": canonical(run.target), "seconds": canonical(run.seconds),
        "app_version": app_version(), "added_at": now(),
    }  # fmt: skip
