"""Descriptors beside the light field: made when asked for, kept, symmetric, and weighed in one distance."""

from dataclasses import replace
from itertools import pairwise

import numba
import numpy as np
import pytest
from world import bar

import engine.shapes.features as features_module
from engine.runs.pairs import LabelledPair
from engine.runs.retrieving import true_partners
from engine.shapes.describing import describe
from engine.shapes.extending import with_nodes
from engine.shapes.families import FAMILIES, make_pair
from engine.shapes.features import FEATURES
from engine.shapes.matching import match_shapes, propose, rematch
from engine.shapes.parameters import PRESETS, preset
from engine.shapes.proposing import (
    EXACT,
    SIGNATURE,
    TRUE_DISTANCE,
    active,
    every_pair,
    geometric_distance,
    looks_distance,
    widened,
)
from engine.shapes.wishes import Wishes
from engine.store import Cache

LIGHT = preset("top-down").changed(light_fields=1, resolution=64)
NOTHING = {f"{name}_weight": 0.0 for name in ("lfd", "size", "extent", "centrality", *FEATURES)}
EVERYTHING = LIGHT.changed(**{f"{name}_weight": 0.3 for name in FEATURES})


@pytest.fixture(scope="module")
def shapes():
    pair = make_pair("lamps", 31, segments=(7, 8))
    return pair.source, pair.target


@pytest.fixture(scope="module")
def proposals(shapes):
    return propose(*(describe(shape, LIGHT) for shape in shapes), LIGHT)


@pytest.fixture(scope="module")
def bars():
    """Two bars of 16 and 18 pieces, with many more nodes than are kept for each."""
    shapes = (bar([1, 2, 1, 3, 1, 1, 2, 4, 1, 7, 1, 1, 9, 2, 5, 3]), bar([2, 2, 1, 1, 3, 1, 6, 2, 3, 1, 1, 8, 1, 4, 1, 2, 2, 1]))
    return propose(*(describe(shape, LIGHT) for shape in shapes), LIGHT.changed(pool=30))


def same(a, b):
    return a.ids == b.ids and all(np.array_equal(getattr(a, x), getattr(b, x)) for x in ("pairs", "score", "similarity"))


def test_nothing_is_made_before_a_weight_asks_for_it(shapes):
    described = [describe(shape, LIGHT) for shape in shapes]
    given = propose(*described, LIGHT)
    for name, values in PRESETS.items():
        rematch(given, values.changed(light_fields=1, resolution=64), preset=name)
    kinds = {"distributions", "pca", "hks", "phks", "heat", "volume"}
    assert all(not kinds & set(d.kept) for d in described)
    rematch(given, LIGHT.changed(pca_weight=1.0))
    assert all(kinds & set(d.kept) == {"pca"} for d in described)
    rematch(given, LIGHT.changed(d3_weight=1.0))
    assert all(kinds & set(d.kept) == {"pca", "distributions"} for d in described)


def test_every_descriptor_has_a_row_a_node_and_a_weight(proposals):
    for shape in (proposals.source, proposals.target):
        assert set(shape.features) == set(FEATURES)
        for name in FEATURES:
            values = shape.features[name]
            assert len(values) == len(shape.layers.members)
            assert np.isfinite(values).all()
            assert active(LIGHT.changed(**{f"{name}_weight": 1.0})) == (name,)
    with pytest.raises(KeyError):
        proposals.source.features["colour"]


@pytest.mark.parametrize("name", FEATURES)
def test_distances_are_symmetric_zero_to_itself_and_not_all_alike(proposals, name):
    p = proposals
    turned = every_pair(p.target, p.source, EXACT)
    n, m = len(p.source.hops) - 1, len(p.target.hops) - 1
    there, back = every_pair(p.source, p.target, EXACT).apart[name].reshape(n, m), turned.apart[name].reshape(m, n)
    assert np.array_equal(there, back.T)
    own = every_pair(p.source, p.source, EXACT).apart[name].reshape(n, n)
    assert (own.diagonal() == 0).all()
    assert (there >= 0).all()
    assert there.std() > 0.1


def test_distances_of_kept_pairs_are_those_of_the_rows(proposals):
    p = proposals
    i, j = p.pairs.T
    apart = np.abs(p.source.features["hks"][i] - p.target.features["hks"][j]).sum(axis=1)
    ratio = p.apart["hks"] / apart
    assert ratio == pytest.approx(np.full(len(ratio), ratio[0]), rel=1e-4)


