"""Majority of the answers to one question: a tie stays a tie, and `unsure` is an abstention."""

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Literal, NamedTuple

Answer = Literal["correct", "wrong", "unsure"]
Verdict = Literal["correct", "wrong", "tie", "unjudged"]
ANSWERS: tuple[Answer, ...] = ("correct", "wrong", "unsure")


class Majority(NamedTuple):
    """How many gave each answer, and what follows."""

    correct: int
    wrong: int
    unsure: int
    verdict: Verdict


def verdict(correct: int, wrong: int) -> Verdict:
    """What most said; nothing but abstentions leaves the match unjudged."""
    if correct == wrong:
        return "tie" if correct else "unjudged"
    return "correct" if correct > wrong else "wrong"


def majority_of(answers: Iterable[str] | Mapping[str, int]) -> Majority:
    """The majority of the answers to one item, or of how many gave each."""
    count = Counter(answers)
    correct, wrong, unsure = (count[answer] for answer in ANSWERS)
    return Majority(correct, wrong, unsure, verdict(correct, wrong))


def majorities(items: Iterable[str], votes: Iterable[tuple[str, str]]) -> dict[str, Majority]:
    """The majority of every item, from (item, answer) pairs; votes on other items are left out."""
    answers: dict[str, list[str]] = {item: [] for item in items}
    for item, answer in votes:
        if item in answers:
            answers[item].append(answer)
    return {item: majority_of(given) for item, given in answers.items()}
