"""How many matches are needed: hand values, laws, and what a simulated study of that size really gives."""

import math

import numpy as np
import pytest
from design_world import run_of

from annotation import study
from annotation.design.designing import Design, create_design
from annotation.design.planning import (
    Expectations,
    design_effect,
    disagreement_of,
    estimated,
    interval_of,
    intraclass_correlation,
    needed,
    pairs_needed,
    votes_each,
)
from engine.errors import BadParameter
from engine.evaluation.intervals import clustered_interval

ALONE = Expectations(precision=0.5, per_pair=1, correlation=0)


def test_independent_matches_need_what_textbooks_say():
    """1.96² · 0.25 / 0.05² = 384.2 matches for ± 5 % around one half, 96 for ± 10 %, a few more by the t distribution."""
    assert pairs_needed(ALONE) == pytest.approx(384.2, rel=0.01)
    assert pairs_needed(ALONE.changed(half_width=0.1)) == pytest.approx(96 * (1.985 / 1.96) ** 2, rel=0.03)
    assert pairs_needed(ALONE.changed(confidence=0.9)) == pytest.approx(1.645**2 * 0.25 / 0.05**2, rel=0.01)


def test_the_fewest_pairs_are_enough_and_one_less_is_not():
    for expected in (Expectations(), ALONE, Expectations(half_width=0.3, per_pair=40), Expectations(correlation=1.0)):
        pairs, wide = pairs_needed(expected), 2 * expected.half_width
        assert np.ptp(interval_of(pairs, expected)) <= wide
        assert pairs == 2 or np.ptp(interval_of(pairs - 1, expected)) > wide


def test_clustered_matches_need_more():
    assert design_effect(10, 0.1) == pytest.approx(1.9)
    assert design_effect(1, 0.9) == 1
    found = [needed(Expectations(correlation=rho), Design()) for rho in (0.0, 0.1, 0.5, 1.0)]
    assert [one.matches for one in found] == sorted(one.matches for one in found)
    assert found[1].matches == pytest.approx(1.9 * found[0].matches, rel=0.1)
    # Where all matches of a pair turn out the same, a pair is worth one match.
    assert found[3].pairs == pairs_needed(Expectations(per_pair=1))


def test_no_number_of_pairs_may_be_enough(monkeypatch):
    monkeypatch.setattr("annotation.design.planning.MOST_PAIRS", 100)
    with pytest.raises(BadParameter, match="wider"):
        pairs_needed(ALONE)


def test_votes_on_a_match_by_hand():
    assert votes_each(3, False, 0.3, 0.0, 9) == 3
    assert votes_each(3, True, 0.0, 0.0, 9) == 2
    assert votes_each(3, True, 0.3, 0.0, 9) == pytest.approx(2.3)  # two, and a third where they differ
    assert votes_each(2, False, 0.3, 0.0, 9) == pytest.approx(2.3)  # a tie gets one more
    assert votes_each(1, True, 0.5, 0.0, 9) == 1
    assert votes_each(1, True, 0.0, 0.25, 9) == pytest.approx(1.25)  # an abstention leaves it open, once
    q = 0.9  # five votes: three alike in three, four or five
    three, four = q**3 + (1 - q) ** 3, 3 * (q**3 * (1 - q) + q * (1 - q) ** 3)
    assert votes_each(5, True, 2 * q * (1 - q), 0.0, 9) == pytest.approx(3 * three + 4 * four + 5 * (1 - three - four))
    assert votes_each(3, True, 0.2, 0.0, 2) == votes_each(2, False, 0.2, 0.0, 2) == 2  # nobody is left


def test_votes_and_hours_of_a_whole_study():
    design = Design(votes=3, overlap=0.2, gold=0.05, gold_least=10, practice=5)
    expected = Expectations(disagreement=0.2, abstention=0.0, seconds=9.0, volunteers=4)
    found = needed(expected, design)
    assert found.votes_each == pytest.approx(0.2 * 3 + 0.8 * 2.2)
    assert found.gold == math.ceil(0.05 * found.matches)
    assert found.votes == math.ceil((found.matches - found.gold) * found.votes_each + 4 * (found.gold + 5) - 1e-9)
    assert found.hours == pytest.approx(found.votes * 9 / 3600)
    assert found.hours_each == pytest.approx(found.hours / 4)
    everybody = needed(expected, design.changed(votes=0))
    assert everybody.votes == 4 * (found.matches + 5)
    assert needed(expected.changed(volunteers=2), design).votes_each < 2.3  # there are no three votes of two volunteers


