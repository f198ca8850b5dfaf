"""Collections of the small world: lamps cut differently, what is left out, which pairs, support and parts."""

import numpy as np
import pytest
from world import LAMP, box, boxes

from engine.errors import BadInput, BadParameter, Cancelled
from engine.shapes.collection_matching import chosen_pairs, jaccard, match_collection, unique_names
from engine.shapes.collection_parameters import CollectionParameters
from engine.shapes.matching import describe, match_shapes
from engine.shapes.mesh import Mesh
from engine.shapes.parameters import preset
from engine.shapes.segmentation import SegmentedShape, segmentation_from_labels

QUICK = preset("top-down").changed(light_fields=1, resolution=64)
OWN = CollectionParameters()


def tall_lamp():
    """Cut as the first lamp, its stem longer."""
    stretched = [((x, y, z * 1.15), (u, v, w * 1.15)) for (x, y, z), (u, v, w) in LAMP]
    return boxes(stretched, "tall lamp")


def one_box():
    vertices, faces = box((0, 0, 0), (1, 1, 1))
    return SegmentedShape(Mesh(vertices, faces, "box"), segmentation_from_labels(np.zeros(12)))


@pytest.fixture(scope="module")
def lamps():
    parts = [LAMP[0], ((-0.2, -0.2, 0.5), (0.2, 0.2, 5.5)), LAMP[3], LAMP[4]]
    coarse = boxes([(np.multiply(low, 1.1), np.multiply(high, 1.1)) for low, high in parts], "coarse lamp")
    return [boxes(LAMP, "lamp"), coarse, tall_lamp()]


@pytest.fixture(scope="module")
def found(lamps):
    return match_collection(lamps, QUICK, OWN, preset="top-down")


def test_every_pair_has_the_matches_of_that_pair_alone(found, lamps):
    assert found.pairs == ((0, 1), (0, 2), (1, 2))
    for (a, b), result in zip(found.pairs, found.results, strict=True):
        assert result.ids == match_shapes(lamps[a], lamps[b], QUICK, preset="top-down").ids


@pytest.mark.parametrize("kind", ["cycles", "matchlift"])
def test_supports_lie_in_0_1_and_true_matches_are_supported(found, kind):
    for values, result in zip(found.supports[kind], found.results, strict=True):
        assert values.shape == (len(result.ids),)
        assert ((values >= 0) & (values <= 1)).all()
    same = {(m.source, m.target): v for m, v in zip(found.results[1].matches(), found.supports[kind][1], strict=True)}
    assert same[(0,), (0,)] > 0.8
    assert same[(1, 2), (1, 2)] > 0.8


def test_parts_are_the_same_things_in_all_lamps(found):
    fine, coarse, tall = (part.tolist() for part in found.parts)
    assert fine == tall
    foot, stem, shade = fine[0], fine[1], fine[3]
    assert len({foot, stem, shade}) == 3
    assert (coarse[0], coarse[2]) == (foot, shade)
    assert coarse[1] in fine[1:3]
    assert found.shares().shape == (3, found.part_count)
    assert (found.shares().sum(axis=1) <= 1 + 1e-9).all()


def test_the_order_of_the_shapes_changes_neither_matches_nor_parts(found, lamps):
    order = [2, 0, 1]
    moved = match_collection([lamps[k] for k in order], QUICK, OWN, preset="top-down")
    first, second = found.parts[2], moved.parts[0]
    assert np.array_equal(first[:, None] == first, second[:, None] == second)
    here = {i: v for r, s in zip(found.results, found.supports["cycles"], strict=True) for i, v in zip(r.ids, s, strict=True)}
    there = {i: v for r, s in zip(moved.results, moved.supports["cycles"], strict=True) for i, v in zip(r.ids, s, strict=True)}
    shared = here.keys() & there.keys()
    assert len(shared) >= 0.7 * len(here)
    if here.keys() == there.keys():
        assert all(here[i] == pytest.approx(there[i], abs=1e-6) for i in shared)


def test_live_parameters_are_followed_without_matching_again(found):
    finest, coarsest = (found.changed(OWN.changed(part_from=x)) for x in (0.95, 0.05))
    assert finest.results is found.results
    assert finest.part_count >= found.part_count >= coarsest.part_count >= 1
    other = found.changed(OWN.changed(support="matchlift"))
    assert other.support(0) is found.supports["matchlift"][0]


def test_two_shapes_are_one_pair_without_support(lamps):
    found = match_collection(lamps[:2], QUICK, OWN)
    assert found.pairs == ((0, 1),)
    assert all(np.isnan(found.supports[kind][0]).all() for kind in found.supports)
    assert any("third shape" in note for note in found.notes)
    assert found.part_count >= 3


def test_a_shape_that_fails_is_left_out_and_named(lamps):
    found = match_collection([lamps[0], one_box(), lamps[1]], QUICK, OWN, failures=("a.off was left out: it is empty.",))
    assert found.names == ("lamp", "coarse lamp")
    assert len(found.failures) == 2
    assert found.failures[1].startswith("box was left out: box has one single segment")
    with pytest.raises(BadInput, match="at least two shapes"):
        match_collection([one_box(), lamps[0]], QUICK, OWN)


def test_too_many_segments_leave_matchlift_out_and_say_so(lamps):
    found = match_collection(lamps, QUICK, OWN.changed(lift_most=5))
    assert np.isnan(found.supports["matchlift"][0]).all()
    assert np.isfinite(found.supports["cycles"][0]).all()
    assert any("lift_most = 5" in note for note in found.notes)
    assert found.part_count >= 2


def test_all_pairs_of_few_and_a_ring_of_many():
    assert chosen_pairs(4, 12, 0) == ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
    pairs = chosen_pairs(30, 6, 5)
    assert pairs == chosen_pairs(30, 6, 5) == tuple(sorted(set(pairs)))
    assert pairs != chosen_pairs(30, 6, 6)
    assert np.bincount(np.array(pairs).ravel(), minlength=30).tolist() == [6] * 30
    joined = np.zeros((30, 30), bool)
    for a, b in pairs:
        assert a < b
        joined[a, b] = joined[b, a] = True
    assert all((joined[a] & joined[b]).any() for a, b in pairs)  # every pair has a third shape


def test_names_are_told_apart():
    assert unique_names(["a", "b", "a", "a"]) == ("a", "b", "a (2)", "a (3)")


def test_jaccard_of_nodes_is_that_of_their_areas(lamps):
    described = describe(lamps[0], QUICK)
    alike, members, area = jaccard(described.measures), described.layers.members, described.graph.area
    for i in range(0, len(members), 3):
        for j in range(len(members)):
            both, either = members[i] & members[j], members[i] | members[j]
            assert alike[i, j] == pytest.approx(area[both].sum() / area[either].sum(), abs=1e-5)


def test_cancelling_stops_and_bad_parameters_are_named(lamps):
    def stop(done, words):
        if done > 0.4:
            raise Cancelled

    with pytest.raises(Cancelled):
        match_collection(lamps, QUICK, OWN, progress=stop)
    with pytest.raises(BadParameter, match="partners"):
        OWN.changed(partners=1)
