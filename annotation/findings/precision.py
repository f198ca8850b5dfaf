"""Precision from majority votes: one row for each method, preset and set.

A match counts as right or wrong by its majority; ties and matches without a decisive vote are undecided: they are
in no precision, and the bounds say what they could make of it. Matches that nobody has seen are unknown, never wrong.
Where items were drawn into a sample, each counts as many as it stands for, 1 / p with p its probability of being drawn
(Hájek 1971); those that were not drawn are in no figure but the counts. The unit of sampling is the pair of inputs, or
the puzzle. Practice votes are of round 0 and never count.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from engine.evaluation.intervals import Interval, clustered_interval, weighted_interval

from ..storage.handle import StudyHandle
from ..voting.majority import ANSWERS, Majority, majority_of, verdict
from .ballots import Ballot, Proposed, Weights, ballots, proposed, proposed_later, sample

ALL_SETS = "(all)"
GUIDED = "(guided)"


class PrecisionRow(NamedTuple):
    """Figures of one method and preset on one set; shares lie in [0, 1], None where nothing is decided.

    `matches` = `correct` + `wrong` + `tie` + `unjudged`; `judged` leaves out the last. `micro` is correct / (correct +
    wrong), `macro` its mean over the pairs that have a decided match; `bound_low`, `bound_high` take all undecided
    matches as wrong, as right. `unsure` is the share of abstentions among the votes. `seen` counts the matches that have
    a vote at all, `unresolved` is the share of these without a majority.

    Where the study is a sample (`sampled`), shares are weighted and the bounds speak of what the `drawn` matches stand for
    and of the `later` ones, which were proposed after the draw and have had no chance; else all are drawn. `recall` is the
    pooled one: correct matches of this method among the distinct correct ones of all methods, on the `recall_pairs` pairs
    on which several methods ran and every proposal of each has been seen. `chosen` says that votes or a truth had a part
    in the parameters (or that people guided the run).
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
    seen: int = 0
    unresolved: float | None = None
    drawn: int = 0
    sampled: bool = False
    recall: float | None = None
    recall_pairs: int = 0
    chosen: bool = False
    later: int = 0


class Cast(NamedTuple):
    """The votes on one item: what most said, and who voted."""

    majority: Majority
    voters: frozenset[str]


def precision_table(handle: StudyHandle, *, round: int = 1) -> tuple[PrecisionRow, ...]:
    """The rows of a study by method, preset and set, and a row over all sets where a method has several."""
    return tabulate(proposed(handle), ballots(handle, round=round), sample(handle), later=proposed_later(handle))


def counted(votes: Iterable[Ballot]) -> dict[str, Cast]:
    """The votes by item; items without a vote are not in it."""
    given: dict[str, dict[str, str]] = {}
    for item, volunteer, answer in votes:
        given.setdefault(item, {})[volunteer] = answer
    return {item: Cast(majority_of(answers.values()), frozenset(answers)) for item, answers in given.items()}


def without(cast: Mapping[str, Cast], votes: Iterable[Ballot]) -> dict[str, Cast]:
    """The same votes but for these."""
    left = dict(cast)
    for item, volunteer, answer in votes:
        count = {name: getattr(left[item].majority, name) - (name == answer) for name in ANSWERS}
        voters = left[item].voters - {volunteer}
        if voters:
            left[item] = Cast(Majority(**count, verdict=verdict(count["correct"], count["wrong"])), voters)
        else:
            del left[item]
    return left


def tabulate(
    results: Iterable[Proposed],
    votes: Sequence[Ballot] | Mapping[str, Cast],
    weights: Weights | None = None,
    chosen: Iterable[str] = (),
    *,
    later: frozenset[str] = frozenset(),
) -> tuple[PrecisionRow, ...]:
    """The rows of results under votes; pure. Methods or presets named in `chosen` have chosen parameters, and `later`
    items had no chance to be drawn into the sample."""
    results, named = tuple(results), frozenset(chosen)
    cast = votes if isinstance(votes, Mapping) else counted(votes)
    pool = judged_pool(results, cast)
    rows = []
    for (method, preset), sets in sorted(grouped(results).items()):
        told = method.endswith(GUIDED) or not named.isdisjoint((method, preset))
        groups = sorted(sets.items())
        if len(sets) > 1:
            groups.append((ALL_SETS, [result for found in sets.values() for result in found]))
        rows += [_row(method, preset, name, found, cast, weights, pool, later)._replace(chosen=told) for name, found in groups]
    return tuple(rows)


def grouped(results: Iterable[Proposed]) -> dict[tuple[str, str], dict[str, list[Proposed]]]:
    """Results by method and preset, then by set."""
    groups: dict[tuple[str, str], dict[str, list[Proposed]]] = {}
    for result in results:
        groups.setdefault((result.method, result.preset), {}).setdefault(result.set_name, []).append(result)
    return groups


