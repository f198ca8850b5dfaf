"""The full rule of diffusion pruning on points of a line: near is a distance below 2, k the ratio of the distances."""

import numpy as np
import pytest

from engine.consistency.growing import grow

RULE = {"c_0": 0.7, "c_1": 0.5, "c_2": 0.7}


class Line:
    """Candidates between places on two lines."""

    def __init__(self, source, target, pairs):
        self.places, self.pairs = (np.array(source, float), np.array(target, float)), np.array(pairs)

    def relate(self, a, others):
        p, q = (np.abs(x[self.pairs[others, side]] - x[self.pairs[a, side]]) for side, x in enumerate(self.places))
        k = np.where((p > 0) & (q > 0), np.minimum(p, q) / np.maximum(np.maximum(p, q), 1e-9), 0.0)
        return p < 2, q < 2, k

    def grow(self, confidence, fixed=(), **changes):
        rows = grow(self.pairs, np.array(confidence, float), self.relate, fixed=np.array(fixed, dtype=np.int64),
                    **(RULE | changes))  # fmt: skip
        return [tuple(p) for p in self.pairs[rows].tolist()]


def test_what_lies_near_is_accepted_where_its_distance_agrees():
    line = Line([0, 1, 1.5], [0, 1, 0.5], [[0, 0], [1, 1], [2, 2]])
    assert line.grow([3, 2, 1]) == [(0, 0), (1, 1)]  # k of 2-2 with 0-0 is 1/3
    assert line.grow([3, 2, 1], c_0=0.3) == [(0, 0), (1, 1), (2, 2)]
    assert line.grow([2, 1, 3], c_0=0.3) == [(2, 2), (0, 0), (1, 1)]


def test_near_on_one_side_only_waits_for_ever():
    line = Line([0, 1], [0, 10], [[0, 0], [1, 1]])
    assert line.grow([2, 1]) == [(0, 0)]
    line = Line([0, 10], [0, 1], [[0, 0], [1, 1]])
    assert line.grow([2, 1]) == [(0, 0)]


def test_the_share_of_those_near_on_both_sides_must_exceed_c_1():
    """2-2 is near 0-0 and 1-1 on the source, near 0-0 alone on the target: |B| / max = 1/2."""
    line = Line([0, 1, -0.9], [0, 1, -1.0], [[0, 0], [1, 1], [2, 2]])
    assert line.grow([3, 2, 1], c_1=0.5) == [(0, 0), (1, 1)]
    assert line.grow([3, 2, 1], c_1=0.4) == [(0, 0), (1, 1), (2, 2)]


def test_a_far_seed_must_agree_with_every_seed():
    line = Line([0, 10, 20], [0, 10, 12], [[0, 0], [1, 1], [2, 2]])
    assert line.grow([3, 2, 1]) == [(0, 0), (1, 1)]  # 20 against 12, and 10 against 2
    assert line.grow([3, 2, 1], c_2=0.2) == [(0, 0), (1, 1), (2, 2)]
    assert line.grow([3, 2, 1], c_2=0.5) == [(0, 0), (1, 1)]  # .6 with the first seed, .2 with the second


def test_a_candidate_that_waited_is_looked_at_again():
    """3-3 at 19 is surer than 2-2, but is no seed (19 against 12); once 2-2 is there it grows beside it."""
    line = Line([0, 17.5, 19], [0, 10.6, 12.1], [[0, 0], [1, 1], [2, 2]])
    assert line.grow([9, 1, 5]) == [(0, 0)]
    assert line.grow([9, 1, 5], fixed=[1]) == [(1, 1), (2, 2)]
    line = Line([0, 1.5, 3], [0, 1.5, 4.5], [[0, 0], [1, 1], [2, 2]])  # 2-2 is far from 0-0: 3 against 4.5
    assert line.grow([9, 1, 5], c_1=0) == [(0, 0), (1, 1)]
    line = Line([0, 1.5, 3], [0, 1.5, 3.2], [[0, 0], [1, 1], [2, 2]])
    assert line.grow([9, 1, 5], c_2=0.95) == [(0, 0), (1, 1), (2, 2)]


def test_one_to_one_and_ties_by_index():
    line = Line([0, 10], [0, 10], [[0, 0], [0, 1], [1, 0], [1, 1]])
    assert line.grow([1, 1, 1, 1]) == [(0, 0), (1, 1)]
    assert line.grow([1, 2, 1, 1]) == [(0, 1), (1, 0)]


def test_no_confidence_no_match():
    assert Line([0, 1], [0, 1], [[0, 0], [1, 1]]).grow([1, 0]) == [(0, 0)]
    assert Line([0], [0], [[0, 0]]).grow([0]) == []


def test_fixed_ones_come_first_even_against_each_other():
    line = Line([0, 1, 10], [0, 1.9, 10], [[0, 0], [1, 1], [2, 2]])
    assert line.grow([0, 0, 1], fixed=[1, 0]) == [(1, 1), (0, 0), (2, 2)]


def plainly(line, confidence, c_0, c_1, c_2):
    """The rule as it is printed: in order of confidence, those that wait again after each acceptance."""
    waiting = [k for k in np.argsort(-np.array(confidence), kind="stable") if confidence[k] > 0]
    accepted, seeds = [], []
    again = True
    while again:
        again = False
        for a in list(waiting):
            if any((line.pairs[a] == line.pairs[b]).any() for b in accepted):
                waiting.remove(a)
                continue
            told = {b: [x[0] for x in line.relate(a, np.array([b]))] for b in accepted}
            first, second = [b for b in accepted if told[b][0]], [b for b in accepted if told[b][1]]
            both = [b for b in first if b in second]
            seed = not first and not second
            if seed and all(told[b][2] >= c_2 for b in seeds):
                seeds.append(a)
            elif seed or len(both) <= c_1 * max(len(first), len(second)):
                continue
            elif not all(told[b][2] > c_0 for b in both):
                waiting.remove(a)
                continue
            accepted.append(a)
            waiting.remove(a)
            again = True
            break
    return accepted


@pytest.mark.parametrize("seed", range(12))
def test_it_is_the_rule_as_printed(seed):
    rng = np.random.default_rng(seed)
    places = np.sort(rng.random(8) * 12)
    line = Line(places, places + rng.normal(0, 0.2, 8), np.argwhere(rng.random((8, 8)) < 0.5))
    confidence = rng.random(len(line.pairs)) * (rng.random(len(line.pairs)) < 0.9)
    want = [tuple(line.pairs[k].tolist()) for k in plainly(line, confidence, **RULE)]
    assert line.grow(confidence) == want
    assert len(want) > 1
