"""The model of Dawid and Skene: it never gets worse, finds what volunteers are, and says when it cannot."""

from itertools import pairwise

import numpy as np
import pytest
from findings_world import cast

from annotation.findings.dawidskene import dawid_skene
from annotation.findings.precision import Ballot


def drawn(items: int, right: list[tuple[float, float]], share: float = 0.7, seed: int = 0) -> tuple[list[Ballot], np.ndarray]:
    """Votes of volunteers of given sensitivity and specificity, and which items are correct."""
    rng = np.random.default_rng(seed)
    truth = rng.random(items) < share
    votes = []
    for k, (sensitivity, specificity) in enumerate(right):
        says = np.where(truth, rng.random(items) < sensitivity, rng.random(items) >= specificity)
        votes += [Ballot(f"{i:05d}", f"v{k}", "correct" if yes else "wrong") for i, yes in enumerate(says)]
    return votes, truth


@pytest.mark.parametrize("prior", [0.0, 1.0])
def test_the_likelihood_never_falls(prior):
    votes, _ = drawn(60, [(0.9, 0.7), (0.6, 0.8), (0.5, 0.5), (0.95, 0.9)], seed=3)
    trace = dawid_skene(votes, prior=prior).trace
    assert len(trace) > 3
    assert all(later >= earlier - 1e-9 for earlier, later in pairwise(trace))


def test_simulated_confusion_matrices_are_recovered():
    right = [(0.95, 0.9), (0.8, 0.6), (0.7, 0.95), (0.55, 0.5), (0.9, 0.8)]
    votes, truth = drawn(4000, right)
    found = dawid_skene(votes)
    assert found.volunteers == tuple(f"v{k}" for k in range(5))
    assert np.abs(found.sensitivity - [s for s, _ in right]).max() < 0.03
    assert np.abs(found.specificity - [s for _, s in right]).max() < 0.05
    assert found.prevalence == pytest.approx(truth.mean(), abs=0.03)
    majority = np.array([sum(v.answer == "correct" for v in votes if v.item == i) > 2 for i in found.items[:400]])
    assert ((found.probability[:400] > 0.5) == truth[:400]).mean() > (majority == truth[:400]).mean()


def test_the_search_ends_where_another_round_changes_nothing():
    """At the end the share of correct matches is the mean of their probabilities, to four more digits than are shown."""
    for seed in range(4):
        found = dawid_skene(drawn(80, [(0.8, 0.7), (0.7, 0.6), (0.6, 0.8)], seed=seed)[0], prior=0.0)
        assert found.prevalence == pytest.approx(found.probability.mean(), abs=1e-6)


def test_one_who_guesses_counts_little():
    votes, _ = drawn(300, [(0.97, 0.97), (0.97, 0.97), (0.5, 0.5)], seed=1)
    found = dawid_skene(votes)
    assert found.sensitivity[2] < 0.65 < 0.9 < found.sensitivity[0]


def test_abstentions_and_the_order_of_votes_do_not_matter():
    votes = cast(a="ccw", b="wwc", c="cc.", d="uww", e="wuu")
    one, other = dawid_skene(votes), dawid_skene([*reversed(votes), Ballot("z", "anna", "unsure")])
    assert one.items == other.items
    assert one.probability == pytest.approx(other.probability)


def test_of_two_volunteers_it_says_nothing():
    assert dawid_skene(cast(a="cw", b="cc")) is None
    assert dawid_skene([]) is None