def test_the_distance_is_the_weighted_sum_of_its_parts(proposals):
    p = LIGHT.changed(lfd_weight=0.5, size_weight=1.5, extent_weight=0.25, centrality_weight=3.0, d2_weight=2.0, hks_weight=0.75)
    g = proposals
    others = 2.0 * g.apart["d2"] + 0.75 * g.apart["hks"]
    expected = 0.5 * g.lfd + 1.5 * g.size + 0.25 * g.extent + 3.0 * g.centrality + others
    assert geometric_distance(g, p) == pytest.approx(expected)
    looks = (0.5 * g.lfd + TRUE_DISTANCE * others) / 3.25
    assert looks_distance(g, p) == pytest.approx(looks)


def test_without_further_weights_the_distance_is_what_it_was_bit_for_bit(proposals):
    g = proposals
    assert np.array_equal(geometric_distance(g, LIGHT), g.lfd + 0.5 * g.extent + 2.0 * g.centrality)
    assert np.array_equal(geometric_distance(g, preset("thesis-rigid")), g.lfd)
    assert np.array_equal(geometric_distance(g, preset("thesis-rigid-size")), g.lfd + 1.0 * g.size)
    assert looks_distance(g, LIGHT) is g.lfd
    assert (geometric_distance(g, LIGHT.changed(**NOTHING)) == 0).all()
    assert widened(g, LIGHT) is g


@pytest.mark.parametrize("name", ["top-down", "thesis-rigid-size", "bottom", "hungarian", "spectral", "diffusion"])
def test_a_weight_changes_what_every_method_sees(proposals, name):
    base = preset(name).changed(light_fields=1, resolution=64, lfd_threshold=0.5)
    plain = rematch(proposals, base)
    assert same(plain, rematch(proposals, base.changed(phks_weight=0.0)))
    assert not same(plain, rematch(proposals, base.changed(phks_weight=3.0)))


@pytest.mark.parametrize("changes", [{"d1_weight": 1.0, "volume_weight": 0.5}, {"lfd_weight": 0.0, "pca_weight": 1.0}])
def test_a_slider_gives_what_a_fresh_run_gives(shapes, proposals, changes):
    parameters = LIGHT.changed(**changes)
    assert same(rematch(proposals, parameters), match_shapes(*shapes, parameters))


@pytest.mark.parametrize("changes", [{"phks_weight": 2.0}, {"lfd_weight": 0.0, "a3_weight": 1.0},
    {"lfd_weight": 0.0, "extent_weight": 0.0, "centrality_weight": 0.0, "hks_weight": 1.0}])  # fmt: skip
def test_the_nearest_by_a_chosen_descriptor_are_among_the_proposals(bars, changes):
    p = LIGHT.changed(pool=30, **changes)
    every = every_pair(bars.source, bars.target, EXACT)
    n, m = len(bars.source.hops) - 1, len(bars.target.hops) - 1
    distance = geometric_distance(every, p).reshape(n, m)
    wide = widened(bars, p)
    kept = np.zeros((n, m), dtype=bool)
    kept[tuple(wide.pairs.T)] = True
    near = np.argsort(distance, axis=1, kind="stable")[:, : p.K]
    assert np.take_along_axis(kept, near, axis=1).mean() > 0.97
    assert widened(bars, p) is wide
    assert len(wide.pairs) > len(bars.pairs)
    assert np.array_equal(wide.pairs, np.unique(wide.pairs, axis=0))
    row = {tuple(pair): k for k, pair in enumerate(wide.pairs.tolist())}
    again = [row[tuple(pair)] for pair in bars.pairs.tolist()]
    assert np.array_equal(wide.lfd[again], bars.lfd)
    assert wide.lfd == pytest.approx(every.lfd[wide.pairs[:, 0] * m + wide.pairs[:, 1]])


def test_what_people_judged_outlives_the_widening(bars):
    pinned = np.zeros(len(bars.pairs), dtype=bool)
    pinned[[3, 50]] = True
    barred = np.roll(pinned, 7)
    wide = widened(replace(bars, pinned=pinned, barred=barred), LIGHT.changed(pool=30, phks_weight=2.0))
    assert wide.pairs[wide.pinned].tolist() == bars.pairs[pinned].tolist()
    assert wide.pairs[wide.barred].tolist() == bars.pairs[barred].tolist()


def test_wishes_and_weights_go_together(proposals):
    wish = Wishes(pinned=(((0, 1, 2, 3, 4, 5), (0, 2, 4)),))
    result = rematch(proposals, EVERYTHING, wishes=wish)
    assert any(match.source == (0, 1, 2, 3, 4, 5) and match.target == (0, 2, 4) for match in result.matches())