def test_correlation_by_hand():
    assert intraclass_correlation([4, 0], [4, 4]) == 1.0
    assert intraclass_correlation([2, 2], [4, 4]) == 0.0
    # Between: (9/4 + 1/4 - 16/8) / 1 = 0.5; within: (4 - 10/4) / 6 = 0.25; (0.5 - 0.25) / (0.5 + 3 * 0.25) = 0.2.
    assert intraclass_correlation([3, 1], [4, 4]) == pytest.approx(0.2)
    assert intraclass_correlation([3, 1, 0], [4, 4, 0]) == pytest.approx(0.2)
    for nothing in (([1], [4]), ([1, 0], [1, 1]), ([4, 4], [4, 4]), ([], [])):
        assert intraclass_correlation(*nothing) is None


def clusters(rng, pairs, per_pair, precision, rho):
    """Correct matches of each pair, beta-binomial with the intraclass correlation rho."""
    scale = 1 / rho - 1
    return rng.binomial(per_pair, rng.beta(precision * scale, (1 - precision) * scale, pairs))


def test_correlation_is_found_again_in_simulated_pairs():
    rng = np.random.default_rng(3)
    found = [intraclass_correlation(clusters(rng, 200, 12, 0.8, 0.15), [12] * 200) for _ in range(40)]
    assert np.mean(found) == pytest.approx(0.15, abs=0.01)


@pytest.mark.parametrize("expected", [
    Expectations(), Expectations(precision=0.6, per_pair=20, correlation=0.2, half_width=0.08),
    Expectations(precision=0.9, per_pair=5, correlation=0.05, half_width=0.03),
])  # fmt: skip
def test_a_simulated_study_of_that_size_gives_the_interval_and_covers(expected):
    pairs, per_pair = pairs_needed(expected), int(expected.per_pair)
    rng, widths, covered = np.random.default_rng(7), [], 0
    for _ in range(300):
        correct = clusters(rng, pairs, per_pair, expected.precision, expected.correlation)
        found = clustered_interval(correct, [per_pair] * pairs)
        widths.append((found.high - found.low) / 2)
        covered += found.low <= expected.precision <= found.high
    assert np.mean(widths) == pytest.approx(expected.half_width, rel=0.06)
    assert covered / 300 > 0.9


def test_a_study_tells_what_to_expect(place):
    items = [[f"{pair}-{n}" for n in range(4)] for pair in "ab"]
    runs = [run_of("lamps", pair, shown) for pair, shown in zip("ab", items, strict=True)]
    with create_design(place, runs, Design(name="Lamps")) as handle:
        assert estimated(handle) == {"per_pair": 4.0}
        for one, rights in zip(items, (3, 1), strict=True):
            for number, item in enumerate(one):
                for code in ("anna", "bert"):
                    study.record_vote(handle, item, code, "correct" if number < rights else "wrong", active_ms=4000)
        study.record_vote(handle, "a-0", "carl", "unsure", active_ms=4000)
        study.record_vote(handle, "a-1", "carl", "wrong", active_ms=4000)
        told = estimated(handle)
    assert told.pop("correlation") == pytest.approx(0.2)
    assert told.pop("abstention") == pytest.approx(1 / 18)
    assert told.pop("disagreement") == pytest.approx((2 / 3) / 8)  # of a-1 two of three pairs of votes differ
    assert told == {"precision": 0.5, "per_pair": 4.0, "volunteers": 3, "seconds": 4.0}


def test_disagreement_needs_two_answers_that_decide():
    assert disagreement_of([["correct", "wrong"], ["correct", "correct"], ["wrong", "unsure"]]) == 0.5
    assert disagreement_of([["correct"], ["unsure", "unsure"], []]) is None
