"""The model of Dawid and Skene (Applied Statistics 28, 1979): how reliable each volunteer is, found from votes alone.

Every match is correct or wrong, a volunteer calls a correct one correct with one probability (sensitivity) and a wrong
one wrong with another (specificity), votes are independent given what the match is. Expectation and maximisation take
turns: what the matches are by what volunteers are worth, and the other way round. Abstentions are left out.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .ballots import Ballot

LEAST_VOLUNTEERS = 3  # of two, nothing can say which of them errs
ROUNDS = 5000
CLOSE = 1e-6  # change of every probability below which the search ends
PRIOR = 1.0  # imagined votes of each kind: few votes do not make a volunteer perfect


class DawidSkene(NamedTuple):
    """What the model says: `probability` (n,) of being correct of each item, and of each volunteer (v,) the shares.

    `trace` is the log of the posterior density after each round (the log-likelihood where `prior` is 0); it never falls.
    """

    items: tuple[str, ...]
    probability: np.ndarray
    volunteers: tuple[str, ...]
    sensitivity: np.ndarray
    specificity: np.ndarray
    prevalence: float
    trace: tuple[float, ...]


def dawid_skene(votes: Sequence[Ballot], *, prior: float = PRIOR) -> DawidSkene | None:
    """Fit the model from the shares of votes on; None with fewer than three volunteers, of whom it can tell nothing."""
    told = [vote for vote in votes if vote.answer != "unsure"]
    items, volunteers = sorted({v.item for v in told}), sorted({v.volunteer for v in told})
    if len(volunteers) < LEAST_VOLUNTEERS:
        return None
    row, column = {name: k for k, name in enumerate(items)}, {name: k for k, name in enumerate(volunteers)}
    of = np.array([row[v.item] for v in told])
    by = np.array([column[v.volunteer] for v in told])
    yes = np.array([v.answer == "correct" for v in told])
    number = np.bincount(of, minlength=len(items))
    p = np.bincount(of, yes, len(items)) / number
    trace: list[float] = []
    while True:
        share, right = _maximised(p, of, by, yes, len(volunteers), prior)
        before = p
        p, objective = _expected(share, right, of, by, yes, len(items), prior)
        trace.append(objective)
        if len(trace) == ROUNDS or np.abs(p - before).max() < CLOSE:
            return DawidSkene(tuple(items), p, tuple(volunteers), right[:, 0], right[:, 1], share, tuple(trace))


def _maximised(
    p: np.ndarray, of: np.ndarray, by: np.ndarray, yes: np.ndarray, count: int, prior: float
) -> tuple[float, np.ndarray]:
    """The share of correct items, and (v, 2) sensitivity and specificity, given p (n,)."""
    right = np.empty((count, 2))
    for k, (weight, agrees) in enumerate(((p[of], yes), (1 - p[of], ~yes))):
        whole = np.bincount(by, weight, count) + 2 * prior
        right[:, k] = np.where(whole > 0, (np.bincount(by, weight * agrees, count) + prior) / np.where(whole > 0, whole, 1), 0.5)
    return float((p.sum() + prior) / (len(p) + 2 * prior)), right


def _expected(
    share: float, right: np.ndarray, of: np.ndarray, by: np.ndarray, yes: np.ndarray, count: int, prior: float
) -> tuple[np.ndarray, float]:
    """The probability (n,) of each item to be correct given shares, and the log of what these explain."""
    sensitivity, specificity = right[by].T
    log_yes = _log(share) + np.bincount(of, _log(np.where(yes, sensitivity, 1 - sensitivity)), count)
    log_no = _log(1 - share) + np.bincount(of, _log(np.where(yes, 1 - specificity, specificity)), count)
    together = np.logaddexp(log_yes, log_no)
    own = prior * float((_log(right) + _log(1 - right)).sum() + _log(share) + _log(1 - share)) if prior else 0.0
    return np.exp(log_yes - together), float(together.sum()) + own


def _log(value: np.ndarray | float) -> np.ndarray:
    return np.log(np.maximum(value, 1e-300))
