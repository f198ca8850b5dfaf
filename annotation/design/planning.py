"""How many matches a study has to judge for an interval of a wanted width, and what work that is. Pure but for `estimated`."""

import math
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from engine.errors import BadParameter
from engine.parameters import Parameters, parameter

from ..findings.precision import ballots, proposed
from ..storage.handle import StudyHandle
from ..voting.answering import current_votes, seconds_each
from ..voting.majority import majorities
from .designing import Design
from .sampling import gold_wanted

MOST_PAIRS = 10_000_000
_WANTED, _EXPECTED, _WORK = "Wanted", "Expected matches", "Expected volunteers"


class Expectations(Parameters):
    """What is wanted of a study and what is expected of its matches and volunteers."""

    half_width: float = parameter(
        0.05, "Half the width of the interval of the precision.", low=0.005, high=0.4, step=0.005, group=_WANTED)  # fmt: skip
    confidence: float = parameter(0.95, "Confidence of that interval.", low=0.5, high=0.999, step=0.01, group=_WANTED)
    precision: float = parameter(
        0.8, "Precision that is expected of the method.", low=0.01, high=0.99, step=0.01, group=_EXPECTED)  # fmt: skip
    per_pair: float = parameter(
        10.0, "Matches of one method on a pair.", low=1.0, high=10_000.0, step=1.0, unit="matches", group=_EXPECTED)  # fmt: skip
    correlation: float = parameter(
        0.1, "How alike the matches of one pair turn out (intraclass correlation): 0 not at all, 1 all the same.", low=0.0,
        high=1.0, step=0.01, symbol="ρ", group=_EXPECTED)  # fmt: skip
    volunteers: int = parameter(3, "Number of volunteers.", low=1, high=10_000, group=_WORK)
    disagreement: float = parameter(
        0.2, "Share of matches on which two volunteers differ.", low=0.0, high=0.5, step=0.01, group=_WORK)  # fmt: skip
    abstention: float = parameter(
        0.05, "Share of votes that are unsure.", low=0.0, high=0.9, step=0.01, group=_WORK)  # fmt: skip
    seconds: float = parameter(8.0, "Time that a vote takes.", low=0.5, high=600.0, step=0.5, unit="s", group=_WORK)


class Needed(NamedTuple):
    """What a study takes. `low` and `high` are the interval to be expected; hours are of all volunteers together."""

    pairs: int
    matches: int
    design_effect: float
    low: float
    high: float
    votes_each: float
    gold: int
    votes: int
    hours: float
    hours_each: float


def needed(expected: Expectations, design: Design) -> Needed:
    """The fewest pairs whose interval is expected to be as narrow as wanted, and their votes under a design."""
    pairs = pairs_needed(expected)
    matches = math.ceil(pairs * expected.per_pair - 1e-9)
    gold = min(matches, gold_wanted(matches, design.gold, design.gold_least))
    k, people = design.votes or expected.volunteers, expected.volunteers
    all_votes, fewer = (
        votes_each(k, adaptive, expected.disagreement, expected.abstention, people) for adaptive in (False, True)
    )
    share = design.overlap if design.adaptive and design.votes else 1.0
    each = share * all_votes + (1 - share) * fewer
    votes = math.ceil((matches - gold) * each + people * (gold + design.practice) - 1e-9)
    hours = votes * expected.seconds / 3600
    return Needed(
        pairs, matches, design_effect(expected.per_pair, expected.correlation), *interval_of(pairs, expected), each, gold,
        votes, hours, hours / people,
    )  # fmt: skip


def design_effect(per_pair: float, correlation: float) -> float:
    """By how much more the share of clustered matches varies than that of independent ones: 1 + (m - 1) ρ (Kish 1965)."""
    return 1 + (per_pair - 1) * correlation


def interval_of(pairs: int, expected: Expectations) -> tuple[float, float]:
    """The interval that so many pairs are expected to give, as `engine.evaluation.intervals.cluster_robust` makes it."""
    from scipy.special import expit, logit, stdtrit

    p = expected.precision
    variance = design_effect(expected.per_pair, expected.correlation) / (pairs * expected.per_pair * p * (1 - p))
    reach = stdtrit(pairs - 1, (1 + expected.confidence) / 2) * math.sqrt(variance)
    return float(expit(logit(p) - reach)), float(expit(logit(p) + reach))


