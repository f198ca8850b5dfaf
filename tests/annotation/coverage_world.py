"""Studies drawn at random, to see how often the tables' intervals hold the truth."""

from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np

from annotation.findings.precision import PairShare, interval_of

PAIRS, SIZES, CORRELATIONS, SHARES = (3, 6, 12, 30, 92), (8, 25), (0.0, 0.1, 0.2), (0.7, 0.85)
CHANCES = np.array([0.2, 0.5, 1.0])  # of a match to be drawn into a sample


class Cell(NamedTuple):
    """What was drawn, how often its interval held the truth, and how wide it was on average."""

    sampled: bool
    pairs: int
    size: int
    correlation: float
    share: float
    coverage: float
    width: float


def cells(trials: int, seed: int = 0, shares: tuple[float, ...] = SHARES) -> Iterator[Cell]:
    """Every combination of numbers of pairs, mean sizes, correlations within pairs and true shares; whole and sampled."""
    for k, (sampled, *drawn) in enumerate(product((False, True), PAIRS, SIZES, CORRELATIONS, shares)):
        rng = np.random.default_rng([seed, k])
        found = [interval_of(study(rng, sampled, *drawn)) for _ in range(trials)]
        held = np.mean([i.low <= drawn[-1] <= i.high for i in found])
        yield Cell(sampled, *drawn, float(held), float(np.mean([i.high - i.low for i in found])))


def study(rng: np.random.Generator, sampled: bool, pairs: int, size: int, correlation: float, share: float) -> list[PairShare]:
    """Pairs of unequal size whose true shares are beta distributed; in a sample, matches drawn with unequal chances."""
    n = np.maximum(1, np.round(rng.lognormal(np.log(size) - 0.18, 0.6, pairs))).astype(int)
    odds = (1 - correlation) / correlation if correlation else 0
    own = rng.beta(share * odds, (1 - share) * odds, pairs) if correlation else np.full(pairs, share)
    of = np.repeat(np.arange(pairs), n)
    right = rng.random(len(of)) < own[of]
    weight = np.ones(len(of))
    if sampled:
        chance = rng.choice(CHANCES, len(of))
        chance[np.unique(of, return_index=True)[1]] = 1.0  # every pair gives one match
        weight = (rng.random(len(of)) < chance) / chance
    sums = (np.bincount(of, values, pairs).tolist() for values in (weight * right, weight, weight * weight))
    return [PairShare(*values) for values in zip(*sums, strict=True)]
