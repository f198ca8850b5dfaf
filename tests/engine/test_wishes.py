"""What people have pinned comes, what they have forbidden does not, by every method and for nodes of no graph."""

from dataclasses import replace

import numpy as np
import pytest
from world import LAMP, bar, boxes

from engine.errors import BadInput
from engine.shapes.describing import describe
from engine.shapes.extending import with_nodes
from engine.shapes.guided import with_wishes
from engine.shapes.hops import hop_distances
from engine.shapes.lightfield import light_field_distances
from engine.shapes.matching import METHODS, match_shapes, propose, rematch
from engine.shapes.parameters import preset
from engine.shapes.proposing import open_rows
from engine.shapes.wishes import NO_WISHES, Wishes

LIGHT = preset("top-down").changed(light_fields=1, resolution=64)
A, B = ((0,), (1,)), ((1, 2), (0,))


@pytest.fixture(scope="module")
def lamps():
    """Proposals of the lamp (foot, two stems, shade, knob) against itself with its stem in one piece."""
    parts = [LAMP[0], ((-0.2, -0.2, 0.5), (0.2, 0.2, 5.5)), LAMP[3], LAMP[4]]
    return propose(*(describe(boxes(p, name), LIGHT) for p, name in ((LAMP, "lamp"), (parts, "coarse"))), LIGHT)


@pytest.fixture(scope="module")
def bars():
    """Proposals of bars whose graphs hold few unions, and of whose pairs few are proposed."""
    few = LIGHT.changed(max_segments=2, pool=30)
    shapes = (bar([1, 2, 1, 3, 1, 1, 2, 4, 1, 7, 1, 1, 9, 2, 5, 3, 1, 1, 1, 2], "twenty"),
              bar([2, 2, 1, 1, 3, 1, 6, 2, 3, 1, 1, 8, 1, 4, 1, 2, 2, 1, 1, 1], "other"))  # fmt: skip
    return propose(*(describe(shape, few) for shape in shapes), few)


def unions(result):
    return {(m.source, m.target) for m in result.matches()}


# --- the type


def test_equal_wishes_are_one_whatever_their_order():
    one, other = Wishes((B, A)), Wishes((((0, 0), (1,)), ((2, 1), (0,)), A))
    assert one == other
    assert hash(one) == hash(other)
    assert one.pinned == (A, B)
    assert not NO_WISHES
    assert Wishes(forbidden=(A,))


@pytest.mark.parametrize(("pinned", "forbidden", "words"), [
    ((A,), (A,), "0 → 1 is both pinned and forbidden"),
    ((A, ((0,), (2,))), (), "0 of the source is pinned to both 1 and 2"),
    ((B, ((3,), (0,))), (), r"0 of the target is pinned to both \{1, 2\} and 3"),
    ((((), (1,)),), (), "at least one segment"),
    ((), (((0,), (-1,)),), "at least one segment"),
])  # fmt: skip
def test_what_cannot_be_is_one_sentence(pinned, forbidden, words):
    with pytest.raises(BadInput, match=words) as caught:
        Wishes(pinned, forbidden)
    assert "\n" not in str(caught.value)


def test_a_new_wish_takes_the_place_of_what_it_contradicts():
    wishes = NO_WISHES.forbid(A).pin(A).pin(((0,), (3,))).forbid(B)
    assert wishes == Wishes((((0,), (3,)),), (B,))
    assert wishes.pin(B) == Wishes((((0,), (3,)), B))
    assert wishes.without(B).without(((0,), (3,))) == NO_WISHES
    assert wishes.turned().turned() == wishes
    assert wishes.turned().forbidden == (((0,), (1, 2)),)


# --- every method


