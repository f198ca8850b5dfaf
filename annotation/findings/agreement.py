"""How far volunteers agree: the raw share, and Krippendorff's alpha beside it, which corrects for chance.

Both take one sequence of answers an item, of any number of volunteers; items with fewer than two answers tell nothing
and are left out. Nearly equal answers everywhere make the raw share high and alpha near zero: that is why both are
shown. Krippendorff, Content Analysis (4th ed., 2018), chapter 12.

A study that asks a third volunteer only where two differ has other numbers of answers on disputed items than on agreed
ones, which shifts both figures; those of the items that were marked to get all votes (`overlapped`) are free of that.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple

from sqlalchemy import select

from ..storage import schema
from ..storage.handle import StudyHandle
from .ballots import Ballot

EVERYTHING = "all matches"
OVERLAPPED = "overlapped matches"


class AgreementRow(NamedTuple):
    """Agreement on some of the items, `items` of them with two decisive votes or more; None where it is not defined."""

    of: str
    items: int
    votes: int
    raw: float | None
    alpha: float | None


class VolunteerAgreement(NamedTuple):
    """One volunteer beside the others; abstentions are left out, shares are None where there is nothing to compare.

    `with_majority` is the share of votes that are those of the majority of the others (items where the others are tied are
    left out: `compared` remain), `pairwise` the share of the `pairs` of one vote of this volunteer and one of another on
    the same item that are equal.
    """

    volunteer: str
    votes: int
    compared: int
    with_majority: float | None
    pairs: int
    pairwise: float | None


def _pairable(units: Iterable[Sequence[str]]) -> list[Counter[str]]:
    return [Counter(unit) for unit in units if len(unit) > 1]


def _observed_disagreement(units: list[Counter[str]]) -> float:
    """Share of disagreeing ordered pairs of answers to the same item, an item weighing as many as its answers."""
    total = sum(unit.total() for unit in units)
    return sum((unit.total() ** 2 - sum(n * n for n in unit.values())) / (unit.total() - 1) for unit in units) / total


def raw_agreement(units: Iterable[Sequence[str]]) -> float | None:
    """Share of agreeing pairs of answers to the same item, in [0, 1]; None without an item of two answers."""
    pairable = _pairable(units)
    return 1 - _observed_disagreement(pairable) if pairable else None


def krippendorff_alpha(units: Iterable[Sequence[str]]) -> float | None:
    """Alpha for nominal answers, 1 - D_o / D_e; None (not defined) where all are equal or none can be paired."""
    pairable = _pairable(units)
    pooled = Counter[str]()
    for unit in pairable:
        pooled.update(unit)
    n = pooled.total()
    if len(pooled) < 2:
        return None
    expected = (n * n - sum(count * count for count in pooled.values())) / (n * (n - 1))
    return 1 - _observed_disagreement(pairable) / expected


def decisive(votes: Iterable[Ballot]) -> dict[str, dict[str, str]]:
    """The answers of each volunteer by item; abstentions are left out."""
    found: dict[str, dict[str, str]] = {}
    for item, volunteer, answer in votes:
        if answer != "unsure":
            found.setdefault(item, {})[volunteer] = answer
    return found


def agreement_rows(
    votes: Iterable[Ballot], overlapped: Collection[str] = (), sets: Mapping[str, Collection[str]] | None = None
) -> tuple[AgreementRow, ...]:
    """Agreement on the overlapped items alone (where there are any), on all, and on those of each set (of several)."""
    answers = decisive(votes)
    groups: dict[str, Collection[str]] = {OVERLAPPED: overlapped} if overlapped else {}
    groups[EVERYTHING] = answers.keys()
    if sets and len(sets) > 1:
        groups |= {name or "–": items for name, items in sorted(sets.items())}
    return tuple(_agreement(name, [list(answers[i].values()) for i in items if i in answers]) for name, items in groups.items())


def volunteer_agreement(votes: Iterable[Ballot]) -> tuple[VolunteerAgreement, ...]:
    """Each volunteer beside the others, in the order of their codes."""
    given, compared, with_majority, pairs, equal = (Counter[str]() for _ in range(5))
    for answers in decisive(votes).values():
        count = Counter(answers.values())
        for volunteer, answer in answers.items():
            same, others = count[answer] - 1, len(answers) - 1
            given[volunteer] += 1
            pairs[volunteer] += others
            equal[volunteer] += same
            if 2 * same != others:
                compared[volunteer] += 1
                with_majority[volunteer] += 2 * same > others
    return tuple(
        VolunteerAgreement(v, given[v], compared[v], _share(with_majority[v], compared[v]), pairs[v], _share(equal[v], pairs[v]))
        for v in sorted(given)
    )


def overlapped_items(handle: StudyHandle) -> frozenset[str]:
    """The items that were marked to get all votes, for agreement."""
    asked = schema.asked.c
    with handle.reading() as connection:
        return frozenset(connection.scalars(select(asked.item_id).where(asked.overlapped == 1)))


def _agreement(name: str, units: list[list[str]]) -> AgreementRow:
    several = [unit for unit in units if len(unit) > 1]
    return AgreementRow(name, len(several), sum(map(len, several)), raw_agreement(several), krippendorff_alpha(several))


def _share(part: int, whole: int) -> float | None:
    return part / whole if whole else None
