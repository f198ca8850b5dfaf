"""The methods to compare with, one rule at a time on candidates made by hand, and laws that hold for all methods."""

from dataclasses import replace
from types import SimpleNamespace

import numba
import numpy as np
import pytest
from world import bar

from engine.errors import BadParameter
from engine.shapes.baselines import match_bottom, match_diffusion, match_hungarian, match_spectral
from engine.shapes.describing import describe
from engine.shapes.families import make_pair
from engine.shapes.hops import UNREACHABLE
from engine.shapes.matching import METHODS, propose, rematch
from engine.shapes.parameters import PRESETS, SHED, method_preset, preset
from engine.shapes.segmentation import SegmentedShape, segmentation_from_labels

BOTTOM_ONLY = ("bottom", "hungarian", "spectral", "shed")
PLAIN = {"sigma": 1.0, "size_weight": 0.0, "extent_weight": 0.0, "centrality_weight": 0.0, "lfd_threshold": 0.0}


def side(nodes, *, hops=None, geodesic=None, edges=()):
    """A shape of separate segments; `hops` and `geodesic` {(i, x): distance}, all others far apart or 1."""
    between, near = np.ones((nodes, nodes)), np.full((nodes, nodes), UNREACHABLE, np.uint8)
    for table, told in ((between, geodesic), (near, hops)):
        np.fill_diagonal(table, 0)
        for (i, x), value in (told or {}).items():
            table[i, x] = table[x, i] = value
    return SimpleNamespace(
        layers=SimpleNamespace(members=np.eye(nodes, dtype=bool)), hops=near, measures=SimpleNamespace(geodesic=between),
        graph=SimpleNamespace(area=np.ones(nodes), edges=np.array(edges, dtype=np.int64).reshape(-1, 2)))  # fmt: skip


def proposals(source, target, candidates, pinned=(), barred=(), unions=()):
    """Candidates {(i, j): light field distance}; those of `unions` are no bottom pairs."""
    pairs = np.array(sorted(candidates))
    rows = [tuple(p) for p in pairs.tolist()]
    marks = [np.array([p in told for p in rows]) for told in (pinned, barred, unions)]
    zero = np.zeros(len(pairs))
    return SimpleNamespace(
        source=source, target=target, pairs=pairs, lfd=np.array([float(candidates[p]) for p in rows]), size=zero,
        extent=zero, centrality=zero, apart={}, pinned=marks[0], barred=marks[1], bottom=~marks[2])  # fmt: skip


def accepted(method, given, **changes):
    """The accepted pairs, best first."""
    name = method.__name__.removeprefix("match_")
    rows, score, similarity, votes = method(given, preset(name).changed(**(PLAIN | changes)))
    assert similarity == pytest.approx(np.exp(-given.lfd[rows]))
    assert (np.diff(score) <= 0).all()
    assert not votes.any()
    return [tuple(p) for p in given.pairs[rows].tolist()]


SQUARE = {(0, 0): 0.1, (0, 1): 0.2, (1, 0): 0.2, (1, 1): 0.9}


def test_the_hungarian_method_takes_the_best_sum():
    given = proposals(side(2), side(2), SQUARE)
    assert accepted(match_hungarian, given) == [(0, 1), (1, 0)]
    assert accepted(match_hungarian, given, distance_max=0.1) == []
    assert accepted(match_hungarian, given, distance_max=0.25) == [(0, 0)]
    assert match_hungarian(given, preset("hungarian").changed(distance_max=0.8))[1] == pytest.approx([0.75, 0.75])


@pytest.mark.parametrize("method", [match_hungarian, match_spectral, match_bottom, match_diffusion])
def test_pins_and_bars_decide(method):
    two = side(2, hops={(0, 1): 5}, edges=[(0, 1)])
    first = accepted(method, proposals(two, two, SQUARE))[0]
    assert first not in accepted(method, proposals(two, two, SQUARE, barred=[first]))
    assert set(accepted(method, proposals(two, two, SQUARE, pinned=[(1, 1)]))) == {(0, 0), (1, 1)}
    assert set(accepted(method, proposals(two, two, SQUARE, pinned=[(1, 1)], barred=[(0, 0)]))) == {(1, 1)}
    assert set(accepted(method, proposals(two, two, SQUARE, pinned=[(0, 1)]))) == {(0, 1), (1, 0)}


@pytest.mark.parametrize("method", [match_hungarian, match_spectral, match_bottom])
def test_only_segments_are_matched(method):
    given = proposals(side(3), side(3), {(0, 0): 0.5, (1, 1): 0.5, (2, 2): 0.1}, unions=[(2, 2)])
    assert sorted(accepted(method, given)) == [(0, 0), (1, 1)]


