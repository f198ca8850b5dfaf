"""Plain cycle support: cycles drawn by hand, and what must hold for any matches."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.consistency.cycles import best_product, cycle_support
from engine.errors import BadInput

EYE = np.eye(3)


def rows(*pairs):
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def test_a_cycle_that_closes_has_support_one_and_a_broken_one_none():
    identity = rows((0, 0), (1, 1), (2, 2))
    swapped = rows((0, 0), (1, 2), (2, 1))
    found = cycle_support({(0, 1): identity, (1, 2): identity, (0, 2): identity}, [EYE] * 3)
    assert all(np.array_equal(found[pair], [1, 1, 1]) for pair in found)
    found = cycle_support({(0, 1): identity, (1, 2): identity, (0, 2): swapped}, [EYE] * 3)
    assert all(np.array_equal(found[pair], [1, 0, 0]) for pair in found)


def test_the_support_is_the_share_of_third_shapes_that_agree():
    same, off = rows((0, 0)), rows((0, 1))
    # by 2 the way from 0 to 1 closes, by 3 it ends elsewhere
    matches = {(0, 1): same, (0, 2): same, (2, 1): same, (0, 3): same, (3, 1): off}
    assert cycle_support(matches, [EYE] * 4)[0, 1] == pytest.approx([0.5])


def test_unions_that_differ_slightly_count_by_how_alike_they_are():
    alike = np.array([[1, 0.8, 0], [0.8, 1, 0], [0, 0, 1]])
    # into the third shape the match of node 1 leads, which is nearly node 0; from there to node 0 exactly
    matches = {(0, 1): rows((0, 0)), (0, 2): rows((1, 0)), (2, 1): rows((0, 0))}
    assert cycle_support(matches, [alike, EYE, EYE])[0, 1] == pytest.approx([0.8])
    matches = {(0, 1): rows((0, 0)), (0, 2): rows((1, 0)), (2, 1): rows((1, 1))}
    assert cycle_support(matches, [alike] * 3)[0, 1] == pytest.approx([0.8**3])


def test_without_a_third_shape_nothing_is_known():
    assert np.isnan(cycle_support({(0, 1): rows((0, 0), (1, 1))}, [EYE] * 2)[0, 1]).all()
    # the third shape was matched with one of the two alone
    assert np.isnan(cycle_support({(0, 1): rows((0, 0)), (1, 2): rows((0, 0))}, [EYE] * 3)[0, 1]).all()


def test_a_third_shape_without_matches_supports_nothing():
    found = cycle_support({(0, 1): rows((0, 0)), (0, 2): rows(), (1, 2): rows((0, 0))}, [EYE] * 3)
    assert found[0, 1].tolist() == [0]
    assert found[0, 2].shape == (0,)


@st.composite
def collections(draw):
    """Matches of 4 shapes with 5 nodes each, and how alike those are."""
    rng = np.random.default_rng(draw(st.integers(0, 10_000)))
    alike = []
    for _ in range(4):
        a = rng.random((5, 5)) ** 2
        a = (a + a.T) / 2
        np.fill_diagonal(a, 1)
        alike.append(a)
    pairs = [(a, b) for a in range(4) for b in range(a + 1, 4)]
    return {pair: rng.integers(0, 5, (rng.integers(0, 6), 2)) for pair in pairs}, alike


@settings(max_examples=30, deadline=None)
@given(collections(), st.permutations(range(4)))
def test_shapes_may_be_numbered_in_any_order_and_pairs_given_from_either_side(collection, order):
    matches, alike = collection
    found = cycle_support(matches, alike)
    renamed = {(order[a], order[b]): m for (a, b), m in matches.items()}
    turned = {(b, a): m[:, ::-1] for (a, b), m in renamed.items()}
    moved = [alike[order.index(k)] for k in range(4)]
    for (a, b), support in found.items():
        np.testing.assert_allclose(cycle_support(renamed, moved)[order[a], order[b]], support)
        np.testing.assert_allclose(cycle_support(turned, moved)[order[b], order[a]], support)


@settings(max_examples=30, deadline=None)
@given(collections())
def test_support_is_that_of_every_way_written_out(collection):
    matches, alike = collection
    found = cycle_support(matches, alike)
    both = {**matches, **{(b, a): m[:, ::-1] for (a, b), m in matches.items()}}
    for (a, b), support in found.items():
        for k, (i, j) in enumerate(matches[a, b]):
            best = [max((alike[a][i, i_] * alike[c][x, x_] * alike[b][j_, j] for i_, x in both[a, c] for x_, j_ in both[c, b]),
                        default=0) for c in range(4) if c not in (a, b)]  # fmt: skip
            assert support[k] == pytest.approx(np.mean(best))


def test_best_product_by_hand():
    assert best_product(np.array([[0.5, 1.0]]), np.array([[1.0, 0.0], [0.4, 0.2]])).tolist() == [[0.5, 0.2]]
    assert best_product(np.zeros((2, 0)), np.zeros((0, 3))).tolist() == [[0, 0, 0], [0, 0, 0]]


@pytest.mark.parametrize(("matches", "word"), [
    ({(0, 0): rows((0, 0))}, "itself"),
    ({(0, 1): rows((0, 0)), (1, 0): rows((0, 0))}, "twice"),
    ({(0, 1): rows((0, 3))}, "lacks"),
    ({(0, 2): rows((0, 0))}, "no object 2"),
])  # fmt: skip
def test_what_cannot_be_is_refused(matches, word):
    with pytest.raises(BadInput, match=word):
        cycle_support(matches, [EYE] * 2)
