"""How far volunteers agree: the raw share, and Krippendorff's alpha beside it, which corrects for chance.

Both take one sequence of answers an item, of any number of volunteers; items with fewer than two answers tell nothing
and are left out. Nearly equal answers everywhere make the raw share high and alpha near zero: that is why both are
shown. Krippendorff, Content Analysis (4th ed., 2018), chapter 12.
"""

from collections import Counter
from collections.abc import Iterable, Sequence


def _pairable(units: Iterable[Sequence[str]]) -> list[Counter[str]]:
    return [Counter(unit) for unit in units if len(unit) > 1]


def _observed_disagreement(units: list[Counter[str]]) -> float:
    """Share of disagreeing ordered pairs of answers to the same item, an item weighing as many as its answers."""
    total = sum(unit.total() for unit in units)
    return sum((unit.total() ** 2 - sum(n * n for n in unit.values())) / (unit.total() - 1) for unit in units) / total


def raw_agreement(units: Iterable[Sequence[str]]) -> float | None:
    """Share of agreeing pairs of answers to the same item, in [0, 1]; None without an item of two answers."""
    pairable = _pairable(units)
    return 1 - _observed_disagreement(pairable) if pairable else None


def krippendorff_alpha(units: Iterable[Sequence[str]]) -> float | None:
    """Alpha for nominal answers, 1 - D_o / D_e; None (not defined) where all are equal or none can be paired."""
    pairable = _pairable(units)
    pooled: Counter[str] = sum(pairable, Counter())
    n = pooled.total()
    if len(pooled) < 2:
        return None
    expected = (n * n - sum(count * count for count in pooled.values())) / (n * (n - 1))
    return 1 - _observed_disagreement(pairable) / expected
