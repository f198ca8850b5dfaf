"""Which matches are shown first."""

import numpy as np

from engine.shapes.matching import match_shapes
from engine.shapes.parameters import preset
from engine.shapes.summary import implied, overviews


def rows(*sets, count):
    return np.array([[i in s for i in range(count)] for s in sets], bool)


def test_a_union_of_smaller_matches_is_implied():
    source = rows({0}, {1}, {0, 1}, {0, 1, 2}, count=3)
    target = rows({0}, {1}, {0, 1}, {0, 1, 2}, count=3)
    assert implied(source, target).tolist() == [False, False, True, False]


def test_both_sides_must_be_covered():
    source = rows({0}, {1}, {0, 1}, count=2)
    target = rows({0}, {1}, {0, 1, 2}, count=3)
    assert implied(source, target).tolist() == [False, False, False]


def test_a_one_to_many_match_stands_by_itself():
    source, target = rows({0}, {1, 2}, count=3), rows({0, 1}, {2}, count=3)
    assert implied(source, target).tolist() == [False, False]


def test_the_definition_by_plain_loops():
    rng = np.random.default_rng(0)
    source, target = rng.random((40, 6)) < 0.4, rng.random((40, 5)) < 0.4
    found = implied(source, target)
    for a in range(40):
        inside = [b for b in range(40) if (source[b] <= source[a]).all() and (target[b] <= target[a]).all()
                  and source[b].sum() + target[b].sum() < source[a].sum() + target[a].sum()]  # fmt: skip
        wanted = (source[inside].any(axis=0) >= source[a]).all() and (target[inside].any(axis=0) >= target[a]).all()
        assert found[a] == wanted


def test_overviews_start_with_single_segments_and_do_not_overlap(lamp, coarse_lamp):
    result = match_shapes(lamp, coarse_lamp, preset("top-down"))
    groups = overviews(result)
    size = result.source_members.sum(axis=1) + result.target_members.sum(axis=1)
    assert (size[groups[0]] == 2).all()
    assert len(groups) > 1
    for group in groups[1:]:
        assert (size[group] > 2).all()
        assert (result.source_members[group].sum(axis=0) <= 1).all()
        assert (result.target_members[group].sum(axis=0) <= 1).all()
    every = np.concatenate(groups)
    assert len(np.unique(every)) == len(every)
