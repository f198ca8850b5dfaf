"""The top-down method on candidates made by hand, so that one rule at a time decides what is accepted."""

from types import SimpleNamespace

import numpy as np
import pytest

from engine.shapes.parameters import preset
from engine.shapes.topdown import match_top_down

PLAIN = preset("top-down")


def packed(nodes, overlap, geodesic):
    """What is read of one shape: nodes overlap only as told by {(i, x): share}, and are 1 apart but for {(i, x): d}."""
    o, g = np.eye(nodes), np.ones((nodes, nodes))
    for (i, x), share in overlap.items():
        o[i, x] = share
    for (i, x), distance in geodesic.items():
        g[i, x] = g[x, i] = distance
    return np.stack([o, o.T, g], axis=-1).astype(np.float32)


def proposals(candidates, *, bottom=(), pinned=(), barred=(), source=None, target=None, extent=None, centrality=None, members=None):
    """Candidates {(i, j): light field distance}; `source` and `target` hold `overlap` and `geodesic` of `packed`."""
    pairs = np.array(sorted(candidates))
    nodes = pairs.max(axis=0) + 1
    read = [packed(n, **{"overlap": {}, "geodesic": {}, **(told or {})})
            for n, told in zip(nodes, (source, target), strict=True)]  # fmt: skip
    members = members or [np.eye(n, dtype=bool) for n in nodes]
    extra = [np.array([(told or {}).get(tuple(p), 0.0) for p in pairs.tolist()]) for told in (extent, centrality)]
    return SimpleNamespace(
        pairs=pairs, lfd=np.array([float(candidates[tuple(p)]) for p in pairs.tolist()]), extent=extra[0],
        centrality=extra[1], **{name: np.array([tuple(p) in chosen for p in pairs.tolist()])
                                for name, chosen in (("bottom", bottom), ("pinned", pinned), ("barred", barred))},
        packed_source=read[0], packed_target=read[1],
        **{name: SimpleNamespace(layers=SimpleNamespace(members=m))
           for name, m in zip(("source", "target"), members, strict=True)})  # fmt: skip


def accepted(given, parameters=PLAIN):
    return {tuple(pair) for pair in given.pairs[match_top_down(given, parameters)[0]].tolist()}


def transposed(given):
    """The same candidates with source and target exchanged."""
    pairs = given.pairs[:, ::-1]
    order = np.lexsort((pairs[:, 1], pairs[:, 0]))
    rows = {name: getattr(given, name)[order] for name in ("lfd", "extent", "centrality", "bottom", "pinned", "barred")}
    return SimpleNamespace(
        pairs=np.ascontiguousarray(pairs[order]), packed_source=given.packed_target, packed_target=given.packed_source,
        source=given.target, target=given.source, **rows)  # fmt: skip


THREE = {(0, 0): 0.1, (1, 1): 0.2, (2, 2): 0.0}  # 2-2 agrees with both others


def test_three_that_agree_in_full_score_one():
    given = proposals(THREE)
    rows, score, similarity, votes = match_top_down(given, PLAIN.changed(sigma=2.0))
    assert len(rows) == 3
    assert score == pytest.approx([1, 1, 1])
    assert similarity == pytest.approx(np.exp(-given.lfd[rows] / 2))
    assert votes.tolist() == [0, 0, 0]


@pytest.mark.parametrize("told", [{(0, 1): 0.5}, {(1, 0): 0.5}])
@pytest.mark.parametrize("flip", [False, True])
def test_overlap_min_rejects_what_overlaps_on_one_side_only(told, flip):
    given = proposals(THREE, source={"overlap": told})  # r = .5 of 0-0 and 1-1
    given = transposed(given) if flip else given
    assert accepted(given) == {(2, 2), (0, 0)}
    assert accepted(given, PLAIN.changed(overlap_min=0.4)) == {(0, 0), (1, 1), (2, 2)}


