"""Laws of drawing: nested, in proportion, as probable as it says, and the same for the same seed."""

import math
from collections import Counter

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from annotation.design.sampling import balanced, draw, gold_wanted, overlapped, sample
from annotation.records import Practice

SIZES = st.dictionaries(st.sampled_from("abcdefgh"), st.integers(1, 12), min_size=1)


def strata_of(sizes: dict[str, int]) -> dict[str, str]:
    return {f"{name}{n}": name for name, size in sizes.items() for n in range(size)}


def taken(strata: dict[str, str], most: int, seed: str = "s") -> Counter[str]:
    return Counter(strata[item] for item in sample(strata, most, seed))


def test_hand_made_strata_are_drawn_in_proportion():
    strata = strata_of({"a": 6, "b": 3, "c": 1})
    assert taken(strata, 5) == {"a": 3, "b": 1, "c": 1}  # one each, then 6/3, then 6/5
    assert taken(strata, 6) == {"a": 3, "b": 2, "c": 1}  # 6/7 is less than 3/3
    assert {(item[0], chance) for item, chance in sample(strata, 5, "s").items()} == {("a", 0.5), ("b", 1 / 3), ("c", 1.0)}
    assert sample(strata, 0, "s") == sample(strata, 99, "s") == dict.fromkeys(strata, 1.0)


@settings(max_examples=60, deadline=None)
@given(SIZES, st.integers(1, 60), st.integers(1, 60), st.text(max_size=3))
def test_a_larger_sample_holds_the_smaller(sizes, one, other, seed):
    strata = strata_of(sizes)
    small, large = sorted((one, other))
    assert set(sample(strata, small, seed)) <= set(sample(strata, large, seed))
    assert len(sample(strata, small, seed)) == min(small, len(strata))


@settings(max_examples=60, deadline=None)
@given(SIZES, st.integers(1, 60))
def test_every_stratum_is_there_and_weights_make_up_the_whole(sizes, most):
    strata = strata_of(sizes)
    chosen = sample(strata, most, "s")
    if most >= len(sizes):
        assert set(taken(strata, most)) == set(sizes)
        assert math.isclose(sum(1 / chance for chance in chosen.values()), len(strata))
        for one in sizes:
            for other in sizes:
                assert sizes[one] <= sizes[other] or taken(strata, most)[one] >= taken(strata, most)[other]


@pytest.mark.parametrize("most", [2, 7])
def test_an_item_is_drawn_as_often_as_its_probability_says(most):
    strata, trials = strata_of({"a": 8, "b": 4, "c": 2}), 600
    drawn, stated = Counter(), Counter()
    for seed in range(trials):
        for item, chance in sample(strata, most, str(seed)).items():
            drawn[item] += 1
            stated[item] = chance
    for item, chance in stated.items():
        assert abs(drawn[item] / trials - chance) < 4 * math.sqrt(chance * (1 - chance) / trials) + 1e-9, item
    assert set(drawn) == set(strata)


def test_what_is_overlapped_grows_with_the_share_and_is_drawn_by_the_seed():
    items = [str(n) for n in range(50)]
    assert len(overlapped(items, 0.2, "s")) == 10
    assert overlapped(items, 0.1, "s") < overlapped(items, 0.2, "s") != overlapped(items, 0.2, "t")
    assert len(overlapped(items[:7], 0.2, "s")) == 2  # never less than the share
    assert overlapped(items, 0.0, "s") == frozenset()


def test_both_answers_are_drawn_by_turns_and_what_is_liked_first():
    pool = {str(n): Practice("correct" if n < 30 else "wrong", "") for n in range(40)}
    assert Counter(pool[i].answer for i in balanced(pool, 8, "s", "gold", lambda i: True)) == {"correct": 4, "wrong": 4}
    assert len(balanced(pool, 99, "s", "gold", lambda i: True)) == 40
    liked = balanced(pool, 6, "s", "gold", lambda i: int(i) % 10 == 0)
    assert {"0", "10", "20", "30"} < set(liked)
    assert balanced(pool, 6, "s", "gold", lambda i: True) != balanced(pool, 6, "t", "gold", lambda i: True)


def test_how_many_gold_items():
    assert [gold_wanted(n, 0.05, 10) for n in (20, 200, 201, 1000)] == [10, 10, 11, 50]
    assert gold_wanted(1000, 0.0, 10) == 0


def test_draws_are_told_apart_by_seed_and_purpose():
    assert len({draw("a", "b", "c"), draw("a", "c", "b"), draw("b", "a", "c"), draw("a", "b", "d")}) == 4
    assert draw("a", "b", "c") == draw("a", "b", "c")