def items_by_pair(results: Iterable[Proposed]) -> dict[str, set[str]]:
    """The items of each pair; a pair that is in several sets counts once."""
    pairs: dict[str, set[str]] = {}
    for result in results:
        pairs.setdefault(result.pair, set()).update(result.items)
    return pairs


def judged_pool(results: Iterable[Proposed], cast: Mapping[str, Cast]) -> dict[str, set[str]]:
    """The distinct correct items of all methods on each pair where several ran and all their proposals have been seen."""
    items: dict[str, set[str]] = {}
    methods: dict[str, set[tuple[str, str]]] = {}
    for result in results:
        items.setdefault(result.pair, set()).update(result.items)
        methods.setdefault(result.pair, set()).add((result.method, result.preset))
    return {
        pair: {item for item in found if cast[item].majority.verdict == "correct"}
        for pair, found in items.items()
        if len(methods[pair]) > 1 and all(item in cast for item in found)
    }


def _row(
    method: str, preset: str, set_name: str, results: Sequence[Proposed], cast: Mapping[str, Cast],
    weights: Weights | None, pool: Mapping[str, set[str]], later: frozenset[str],
) -> PrecisionRow:  # fmt: skip
    pairs = items_by_pair(results)
    items = _union(pairs.values())
    drawn = items if weights is None else items & weights.keys()
    seen = [cast[item] for item in items if item in cast]
    count = dict.fromkeys(("correct", "wrong", "tie", "unjudged"), 0)
    for one in seen:
        count[one.majority.verdict] += 1
    decided, m = count["correct"] + count["wrong"], len(items)
    count["unjudged"] += m - len(seen)
    shares = by_pair(pairs.values(), cast, weights)
    known = [s.correct / s.decided for s in shares if s.decided]
    abstained, votes = sum(one.majority.unsure for one in seen), sum(len(one.voters) for one in seen)
    (pooled,) = by_pair([items], cast, weights)  # a match that is in several pairs counts once
    added = len(items & later) if weights is not None else 0
    right, every, weight = pooled.correct, pooled.decided, sum(_weights(drawn, weights)) + added
    wrong = every - right
    found = [pair for pair in pairs if pair in pool]
    return PrecisionRow(
        method, preset, set_name, len({result.parameters for result in results}), len(pairs), m, m - count["unjudged"],
        count["correct"], count["wrong"], count["tie"], count["unjudged"],
        micro=_share(right, every), macro=_share(sum(known), len(known)), interval=interval_of(shares),
        bound_low=_share(right, weight), bound_high=_share(weight - wrong, weight),
        volunteers=len(frozenset[str]().union(*(one.voters for one in seen))), votes=votes,
        unsure=_share(abstained, votes), seen=len(seen), unresolved=_share(len(seen) - decided, len(seen)),
        drawn=len(drawn), sampled=weights is not None,
        recall=_share(len(_union(pool[pair] & pairs[pair] for pair in found)), len(_union(pool[pair] for pair in found))),
        recall_pairs=len(found), later=added,
    )  # fmt: skip


class PairShare(NamedTuple):
    """Amounts of correct and of decided items of one pair, and the sum of the squared weights of the latter."""

    correct: float
    decided: float
    squares: float


def by_pair(pairs: Iterable[Iterable[str]], cast: Mapping[str, Cast], weights: Weights | None) -> list[PairShare]:
    """What is decided of each pair, each drawn item by its weight."""
    found = []
    for items in pairs:
        correct = decided = squares = 0.0
        for item in items if weights is None else sorted(items):  # sums of weights in one order, for equal last digits
            said = cast[item].majority.verdict if item in cast else "unjudged"
            weight = 1.0 if weights is None else weights.get(item, 0.0)
            if said in ("correct", "wrong"):
                correct += weight * (said == "correct")
                decided += weight
                squares += weight * weight
        found.append(PairShare(correct, decided, squares))
    return found


def interval_of(shares: Sequence[PairShare]) -> Interval | None:
    """The interval of the pooled share: of whole counts where all weights are equal, else of weighted amounts."""
    some = [s for s in shares if s.decided]
    total, squares = sum(s.decided for s in some), sum(s.squares for s in some)
    unit = squares / total if some else 1.0  # the common weight, if there is one
    n = [s.decided / unit for s in some]
    whole = all(abs(k - round(k)) < 1e-9 and abs(s.squares / unit - s.decided) < 1e-9 * s.decided
                for k, s in zip(n, some, strict=True))  # fmt: skip
    if whole:
        return clustered_interval([round(s.correct / unit) for s in some], [round(k) for k in n])
    return weighted_interval([s.correct for s in some], [s.decided for s in some], [s.squares for s in some])


def _weights(items: Iterable[str], weights: Weights | None) -> list[float]:
    return [1.0 if weights is None else weights[item] for item in sorted(items)]


def _union(sets: Iterable[set[str]]) -> set[str]:
    return set[str]().union(*sets)


def _share(part: float, whole: float) -> float | None:
    return part / whole if whole else None
