"""The learned method: its rule of choice by hand, and its laws on drawn shapes."""

from dataclasses import replace

import numpy as np
import pytest

from engine.shapes import learned
from engine.shapes.context import Neighbourhood
from engine.shapes.describing import describe
from engine.shapes.families import make_pair
from engine.shapes.families.generated import random_rotation
from engine.shapes.learned import judge, weights
from engine.shapes.learnedmatching import choose
from engine.shapes.matching import match_shapes, propose, rematch
from engine.shapes.mesh import Mesh
from engine.shapes.parameters import preset
from engine.shapes.proposing import geometric_distance
from engine.shapes.segmentation import SegmentedShape, segmentation_from_labels
from engine.shapes.truth import evaluate_result
from engine.shapes.wishes import Wishes
from engine.store import Cache

LEARNED = preset("learned").changed(node_cap=60, light_fields=1, resolution=64)
# Two shapes of two segments and their union; nothing overlaps but the union and its parts.
MEMBERS = np.array([[1, 0], [0, 1], [1, 1]], dtype=bool)
AREA = np.array([0.25, 0.75])


def around(distance=1.0):
    overlap = (MEMBERS * AREA) @ MEMBERS.T / (MEMBERS @ AREA)[:, None]
    pack = np.stack([overlap, overlap.T, np.full((3, 3), 1.0)], axis=-1).astype(np.float32)
    other = pack.copy()
    other[..., 2] = distance
    return Neighbourhood(pack, other, MEMBERS, MEMBERS, AREA, AREA)


def chosen(candidates, near=None, **changes):
    """Pairs chosen of {(i, j): probability}; all are equally pure."""
    pairs = np.array(sorted(candidates))
    p = np.array([candidates[tuple(pair)] for pair in pairs.tolist()])
    pins = np.array([k for k, pair in enumerate(pairs.tolist()) if tuple(pair) in changes.pop("pinned", ())], dtype=int)
    rows = choose(pairs, p, np.ones(len(p)), near or around(), LEARNED.changed(**changes), pinned=pins)
    return [tuple(pair) for pair in pairs[rows].tolist()]


def test_likely_pairs_are_taken_one_to_one():
    assert chosen({(0, 0): 0.9, (0, 1): 0.8, (1, 1): 0.7, (1, 0): 0.95}, small_first=0.0) == [(1, 0), (0, 1)]
    assert chosen({(0, 0): 0.9, (1, 1): 0.7, (2, 2): 0.8}, small_first=0.0) == [(0, 0), (2, 2), (1, 1)]


def test_pairs_below_the_least_probability_are_left():
    assert chosen({(0, 0): 0.6, (1, 1): 0.4}) == [(0, 0)]
    assert set(chosen({(0, 0): 0.6, (1, 1): 0.4}, probability_min=0.3)) == {(0, 0), (1, 1)}


def test_small_nodes_come_sooner_the_larger_lambda_is():
    candidates = {(0, 0): 0.6, (1, 1): 0.7, (2, 2): 0.9}
    assert chosen(candidates, small_first=0.0) == [(2, 2), (1, 1), (0, 0)]
    assert chosen(candidates, small_first=1.0) == [(0, 0), (1, 1), (2, 2)]  # .6/.25, .7/.75, .9/1


def test_a_pair_that_overlaps_otherwise_is_refused():
    assert chosen({(0, 0): 0.9, (2, 1): 0.8}, small_first=0.0) == [(0, 0)]  # the union holds 0, segment 1 does not


def test_a_pair_at_another_distance_is_refused():
    assert chosen({(0, 0): 0.9, (1, 1): 0.8}, around(0.6)) == [(0, 0), (1, 1)]
    assert chosen({(0, 0): 0.9, (1, 1): 0.8}, around(0.4)) == [(0, 0)]


def test_the_fitted_file_fits_what_is_seen():
    pair = make_pair("lamps", 1)
    seen = learned.look(describe(pair.source, LEARNED), describe(pair.target, LEARNED))
    assert np.isfinite(seen.inputs).all()
    first, *later = ({len(net["mean"]) for net in stage} for stage in weights()["stages"])
    found = np.full((len(seen.pairs), 3), 0.5)
    assert first == {seen.inputs.shape[1]}
    assert all(widths == {learned.later_inputs(seen, found).shape[1]} for widths in later)


def test_looks_are_those_of_the_top_down_method():
    pair = make_pair("lamps", 1)
    a, b = describe(pair.source, LEARNED), describe(pair.target, LEARNED)
    seen, proposals = learned.look(a, b), propose(a, b, preset("top-down"))
    expected = dict(zip(map(tuple, proposals.pairs.tolist()), geometric_distance(proposals, preset("top-down")), strict=True))
    looks = sum(weight * seen.inputs[:, column] for column, weight in learned.LOOKS.items())
    known = [k for k, row in enumerate(seen.pairs.tolist()) if tuple(row) in expected]
    assert len(known) > 100
    assert looks[known] == pytest.approx([expected[tuple(seen.pairs[k].tolist())] for k in known], abs=1e-4)