def test_spectral_matching_prefers_what_keeps_geodesic_distances():
    """0-0 and 1-1 look alike a little less than 0-1 and 1-0, but only they are as far from 2-2 on both sides."""
    candidates = {(0, 0): 0.3, (0, 1): 0.2, (1, 0): 0.2, (1, 1): 0.3, (2, 2): 0.1}
    told = {(0, 1): 1.0, (0, 2): 0.3, (1, 2): 0.9}
    given = proposals(side(3, geodesic=told), side(3, geodesic=told), candidates)
    assert sorted(accepted(match_spectral, given)) == [(0, 0), (1, 1), (2, 2)]
    assert sorted(accepted(match_hungarian, given)) == [(0, 1), (1, 0), (2, 2)]
    assert sorted(accepted(match_spectral, given, geodesic_sigma=2.0)) == [(0, 1), (1, 0), (2, 2)]


def test_spectral_confidence_by_hand():
    """Two candidates alike, whose distances differ by σ: M = g·[[1, g·8/9], [g·8/9, 1]] has the eigenvector (1, 1)."""
    given = proposals(side(2, geodesic={(0, 1): 1.0}), side(2, geodesic={(0, 1): 1.5}), {(0, 0): 0.4, (1, 1): 0.4})
    p = preset("spectral").changed(**PLAIN, geodesic_sigma=0.5)
    assert match_spectral(given, p)[1] == pytest.approx([1, 1])
    third = proposals(
        side(3, geodesic={(0, 1): 1.0}), side(3, geodesic={(0, 1): 1.5, (0, 2): 9.0, (1, 2): 9.0}),
        {(0, 0): 0.4, (1, 1): 0.4, (2, 2): 0.8})  # fmt: skip
    assert accepted(match_spectral, third, geodesic_sigma=0.5) == [(0, 0), (1, 1)]  # nothing supports 2-2


def test_the_least_confidence_leaves_doubtful_matches_out():
    told = {(0, 1): 1.0, (0, 2): 1.0, (1, 2): 1.0}
    given = proposals(side(3, geodesic=told), side(3, geodesic=told), {(0, 0): 0.1, (1, 1): 0.1, (2, 2): 0.9})
    assert accepted(match_spectral, given) == [(0, 0), (1, 1), (2, 2)]
    assert accepted(match_spectral, given, confidence_min=0.5) == [(0, 0), (1, 1)]


CHAIN = [(k, k + 1) for k in range(5)]


def test_the_bottom_layer_counts_hops_between_segments():
    """A chain 0-1-...-5: 1-1 keeps its one hop from 0-0, 1-4 does not (four hops), and is left out by c₂."""
    chain = side(6, edges=CHAIN)
    candidates = {(0, 0): 0.1, (1, 4): 0.2, (2, 2): 0.3}
    given = proposals(chain, chain, candidates)
    assert accepted(match_bottom, given, delta_1=0.8) == [(0, 0), (2, 2)]
    assert accepted(match_bottom, given, delta_1=0.2) == [(0, 0), (1, 4), (2, 2)]  # four hops are beyond the region
    assert accepted(match_bottom, given, delta_1=0.8, c_2=0.2) == [(0, 0), (2, 2), (1, 4)]
    assert accepted(match_bottom, given, delta_1=0.8, lfd_threshold=0.8) == [(0, 0)]


def test_support_decides_at_the_bottom():
    """0-0, 1-1 and 2-2 keep their hops and support each other; 0-2 alone looks a little better."""
    chain = side(6, edges=CHAIN)
    candidates = {(0, 0): 0.3, (0, 2): 0.1, (1, 1): 0.3, (2, 2): 0.3}
    given = proposals(chain, chain, candidates)
    assert sorted(accepted(match_bottom, given, delta_1=0.4)) == [(0, 0), (1, 1), (2, 2)]
    assert accepted(match_bottom, given, delta_1=0.0)[0] == (0, 2)


def test_the_full_rule_grows_from_seeds():
    """1-1 is near 0-0 on both sides and keeps its hop; 2-2 is near on the source alone, and waits for ever."""
    source = side(4, hops={(0, 1): 1, (0, 2): 1, (1, 2): 2, (0, 3): 5, (1, 3): 5, (2, 3): 5})
    target = side(4, hops={(0, 1): 1, (0, 2): 5, (1, 2): 5, (0, 3): 5, (1, 3): 5, (2, 3): 5})
    candidates = {(0, 0): 0.1, (1, 1): 0.3, (2, 2): 0.2, (3, 3): 0.4}
    given = proposals(source, target, candidates)
    assert accepted(match_diffusion, given, delta_2=0.2) == [(0, 0), (1, 1), (3, 3)]
    assert accepted(match_diffusion, given, delta_2=0.2, K=1) == [(0, 0), (1, 1), (3, 3)]
    assert sorted(accepted(match_diffusion, given, delta_2=1.0)) == [(0, 0), (1, 1), (3, 3)]  # one hop against five: k = .2


