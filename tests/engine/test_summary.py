"""Which matches follow from smaller ones."""

import numpy as np

from engine.shapes.summary import implied


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
