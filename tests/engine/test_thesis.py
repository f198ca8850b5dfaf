"""The thesis's method on candidates made by hand, so that one rule at a time decides what is accepted."""

from types import SimpleNamespace

import numpy as np
import pytest

from engine.shapes.parameters import preset
from engine.shapes.thesis import match_thesis

FAR = 9  # a hop distance outside every region that the tests use
RIGID = preset("thesis-rigid").changed(sigma=1.0, c_0=0.99, lfd_threshold=0.0)
PLAIN = RIGID.changed(anchors="off", voting=False, second_run=False)


def side(nodes, hops):
    """A shape of the given nodes (sets of segments) and hops {(i, x): distance}; all others are far apart.

    One node more lies 10 hops from all: it makes the diameter 10, so that a region of .2 reaches 2 hops, of .8 eight.
    """
    count = len(nodes) + 1
    distance = np.full((count, count), FAR, np.uint8)
    distance[-1] = distance[:, -1] = 10
    np.fill_diagonal(distance, 0)
    for (i, x), value in hops.items():
        distance[i, x] = distance[x, i] = value
    segments = 1 + max(max(node) for node in nodes)
    members = np.array([[s in node for s in range(segments)] for node in [*nodes, range(segments)]])
    return SimpleNamespace(hops=distance, layers=SimpleNamespace(members=members))


def proposals(source, target, candidates, source_hops=None, target_hops=None, size=None, pinned=(), barred=()):
    """Candidates {(i, j): similarity}; a number for `source` or `target` means so many separate segments."""
    nodes = [[{i} for i in range(n)] if isinstance(n, int) else n for n in (source, target)]
    pairs = np.array(sorted(candidates))
    single = [np.array([len(node) == 1 for node in side_nodes]) for side_nodes in nodes]
    return SimpleNamespace(
        source=side(nodes[0], source_hops or {}), target=side(nodes[1], target_hops or {}), pairs=pairs,
        lfd=np.array([-np.log(candidates[tuple(pair)]) for pair in pairs.tolist()]),
        size=np.zeros(len(pairs)) if size is None else np.array([size.get(tuple(p), 0.0) for p in pairs.tolist()]),
        bottom=single[0][pairs[:, 0]] & single[1][pairs[:, 1]],
        pinned=np.array([tuple(p) in pinned for p in pairs.tolist()]),
        barred=np.array([tuple(p) in barred for p in pairs.tolist()]))  # fmt: skip


def accepted(given, parameters):
    """The accepted pairs, best first."""
    return [tuple(pair) for pair in given.pairs[match_thesis(given, parameters)[0]].tolist()]


def test_the_threshold_asks_for_light_field_similarity_alone():
    given = proposals(2, 2, {(0, 0): 0.9, (1, 1): 0.7}, size={(0, 0): 5.0})
    assert accepted(given, PLAIN.changed(lfd_threshold=0.6, size_weight=0.0)) == [(0, 0), (1, 1)]
    assert accepted(given, PLAIN.changed(lfd_threshold=0.8, size_weight=0.0)) == [(0, 0)]
    assert accepted(given, PLAIN.changed(lfd_threshold=0.8, size_weight=1.0)) == [(0, 0)]


@pytest.mark.parametrize("k", [1, 7])
def test_relative_size_decides_by_its_weight(k):
    given = proposals(1, 2, {(0, 0): 0.9, (0, 1): 0.8}, size={(0, 0): 1.0})
    assert accepted(given, PLAIN.changed(K=k, size_weight=0.0)) == [(0, 0)]
    assert accepted(given, PLAIN.changed(K=k, size_weight=1.0)) == [(0, 1)]
    rows, _, similarity, _ = match_thesis(given, PLAIN.changed(size_weight=0.1, sigma=2.0))
    assert given.pairs[rows].tolist() == [[0, 0]]
    assert similarity == pytest.approx([0.9**0.5 * np.exp(-0.1 / 2)])


def test_the_k_best_of_each_source_node_are_candidates():
    given = proposals(2, 2, {(0, 0): 0.9, (1, 0): 0.8, (1, 1): 0.7})
    assert accepted(given, PLAIN.changed(K=1)) == [(0, 0)]
    assert accepted(given, PLAIN.changed(K=2)) == [(0, 0), (1, 1)]