@pytest.mark.parametrize("flip", [False, True])
def test_ratio_min_rejects_what_is_far_apart_on_one_side_only(flip):
    given = proposals(THREE, source={"geodesic": {(0, 1): 0.4}})
    given = transposed(given) if flip else given
    assert accepted(given) == {(2, 2), (0, 0)}
    assert accepted(given, PLAIN.changed(ratio_min=0.3)) == {(0, 0), (1, 1), (2, 2)}


def test_a_match_that_agrees_with_no_other_is_left_out():
    given = proposals(THREE, source={"geodesic": {(0, 1): 0.65, (1, 2): 0.65}})
    assert accepted(given) == {(2, 2), (0, 0)}
    assert accepted(given, PLAIN.changed(agree_from=0.6)) == {(2, 2), (0, 0), (1, 1)}


@pytest.mark.parametrize("flip", [False, True])
def test_the_best_of_either_side_are_candidates(flip):
    """0-0 is the best of node 0, but 0-1 is the best of target 1, and fits 2-2 better (m = 1 against .75)."""
    given = proposals({(0, 0): 0.1, (0, 1): 0.2, (2, 2): 0.0}, target={"geodesic": {(0, 2): 0.75}})
    wanted = {(0, 1), (2, 2)}
    if flip:
        given, wanted = transposed(given), {(1, 0), (2, 2)}
    assert accepted(given, PLAIN.changed(K=1)) == wanted


def test_no_more_than_the_k_best_are_candidates():
    """1-1 fits 2-2 best of all (m = 1 against .75), but it is the nearest of neither node."""
    given = proposals({(1, 0): 0.1, (0, 1): 0.1, (1, 1): 0.2, (2, 2): 0.0}, source={"geodesic": {(0, 2): 0.75}},
                      target={"geodesic": {(0, 2): 0.75, (0, 1): 0.7}})  # fmt: skip
    assert accepted(given, PLAIN.changed(K=2)) == {(1, 1), (2, 2)}
    assert accepted(given, PLAIN.changed(K=1)) == {(2, 2), (1, 0), (0, 1)}


@pytest.mark.parametrize("name", ["extent", "centrality"])
def test_differences_of_extent_and_centrality_count_by_their_weights(name):
    given = proposals({(0, 0): 0.1, (0, 1): 0.3, (2, 2): 0.0}, **{name: {(0, 0): 1.0}})
    weight = f"{name}_weight"
    assert accepted(given, PLAIN.changed(**{weight: 0.0})) == {(0, 0), (2, 2)}
    assert accepted(given, PLAIN.changed(**{weight: 0.5})) == {(0, 1), (2, 2)}
    assert accepted(given, PLAIN.changed(**{weight: 0.1})) == {(0, 0), (2, 2)}


def test_a_small_scale_trusts_near_candidates_more():
    """0-0 is nearer by .2 and fits 2-2 half as well: exp(.2/scale) against 2 decides, at a scale of .2/log 2 = .29."""
    given = proposals({(0, 0): 0.1, (0, 1): 0.3, (2, 2): 0.0}, target={"geodesic": {(0, 2): 0.85}})
    assert accepted(given, PLAIN.changed(g_scale=0.25)) == {(0, 0), (2, 2)}
    assert accepted(given, PLAIN.changed(g_scale=0.35)) == {(0, 1), (2, 2)}


def segments_last(near=0.65, far=0.65):
    """Segment 0 may take segment 0 or the farther segment 3; unions 1-1 and 2-2 agree, and with them by the ratios.

    Below .7 nothing is supported in the main step, so only the last step can accept a pair of segments.
    """
    given = {(0, 0): 0.1, (0, 3): 0.2, (1, 1): 0.0, (2, 2): 0.0}
    ratios = {(0, 1): near, (0, 2): near, (1, 3): far, (2, 3): far}
    return proposals(given, bottom={(0, 0), (0, 3)}, target={"geodesic": ratios})