@pytest.mark.parametrize("method", METHODS)
def test_every_method_honours_wishes_exactly(lamps, method):
    p = LIGHT.changed(method=method)
    free = rematch(lamps, p)
    found = sorted(unions(free))
    assert found
    wrong = ((0,), (3,))  # the foot to the knob, which nobody would propose
    wishes = Wishes(pinned=(wrong,), forbidden=tuple(pair for pair in found if pair != wrong))
    guided = rematch(lamps, p, wishes=wishes)
    assert wrong in unions(guided)
    assert not unions(guided) & set(wishes.forbidden)
    assert [m.pinned for m in guided.matches()] == [(m.source, m.target) == wrong for m in guided.matches()]
    assert guided.wishes == wishes
    assert (np.diff(guided.score) <= 1e-12).all()
    assert ((guided.score >= 0) & (guided.score <= 1)).all()
    assert not any(m.pinned for m in free.matches())


@pytest.mark.parametrize("method", METHODS)
def test_pins_that_contradict_each_other_in_the_large_are_all_kept(lamps, method):
    """The stem upside down, nested one way on the left and the other way on the right."""
    pins = (((0, 1), (3,)), ((0,), (2, 3)), ((3,), (0,)), ((4,), (1,)))
    found = unions(rematch(lamps, LIGHT.changed(method=method), wishes=Wishes(pins)))
    assert set(pins) <= found


@pytest.mark.parametrize("method", METHODS)
def test_nodes_of_no_graph_and_pairs_of_no_proposal_can_be_pinned(bars, method):
    known = {tuple(np.flatnonzero(m)) for m in bars.source.layers.members}
    pins = (((0, 1, 2, 3, 4), (5, 6, 7)), ((9,), (1, 2, 3, 4)), ((6, 12), (8,)))  # the last in two pieces
    assert pins[0][0] not in known
    result = rematch(bars, bars.source.parameters.changed(method=method), wishes=Wishes(pins))
    assert set(pins) <= unions(result)
    assert len(result.ids) == len(set(result.ids))


@pytest.mark.parametrize("method", METHODS)
def test_pinning_what_comes_anyway_changes_no_match(lamps, method):
    """Law: what a method finds, pinned altogether, is found again."""
    p = LIGHT.changed(method=method)
    free = unions(rematch(lamps, p))
    ones = [pair for pair in free if sum(pair[0] == other[0] or pair[1] == other[1] for other in free) == 1]
    assert set(ones) <= unions(rematch(lamps, p, wishes=Wishes(tuple(ones))))


@pytest.mark.parametrize("method", METHODS)
def test_wishes_for_nothing_change_nothing(lamps, method):
    p = LIGHT.changed(method=method)
    free = rematch(lamps, p)
    absent = next(pair for pair in ((((0,), (3,)), ((4,), (0,)))) if pair not in unions(free))
    for wishes in (NO_WISHES, Wishes(), Wishes(forbidden=(((0, 4), (1, 3)),))):
        again = rematch(lamps, p, wishes=wishes)
        assert again.ids == free.ids
        assert np.array_equal(again.score, free.score)
    assert rematch(lamps, p, wishes=Wishes(forbidden=(absent,))).ids is not None


@pytest.mark.parametrize("method", METHODS)
def test_from_the_other_side_the_same_wishes_hold(method):
    shapes = [boxes(LAMP, "lamp"), boxes(LAMP[:4], "no knob")]
    p = LIGHT.changed(method=method)
    wishes = Wishes((((0, 1), (0,)),), (((3,), (3,)),))
    one = match_shapes(*shapes, p, wishes=wishes)
    other = match_shapes(*shapes[::-1], p, wishes=wishes.turned())
    assert ((0, 1), (0,)) in unions(one)
    assert ((0,), (0, 1)) in unions(other)
    assert ((3,), (3,)) not in unions(one) | unions(other)


def test_what_disagrees_with_a_pin_does_not_come(lamps):
    """Foot to knob turns the lamp upside down; the shade may then not go to the shade."""
    p = LIGHT.changed(bottom_min=0.0)
    assert ((3,), (2,)) in unions(rematch(lamps, p))
    assert ((3,), (2,)) not in unions(rematch(lamps, p, wishes=Wishes((((0,), (3,)), ((4,), (0,))))))