def pairs_needed(expected: Expectations) -> int:
    """The fewest pairs, two at least, whose interval has at most the wanted half width.

    Raises `BadParameter` where that takes more pairs than anybody has.
    """

    def narrow(pairs: int) -> bool:
        low, high = interval_of(pairs, expected)
        return high - low <= 2 * expected.half_width

    high = 2
    while not narrow(high):
        high *= 2
        if high > MOST_PAIRS:
            raise BadParameter("No number of pairs gives so narrow an interval; ask for a wider one.")
    return _first(narrow, high // 2, high)


def _first(holds: Callable[[int], bool], low: int, high: int) -> int:
    """The first number above `low` that a condition holds of, which it does from there on and of `high`."""
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def votes_each(k: int, adaptive: bool, disagreement: float, abstention: float, volunteers: int) -> float:
    """Expected votes on a match that is to get `k`, by the rule of `annotation.storage.schema.WANTED`.

    Volunteers answer as most would with one probability q, 2 q (1 - q) being the share of disagreement. A match that k
    votes leave unresolved gets one more, if there is a volunteer left.
    """
    q = (1 + math.sqrt(1 - 2 * disagreement)) / 2

    @cache
    def from_here(right: int, wrong: int, votes: int) -> float:
        if votes == volunteers or votes > k or (votes == k and right != wrong) or (adaptive and 2 * max(right, wrong) > k):
            return 0.0
        chances = ((q, 1, 0), (1 - q, 0, 1))
        going_on = sum(share * from_here(right + r, wrong + w, votes + 1) for share, r, w in chances)
        return 1 + abstention * from_here(right, wrong, votes + 1) + (1 - abstention) * going_on

    return from_here(0, 0, 0)


def intraclass_correlation(correct: Sequence[int], decided: Sequence[int]) -> float | None:
    """How alike the matches of one pair turn out, in [0, 1], by the analysis of variance of 0 and 1 (Ridout et al.,
    Biometrics 55, 1999).

    `correct` of `decided` matches a pair, (G,) each. None where nothing can be said: fewer than two pairs, one match in
    each, or no two matches that differ.
    """
    n = np.array([d for d in decided if d], float)
    k = np.array([c for c, d in zip(correct, decided, strict=True) if d], float)
    groups, total = len(n), n.sum()
    if groups < 2 or total <= groups or k.sum() in (0, total):
        return None
    between = (np.sum(k * k / n) - k.sum() ** 2 / total) / (groups - 1)
    within = (k.sum() - np.sum(k * k / n)) / (total - groups)
    size = (total - np.sum(n * n) / total) / (groups - 1)
    return float(np.clip((between - within) / (between + (size - 1) * within), 0.0, 1.0))


def disagreement_of(answers: Iterable[Sequence[str]]) -> float | None:
    """The share of items on which two random decisive answers differ, over the items with two or more; None without."""
    shares = []
    for given in answers:
        a, b = given.count("correct"), given.count("wrong")
        if a + b > 1:
            shares.append(2 * a * b / ((a + b) * (a + b - 1)))
    return sum(shares) / len(shares) if shares else None


def estimated(handle: StudyHandle) -> dict[str, Any]:
    """What a study's own votes say of these expectations, by name; what they do not tell is not there."""
    results, votes = proposed(handle), ballots(handle)
    pairs: dict[str, set[str]] = {}
    for result in results:
        pairs.setdefault(result.pair, set()).update(result.items)
    verdicts = majorities(set().union(*pairs.values()), ((vote.item, vote.answer) for vote in votes))
    said = [[verdicts[item].verdict for item in items] for items in pairs.values()]
    correct = [verdict.count("correct") for verdict in said]
    decided = [c + verdict.count("wrong") for c, verdict in zip(correct, said, strict=True)]
    answers: dict[str, list[str]] = {}
    for vote in votes:
        answers.setdefault(vote.item, []).append(vote.answer)
    times = [vote.active_ms if vote.active_ms is not None else vote.shown_ms for vote in current_votes(handle)]
    told: dict[str, float | None] = {
        "precision": sum(correct) / sum(decided) if sum(decided) else None,
        "per_pair": sum(len(result.items) for result in results) / len(results) if results else None,
        "correlation": intraclass_correlation(correct, decided),
        "volunteers": len({vote.volunteer for vote in votes}) or None,
        "disagreement": disagreement_of(answers.values()),
        "abstention": sum(vote.answer == "unsure" for vote in votes) / len(votes) if votes else None,
        "seconds": seconds_each([ms for ms in times if ms is not None]),
    }
    return {name: _within(name, value) for name, value in told.items() if value is not None}


class Held(NamedTuple):
    """What a study has of one method: its pairs and distinct matches, and how many of them have a vote that decides."""

    method: str
    preset: str
    pairs: int
    matches: int
    judged: int


def held(handle: StudyHandle) -> tuple[Held, ...]:
    """What the study has to put against what is needed, by method and preset."""
    decided = {vote.item for vote in ballots(handle) if vote.answer != "unsure"}
    found: dict[tuple[str, str], tuple[set[str], set[str]]] = {}
    for result in proposed(handle):
        pairs, items = found.setdefault((result.method, result.preset), (set(), set()))
        pairs.add(result.pair)
        items.update(result.items)
    return tuple(Held(*name, len(pairs), len(items), len(items & decided)) for name, (pairs, items) in sorted(found.items()))


def _within(name: str, value: float) -> float:
    """A value moved into the declared range."""
    limits = {side: getattr(mark, side) for mark in Expectations.model_fields[name].metadata
              for side in ("ge", "le") if hasattr(mark, side)}  # fmt: skip
    return min(max(value, limits["ge"]), limits["le"])
