"""The model of Dawid and Skene (Applied Statistics 28, 1979): how reliable each volunteer is, found from votes alone.

Every match is correct or wrong, a volunteer calls a correct one correct with one probability (sensitivity) and a wrong
one wrong with another (specificity), votes are independent given what the match is. Expectation and maximisation take
turns: what the matches are by what volunteers are worth, and the other way round. Abstentions are left out.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .ballots import Ballot

if TYPE_CHECKING:
    from scipy.sparse import csr_array

LEAST_VOLUNTEERS = 3  # of two, nothing can say which of them errs
ROUNDS = 1000
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
    said = [_table(told, answer, row, column) for answer in ("correct", "wrong")]
    said.append(said[0] + said[1])
    p = np.asarray(said[0].sum(axis=1) / said[2].sum(axis=1))
    trace: list[float] = []
    while True:
        share, right = _maximised(p, said, prior)
        before = p
        p, objective = _expected(share, right, said, prior)
        trace.append(objective)
        if len(trace) == ROUNDS or np.abs(p - before).max() < CLOSE:
            return DawidSkene(tuple(items), p, tuple(volunteers), right[:, 0], right[:, 1], share, tuple(trace))


def _table(votes: Sequence[Ballot], answer: str, row: Mapping[str, int], column: Mapping[str, int]) -> "csr_array":
    """Which items (n) which volunteers (v) gave an answer to, (n, v) of 0 and 1, sparse."""
    from scipy.sparse import csr_array

    places = sorted((row[v.item], column[v.volunteer]) for v in votes if v.answer == answer)
    of, by = np.array(places, dtype=np.int64).reshape(-1, 2).T
    return csr_array((np.ones(len(places)), (of, by)), shape=(len(row), len(column)))


def _maximised(p: np.ndarray, said: Sequence["csr_array"], prior: float) -> tuple[float, np.ndarray]:
    """The share of correct items, and (v, 2) sensitivity and specificity, given p (n,), and who called what correct, wrong, either."""
    right = np.empty((said[0].shape[1], 2))
    for k, weight in enumerate((p, 1 - p)):
        whole = said[2].T @ weight + 2 * prior
        right[:, k] = np.where(whole > 0, (said[k].T @ weight + prior) / np.where(whole > 0, whole, 1), 0.5)
    return float((p.sum() + prior) / (len(p) + 2 * prior)), right


def _expected(share: float, right: np.ndarray, said: Sequence["csr_array"], prior: float) -> tuple[np.ndarray, float]:
    """The probability (n,) of each item to be correct given shares, and the log of what these explain."""
    (sensitivity, specificity), (yes, no, _) = right.T, said
    log_yes = _log(share) + yes @ _log(sensitivity) + no @ _log(1 - sensitivity)
    log_no = _log(1 - share) + yes @ _log(1 - specificity) + no @ _log(specificity)
    together = np.logaddexp(log_yes, log_no)
    own = prior * float((_log(right) + _log(1 - right)).sum() + _log(share) + _log(1 - share)) if prior else 0.0
    return np.exp(log_yes - together), float(together.sum()) + own


def _log(value: np.ndarray | float) -> np.ndarray:
    return np.log(np.maximum(value, 1e-300))