def test_an_unknown_segment_is_one_sentence(lamps):
    with pytest.raises(BadInput, match=r"0 → 4 names segment 4 of the target, which has the segments 0 to 3\.$"):
        rematch(lamps, LIGHT, wishes=Wishes((((0,), (4,)),)))


# --- proposals and graphs with wishes


def test_marked_rows_and_what_may_still_be_chosen(lamps):
    given = with_wishes(lamps, Wishes((A,), (B,)))
    m = [shape.layers.members for shape in (given.source, given.target)]
    sides = [[tuple(np.flatnonzero(m[k][row])) for row in given.pairs[:, k]] for k in (0, 1)]
    pairs = list(zip(*sides, strict=True))
    assert [pairs[row] for row in np.flatnonzero(given.pinned)] == [A]
    assert [pairs[row] for row in np.flatnonzero(given.barred)] == [B]
    assert open_rows(given).tolist() == [p == A or (p != B and p[0] != A[0] and p[1] != A[1]) for p in pairs]
    assert with_wishes(lamps, Wishes((A,), (B,))) is given  # a slider that moves pays once


def test_added_pairs_have_exact_distances_and_stay_sorted(bars):
    given = with_wishes(bars, Wishes((((0, 1, 2, 3, 4), (5, 6, 7)), ((9,), (1, 2, 3, 4)))))
    assert np.array_equal(given.pairs, np.unique(given.pairs, axis=0))
    assert len(given.pairs) == len(bars.pairs) + 2
    assert np.array_equal(given.lfd, light_field_distances(given.source.descriptors, given.target.descriptors, given.pairs))
    for name in ("size", "extent", "centrality"):
        s, t = (np.log(getattr(shape.measures, name)) for shape in (given.source, given.target))
        assert getattr(given, name) == pytest.approx(np.abs(s[given.pairs[:, 0]] - t[given.pairs[:, 1]]))
    assert given.bottom.sum() == bars.bottom.sum()
    assert given.source.layers.members[-1].all()


def test_a_node_added_is_as_if_it_had_been_there():
    """Law: a graph without one of its nodes, and that node added again, measures as before."""
    full = describe(boxes(LAMP, "lamp"), LIGHT)
    row = int(np.flatnonzero((full.layers.members == [1, 1, 1, 0, 0]).all(axis=1))[0])
    others = np.delete(np.arange(len(full.layers.members)), row)
    kept = (full.layers.edges != row).all(axis=1)
    edges = np.searchsorted(others, full.layers.edges[kept])
    layers = replace(full.layers, members=full.layers.members[others], layer=full.layers.layer[others], edges=edges,
                     kind=full.layers.kind[kept])  # fmt: skip
    less = replace(full, layers=layers, hops=hop_distances(len(others), edges), descriptors=full.descriptors[others],
                   signatures=full.signatures[others])  # fmt: skip
    again = with_nodes(less, full.layers.members[[row]])
    order = [(again.layers.members == m).all(axis=1).nonzero()[0][0] for m in full.layers.members]
    assert np.array_equal(again.descriptors[order], full.descriptors)
    assert np.array_equal(again.layers.layer[order], full.layers.layer)
    for name in ("size", "extent", "centrality"):
        assert getattr(again.measures, name)[order] == pytest.approx(getattr(full.measures, name))
    assert again.measures.geodesic[np.ix_(order, order)] == pytest.approx(full.measures.geodesic, rel=1e-5)
    assert np.array_equal(again.hops[order.index(len(others) - 1)], again.hops[:, order.index(len(others) - 1)])
    place = np.argsort(order)
    new = place == row
    assert np.array_equal(again.hops[np.ix_(new, ~new)], full.hops[np.ix_([row], place[~new])])
    found = {tuple(sorted(place[list(e)].tolist())) for e in again.layers.edges.tolist()}
    assert found == {tuple(e) for e in full.layers.edges.tolist()}


def test_nodes_that_are_there_are_not_added_again(lamps):
    assert with_nodes(lamps.source, lamps.source.layers.members[[0, -1]]) is lamps.source
