"""How good are matches between unions of segments, where the truth is a class for every bit of area?

Everything here works on two tables: the area (s, c) that each of s segments has of each of c classes.

*Lenient*: the two distributions of classes overlap by at least half. *Strict*: the Jaccard index of the coverage of
the classes, weighted by their size, is at least half. Matches of a whole shape never count. *Chance* is what random
pairs of the same nodes score: large unions are right almost by accident. *Label transfer* gives each segment the
classes of the smallest match that holds it, in both directions, by area; it is the one fair comparison of methods
whose matches differ in kind.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arrays import frozen_array

WHOLE = 0.97
SHUFFLES = 200
SIZE_CLASSES = (("1", 1, 1), ("2-3", 2, 3), ("4+", 4, np.inf))


class SizeClass(NamedTuple):
    """Counts for the matches whose larger node unites so many segments."""

    name: str
    judged: int
    lenient: int
    strict: int


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """The figures of one pair, or of several pooled: counts and areas, so that sums stay sums.

    `judged` matches, of them `lenient_correct` and `strict_correct`; `chance_lenient` and `chance_strict` in [0, 1];
    `transfer_right`, `transfer_covered` and `transfer_total` are areas in the units of the tables.
    """

    judged: int
    lenient_correct: int
    strict_correct: int
    chance_lenient: float
    chance_strict: float
    transfer_right: float
    transfer_covered: float
    transfer_total: float
    sizes: tuple[SizeClass, ...]

    @property
    def lenient(self) -> float:
        """Lenient precision; NaN where nothing was judged."""
        return _share(self.lenient_correct, self.judged)

    @property
    def strict(self) -> float:
        """Strict precision; NaN where nothing was judged."""
        return _share(self.strict_correct, self.judged)

    @property
    def transfer_precision(self) -> float:
        """Share of the covered area that gets its own class; NaN where nothing is covered."""
        return _share(self.transfer_right, self.transfer_covered)

    @property
    def transfer_recall(self) -> float:
        """Share of all area (of classes that both shapes have) that gets its own class."""
        return _share(self.transfer_right, self.transfer_total)


def evaluate_tables(
    source: np.ndarray, target: np.ndarray, matches: Iterable[tuple[Sequence[int], Sequence[int]]]
) -> Evaluation:
    """Judge `matches`, pairs of segment rows, by the tables (s, c) and (t, c) of area per class."""
    source = frozen_array(source, np.float64, (None, None), "The source's table")
    target = frozen_array(target, np.float64, (None, source.shape[1]), "The target's table")
    left, right = _members(matches, len(source), len(target))
    h, g = _union(left, source), _union(right, target)
    kept = _partial(h, source) & _partial(g, target)
    left, right, h, g = left[kept], right[kept], h[kept], g[kept]
    lenient, strict = verdicts(h, g, source.sum(axis=0), target.sum(axis=0))
    both = np.minimum(source.sum(axis=0), target.sum(axis=0)) > 0
    right_area, covered, total = transfer(source, left, h, g, both) + transfer(target, right, g, h, both)
    own = np.arange(len(h))
    chance_lenient, chance_strict = chance_level(lenient, strict)
    sizes = _by_size(np.maximum(left.sum(axis=1), right.sum(axis=1)), lenient[own, own], strict[own, own])
    return Evaluation(
        judged=len(h),
        lenient_correct=int(lenient[own, own].sum()),
        strict_correct=int(strict[own, own].sum()),
        chance_lenient=chance_lenient,
        chance_strict=chance_strict,
        transfer_right=float(right_area),
        transfer_covered=float(covered),
        transfer_total=float(total),
        sizes=sizes,
    )


def verdicts(h: np.ndarray, g: np.ndarray, all_h: np.ndarray, all_g: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lenient and strict verdict (k, l) bool on every pair of a source row (k, c) with a target row (l, c).

    `all_h` and `all_g` (c,) are the areas of the classes in the whole shapes.
    """
    p, q = h / h.sum(axis=1, keepdims=True), g / g.sum(axis=1, keepdims=True)
    x = np.divide(h, all_h, out=np.zeros_like(h), where=all_h > 0)
    y = np.divide(g, all_g, out=np.zeros_like(g), where=all_g > 0)
    w = (all_h / all_h.sum() + all_g / all_g.sum()) / 2
    lenient, strict = (np.zeros((len(h), len(g)), dtype=bool) for _ in range(2))
    for i in range(len(h)):
        lenient[i] = np.minimum(p[i], q).sum(axis=1) >= 0.5
        strict[i] = (w * np.minimum(x[i], y)).sum(axis=1) >= 0.5 * (w * np.maximum(x[i], y)).sum(axis=1)
    return lenient, strict