def test_added_nodes_have_the_rows_that_they_would_have_had(shapes):
    """Rows of nodes that were there stay as they are, and the new one is composed of the same samples."""
    described = describe(shapes[0], LIGHT)
    before = {name: described.features[name] for name in FEATURES}
    new = np.zeros((1, shapes[0].segmentation.count), dtype=bool)
    known = {row.tobytes() for row in described.layers.members}
    while new.tobytes() in known or not new.any():
        new[0] = np.random.default_rng(len(known) + int(new.sum())).random(new.shape[1]) < 0.5
    more = with_nodes(described, new)
    place = np.flatnonzero((more.layers.members == new).all(axis=1))[0]
    for name in FEATURES:
        assert np.array_equal(np.delete(more.features[name], place, axis=0), before[name])
        alone = replace(described, layers=more.layers, kept={}).features[name][place]
        assert more.features[name][place] == pytest.approx(alone, abs=1e-5)


def test_the_disk_keeps_what_is_slow(tmp_path, shapes, monkeypatch):
    cache = Cache(tmp_path)
    made = describe(shapes[0], LIGHT, cache=cache).features
    first = {name: made[name] for name in FEATURES}

    def never(*_, **__):
        raise AssertionError("this was kept on disk")

    monkeypatch.setattr(features_module, "shape_distributions", never)
    monkeypatch.setattr("engine.shapes.heatkernel.heat_kernel", never)
    found = describe(shapes[0], LIGHT, cache=cache).features
    for name in FEATURES:
        assert np.array_equal(found[name], first[name])
    other = describe(shapes[0], LIGHT.changed(seed=1), cache=cache).features
    with pytest.raises(AssertionError, match="kept on disk"):
        other["d1"]


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="this machine has one thread")
def test_the_number_of_threads_changes_nothing(shapes):
    before, found = numba.get_num_threads(), []
    try:
        for threads in (1, 2):
            numba.set_num_threads(threads)
            features = describe(shapes[0], LIGHT).features
            found.append([features[name] for name in FEATURES])
    finally:
        numba.set_num_threads(before)
    assert all(np.array_equal(a, b) for a, b in zip(*found, strict=True))


def test_signatures_stand_for_light_fields_on_the_same_scale(shapes):
    source, target = (describe(shape, preset("top-down").changed(resolution=128)) for shape in shapes)
    exact, fast = (every_pair(source, target, kind).lfd for kind in (EXACT, SIGNATURE))
    assert np.median(exact / fast) == pytest.approx(1.0, abs=0.25)
    assert np.corrcoef(exact, fast)[0, 1] > 0.9
    chosen = propose(source, target, preset("top-down").changed(lfd=SIGNATURE))
    rows = chosen.pairs[:, 0] * (len(target.hops) - 1) + chosen.pairs[:, 1]
    assert chosen.lfd == pytest.approx(fast[rows])


def test_true_pairs_are_about_one_apart_by_every_descriptor():
    """The scales are frozen: the median over pairs of five families of the median distance of true partners."""
    medians = {name: [] for name in (*FEATURES, EXACT, SIGNATURE)}
    for family in FAMILIES:
        pair, parameters = make_pair(family, 301), LIGHT.changed(node_cap=60, light_fields=4, resolution=128)
        described = [describe(shape, parameters) for shape in (pair.source, pair.target)]
        true = true_partners(LabelledPair(pair.source, pair.target, pair.source_label, pair.target_label), *described).ravel()
        every = {kind: every_pair(*described, kind) for kind in (EXACT, SIGNATURE)}
        for name in FEATURES:
            medians[name].append(np.median(every[EXACT].apart[name][true]))
        for kind, given in every.items():
            medians[kind].append(np.median(given.lfd[true]) / TRUE_DISTANCE)
    for name, values in medians.items():
        assert 0.7 <= np.median(values) <= 1.4, name


def test_a_larger_weight_counts_more(proposals):
    steps = [geometric_distance(proposals, LIGHT.changed(volume_weight=weight)) for weight in (0.0, 0.5, 1.0)]
    assert all((b >= a).all() for a, b in pairwise(steps))
    assert steps[2] - steps[0] == pytest.approx(2 * (steps[1] - steps[0]))


def test_only_the_last_sets_of_descriptors_are_remembered(bars):
    given = replace(bars)
    wide = [widened(given, LIGHT.changed(pool=30, **{f"{name}_weight": 1.0})) for name in FEATURES]
    assert len(given._memory) == 4
    assert widened(given, LIGHT.changed(pool=30, volume_weight=0.1)) is wide[-1]
    first = widened(given, LIGHT.changed(pool=30, d1_weight=1.0))
    assert first is not wide[0]
    assert np.array_equal(first.pairs, wide[0].pairs)
