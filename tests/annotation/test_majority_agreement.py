"""Majorities and agreement, against values worked out by hand and printed ones."""

import pytest
from findings_world import cast

from annotation.findings.agreement import (
    EVERYTHING,
    OVERLAPPED,
    agreement_rows,
    krippendorff_alpha,
    raw_agreement,
    volunteer_agreement,
)
from annotation.voting.majority import Majority, majorities, majority_of


@pytest.mark.parametrize(
    ("answers", "expected"),
    [
        ("", Majority(0, 0, 0, "unjudged")),
        ("u", Majority(0, 0, 1, "unjudged")),
        ("cw", Majority(1, 1, 0, "tie")),
        ("cwu", Majority(1, 1, 1, "tie")),
        ("ccw", Majority(2, 1, 0, "correct")),
        ("wuu", Majority(0, 1, 2, "wrong")),
    ],
)
def test_majority_of_a_few(answers: str, expected: Majority) -> None:
    words = {"c": "correct", "w": "wrong", "u": "unsure"}
    assert majority_of(words[letter] for letter in answers) == expected


def test_votes_on_other_items_are_left_out() -> None:
    assert majorities(["a", "b"], [("a", "wrong"), ("c", "correct")]) == {
        "a": Majority(0, 1, 0, "wrong"),
        "b": Majority(0, 0, 0, "unjudged"),
    }


def test_alpha_of_two_observers_as_printed() -> None:
    """Krippendorff, Computing Krippendorff's Alpha-Reliability (2011), section A: 0.095."""
    units = list(zip("0100000010", "1110010000", strict=True))
    assert krippendorff_alpha(units) == pytest.approx(0.095, abs=5e-4)
    assert raw_agreement(units) == pytest.approx(0.6)


def test_alpha_with_missing_answers_as_printed() -> None:
    """Section C of the same paper, four observers: 0.743."""
    observers = ("123321412...", "1233224125.3", ".3332342251.", "12332441251.")
    units = ["".join(column).replace(".", "") for column in zip(*observers, strict=True)]
    assert krippendorff_alpha(units) == pytest.approx(0.743, abs=5e-4)


def test_high_raw_agreement_can_be_worth_nothing() -> None:
    units = [("c", "c")] * 98 + [("c", "w")] * 2
    assert raw_agreement(units) == pytest.approx(0.98)
    assert krippendorff_alpha(units) == pytest.approx(1 - 0.02 / (2 * 198 * 2 / (200 * 199)))
    assert krippendorff_alpha(units) < 0


def test_alpha_is_not_defined_where_all_answers_are_equal() -> None:
    assert krippendorff_alpha([("c", "c"), ("c", "c", "c")]) is None
    assert raw_agreement([("c", "c"), ("c", "c", "c")]) == 1
    assert raw_agreement([("c",), ()]) is None
    assert krippendorff_alpha([("c",), ("w",)]) is None


def test_alpha_does_not_mind_names_or_order() -> None:
    units = [("c", "w", "c"), ("w", "w"), ("c", "c"), ("w", "c")]
    swapped = [tuple({"c": "w", "w": "c"}[answer] for answer in reversed(unit)) for unit in reversed(units)]
    assert krippendorff_alpha(units) == pytest.approx(krippendorff_alpha(swapped))


def test_each_volunteer_beside_the_others_by_hand() -> None:
    """anna: on a with both others, on b against both, on c the others are tied. Pairs: 2 + 0 + 1 of 6 agree."""
    rows = {row.volunteer: row for row in volunteer_agreement(cast(a="ccc", b="cww", c="cwc", d="u", e="w"))}
    assert rows["anna"] == ("anna", 4, 2, pytest.approx(1 / 2), 6, pytest.approx(3 / 6))
    assert rows["bert"] == ("bert", 3, 2, pytest.approx(1 / 2), 6, pytest.approx(3 / 6))
    assert rows["carl"] == ("carl", 3, 1, pytest.approx(1.0), 6, pytest.approx(4 / 6))


def test_who_votes_alone_has_nothing_to_be_compared_with() -> None:
    assert volunteer_agreement(cast(a="c", b="w")) == (("anna", 2, 0, None, 0, None),)


def test_agreement_on_overlapped_items_stands_apart_from_all_and_sets() -> None:
    votes = cast(a="cc", b="cw", c="ccw", d="u")
    rows = agreement_rows(votes, {"a", "b"}, {"lamps": {"a", "c"}, "vases": {"b", "d"}})
    assert [(row.of, row.items, row.votes) for row in rows] == [(OVERLAPPED, 2, 4), (EVERYTHING, 3, 7), ("lamps", 2, 5), ("vases", 1, 2)]
    assert rows[0].raw == pytest.approx(1 / 2)
    assert rows[1].raw == pytest.approx((2 * 1 + 2 * 0 + 3 / 3) / 7)
    assert rows[3].raw == 0
    assert [row.of for row in agreement_rows(votes)] == [EVERYTHING]


def test_a_third_vote_where_two_differ_shifts_alpha() -> None:
    """The same first two votes; only the disputed items get a third."""
    two = [("c", "c")] * 60 + [("w", "w")] * 20 + [("c", "w")] * 20
    three = [*two[:80], *[("c", "w", "c")] * 12, *[("c", "w", "w")] * 8]
    assert krippendorff_alpha(three) != pytest.approx(krippendorff_alpha(two), abs=0.005)
