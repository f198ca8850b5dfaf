"""A study after it was made: new matches are asked too, gold and practice items are named, what is left becomes a study.

Votes stay as they are. Everything new is drawn by the seed of the study, as `annotation.design.designing` does.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Row, Table, insert, select, update

from engine.errors import BadInput, BadParameter

from ..exchange.tombstones import family
from ..records import Study
from ..results.proposals import batched
from ..storage import schema
from ..storage.handle import StudyHandle
from ..storage.payloads import read_payload
from ..storage.stamps import now
from ..study import about, create_study, study_name
from .designing import Design, put_asked, stratum_of
from .sampling import Drawn, Known, balanced, overlapped, sample

_asked = schema.asked.c


def top_up(handle: StudyHandle, *, most: int | None = None) -> int:
    """Ask the matches of results that are not asked yet too, at most `most` of them; returns how many.

    0 stands for all, which is also what a study without a sample takes. Raises `BadParameter` where a study that asks a
    sample is not told how many more.
    """
    study = about(handle)
    with handle.writing() as connection:
        rows = _drawn(connection, study, _checked(study, most))
        put_asked(connection, rows)
        settle_probabilities(connection)
    return len(rows)


def top_up_study(
    handle: StudyHandle, where: Path | str, *, name: str = "", most: int | None = None
) -> tuple[StudyHandle, int]:
    """Make a study of those matches alone that have no vote yet (and of the practice items); the first stays as it is.

    Its settings say whose top-up it is (`tops_up`), and of which first study (`family`), so that it can be merged back.
    Returns it, open, and how many matches it asks. Raises `BadParameter` where none are left.
    """
    study = about(handle)
    with handle.reading() as connection:
        new = _drawn(connection, study, _checked(study, most))
        voted = set(connection.scalars(select(schema.current_vote.c.item_id).where(schema.current_vote.c.round == 1)))
        before = [_drawn_row(row) for row in connection.execute(select(schema.asked))]
        chances = _chances((*before, *new), _strata(connection))
        old = [row for row in before if row.item_id not in voted]
        every = {row.item_id for row in (*old, *new)} if old or new else _items(connection) - voted
        contents = _contents(connection, every)
    left = sum(row.role != "practice" for row in (*old, *new)) if old or new else len(every)
    if not left:
        raise BadParameter(f"Every match of {handle.where} has a vote; there is nothing left for a top-up.")

    def fill(connection: Connection) -> None:
        for table, rows in contents:
            if rows:
                connection.execute(insert(table), rows)
        put_asked(connection, (_likely(row, chances) for row in (*old, *new)))

    settings = {**study.settings, "tops_up": study.id, "family": family(study.id, study.settings)}
    made = create_study(
        where, name=name or f"{study.name}, {study_name(where)}", question=study.question, guideline=study.guideline,
        seed=study.seed, votes=study.votes, adaptive=study.adaptive, unsure=study.unsure, settings=settings, also=fill,
    )  # fmt: skip
    return made, left


def name_gold(handle: StudyHandle, known: Known, count: int | None = None) -> int:
    """Make matches that are asked gold, at most `count` of those whose answer is known; returns how many are new."""
    return _name(handle, "gold", known, count)


def name_practice(handle: StudyHandle, known: Known, count: int | None = None) -> int:
    """Make matches without any vote practice items, those first that are not asked; they leave the tables."""
    return _name(handle, "practice", known, count)


def _name(handle: StudyHandle, role: str, known: Known, count: int | None) -> int:
    study = about(handle)
    with handle.writing() as connection:
        _ask_by_name(connection)
        rows = {row.item_id: row for row in connection.execute(select(schema.asked))}
        strata, voted = _strata(connection), set(connection.scalars(select(schema.event.c.item_id)))
        open_to = {
            item: told
            for item, told in known.items()
            if (item in strata and item not in voted if role == "practice" else item in rows)
            and (item not in rows or rows[item].role == "judged")
        }
        first = (lambda item: item not in rows) if role == "practice" else (lambda item: True)
        chosen = balanced(open_to, len(open_to) if count is None else count, study.seed, role, first)
        put_asked(connection, (
            Drawn(item, role, known[item].answer, known[item].reason, strata.get(item, ""),
                  rows[item].probability if role == "gold" else None, False)
            for item in chosen
        ))  # fmt: skip
    return len(chosen)


def _checked(study: Study, most: int | None) -> int:
    """How many are to be drawn at most."""
    sampled = _setting(study, "most")
    if most is None and sampled:
        raise BadParameter(f"{study.name} asks a sample of {sampled} matches; say how many more are to be drawn with "
                           "--most, 0 for all.")  # fmt: skip
    if most is not None and most < 0:
        raise BadParameter(f"A top-up of {most} matches is not possible; give 0 for all, or a number above it.")
    return most or 0


def _setting(study: Study, name: str) -> Any:
    """What the study keeps of its design, the default where it keeps nothing; raises `BadInput` where that is none."""
    try:
        kept = {**study.settings.get("design", {})}
        return getattr(Design().changed(**{name: kept.get(name, getattr(Design(), name))}), name)
    except (TypeError, BadParameter):
        raise BadInput(f"The settings of {study.name} are damaged (its design has no {name!r}); use a backup.") from None


def _drawn(connection: Connection, study: Study, most: int) -> list[Drawn]:
    """The matches of results that are not asked yet, or a sample of them; none in a study that asks everything."""
    known = set(connection.scalars(select(_asked.item_id)))
    left = {item: stratum for item, stratum in _strata(connection).items() if item not in known}
    if not known or not left:
        return []
    drawn = sample(left, most, study.seed)
    share = _setting(study, "overlap")
    twice = overlapped(list(drawn), share if study.adaptive and study.votes > 2 else 0.0, study.seed)
    return [Drawn(item, "judged", None, "", left[item], chance, item in twice) for item, chance in drawn.items()]


def settle_probabilities(connection: Connection) -> None:
    """Give what was drawn in several steps, or in a top-up that was merged back, the probability that it has together."""
    rows = [_drawn_row(row) for row in connection.execute(select(schema.asked))]
    for stratum, chance in _chances(rows, _strata(connection)).items():
        drawn = _asked.stratum == stratum, _asked.probability.is_not(None), _asked.probability != chance
        connection.execute(update(schema.asked).where(*drawn).values(probability=chance, added_at=now()))


def _chances(rows: Iterable[Drawn], strata: Mapping[str, str]) -> dict[str, float]:
    """With which probability each item of a stratum is drawn: the number of those drawn over that of all.

    Practice items, and gold ones that were not drawn, are of neither.
    """
    asked = {row.item_id: row for row in rows}
    size, taken = Counter[str](), Counter[str]()
    for item, stratum in strata.items():
        row = asked.get(item)
        if row is None:
            size[stratum] += 1
        elif row.probability is not None:
            size[row.stratum] += 1
            taken[row.stratum] += 1
    return {stratum: drawn / size[stratum] for stratum, drawn in taken.items()}


def _ask_by_name(connection: Connection) -> None:
    """Say in the table that everything is asked, where it says so by being empty."""
    if connection.scalar(select(_asked.item_id).limit(1)) is None:
        strata = _strata(connection)
        put_asked(connection, (Drawn(item, "judged", None, "", strata[item], 1.0, False) for item in sorted(strata)))


def _strata(connection: Connection) -> dict[str, str]:
    """The stratum of every item, by the results that propose it; '' for one of no result."""
    run, match = schema.run.c, schema.run_match.c
    query = select(match.item_id, run.set_name, run.pair).join_from(schema.run_match, schema.run, match.run_id == run.id)
    found: dict[str, str] = {}
    for row in connection.execute(query):
        stratum = stratum_of(row.set_name, row.pair)
        found[row.item_id] = min(stratum, found.get(row.item_id, stratum))
    return dict.fromkeys(sorted(_items(connection)), "") | found


def _items(connection: Connection) -> set[str]:
    return set(connection.scalars(select(schema.item.c.id)))


def _contents(connection: Connection, items: Iterable[str]) -> list[tuple[Table, list[Mapping[str, Any]]]]:
    """The rows of a study that are about some items: these, their results, and the shapes that they show."""
    chosen = sorted(items)
    shown = _picked(connection, schema.item, schema.item.c.id, chosen)
    proposed = _picked(connection, schema.run_match, schema.run_match.c.item_id, chosen)
    runs = _picked(connection, schema.run, schema.run.c.id, sorted({row["run_id"] for row in proposed}))
    meshes = {side.get("sha256") for row in shown for side in read_payload(row["payload"]).values() if isinstance(side, dict)}
    keys = [key for key in connection.scalars(select(schema.blob.c.key)) if key.split(":")[0] in meshes]
    blobs = _picked(connection, schema.blob, schema.blob.c.key, keys)
    return [(schema.item, shown), (schema.run, runs), (schema.run_match, proposed), (schema.blob, blobs)]


def _picked(connection: Connection, table: Table, column: Any, keys: Iterable[str]) -> list[Mapping[str, Any]]:
    """The rows whose key is one of these."""
    return [
        dict(row._mapping)
        for part in batched(keys, 5000)
        for row in connection.execute(select(table).where(column.in_(part)))
    ]


def _likely(row: Drawn, chances: Mapping[str, float]) -> Drawn:
    return row if row.probability is None else row._replace(probability=chances[row.stratum])


def _drawn_row(row: Row[Any]) -> Drawn:
    return Drawn(row.item_id, row.role, row.answer, row.reason, row.stratum, row.probability, bool(row.overlapped))