def test_confidence_by_hand():
    """Distances 2 and 3: m = 2/3, and with c₀ = .5 each supports the other by (2/3 - .5)/.5 = 1/3."""
    given = proposals(2, 2, {(0, 0): 0.9, (1, 1): 0.8}, {(0, 1): 2}, {(0, 1): 3})
    _, score, similarity, votes = match_thesis(given, PLAIN.changed(c_0=0.5))
    assert score == pytest.approx([1, (0.8 + 1 / 3) / (0.9 + 1 / 3)])
    assert similarity == pytest.approx([0.9, 0.8])
    assert votes.tolist() == [0, 0]
    assert match_thesis(given, PLAIN.changed(c_0=0.7))[1] == pytest.approx([1, 0.8 / 0.9])


def test_a_match_that_bends_distances_is_rejected_by_c_2():
    given = proposals(2, 2, {(0, 0): 0.9, (1, 1): 0.8}, {(0, 1): 1}, {(0, 1): 4})  # m = 1/4
    assert accepted(given, PLAIN.changed(c_2=0.3)) == [(0, 0)]
    assert accepted(given, PLAIN.changed(c_2=0.2)) == [(0, 0), (1, 1)]


@pytest.mark.parametrize("hops", [({(0, 1): 1}, {}), ({}, {(0, 1): 1})])
def test_c_2_counts_only_where_both_ends_lie_inside_the_regions(hops):
    given = proposals(2, 2, {(0, 0): 0.9, (1, 1): 0.8}, *hops)  # 1 hop against 9, with regions of 8
    assert accepted(given, PLAIN.changed(c_2=1.0)) == [(0, 0), (1, 1)]
    assert accepted(given, PLAIN.changed(c_2=1.0, delta_2=0.9)) == [(0, 0)]


def test_the_second_stage_looks_as_far_as_delta_2():
    given = proposals(2, 2, {(0, 0): 0.9, (1, 1): 0.8}, {(0, 1): 1}, {(0, 1): 4})
    for anchors in ("off", "first"):
        wide = PLAIN.changed(anchors=anchors, delta_1=0.2, delta_2=0.8)
        assert accepted(given, wide) == [(0, 0)]
        assert accepted(given, wide.changed(delta_1=0.8, delta_2=0.2)) == [(0, 0), (1, 1)]


def test_the_first_stage_looks_as_far_as_delta_1():
    """Segments 1-1 clash with 0-0 at 4 hops; the union {1, 2} of the target is the better partner of segment 1.

    An anchor stage that sees the clash leaves 1-1 out, and the union wins; one that does not see it keeps 1-1.
    """
    given = proposals(
        2, [{0}, {1}, {1, 2}], {(0, 0): 0.9, (1, 1): 0.7, (1, 2): 0.8}, {(0, 1): 1}, {(0, 1): 4})  # fmt: skip
    first = PLAIN.changed(anchors="first", delta_2=0.2)
    assert accepted(given, first.changed(delta_1=0.8)) == [(0, 0), (1, 2)]
    assert accepted(given, first.changed(delta_1=0.2)) == [(0, 0), (1, 1)]


def two_readings(anchor, free):
    """Two segments B, D that support each other, against unions C, E, F: both E and F support C, so C is surest.

    Only one of E and F can be accepted, so as a whole {C, E} is as coherent as {B, D}: 1 + the mean similarity.
    """
    b, d, c, e, f = (0, 0), (1, 1), (0, 2), (2, 3), (2, 4)
    source = [{0}, {1}, {2, 3}]
    target = [{0}, {1}, {2, 3}, {4, 5}, {6, 7}]
    support = {(0, 1): 1, (2, 3): 1, (2, 4): 1}  # B-D, C-E and C-F; the clashes are C-D, D-E and D-F
    given = proposals(source, target, {b: anchor, d: anchor, c: free, e: free, f: free},
                      {(0, 1): 1, (0, 2): 1, (1, 2): 1}, support | {(1, 2): 4, (1, 3): 4, (1, 4): 4})  # fmt: skip
    return given, {b, d}, {c, e}


@pytest.mark.parametrize("similar", [(0.9, 0.8), (0.8, 0.9)])
def test_anchors_off_and_first(similar):
    given, anchored, free = two_readings(*similar)
    assert set(accepted(given, PLAIN.changed(anchors="off"))) == free
    assert set(accepted(given, PLAIN.changed(anchors="first"))) == anchored