def chance_level(lenient: np.ndarray, strict: np.ndarray) -> tuple[float, float]:
    """Mean verdict when the k targets are dealt to the k sources at random, 200 times from a fixed seed."""
    k = len(lenient)
    if not k:
        return float("nan"), float("nan")
    rng = np.random.default_rng(0)
    dealt = np.array([rng.permutation(k) for _ in range(SHUFFLES)])
    return float(lenient[np.arange(k), dealt].mean()), float(strict[np.arange(k), dealt].mean())


def transfer(
    table: np.ndarray, members: np.ndarray, own: np.ndarray, other: np.ndarray, both: np.ndarray
) -> np.ndarray:
    """Area given its own class, area covered, and area in all of the classes in `both` (c,) bool: (3,).

    `members` (k, s) bool are the accepted nodes on this side, `own` and `other` (k, c) their areas on either side.
    """
    total = table[:, both].sum()
    covered = members.any(axis=0)
    if not covered.any():
        return np.array([0.0, 0.0, total])
    smallest = np.where(members, own.sum(axis=1)[:, None], np.inf)[:, covered].argmin(axis=0)
    given = other[smallest] / other[smallest].sum(axis=1, keepdims=True)
    return np.array([(table[covered] * given).sum(), table[covered].sum(), total])


def pooled(evaluations: Sequence[Evaluation]) -> Evaluation:
    """Several pairs as one: counts and areas add up, chance is weighted by the matches judged."""
    judged = sum(e.judged for e in evaluations)
    names = [name for name, _, _ in SIZE_CLASSES]
    rows = {name: [s for e in evaluations for s in e.sizes if s.name == name] for name in names}
    sizes = tuple(
        SizeClass(n, sum(r.judged for r in rows[n]), sum(r.lenient for r in rows[n]), sum(r.strict for r in rows[n]))
        for n in names
        if rows[n]
    )
    return Evaluation(
        judged,
        sum(e.lenient_correct for e in evaluations),
        sum(e.strict_correct for e in evaluations),
        _share(sum(e.judged * e.chance_lenient for e in evaluations if e.judged), judged),
        _share(sum(e.judged * e.chance_strict for e in evaluations if e.judged), judged),
        sum(e.transfer_right for e in evaluations),
        sum(e.transfer_covered for e in evaluations),
        sum(e.transfer_total for e in evaluations),
        sizes,
    )


def _members(matches: Iterable[tuple[Sequence[int], Sequence[int]]], s: int, t: int) -> tuple[np.ndarray, np.ndarray]:
    """Matches as bool matrices (k, s) and (k, t)."""
    rows = list(matches)
    left, right = np.zeros((len(rows), s), dtype=bool), np.zeros((len(rows), t), dtype=bool)
    for k, (a, b) in enumerate(rows):
        left[k, list(a)] = True
        right[k, list(b)] = True
    return left, right


def _union(members: np.ndarray, table: np.ndarray) -> np.ndarray:
    """Area per class (k, c) of the unions."""
    return members.astype(np.float64) @ table


def _partial(h: np.ndarray, table: np.ndarray) -> np.ndarray:
    """Which rows are neither empty nor (nearly) the whole shape."""
    return (h.sum(axis=1) > 0) & (h.sum(axis=1) <= WHOLE * table.sum())


def _by_size(size: np.ndarray, lenient: np.ndarray, strict: np.ndarray) -> tuple[SizeClass, ...]:
    chosen = [(name, (size >= low) & (size <= high)) for name, low, high in SIZE_CLASSES]
    return tuple(SizeClass(name, int(m.sum()), int(lenient[m].sum()), int(strict[m].sum()))
                 for name, m in chosen if m.any())  # fmt: skip


def _share(part: float, whole: float) -> float:
    return part / whole if whole else float("nan")
