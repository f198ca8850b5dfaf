"""Methods beside each other on the same pairs, and how much the figures hang on single volunteers or on the majority rule."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

from engine.evaluation.paired import LEAST_PAIRS, PairedTest, holm, mcnemar, paired_test

from .dawidskene import DawidSkene
from .precision import (
    ALL_SETS,
    Ballot,
    Cast,
    PrecisionRow,
    Proposed,
    Weights,
    by_pair,
    counted,
    grouped,
    items_by_pair,
    tabulate,
    without,
)

Method = tuple[str, str]


class Compared(NamedTuple):
    """A method against another one on the pairs of a set where both have a precision (`test`: second - first).

    McNemar's test asks whether both find the same share of what is known to be correct: its cases are the matches that are
    correct by majority and that either proposes, on the `seen_pairs` pairs where all proposals of both have been seen, and
    a method finds each or does not. `first_alone` of them only the first one finds, `second_alone` only the second. What
    is wrong or a tie is no case: a method is not asked about what it does not propose, and wrong proposals lower precision,
    which `test` compares. `holm_permutation`, `holm_wilcoxon` and `holm_mcnemar` are adjusted for the number of sets; on all
    sets together they are those of the tests themselves. All p-values are None below 6 pairs.
    """

    first: Method
    second: Method
    set_name: str
    test: PairedTest
    holm_permutation: float | None
    holm_wilcoxon: float | None
    seen_pairs: int
    first_alone: int
    second_alone: int
    mcnemar: float | None
    holm_mcnemar: float | None


class LeftOut(NamedTuple):
    """The range of a row's precision when one volunteer at a time is left out, and whose leaving moves it most."""

    method: str
    preset: str
    set_name: str
    micro: float | None
    low: float | None
    high: float | None
    volunteer: str


class Modelled(NamedTuple):
    """A row's precision by majority beside that of Dawid and Skene's model over the same and the tied matches."""

    method: str
    preset: str
    set_name: str
    micro: float | None
    model: float | None
    matches: int


def compared(results: Sequence[Proposed], cast: Mapping[str, Cast], weights: Weights | None = None) -> tuple[Compared, ...]:
    """Every two methods, on each set that both ran on and over all sets."""
    rows: list[Compared] = []
    groups = sorted(grouped(results).items())
    for (first, one), (second, two) in combinations(groups, 2):
        names = sorted(one.keys() & two.keys())
        found = [_compared(first, second, name, one[name], two[name], cast, weights) for name in names]
        p, q = holm([c.test.permutation for c in found]), holm([c.test.wilcoxon for c in found])
        m = holm([c.mcnemar for c in found])
        rows += [c._replace(holm_permutation=p[k], holm_wilcoxon=q[k], holm_mcnemar=m[k]) for k, c in enumerate(found)]
        if len(names) > 1:
            a, b = ([r for name in names for r in sets[name]] for sets in (one, two))
            rows.append(_compared(first, second, ALL_SETS, a, b, cast, weights))
    return tuple(rows)


def _compared(
    first: Method, second: Method, set_name: str, one: Sequence[Proposed], two: Sequence[Proposed],
    cast: Mapping[str, Cast], weights: Weights | None,
) -> Compared:  # fmt: skip
    a, b = items_by_pair(one), items_by_pair(two)
    both = sorted(a.keys() & b.keys())
    test = paired_test(*(_precisions([side[pair] for pair in both], cast, weights) for side in (a, b)))
    seen = [pair for pair in both if all(item in cast for item in a[pair] | b[pair])]
    one_alone, two_alone = (_correct((mine[pair] - other[pair] for pair in seen), cast) for mine, other in ((a, b), (b, a)))
    p = mcnemar(one_alone, two_alone) if len(seen) >= LEAST_PAIRS else None
    return Compared(first, second, set_name, test, test.permutation, test.wilcoxon, len(seen), one_alone, two_alone, p, p)


def _precisions(pairs: Iterable[Iterable[str]], cast: Mapping[str, Cast], weights: Weights | None) -> list[float]:
    """The precision of each pair, NaN where nothing is decided."""
    return [s.correct / s.decided if s.decided else float("nan") for s in by_pair(pairs, cast, weights)]


def _correct(groups: Iterable[Iterable[str]], cast: Mapping[str, Cast]) -> int:
    """How many of these items, all of them seen, are correct."""
    return sum(cast[item].majority.verdict == "correct" for items in groups for item in items)


def leave_one_out(
    results: Sequence[Proposed], votes: Sequence[Ballot], weights: Weights | None = None
) -> tuple[LeftOut, ...]:
    """The range of every row's precision when each volunteer in turn is left out; none with a single volunteer."""
    own: dict[str, list[Ballot]] = {}
    for vote in votes:
        own.setdefault(vote.volunteer, []).append(vote)
    if len(own) < 2:
        return ()
    cast = counted(votes)
    rows = tabulate(results, cast, weights)
    items = [frozenset(item for r in results_of(results, row) for item in r.items) for row in rows]
    left = {code: without(cast, own[code]) for code in sorted(own)}
    return tuple(
        _left_out(row, {code: _micro(mine, votes_left, weights) for code, votes_left in left.items()})
        for row, mine in zip(rows, items, strict=True)
    )


def results_of(results: Iterable[Proposed], row: PrecisionRow) -> list[Proposed]:
    """The results that a row is about."""
    return [r for r in results if (r.method, r.preset) == row[:2] and row.set_name in (r.set_name, ALL_SETS)]


def _micro(items: Iterable[str], cast: Mapping[str, Cast], weights: Weights | None) -> float | None:
    """The pooled precision, None where nothing is decided."""
    (pooled,) = by_pair([items], cast, weights)
    return pooled.correct / pooled.decided if pooled.decided else None


def _left_out(row: PrecisionRow, left: Mapping[str, float | None]) -> LeftOut:
    known = {code: micro for code, micro in left.items() if micro is not None}
    if row.micro is None or not known:
        return LeftOut(row.method, row.preset, row.set_name, row.micro, None, None, "")
    here = row.micro
    most = max(known, key=lambda code: abs(known[code] - here))
    moved = abs(known[most] - here) > 0
    return LeftOut(
        row.method, row.preset, row.set_name, here, min(known.values()), max(known.values()), most if moved else ""
    )


def modelled(
    results: Iterable[Proposed], rows: Sequence[PrecisionRow], model: DawidSkene | None, weights: Weights | None = None
) -> tuple[Modelled, ...]:
    """Each row's precision by majority beside the mean probability of its voted matches under the model."""
    if model is None:
        return ()
    p, every = dict(zip(model.items, model.probability.tolist(), strict=True)), tuple(results)
    found = []
    for row in rows:
        told = [(p[item], 1.0 if weights is None else weights.get(item, 0.0))
                for item in sorted({item for r in results_of(every, row) for item in r.items}) if item in p]  # fmt: skip
        total = sum(weight for _, weight in told)
        share = sum(value * weight for value, weight in told) / total if total else None
        found.append(Modelled(row.method, row.preset, row.set_name, row.micro, share, sum(w > 0 for _, w in told)))
    return tuple(found)


