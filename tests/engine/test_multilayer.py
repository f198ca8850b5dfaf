"""Nodes and edges of the multi-layer graph, by hand on a chain and by laws on random graphs."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import shortest_path

from engine.shapes.enumeration import connected_sets, normalised_cuts, spread_best
from engine.shapes.hops import UNREACHABLE, diameter, hop_distances
from engine.shapes.multilayer import ADJACENT, PART_OF, build_multilayer_graph
from engine.shapes.parameters import preset
from engine.shapes.segmentation import SegmentGraph


def chain(areas):
    n = len(areas)
    edges = [(i, i + 1) for i in range(n - 1)]
    return SegmentGraph(np.array(areas, float), np.array(areas, float), np.array(edges), np.zeros(n - 1))


def build(graph, **changes):
    return build_multilayer_graph(graph, preset("top-down").changed(**changes), graph.adjacency().astype(float))


def nodes(found):
    return ["".join(map(str, np.flatnonzero(row))) for row in found.members]


def edge_names(found, kind):
    names = nodes(found)
    return {(names[i], names[j]) for (i, j), k in zip(found.edges, found.kind, strict=True) if k == kind}


def test_connected_sets_of_a_chain_are_its_intervals():
    found = build(chain([1, 1, 1, 1]), mode="connected")
    assert nodes(found) == ["0", "1", "2", "3", "01", "12", "23", "012", "123", "0123"]
    assert found.layer.tolist() == [1, 1, 1, 1, 5, 5, 5, 7, 7, 8]  # clamp(floor(8 v) + 1, 2, 8)
    assert found.capped == ""


def test_most_segments_in_a_node():
    found = build(chain([1] * 6), mode="connected", max_segments=2)
    assert nodes(found) == ["0", "1", "2", "3", "4", "5", "01", "12", "23", "34", "45", "012345"]
    assert found.capped == "Unions hold at most 2 of 6 segments (max_segments)."


@pytest.mark.parametrize("mode", ["literal", "relaxed", "connected", "beam"])
def test_most_segments_holds_in_every_mode(mode):
    found = build(random_graph(12, 2), mode=mode, max_segments=3)
    assert found.members[:-1].sum(axis=1).max() == 3
    assert "max_segments" in found.capped


@pytest.mark.parametrize("mode", ["literal", "relaxed", "connected", "beam"])
@pytest.mark.parametrize("cap", [42, 45, 60])
def test_the_cap_is_never_exceeded_and_few_nodes_are_wasted(mode, cap):
    found = build(random_graph(40, 5), mode=mode, node_cap=cap)
    assert len(found.members) <= cap


def test_segments_beyond_the_cap_stay_and_it_is_said():
    found = build(random_graph(40, 5), node_cap=30)
    assert len(found.members) == 41
    assert "alone exceed the node cap of 30" in found.capped


def test_volume_can_be_the_measure_of_size():
    graph = SegmentGraph(np.array([1.0, 1, 1, 1]), np.array([5.0, 1, 1, 1]), np.array([(0, 1), (1, 2), (2, 3)]), np.zeros(3))
    by_area, by_volume = (build(graph, mode="connected", size_measure=m) for m in ("area", "volume"))
    row = nodes(by_area).index("01")
    assert (by_area.layer[row], by_volume.layer[row]) == (5, 7)  # 2/4 and 6/8 of the whole


def test_edges_of_eq_3_2():
    found = build(chain([1, 1, 1]), mode="connected")
    assert edge_names(found, ADJACENT) == {("0", "1"), ("1", "2"), ("01", "12")}
    assert edge_names(found, PART_OF) == {
        ("0", "01"), ("1", "01"), ("1", "12"), ("2", "12"), ("01", "012"), ("12", "012"), ("0", "012"), ("2", "012")
    }  # fmt: skip


def test_literal_eq_3_1_by_hand():
    # L = 4, areas 1 1 2: unions 01 (v = .5, layer 3), 12 (.75, layer 4); 012 is the top.
    found = build(chain([1, 1, 2]), mode="literal", layers=4)
    assert dict(zip(nodes(found), found.layer.tolist(), strict=True)) == {"0": 1, "1": 1, "2": 1, "01": 3, "12": 4, "012": 4}


def test_relaxed_holds_all_that_literal_holds():
    for seed in range(5):
        graph = random_graph(9, seed)
        literal, relaxed = (set(nodes(build(graph, mode=m, node_cap=5000))) for m in ("literal", "relaxed"))
        assert literal <= relaxed


def test_a_relaxed_layer_holds_unions_of_its_own_nodes():
    # L = 2: every merged node below half is in layer 2, so wider unions need the relaxed rule.
    graph = chain([1] * 8)
    assert "0123" not in nodes(build(graph, mode="literal", layers=2))
    assert "0123" in nodes(build(graph, mode="relaxed", layers=2))


def random_graph(n, seed):
    rng = np.random.default_rng(seed)
    edges = {(int(rng.integers(0, i)), i) for i in range(1, n)}
    edges |= {tuple(sorted(map(int, rng.choice(n, 2, replace=False)))) for _ in range(n // 2)}
    return SegmentGraph(rng.random(n) + 0.1, rng.random(n), np.array(sorted(edges)), np.zeros(len(edges)))


@given(st.integers(3, 9), st.integers(0, 10**6))
@settings(max_examples=25, deadline=None)
def test_connected_sets_are_exactly_the_connected_subsets(n, seed):
    graph = random_graph(n, seed)
    adjacency = graph.adjacency()
    masks = [sum(1 << int(j) for j in np.flatnonzero(row)) for row in adjacency]
    found, capped = connected_sets(masks, adjacency.astype(float), largest=n, most=10**6)
    wanted = set()
    for size in range(2, n):
        for subset in combinations(range(n), size):
            inner = adjacency[np.ix_(subset, subset)]
            if np.isfinite(shortest_path(inner.astype(float), unweighted=True)).all():
                wanted.add(sum(1 << i for i in subset))
    assert set(found) == wanted
    assert len(found) == len(wanted)
    assert not capped


@pytest.mark.parametrize("mode", ["literal", "relaxed", "connected", "beam"])
def test_caps_hold_and_are_reported_and_every_segment_stays_in_a_merged_node(mode):
    graph = random_graph(40, 3)
    found = build(graph, mode=mode, node_cap=120)
    assert len(found.members) <= 120
    assert "node cap" in found.capped
    assert mode in found.capped
    if mode in ("connected", "beam"):
        assert found.members[40:-1].any(axis=0).all()


@pytest.mark.parametrize("mode", ["literal", "relaxed", "connected", "beam"])
def test_laws_of_every_mode(mode):
    graph = random_graph(12, 1)
    found = build(graph, mode=mode, node_cap=2000)
    assert found.members[:12].tolist() == np.eye(12, dtype=bool).tolist()
    assert found.members[-1].all()
    assert len(np.unique(found.members, axis=0)) == len(found.members)
    adjacency = graph.adjacency()
    for row in found.members:
        inside = np.flatnonzero(row)
        assert np.isfinite(shortest_path(adjacency[np.ix_(inside, inside)].astype(float), unweighted=True)).all()
    hops = hop_distances(len(found.members), found.edges)
    assert hops.max() < UNREACHABLE
    share = found.members @ graph.area / graph.area.sum()
    merged = found.members.sum(axis=1) > 1
    assert found.layer[merged].tolist() == np.clip(np.floor(8 * share[merged] + 1e-9).astype(int) + 1, 2, 8).tolist()


def test_two_hundred_segments_stay_within_the_cap():
    found = build(random_graph(200, 0), node_cap=400)
    assert len(found.members) <= 400
    assert "200 segments" in found.capped


def test_hops_agree_with_scipy():
    rng = np.random.default_rng(0)
    edges = np.unique(np.sort(rng.integers(0, 150, (170, 2)), axis=1), axis=0)
    edges = edges[edges[:, 0] != edges[:, 1]]
    dense = np.zeros((150, 150))
    dense[edges[:, 0], edges[:, 1]] = 1
    wanted = shortest_path(dense, directed=False, unweighted=True)
    found = hop_distances(150, edges).astype(float)
    found[found == UNREACHABLE] = np.inf
    assert np.array_equal(found, wanted)
    assert diameter(hop_distances(150, edges)) == wanted[np.isfinite(wanted)].max()


def test_normalised_cut_by_hand():
    # a path 0-1-2-3 cut in the middle: cut 1, each side has volume 3
    weights = chain([1, 1, 1, 1]).adjacency().astype(float)
    members = np.array([[True, True, False, False], [True, False, False, False]])
    assert normalised_cuts(members, weights) == pytest.approx([1 / 3 + 1 / 3, 1 / 1 + 1 / 5])


def test_spread_best_gives_every_segment_its_own_best():
    members = np.array([[1, 1, 0, 0], [1, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], bool)
    assert spread_best(members, np.array([0.1, 0.2, 5.0, 9.0]), 3).tolist() == [0, 2, 3]
