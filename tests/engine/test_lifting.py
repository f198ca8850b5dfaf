"""MatchLift on atoms, and the parts that are cut from it: by hand, and laws."""

from itertools import pairwise

import numpy as np
import pytest

from engine.consistency.lifting import lift_atoms, lifted_support, together
from engine.consistency.parts import consistent_parts
from engine.errors import BadInput

NUMBERS = {"sparsity": 0.4, "penalty": 0.5, "tolerance": 1e-4, "max_steps": 2000, "most": 100}


def members(count, *unions):
    out = np.zeros((len(unions), count), bool)
    for row, union in enumerate(unions):
        out[row, list(union)] = True
    return out


def single(*targets, count=3):
    """Matches of single atoms 0.. with the given ones."""
    return members(count, *[(k,) for k in range(len(targets))]), members(count, *[(t,) for t in targets])


def test_together_is_the_share_of_matches_that_hold_both():
    left, right = members(2, (0,), (0, 1)), members(3, (0,), (0, 1, 2))
    assert together(left, right).tolist() == [[1, 0.5, 0.5], [0.5, 1, 1]]
    assert together(members(2), members(3)).tolist() == [[0, 0, 0], [0, 0, 0]]


def test_one_wrong_pair_of_four_shapes_is_outvoted():
    right, wrong = single(0, 1, 2), single(0, 2, 1)
    pairs = [(a, b) for a in range(4) for b in range(a + 1, 4)]
    found = lift_atoms({pair: wrong if pair == (0, 3) else right for pair in pairs}, [3] * 4, **NUMBERS)
    size = np.ones(3)
    assert found.lift.converged
    np.testing.assert_allclose(lifted_support(found.block(0, 1), *right, size, size), 1, atol=0.02)
    np.testing.assert_allclose(lifted_support(found.block(0, 3), *wrong, size, size), [1, 0, 0], atol=0.02)
    np.testing.assert_allclose(lifted_support(found.block(0, 3), *right, size, size), 1, atol=0.02)
    parts = consistent_parts(found.matches, found.objects, np.ones(12), part_from=0.5)
    assert (parts.reshape(4, 3) == parts[:3]).all()
    assert sorted(parts[:3]) == [0, 1, 2]


def test_a_common_refinement_is_supported_in_full():
    """One atom is the same as two others: between atoms the lifted entries are 1/√2, between the unions 1."""
    block = np.array([[np.sqrt(0.5), np.sqrt(0.5), 0], [0, 0, 1]])
    support = lifted_support(block, members(2, (0,), (0,), (1,)), members(3, (0, 1), (0,), (0, 1)), np.array([2.0, 1.0]), np.ones(3))
    np.testing.assert_allclose(support, [1, np.sqrt(0.5), 0], atol=1e-12)


def test_objects_that_were_not_matched_are_joined_by_those_between():
    """A chain of four: the ends never met, and an unmatched pair is no evidence against it."""
    chain = {(0, 1): single(1, 2, 0), (1, 2): single(2, 1, 0), (2, 3): single(0, 1, 2), (0, 2): single(1, 0, 2)}
    found = lift_atoms(chain, [3] * 4, **NUMBERS)
    np.testing.assert_allclose(found.block(0, 3), np.eye(3)[[1, 0, 2]], atol=0.05)
    assert not found.evidence[:3, 9:].any()


def test_a_finely_cut_shape_has_all_its_pieces_in_the_part():
    coarse_fine = members(2, (0,), (1,)), members(3, (0, 1), (2,))
    same = members(2, (0,), (1,)), members(2, (0,), (1,))
    found = lift_atoms({(0, 1): coarse_fine, (0, 2): same, (2, 1): coarse_fine}, [2, 3, 2], **NUMBERS)
    parts = consistent_parts(found.matches, found.objects, np.ones(7), part_from=0.5)
    assert parts.tolist() == [0, 1, 0, 0, 1, 0, 1]


def test_numbering_of_shapes_does_not_matter():
    rng = np.random.default_rng(4)
    pairs = [(a, b) for a in range(3) for b in range(a + 1, 3)]
    data = {pair: (rng.random((6, 4)) < 0.4, rng.random((6, 4)) < 0.4) for pair in pairs}
    found = lift_atoms(data, [4] * 3, **NUMBERS)
    order = [2, 0, 1]
    moved = lift_atoms({(order[a], order[b]): m for (a, b), m in data.items()}, [4] * 3, **NUMBERS)
    for a, b in pairs:
        np.testing.assert_allclose(moved.block(order[a], order[b]), found.block(a, b), atol=1e-3)
    first = consistent_parts(found.matches, found.objects, np.ones(12), part_from=0.5).reshape(3, 4)
    second = consistent_parts(moved.matches, moved.objects, np.ones(12), part_from=0.5).reshape(3, 4)[order]
    same = first.ravel()[:, None] == first.ravel()
    assert np.array_equal(same, second.ravel()[:, None] == second.ravel())


@pytest.mark.parametrize("changes", [{"most": 5}, {}])
def test_too_many_atoms_or_no_match_are_not_lifted(changes):
    data = {(0, 1): single(0, 1, 2)} if changes else {(0, 1): (members(3), members(3))}
    found = lift_atoms(data, [3, 3], **{**NUMBERS, **changes})
    assert found.lift is None
    assert np.array_equal(found.matches, np.eye(6)[:, [3, 4, 5, 0, 1, 2]] * bool(changes))
    assert np.array_equal(found.evidence, found.matches)


def test_parts_are_shared_and_ordered_by_size():
    matches = np.zeros((6, 6))
    for a, b in ((0, 3), (1, 4)):
        matches[a, b] = matches[b, a] = 1
    objects, size = np.array([0, 0, 0, 1, 1, 1]), np.array([1, 5, 9, 1, 5, 9.0])
    assert consistent_parts(matches, objects, size, part_from=0.5).tolist() == [1, 0, -1, 1, 0, -1]
    assert consistent_parts(np.zeros((6, 6)), objects, size, part_from=0.5).tolist() == [-1] * 6
    within = np.zeros((6, 6))
    within[0, 1] = within[1, 0] = 1
    assert consistent_parts(within, objects, size, part_from=0.5).tolist() == [-1] * 6


def test_higher_part_from_makes_no_fewer_parts():
    rng = np.random.default_rng(1)
    m = rng.random((20, 20)) ** 3
    m = (m + m.T) / 2
    objects = np.repeat(range(4), 5)
    grouped = [consistent_parts(m, objects, np.ones(20), part_from=x) for x in (0.2, 0.5, 0.8, 0.95)]
    pairs = [(g[:, None] == g) & (g >= 0)[:, None] for g in grouped]
    assert all((finer <= coarser).all() for coarser, finer in pairwise(pairs))


def test_asymmetric_or_unbounded_input_cannot_reach_the_programme():
    with pytest.raises((BadInput, ValueError)):
        lift_atoms({(0, 1): (members(3, (0,)), members(2, (0,)))}, [3, 3], **NUMBERS)