def test_segments_come_last_and_need_a_mean_agreement():
    assert accepted(segments_last()) == {(0, 0), (1, 1), (2, 2)}
    assert accepted(segments_last(), PLAIN.changed(bottom_min=0.64)) == {(0, 0), (1, 1), (2, 2)}
    assert accepted(segments_last(), PLAIN.changed(bottom_min=0.66)) == {(1, 1), (2, 2)}


def test_scores_are_mean_agreements_with_the_others():
    _, score, _, _ = match_top_down(segments_last(), PLAIN)
    assert score == pytest.approx([(1 + 0.65) / 2, (1 + 0.65) / 2, 0.65], abs=1e-5)


def test_only_the_bottom_k_nearest_segments_are_looked_at():
    """Confidence .62²·√exp(-.2) = .35 of the nearer, .69²·√exp(-.4) = .39 of the farther."""
    given = segments_last(0.62, 0.69)
    assert accepted(given, PLAIN.changed(bottom_K=2)) == {(0, 3), (1, 1), (2, 2)}
    assert accepted(given, PLAIN.changed(bottom_K=1)) == {(0, 0), (1, 1), (2, 2)}
    assert accepted(segments_last(0.62, 0.64), PLAIN.changed(bottom_K=2)) == {(0, 0), (1, 1), (2, 2)}


def test_a_taken_segment_is_not_matched_again():
    given = segments_last()
    given.pairs[0], given.pairs[1] = (1, 0), (1, 3)  # node 1 is taken by the union's match
    assert accepted(given) == {(1, 1), (2, 2)}


def test_votes_count_the_matches_that_hold_one_on_both_sides():
    nested = np.array([[1, 0, 0], [1, 1, 0], [1, 1, 1]], bool)
    given = proposals(THREE, members=[nested, nested])
    rows, _, _, votes = match_top_down(given, PLAIN)
    assert dict(zip(map(tuple, given.pairs[rows].tolist()), votes.tolist(), strict=True)) == {
        (0, 0): 2, (1, 1): 1, (2, 2): 0}  # fmt: skip


def test_nothing_in_agreement_gives_no_match():
    given = proposals({(0, 0): 0.1, (1, 1): 0.1}, bottom={(0, 0), (1, 1)}, source={"geodesic": {(0, 1): 0.1}})
    assert [len(x) for x in match_top_down(given, PLAIN)] == [0, 0, 0, 0]


def test_a_pin_comes_first_and_what_disagrees_with_it_does_not_come():
    """0-1 is far and fits nothing; pinned it takes both its nodes, and 2-2, too near to it on one side, goes."""
    candidates = {(0, 0): 0.1, (0, 1): 9.0, (1, 1): 0.2, (2, 2): 0.0, (3, 3): 0.0}
    told = {"geodesic": {(1, 2): 0.3}}
    assert accepted(proposals(candidates, target=told)) == {(0, 0), (2, 2), (3, 3)}
    assert accepted(proposals(candidates, target=told, pinned={(0, 1)})) == {(0, 1), (3, 3)}


def test_pins_that_disagree_are_both_kept():
    given = proposals({**THREE, (3, 3): 0.0}, source={"geodesic": {(0, 1): 0.1}}, pinned={(0, 0), (1, 1)})
    assert {(0, 0), (1, 1)} <= accepted(given)


def test_a_barred_pair_does_not_come_and_makes_room_for_the_next():
    given = {(0, 0): 0.1, (0, 1): 0.3, (2, 2): 0.0}
    assert accepted(proposals(given)) == {(0, 0), (2, 2)}
    assert accepted(proposals(given, barred={(0, 0)})) == {(0, 1), (2, 2)}
    assert accepted(proposals(given, barred={(0, 0)}), PLAIN.changed(K=1)) == {(0, 1), (2, 2)}
    assert accepted(proposals(given, barred=set(given))) == set()


def test_a_barred_pair_of_segments_does_not_come_last_either():
    given = segments_last()
    given.barred = np.array([tuple(p) == (0, 0) for p in given.pairs.tolist()])
    assert accepted(given, PLAIN.changed(bottom_min=0.6)) == {(0, 3), (1, 1), (2, 2)}
