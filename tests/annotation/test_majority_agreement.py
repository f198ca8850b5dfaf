"""Majorities and agreement, against values worked out by hand and printed ones."""

import pytest

from annotation.agreement import krippendorff_alpha, raw_agreement
from annotation.majority import Majority, majorities, majority_of


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