def test_full_and_simple_confidence_differ_by_the_square():
    """Hops 2 and 3, c₀ = .5: k = 2/3, affinity 1/3, squared 1/9."""
    source, target = (side(3, hops={(0, 1): d, (0, 2): 9, (1, 2): 9}) for d in (2, 3))
    given = proposals(source, target, {(0, 0): 0.1, (1, 1): 0.3})
    p = preset("diffusion").changed(**(PLAIN | {"c_0": 0.5, "delta_2": 0.5}))
    assert match_diffusion(given, p)[1] == pytest.approx([1, (np.exp(-0.3) + 1 / 9) / (np.exp(-0.1) + 1 / 9)])


def test_each_method_has_a_preset_and_an_unknown_one_is_a_sentence():
    assert all(preset(method_preset(name)).method == name for name in METHODS)
    assert {values.method for values in PRESETS.values()} == set(METHODS)
    with pytest.raises(BadParameter, match=r"no method named 'magic'; the methods are: .*spectral"):
        method_preset("magic")


# --- laws, on generated shapes


LIGHT = preset("top-down").changed(light_fields=1, resolution=64, node_cap=100)


def renumbered(shape, order):
    """The same described shape, its segment k under the number order[k]; unions keep theirs."""
    inverse = np.argsort(order)
    nodes = np.concatenate([inverse, np.arange(len(order), len(shape.hops))])
    layers, m, points = shape.layers, shape.measures, shape.kept.get("points")  # the points are drawn anew, but for this
    square = np.ix_(nodes, nodes)
    segments = SegmentedShape(shape.shape.mesh, segmentation_from_labels(order[shape.shape.segmentation.labels]))
    edges = np.sort(order[shape.graph.edges], axis=1)
    return replace(
        shape, shape=segments, segment_ids=tuple(shape.segment_ids[k] for k in inverse), hops=shape.hops[square],
        graph=replace(shape.graph, area=shape.graph.area[inverse], volume=shape.graph.volume[inverse], edges=edges),
        layers=replace(layers, members=layers.members[nodes][:, inverse], layer=layers.layer[nodes]),
        measures=replace(m, size=m.size[nodes], extent=m.extent[nodes], centrality=m.centrality[nodes],
                         geodesic=m.geodesic[square], overlap=m.overlap[square], between=m.between[np.ix_(inverse, inverse)]),
        descriptors=shape.descriptors[nodes], signatures=shape.signatures[nodes],
        kept={"points": replace(points, owner=order[points.owner])} if points else {})  # fmt: skip


def unions(result):
    return {(m.source, m.target): round(m.score, 6) for m in result.matches()}


@pytest.fixture(scope="module")
def lamps():
    made = make_pair("lamps", 41, segments=(8, 10))
    return propose(*(describe(shape, LIGHT) for shape in (made.source, made.target)), LIGHT)


@pytest.mark.parametrize("method", METHODS)
def test_renumbering_renumbers_the_matches(lamps, method):
    p = preset(method_preset(method))
    plain = unions(rematch(lamps, p))
    assert plain
    order = np.random.default_rng(5).permutation(len(lamps.source.segment_ids))
    other = propose(renumbered(lamps.source, order), lamps.target, LIGHT)
    assert {(tuple(sorted(int(order[i]) for i in s)), t): score for (s, t), score in plain.items()} == unions(rematch(other, p))


@pytest.mark.parametrize("method", ["hungarian", "spectral", "shed"])
def test_from_the_other_side_the_same_matches(lamps, method):
    back = propose(lamps.target, lamps.source, LIGHT)
    p = preset(method)
    assert {(t, s): score for (s, t), score in unions(rematch(lamps, p)).items()} == unions(rematch(back, p))


@pytest.mark.parametrize("method", METHODS)
def test_the_number_of_threads_changes_nothing(lamps, method):
    before, results = numba.get_num_threads(), []
    try:
        for threads in (1, before):
            numba.set_num_threads(threads)
            results.append(rematch(lamps, preset(method_preset(method))))
    finally:
        numba.set_num_threads(before)
    assert results[0].ids == results[1].ids
    assert np.array_equal(results[0].score, results[1].score)


@pytest.mark.parametrize("method", BOTTOM_ONLY)
def test_methods_of_the_bottom_layer_match_single_segments(lamps, method):
    found = unions(rematch(lamps, preset(method)))
    assert found
    assert all(len(s) == len(t) == 1 for s, t in found)
    if method != SHED:
        assert len({s for s, _ in found}) == len({t for _, t in found}) == len(found)


@pytest.mark.parametrize("method", METHODS)
def test_two_segments_are_enough(method):
    two = propose(*(describe(bar(lengths), LIGHT) for lengths in ([1, 3], [2, 5])), LIGHT)
    assert len(rematch(two, preset(method_preset(method))).ids) <= 2
