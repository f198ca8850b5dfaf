"""Methods compared on the same pairs, and figures without one volunteer, by hand."""

from itertools import pairwise

import pytest
from findings_world import cast, ran
from scipy.stats import binomtest

from annotation.findings.comparing import compared, leave_one_out, modelled
from annotation.findings.dawidskene import dawid_skene
from annotation.findings.precision import ALL_SETS, counted, tabulate

PAIRS = [f"p{k}" for k in range(7)]


def two_methods(sets=("lamps",)):
    """On each pair m proposes a right and a wrong match, n the right one and one more that is right."""
    results = [r for name in sets for p in PAIRS for r in (ran("m", name + p, f"{name}{p}a {name}{p}b", name),
                                                         ran("n", name + p, f"{name}{p}a {name}{p}c", name))]  # fmt: skip
    votes = [v for name in sets for p in PAIRS for v in cast(**{f"{name}{p}a": "c", f"{name}{p}b": "w", f"{name}{p}c": "c"})]
    return results, votes


def test_differences_pair_by_pair_and_mcnemar_on_correct_matches_found_alone():
    """n is always better by a half; on each pair it alone finds a correct match, and m alone a wrong one, which is no case."""
    results, votes = two_methods()
    (row,) = compared(results, counted(votes))
    assert (row.first, row.second, row.set_name) == (("m", "m"), ("n", "n"), "lamps")
    assert row.test[:5] == (7, 7, 0, 0, pytest.approx(0.5))
    assert row.test.permutation == pytest.approx(2 / 2**7)
    assert (row.seen_pairs, row.first_alone, row.second_alone) == (7, 0, 7)
    assert row.mcnemar == row.holm_mcnemar == pytest.approx(binomtest(0, 7).pvalue)


def test_wrong_and_tied_proposals_are_no_cases_of_mcnemar():
    """m proposes what n does, and on each pair two more, one wrong and one tied: nothing that is correct is found alone."""
    results = [r for p in PAIRS for r in (ran("m", p, f"{p}a {p}b {p}c"), ran("n", p, f"{p}a"))]
    (row,) = compared(results, counted([v for p in PAIRS for v in cast(**{f"{p}a": "cc", f"{p}b": "ww", f"{p}c": "cw"})]))
    assert (row.seen_pairs, row.first_alone, row.second_alone, row.mcnemar) == (7, 0, 0, 1.0)
    assert row.test.difference == pytest.approx(0.5)


def test_below_six_pairs_there_is_no_p():
    results, votes = two_methods()
    (row,) = compared([r for r in results if r.pair < "lampsp5"], counted(votes))
    assert (row.test.pairs, row.test.permutation, row.holm_wilcoxon, row.mcnemar, row.holm_mcnemar) == (5, *[None] * 4)
    assert row.test.difference == pytest.approx(0.5)


def test_sets_are_adjusted_after_holm_and_their_whole_is_not():
    results, votes = two_methods(("lamps", "vases"))
    one, two, every = compared(results, counted(votes))
    assert [r.set_name for r in (one, two, every)] == ["lamps", "vases", ALL_SETS]
    assert one.holm_permutation == pytest.approx(2 * one.test.permutation)
    assert one.holm_mcnemar == pytest.approx(2 * one.mcnemar)
    assert every.test.pairs == 14
    assert every.holm_mcnemar == every.mcnemar < one.mcnemar
    assert every.holm_permutation == every.test.permutation < one.test.permutation


def test_pairs_with_an_unseen_proposal_are_not_in_mcnemar():
    results, votes = two_methods()
    (row,) = compared(results, counted([v for v in votes if v.item != "lampsp0c"]))
    assert (row.seen_pairs, row.second_alone, row.test.pairs) == (6, 6, 7)


def test_exchanged_methods_mirror_the_difference():
    results, votes = two_methods()
    turned = [r._replace(method={"m": "n", "n": "m"}[r.method], preset={"m": "n", "n": "m"}[r.preset]) for r in results]
    (there,), (back,) = compared(results, counted(votes)), compared(turned, counted(votes))
    assert there.test.difference == -back.test.difference
    assert (there.first_alone, there.second_alone, there.mcnemar) == (back.second_alone, back.first_alone, back.mcnemar)


def test_without_one_volunteer_by_hand():
    """a is right by two of three, b by one of one (carl): without carl b is unknown; without anna a is a tie."""
    results, votes = [ran("m", "p", "a b")], cast(a="ccw", b="..w")
    (row,) = leave_one_out(results, votes)
    assert (row.micro, row.low, row.high) == (0.5, 0.0, 1.0)
    assert row.volunteer in ("anna", "bert", "carl")
    assert leave_one_out(results, cast(a="c")) == ()


def test_leaving_out_is_counting_anew():
    results, votes = [ran("m", "p", "a b c"), ran("n", "p", "c d")], cast(a="ccw", b="cwu", c="wwc", d="c.c")
    codes = sorted({v.volunteer for v in votes})
    for k, row in enumerate(leave_one_out(results, votes)):
        anew = [tabulate(results, [v for v in votes if v.volunteer != code])[k].micro for code in codes]
        known = [m for m in anew if m is not None]
        assert (row.low, row.high) == (min(known), max(known))


def test_the_model_counts_ties_and_weights():
    results, votes = [ran("m", "p", "a b c d")], cast(a="ccc", b="cw.", c="www", d="cc.")
    model, rows = dawid_skene(votes), tabulate(results, votes)
    (plain,) = modelled(results, rows, model)
    assert plain.matches == 4
    assert plain.model == pytest.approx(model.probability.mean())
    (weighted,) = modelled(results, rows, model, {"a": 2.0, "c": 2.0})
    assert (weighted.matches, weighted.model) == (2, pytest.approx((model.probability[0] + model.probability[2]) / 2))
    assert modelled(results, rows, None) == ()
    assert all(a <= b + 1e-9 for a, b in pairwise(model.trace))