def test_checked_anchors_stay_where_the_whole_is_more_coherent_with_them():
    given, anchored, _ = two_readings(0.9, 0.8)
    assert set(accepted(given, PLAIN.changed(anchors="checked"))) == anchored
    given, _, free = two_readings(0.8, 0.9)
    assert set(accepted(given, PLAIN.changed(anchors="checked"))) == free


def test_an_anchor_outside_the_k_best_is_still_a_candidate():
    given = proposals([{0}], [{0}, {1, 2}], {(0, 0): 0.7, (0, 1): 0.9})
    assert accepted(given, PLAIN.changed(K=1, anchors="first")) == [(0, 0)]
    assert accepted(given, PLAIN.changed(K=1, anchors="off")) == [(0, 1)]


def test_voting_drops_a_match_that_nests_on_one_side_only():
    """{0} lies in {0, 1}, but its partner {0} does not lie in {1, 2}; {1} - {1} nests on both sides and votes."""
    nodes = [{0}, {1}, {0, 1}], [{0}, {1}, {1, 2}]
    given = proposals(*nodes, {(0, 0): 0.95, (1, 1): 0.8, (2, 2): 0.9})
    assert accepted(given, PLAIN) == [(0, 0), (2, 2), (1, 1)]
    assert accepted(given, PLAIN.changed(voting=True)) == [(0, 0), (1, 1)]  # 1-1 by its vote, 0-0 before 2-2 by π
    assert match_thesis(given, PLAIN.changed(voting=True))[3].tolist() == [0, 1]
    assert accepted(given, PLAIN.changed(voting=True, second_run=True)) == [(0, 0), (1, 1)]


def test_the_second_run_fills_the_place_of_an_anchor_that_was_voted_out():
    """Segment {0} is anchored to {0}, and so its better partner {1, 2} is out; {0, 1} - {1, 2, 3} votes the anchor out."""
    nodes = [{0}, {0, 1}], [{0}, {1, 2}, {1, 2, 3}]
    given = proposals(*nodes, {(0, 0): 0.7, (0, 1): 0.8, (1, 2): 0.9})
    first = PLAIN.changed(anchors="first", voting=True)
    assert accepted(given, first) == [(1, 2)]
    assert accepted(given, first.changed(second_run=True)) == [(1, 2), (0, 1)]
    assert accepted(given, first.changed(second_run=True, voting=False)) == [(1, 2), (0, 0)]


def test_nothing_above_the_threshold_gives_no_match():
    given = proposals(2, 2, {(0, 0): 0.5, (1, 1): 0.4})
    for anchors in ("off", "first", "checked"):
        rows, score, similarity, votes = match_thesis(given, RIGID.changed(lfd_threshold=0.9, anchors=anchors))
        assert len(rows) == len(score) == len(similarity) == len(votes) == 0


def test_a_pin_needs_no_similarity_and_takes_its_nodes():
    given = {(0, 0): 0.9, (1, 1): 0.9, (0, 1): 0.1}
    asked = PLAIN.changed(lfd_threshold=0.5)
    assert set(accepted(proposals(2, 2, given), asked)) == {(0, 0), (1, 1)}
    assert accepted(proposals(2, 2, given, pinned={(0, 1)}), asked) == [(0, 1)]
    for anchors in ("off", "first", "checked"):
        assert accepted(proposals(2, 2, given, pinned={(0, 1)}), RIGID.changed(lfd_threshold=0.5, anchors=anchors)) == [(0, 1)]


def test_a_barred_pair_is_no_candidate_of_either_stage():
    given = {(0, 0): 0.9, (1, 1): 0.9, (0, 1): 0.1}
    for parameters in (PLAIN, RIGID):
        found = accepted(proposals(2, 2, given, barred={(0, 0)}), parameters.changed(K=1))
        assert (0, 0) not in found
        assert (1, 1) in found


def test_voting_does_not_drop_a_pin():
    """Node 2 holds node 0 at the source, its partner holds nothing: of 0-0 and 2-1 voting keeps the surer one."""
    nodes = [{0}, {1}, {0, 1}]
    given = {(0, 0): 0.2, (2, 1): 0.9}
    asked = RIGID.changed(anchors="off")
    assert accepted(proposals(nodes, 2, given), asked) == [(2, 1)]
    assert accepted(proposals(nodes, 2, given, pinned={(0, 0)}), asked) == [(0, 0)]
