"""Precision from majority votes: one row for each method, preset and set.

A match counts as right or wrong by its majority; ties and matches without a decisive vote are unresolved: they are
in no precision, and the bounds say what they could make of it. The unit of sampling is the pair of inputs, or the puzzle.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from sqlalchemy import func, select

from engine.evaluation.intervals import Interval, clustered_interval

from . import schema
from .handle import StudyHandle
from .majority import Majority, majorities

ALL_SETS = "(all)"


class PrecisionRow(NamedTuple):
    """Figures of one method and preset on one set; shares lie in [0, 1], None where nothing is decided.

    `matches` = `correct` + `wrong` + `tie` + `unjudged`; `judged` leaves out the last. `micro` is correct / (correct +
    wrong), `macro` its mean over the pairs that have a decided match; `bound_low`, `bound_high` take all unresolved
    matches as wrong, as right. `unsure` is the share of abstentions among the votes.
    """

    method: str
    preset: str
    set_name: str
    parameter_sets: int
    pairs: int
    matches: int
    judged: int
    correct: int
    wrong: int
    tie: int
    unjudged: int
    micro: float | None
    macro: float | None
    interval: Interval | None
    bound_low: float | None
    bound_high: float | None
    volunteers: int
    votes: int
    unsure: float | None


class Proposed(NamedTuple):
    """The items that the newest run of a method, preset and set proposed for one pair."""

    method: str
    preset: str
    set_name: str
    pair: str
    parameters: str
    items: tuple[str, ...]


class Ballot(NamedTuple):
    """One vote that counts."""

    item: str
    volunteer: str
    answer: str


def precision_table(handle: StudyHandle, *, round: int = 1) -> tuple[PrecisionRow, ...]:
    """The rows of a study by method, preset and set, and a row over all sets where a method has several."""
    return tabulate(proposed(handle), ballots(handle, round=round))


def proposed(handle: StudyHandle) -> tuple[Proposed, ...]:
    """What each method proposed for each pair, by its newest run there (a re-run replaces, it does not count twice)."""
    run, match = schema.run.c, schema.run_match.c
    group = (run.method, run.preset, run.set_name, run.pair)
    newest = func.row_number().over(partition_by=group, order_by=(run.added_at.desc(), run.id.desc())).label("age")
    with handle.reading() as connection:
        runs = connection.execute(select(run.id, *group, run.parameters, newest).order_by(*group)).all()
        items: dict[str, list[str]] = {}
        for row in connection.execute(select(match.run_id, match.item_id).order_by(match.run_id, match.rank)):
            items.setdefault(row.run_id, []).append(row.item_id)
    return tuple(
        Proposed(row.method, row.preset, row.set_name, row.pair, row.parameters, tuple(items.get(row.id, ())))
        for row in runs
        if row.age == 1
    )


def ballots(handle: StudyHandle, *, round: int = 1) -> tuple[Ballot, ...]:
    """The votes that count."""
    vote = schema.current_vote.c
    with handle.reading() as connection:
        rows = connection.execute(select(vote.item_id, vote.volunteer, vote.answer).where(vote.round == round))
        return tuple(Ballot(*row) for row in rows)


def tabulate(results: Iterable[Proposed], votes: Sequence[Ballot]) -> tuple[PrecisionRow, ...]:
    """The rows of results under votes; pure."""
    groups: dict[tuple[str, str], dict[str, list[Proposed]]] = {}
    for result in results:
        groups.setdefault((result.method, result.preset), {}).setdefault(result.set_name, []).append(result)
    rows = []
    for (method, preset), sets in sorted(groups.items()):
        rows += [precision_row(method, preset, name, found, votes) for name, found in sorted(sets.items())]
        if len(sets) > 1:
            every = [result for found in sets.values() for result in found]
            rows.append(precision_row(method, preset, ALL_SETS, every, votes))
    return tuple(rows)


def precision_row(
    method: str, preset: str, set_name: str, results: Sequence[Proposed], votes: Sequence[Ballot]
) -> PrecisionRow:
    """One row; a pair that is in several sets counts once."""
    pairs: dict[str, set[str]] = {}
    for result in results:
        pairs.setdefault(result.pair, set()).update(result.items)
    items = set[str]().union(*pairs.values())
    cast = [vote for vote in votes if vote.item in items]
    verdicts = majorities(items, ((vote.item, vote.answer) for vote in cast))
    count = {
        name: sum(m.verdict == name for m in verdicts.values()) for name in ("correct", "wrong", "tie", "unjudged")
    }
    correct, decided = _by_pair(pairs.values(), verdicts)
    shares = [k / n for k, n in zip(correct, decided, strict=True) if n]
    m, unresolved = len(items), count["tie"] + count["unjudged"]
    return PrecisionRow(
        method, preset, set_name, len({result.parameters for result in results}), len(pairs), m, m - count["unjudged"],
        **count,
        micro=_share(count["correct"], count["correct"] + count["wrong"]),
        macro=_share(sum(shares), len(shares)),
        interval=clustered_interval(correct, decided),
        bound_low=_share(count["correct"], m),
        bound_high=_share(count["correct"] + unresolved, m),
        volunteers=len({vote.volunteer for vote in cast}),
        votes=len(cast),
        unsure=_share(sum(vote.answer == "unsure" for vote in cast), len(cast)),
    )  # fmt: skip


def _by_pair(pairs: Iterable[set[str]], verdicts: Mapping[str, Majority]) -> tuple[list[int], list[int]]:
    """How many matches of each pair are correct, and how many are decided."""
    given = [[verdicts[item].verdict for item in items] for items in pairs]
    correct = [verdict.count("correct") for verdict in given]
    return correct, [k + verdict.count("wrong") for k, verdict in zip(correct, given, strict=True)]


def _share(part: float, whole: int) -> float | None:
    return part / whole if whole else None
