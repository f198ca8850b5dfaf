"""What the rest of a pair says of a candidate, on two shapes of three segments whose nodes are known."""

import numpy as np
import pytest

from engine.shapes.context import (
    Neighbourhood,
    _asked,
    _rival,
    _transported,
    context_features,
    hypothesis_features,
)

MEMBERS = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0]], dtype=bool)  # nodes 0, 1, 2 and 0+1
AREA = np.array([0.5, 0.3, 0.2])
PAIRS = np.array([(i, j) for i in range(4) for j in range(4)])


def packed(distance):
    """Overlaps of the nodes by their areas, and the geodesic distances (4, 4)."""
    size = MEMBERS @ AREA
    overlap = (MEMBERS * AREA) @ MEMBERS.T / size[:, None]
    return np.stack([overlap, overlap.T, np.asarray(distance, float)], axis=-1).astype(np.float32)


DISTANCE = np.array([[0.2, 1.0, 2.0, 0.5], [1.0, 0.2, 1.2, 0.5], [2.0, 1.2, 0.1, 1.7], [0.5, 0.5, 1.7, 0.6]])
AROUND = Neighbourhood(packed(DISTANCE), packed(DISTANCE), MEMBERS, MEMBERS, AREA, AREA)


def right():
    return np.where(PAIRS[:, 0] == PAIRS[:, 1], 0.9, 0.05)


def test_a_rival_is_the_best_other_candidate_at_a_node():
    node, p = np.array([0, 0, 0, 1, 2, 2]), np.array([0.2, 0.9, 0.5, 0.4, 0.3, 0.3])
    assert _rival(node, p).tolist() == [0.9, 0.5, 0.9, 0.0, 0.3, 0.3]


def test_only_likely_candidates_that_are_best_at_a_node_are_asked():
    pairs = np.array([[0, 0], [0, 1], [1, 0], [1, 1], [2, 2]])
    assert _asked(pairs, np.array([0.9, 0.5, 0.6, 0.4, 0.1])).tolist() == [0, 2, 1]


def test_a_right_candidate_is_agreed_with_in_full():
    found = context_features(PAIRS, right(), AROUND)
    own = PAIRS[:, 0] == PAIRS[:, 1]
    assert found.shape == (16, 19)
    assert found[own, 3] == pytest.approx(1, abs=1e-5)  # overlap and distance
    assert found[own, 5] == pytest.approx(0)  # clashes of overlap
    assert (found[~own, 3] < 0.95).all()
    assert (found[own, 0] > 2).all()
    assert (found[~own, 0] < -2).all()


def test_segments_are_carried_to_their_partners():
    least, most, jaccard, behind_source, behind_target = _transported(PAIRS, np.where(right() > 0.2, right() ** 2, 0), AROUND)
    own = PAIRS[:, 0] == PAIRS[:, 1]
    assert jaccard[[10, 15]] == pytest.approx(1, abs=1e-3)  # the segment apart, and the union of the others
    assert behind_source[own] == pytest.approx(1, abs=1e-5)
    assert behind_target[own] == pytest.approx(1, abs=1e-5)
    assert (least <= most + 1e-12).all()
    assert (jaccard <= least + 1e-12).all()
    assert jaccard[~own & ~(MEMBERS[PAIRS[:, 0]] & MEMBERS[PAIRS[:, 1]]).any(axis=1)].max() < 0.25


def test_nothing_likely_says_nothing():
    found = context_features(PAIRS, np.full(16, 0.01), AROUND)
    assert np.isfinite(found).all()
    assert found[:, 3:13] == pytest.approx(0.5)


def test_the_order_of_candidates_does_not_matter():
    order = np.random.default_rng(0).permutation(16)
    plain, mixed = context_features(PAIRS, right(), AROUND), context_features(PAIRS[order], right()[order], AROUND)
    assert mixed == pytest.approx(plain[order], abs=1e-6)


def test_a_hypothesis_is_the_set_that_agrees_most():
    # 0-0, 1-1, 2-2 and 3-3 agree in all; 0-1 and 1-0 are as likely alone, but only agree with each other
    weight = np.where(PAIRS[:, 0] == PAIRS[:, 1], 0.5, 0.1)
    weight[(PAIRS == (0, 1)).all(axis=1) | (PAIRS == (1, 0)).all(axis=1)] = 0.5
    found = hypothesis_features(PAIRS, weight, AROUND)
    own = PAIRS[:, 0] == PAIRS[:, 1]
    assert found.shape == (16, 18)
    assert found[own, 15].tolist() == [1, 1, 1, 1]  # in the set
    assert not found[~own, 15].any()
    assert found[own, 0] == pytest.approx(1, abs=1e-5)  # agreement in overlap and distance
    assert found[0, 17] == pytest.approx(1, abs=1e-5)  # of the set in itself
    assert np.log(1.0001) == pytest.approx(found[:, 16].max(), abs=1e-5)  # the best score is 1


def test_no_weight_makes_no_hypothesis():
    found = hypothesis_features(PAIRS, np.zeros(16), AROUND)
    assert np.isfinite(found).all()
    assert not found[:, 15].any()
    assert not found[:, 17].any()