def test_swapping_the_shapes_swaps_the_judgement():
    pair = make_pair("candles", 2)
    a, b = describe(pair.source, LEARNED), describe(pair.target, LEARNED)
    forth, back = judge(a, b), judge(b, a)
    table = {tuple(p): (r, q) for p, r, q in zip(forth.pairs.tolist(), forth.right, forth.pure, strict=True)}
    assert table == {tuple(p[::-1]): (r, q) for p, r, q in zip(back.pairs.tolist(), back.right, back.pure, strict=True)}
    assert (np.diff(back.pairs[:, 0]) >= 0).all()


def test_the_whole_shapes_are_not_judged_and_all_pairs_of_segments_are():
    pair = make_pair("vases", 3)
    a, b = describe(pair.source, LEARNED), describe(pair.target, LEARNED)
    found = judge(a, b)
    assert found.pairs.max(axis=0).tolist() <= [len(a.layers.members) - 2, len(b.layers.members) - 2]
    bottom = {tuple(p) for p in found.pairs.tolist() if p[0] < len(a.graph.area) and p[1] < len(b.graph.area)}
    assert len(bottom) == len(a.graph.area) * len(b.graph.area)
    assert ((found.right >= 0) & (found.right <= 1) & (found.pure >= 0) & (found.pure <= 1)).all()


def test_the_cache_changes_nothing(tmp_path):
    pair = make_pair("animals", 4)
    cache = Cache(tmp_path)
    results = [match_shapes(pair.source, pair.target, LEARNED, cache=c) for c in (None, cache, cache)]
    assert results[0].ids == results[1].ids == results[2].ids
    assert results[0].score.tolist() == results[2].score.tolist()


def test_a_shape_finds_its_parts_again_when_turned():
    pair = make_pair("animals", 6)
    rotation = random_rotation(np.random.default_rng(1))
    turned = SegmentedShape(Mesh(pair.source.mesh.vertices @ rotation.T, pair.source.mesh.faces, "turned"), pair.source.segmentation)
    result = match_shapes(pair.source, turned, LEARNED)
    figures = evaluate_result(result, pair.source, turned, pair.source_label, pair.source_label)
    assert figures.strict > 0.9
    assert figures.transfer_recall > 0.6


def test_scores_are_probabilities_best_first_and_within_reason_right():
    pairs = [make_pair(family, 71) for family in ("animals", "aeroplanes", "vases")]
    judged = right = 0
    for pair in pairs:
        result = match_shapes(pair.source, pair.target, LEARNED)
        assert (np.diff(result.score) <= 0).all()
        assert (result.score >= LEARNED.probability_min).all()
        figures = evaluate_result(result, pair.source, pair.target, pair.source_label, pair.target_label)
        judged, right = judged + figures.judged, right + figures.lenient_correct
    assert right / judged > 0.8


def test_pins_stay_and_forbidden_matches_go():
    pair = make_pair("lamps", 7)
    proposals = propose(describe(pair.source, LEARNED), describe(pair.target, LEARNED), LEARNED)
    plain = rematch(proposals, LEARNED).matches()
    wrong = ((0,), (pair.target.segmentation.count - 1,))
    gone = (plain[0].source, plain[0].target)
    found = rematch(proposals, LEARNED, wishes=Wishes(pinned=(wrong,), forbidden=(gone,)))
    chosen_now = {(m.source, m.target): m.score for m in found.matches()}
    assert chosen_now[wrong] == 1.0
    assert gone not in chosen_now


def test_another_method_may_become_learned_without_proposing_anew():
    pair = make_pair("lamps", 8)
    shapes = describe(pair.source, LEARNED), describe(pair.target, LEARNED)
    top_down = LEARNED.changed(method="top-down")
    later = rematch(propose(*shapes, top_down), LEARNED)
    assert later.ids == rematch(propose(*shapes, LEARNED), LEARNED).ids
    assert replace(later, parameters=top_down).ids == later.ids


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_a_segment_without_area_is_matched_like_any_other(lamp):
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0]])
    mesh = Mesh(corners, np.array([[0, 1, 2], [0, 1, 3], [1, 4, 3]]), "one part without area")
    flat = SegmentedShape(mesh, segmentation_from_labels([0, 1, 2]))
    for other in (flat, lamp):
        assert np.isfinite(match_shapes(flat, other, LEARNED).score).all()


def test_other_geodesic_distances_are_judged_anew_though_the_cache_knows_the_pair(tmp_path):
    pair, cache, other = make_pair("candles", 5), Cache(tmp_path), LEARNED.changed(geodesic_points=150)
    match_shapes(pair.source, pair.target, LEARNED, cache=cache)
    kept, plain = (match_shapes(pair.source, pair.target, other, cache=c) for c in (cache, None))
    assert kept.ids == plain.ids
    assert kept.score.tolist() == plain.score.tolist()
