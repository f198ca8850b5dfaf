"""Lenient, strict, chance and label transfer: values worked out by hand, and laws."""

import numpy as np
import pytest

from engine.errors import BadInput
from engine.evaluation.correspondence import evaluate_tables, pooled, transfer, verdicts

# Two classes. Source segments: 4 of class 0; 2 and 2; 4 of class 1 (areas). Target: 6 of class 0; 1 and 5.
SOURCE = np.array([[4.0, 0], [2, 2], [0, 4]])
TARGET = np.array([[6.0, 0], [1, 5]])


def test_verdicts_by_hand():
    """Rows: source segment 1 = (2, 2), the union {0, 1} = (6, 2). Columns: target segment 0 = (6, 0), 1 = (1, 5).

    Lenient: (.5, .5) overlaps (1, 0) by .5 and (1/6, 5/6) by 1/6 + 1/2 = 2/3; (.75, .25) overlaps them by .75 and
    1/6 + 1/4 = 5/12.
    Strict: coverage of (2, 2) is (1/3, 1/3), of (6, 2) is (1, 1/3), of the targets (6/7, 0) and (1/7, 1); both classes
    weigh about the same (w = 13/24 + ... by area: (6/12 + 7/12)/2 = 13/24 and 11/24).
    (2,2)-(6,0): 13·(1/3) / (13·6/7 + 11/3) < 1/2; (2,2)-(1,5): (13/7 + 11/3) / (13/3 + 11) = .36;
    (6,2)-(6,0): 13·(6/7) / (13 + 11/3) = .67; (6,2)-(1,5): (13/7 + 11/3) / (13 + 11) = .23.
    """
    lenient, strict = verdicts(np.array([[2.0, 2], [6, 2]]), TARGET, SOURCE.sum(axis=0), TARGET.sum(axis=0))
    assert lenient.tolist() == [[True, True], [True, False]]
    assert strict.tolist() == [[False, False], [True, False]]


def test_label_transfer_by_hand():
    """Segment 1 takes the classes of its smallest match: (1, 5)/6 from target 1, not (6, 0) from the union's match.

    Segment 0 takes (1, 0): 4 right. Segment 1 = (2, 2) takes (1/6, 5/6): 2 right. Segment 2 has no match. 6 of 8
    covered, of 12 in all.
    """
    members = np.array([[True, True, False], [False, True, False]])
    own = np.array([[6.0, 2], [2, 2]])
    right = transfer(SOURCE, members, own, TARGET, np.array([True, True]))
    assert right == pytest.approx([4 + 2 / 6 + 10 / 6, 8, 12])


def test_area_of_a_class_that_the_other_shape_lacks_is_not_asked_for():
    e = evaluate_tables(np.array([[2.0, 0], [0, 3]]), np.array([[4.0, 0], [1, 0]]), [([0], [0])])
    assert e.transfer_total == 2 + 5
    assert e.transfer_covered == 2 + 4
    assert e.transfer_precision == 1
    assert e.transfer_recall == pytest.approx(6 / 7)


def test_whole_shapes_and_empty_matches_are_not_judged():
    e = evaluate_tables(SOURCE, TARGET, [([0, 1, 2], [0]), ([0], [0, 1]), ([], [0]), ([2], [1])])
    assert e.judged == 1
    assert e.lenient == e.strict == e.chance_lenient == 1
    assert [s.name for s in e.sizes] == ["1"]


def test_no_matches_have_no_precision_but_zero_recall():
    e = evaluate_tables(SOURCE, TARGET, [])
    assert e.judged == 0
    assert np.isnan(e.lenient)
    assert np.isnan(e.chance_lenient)
    assert np.isnan(e.transfer_precision)
    assert e.transfer_recall == 0


def test_two_opposite_matches_are_right_by_chance_half_the_time():
    """Segments of pure classes matched straight: dealt at random, both are right or both are wrong."""
    table = np.eye(2)
    e = evaluate_tables(table, table, [([0], [0]), ([1], [1])])
    assert e.lenient == e.strict == 1
    assert e.chance_lenient == e.chance_strict
    assert e.chance_lenient == pytest.approx(0.5, abs=0.12)


def test_size_is_that_of_the_larger_node():
    table = np.kron(np.eye(2), np.ones((5, 1)))
    e = evaluate_tables(table, table, [([0], [0, 1]), ([0, 1, 2, 3], [5]), ([5], [5])])
    assert [(s.name, s.judged, s.lenient, s.strict) for s in e.sizes] == [
        ("1", 1, 1, 1),
        ("2-3", 1, 1, 1),
        ("4+", 1, 0, 0),
    ]


def test_matching_from_the_other_side_changes_nothing_but_chance():
    rng = np.random.default_rng(1)
    a, b = rng.uniform(size=(7, 3)), rng.uniform(size=(6, 3))
    matches = [(rng.choice(7, 2, replace=False), rng.choice(6, 3, replace=False)) for _ in range(9)]
    e, f = evaluate_tables(a, b, matches), evaluate_tables(b, a, [(t, s) for s, t in matches])
    assert (e.judged, e.lenient_correct, e.strict_correct) == (f.judged, f.lenient_correct, f.strict_correct)
    assert e.transfer_right == pytest.approx(f.transfer_right)
    assert e.transfer_total == pytest.approx(f.transfer_total)


def test_pooling_adds_counts_and_weighs_chance():
    table = np.eye(3)
    good = evaluate_tables(table, table, [([0], [0]), ([1], [1])])
    bad = evaluate_tables(table, table, [([0], [1])])
    none = evaluate_tables(table, table, [])
    both = pooled([good, bad, none])
    assert both.judged == 3
    assert both.lenient == pytest.approx(2 / 3)
    assert both.chance_lenient == pytest.approx((2 * good.chance_lenient + bad.chance_lenient) / 3)
    assert both.transfer_total == pytest.approx(18)
    assert both.transfer_recall == pytest.approx(4 / 18)
    assert [(s.name, s.judged) for s in both.sizes] == [("1", 3)]
    assert pooled([]).judged == 0


def test_tables_of_different_classes_are_refused():
    with pytest.raises(BadInput, match="target's table"):
        evaluate_tables(np.eye(2), np.eye(3), [])
