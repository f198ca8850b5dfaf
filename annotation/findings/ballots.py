"""What the figures of a study are made of: proposals by the newest run of each method, votes that count, the sample."""

from collections.abc import Mapping
from pathlib import PurePath
from typing import NamedTuple

from sqlalchemy import func, select

from ..storage import schema
from ..storage.handle import StudyHandle
from ..storage.payloads import read_payload

Weights = Mapping[str, float]
"""What each drawn item stands for, 1 / p; items that are not in it were not drawn."""


class Proposed(NamedTuple):
    """The items that the newest run of a method, preset and set proposed for one pair; `name` is for people."""

    method: str
    preset: str
    set_name: str
    pair: str
    parameters: str
    items: tuple[str, ...]
    name: str = ""


class Ballot(NamedTuple):
    """One vote that counts."""

    item: str
    volunteer: str
    answer: str


def proposed(handle: StudyHandle) -> tuple[Proposed, ...]:
    """What each method proposed for each pair, by its newest run there (a re-run replaces, it does not count twice).

    Practice items count in no table.
    """
    run, match, asked = schema.run.c, schema.run_match.c, schema.asked.c
    counted = match.item_id.not_in(select(asked.item_id).where(asked.role == "practice"))
    group = (run.method, run.preset, run.set_name, run.pair)
    newest = func.row_number().over(partition_by=group, order_by=(run.added_at.desc(), run.id.desc())).label("age")
    with handle.reading() as connection:
        runs = connection.execute(
            select(run.id, *group, run.parameters, run.source, run.target, newest).order_by(*group)
        ).all()
        items: dict[str, list[str]] = {}
        for row in connection.execute(select(match.run_id, match.item_id).where(counted).order_by(match.run_id, match.rank)):
            items.setdefault(row.run_id, []).append(row.item_id)
    return tuple(
        Proposed(row.method, row.preset, row.set_name, row.pair, row.parameters, tuple(items.get(row.id, ())),
                 _pair_name(row.source, row.target))
        for row in runs
        if row.age == 1
    )  # fmt: skip


def ballots(handle: StudyHandle, *, round: int = 1) -> tuple[Ballot, ...]:
    """The votes that count."""
    vote = schema.current_vote.c
    with handle.reading() as connection:
        rows = connection.execute(select(vote.item_id, vote.volunteer, vote.answer).where(vote.round == round))
        return tuple(Ballot(*row) for row in rows)


def sample(handle: StudyHandle) -> dict[str, float] | None:
    """What each drawn item stands for; None where nothing was left out, so that every match counts alike."""
    asked = schema.asked.c
    with handle.reading() as connection:
        rows = connection.execute(select(asked.item_id, asked.probability).where(asked.probability.is_not(None))).all()
    return {row.item_id: 1 / row.probability for row in rows} if any(row.probability < 1 for row in rows) else None


def proposed_later(handle: StudyHandle) -> frozenset[str]:
    """The items that came into a study after its sample was drawn, and were not drawn since; none without a sample."""
    asked, item = schema.asked.c, schema.item.c
    with handle.reading() as connection:
        drawn = connection.execute(select(func.min(asked.probability), func.max(asked.added_at)).where(asked.probability.is_not(None)))
        least, last = drawn.one()
        if least is None or least >= 1:
            return frozenset()
        unasked = item.id.not_in(select(asked.item_id))
        return frozenset(connection.scalars(select(item.id).where(unasked, item.created_at > last)))


def _pair_name(source: str, target: str) -> str:
    """The files of the two inputs, or of the one puzzle, without their folders."""
    files = (str(read_payload(side).get("file", "")) for side in (source, target))
    return " – ".join(PurePath(file).name for file in files if file)
