"""The results of a study as they were taken in, newest first, to be judged again elsewhere."""

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import func, select

from ..records import Item, Proposal, Run
from ..storage import schema
from ..storage.blobs import kept_shapes, shape_key
from ..storage.handle import StudyHandle
from ..storage.payloads import read_payload

if TYPE_CHECKING:
    from engine.shapes.segmentation import SegmentedShape


def runs_of_study(handle: StudyHandle) -> tuple[Run, ...]:
    """Every run with its proposals, best first; adding one to another study gives the same run and items there."""
    run, match = schema.run.c, schema.run_match.c
    with handle.reading() as connection:
        items = {row.id: Item(row.id, row.kind, read_payload(row.payload)) for row in connection.execute(select(schema.item))}
        proposals: dict[str, list[Proposal]] = {}
        for row in connection.execute(select(schema.run_match).order_by(match.run_id, match.rank)):
            one = Proposal(items[row.item_id], row.score, row.votes, row.source_layer, row.target_layer)
            proposals.setdefault(row.run_id, []).append(one)
        rows = connection.execute(select(schema.run).order_by(run.added_at.desc(), run.id)).all()
    return tuple(
        Run(row.kind, row.method, row.preset, json.loads(row.parameters), row.set_name, json.loads(row.source),
            json.loads(row.target), json.loads(row.seconds), tuple(proposals.get(row.id, ())))
        for row in rows
    )  # fmt: skip


def shapes_of_study(handle: StudyHandle, runs: tuple[Run, ...]) -> dict[str, "SegmentedShape"]:
    """The shapes of runs that the study keeps, by key."""
    sides: dict[str, Mapping[str, Any]] = {
        shape_key(side): side for run in runs if run.kind == "shape" for side in (run.source, run.target)
    }
    kept = {key: kept_shapes(handle, side) for key, side in sides.items()}
    return {key: shapes[0] for key, shapes in kept.items() if shapes}


class Unasked(NamedTuple):
    """How many matches of a study's results nobody is asked about, and whether the study asks a sample."""

    matches: int
    sampled: bool


def unasked(handle: StudyHandle) -> Unasked:
    """What a top-up could ask; nothing in a study that asks everything."""
    asked = schema.asked.c
    with handle.reading() as connection:
        known = set(connection.scalars(select(asked.item_id)))
        every = set(connection.scalars(select(schema.item.c.id)))
        drawn = set(connection.scalars(select(asked.probability).distinct()))
    return Unasked(len(every - known) if known else 0, any(p is not None and p < 1 for p in drawn))


def item_count(handle: StudyHandle) -> int:
    """How many distinct matches a study has."""
    with handle.reading() as connection:
        return connection.scalar(select(func.count()).select_from(schema.item)) or 0
