"""From judged pairs to the figures of each method on each set, and to tests of one method against another.

Two averages of each share. *Macro* is the mean over pairs: every pair counts alike; a pair without a match has a recall
of 0 and no precision, so it is in the mean of recall only. *Micro* pools: precision over all matches, label transfer over
all area (each pair's area taken as 1, for meshes have no common unit).
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from .ceiling import Ceiling
from .correspondence import SIZE_CLASSES, Evaluation
from .intervals import Interval, clustered_interval, ratio_interval
from .paired import PairedTest, holm, paired_test

ALL_SETS = "(all)"


class Judged(NamedTuple):
    """One pair by one method; `figures` and `ceiling` are None, and `failure` a sentence, where the method failed."""

    set_name: str
    pair: str
    method: str
    figures: Evaluation | None
    ceiling: Ceiling | None
    seconds: float
    failure: str


class Share(NamedTuple):
    """A share in [0, 1], pooled and as the mean over pairs; NaN where nothing is known."""

    micro: float
    macro: float


class SizeRow(NamedTuple):
    """Matches whose larger node unites so many segments."""

    name: str
    matches: int
    lenient: float
    strict: float


class SetRow(NamedTuple):
    """The figures of one method on one set: of `pairs`, `failed` could not be matched and `empty` have no match."""

    method: str
    set_name: str
    pairs: int
    failed: int
    empty: int
    matches: int
    lenient: Share
    lenient_interval: Interval | None
    chance_lenient: Share
    strict: Share
    strict_interval: Interval | None
    chance_strict: Share
    transfer_precision: Share
    transfer_precision_interval: Interval | None
    transfer_recall: Share
    transfer_recall_interval: Interval | None
    ceiling_precision: Share
    ceiling_recall: Share
    right_exists: float
    sizes: tuple[SizeRow, ...]
    seconds: float


class Comparison(NamedTuple):
    """A method against the first one on one set, by one measure; `holm_*` are adjusted for the number of sets."""

    method: str
    against: str
    set_name: str
    measure: str
    test: PairedTest
    holm_permutation: float | None
    holm_wilcoxon: float | None


MEASURES: dict[str, Callable[[Evaluation], float]] = {
    "lenient precision": lambda e: e.lenient,
    "strict precision": lambda e: e.strict,
    "transfer precision": lambda e: e.transfer_precision,
    "transfer recall": lambda e: e.transfer_recall,
}


def set_rows(judged: Sequence[Judged]) -> list[SetRow]:
    """One row for each set and method in order of appearance, and at the end those over all sets where there are several."""
    methods, sets = list(dict.fromkeys(j.method for j in judged)), list(dict.fromkeys(j.set_name for j in judged))
    return [
        set_row(method, name, [j for j in judged if j.method == method and name in (j.set_name, ALL_SETS)])
        for name in (*sets, *([ALL_SETS] if len(sets) > 1 else []))
        for method in methods
    ]


def set_row(method: str, set_name: str, judged: Sequence[Judged]) -> SetRow:
    """The figures of one method over some pairs; intervals are those of the pooled shares."""
    known = [(j.figures, j.ceiling, j.seconds) for j in judged if j.figures is not None and j.ceiling is not None]
    figures, ceilings = [f for f, _, _ in known], [c for _, c, _ in known]
    n = np.array([f.judged for f in figures], dtype=np.int64)
    area = np.array([c.area for c in ceilings])
    right = np.array([f.transfer_right for f in figures]) / area
    covered, total = (np.array([getattr(f, name) for f in figures]) / area for name in ("transfer_covered", "transfer_total"))
    return SetRow(
        method, set_name, len(judged), len(judged) - len(known), int((n == 0).sum()), int(n.sum()),
        _share([f.lenient_correct for f in figures], n), clustered_interval([f.lenient_correct for f in figures], n),
        _share([f.judged * f.chance_lenient if f.judged else 0 for f in figures], n),
        _share([f.strict_correct for f in figures], n), clustered_interval([f.strict_correct for f in figures], n),
        _share([f.judged * f.chance_strict if f.judged else 0 for f in figures], n),
        _share(right, covered), ratio_interval(right, covered), _share(right, total), ratio_interval(right, total),
        _share(np.array([c.kept_right for c in ceilings]) / area, np.array([c.kept for c in ceilings]) / area),
        _share(np.array([c.right for c in ceilings]) / area, total),
        float(np.mean([c.strict for c in ceilings])) if ceilings else float("nan"),
        _sizes(figures), float(np.mean([s for _, _, s in known])) if known else float("nan"))  # fmt: skip


def comparison_rows(judged: Sequence[Judged]) -> list[Comparison]:
    """Every other method against the first, by four measures, set by set and over all pairs."""
    methods = list(dict.fromkeys(j.method for j in judged))
    sets = list(dict.fromkeys(j.set_name for j in judged))
    rows = []
    for method in methods[1:]:
        for measure, value in MEASURES.items():
            tests = [_compared(judged, methods[0], method, name, value) for name in sets]
            p, q = holm([t.permutation for t in tests]), holm([t.wilcoxon for t in tests])
            rows += [
                Comparison(method, methods[0], name, measure, test, p[k], q[k])
                for k, (name, test) in enumerate(zip(sets, tests, strict=True))
            ]
            if len(sets) > 1:
                test = _compared(judged, methods[0], method, ALL_SETS, value)
                rows.append(Comparison(method, methods[0], ALL_SETS, measure, test, test.permutation, test.wilcoxon))
    return rows


def _compared(
    judged: Sequence[Judged], first: str, second: str, set_name: str, value: Callable[[Evaluation], float]
) -> PairedTest:
    found: dict[str, dict[tuple[str, str], float]] = {first: {}, second: {}}
    for j in judged:
        if j.method in found and set_name in (j.set_name, ALL_SETS) and j.figures is not None:
            found[j.method][j.set_name, j.pair] = value(j.figures)
    both = [pair for pair in found[first] if pair in found[second]]
    return paired_test([found[first][pair] for pair in both], [found[second][pair] for pair in both])


def _share(parts: object, wholes: object) -> Share:
    """Pooled share and mean share of parts (n,) in wholes (n,)."""
    part, whole = np.asarray(parts, dtype=np.float64), np.asarray(wholes, dtype=np.float64)
    some = whole > 0
    if not some.any():
        return Share(float("nan"), float("nan"))
    return Share(float(part[some].sum() / whole[some].sum()), float((part[some] / whole[some]).mean()))


def _sizes(figures: Sequence[Evaluation]) -> tuple[SizeRow, ...]:
    rows = []
    for name, _, _ in SIZE_CLASSES:
        mine = [s for f in figures for s in f.sizes if s.name == name]
        judged = sum(s.judged for s in mine)
        if judged:
            rows.append(SizeRow(name, judged, sum(s.lenient for s in mine) / judged, sum(s.strict for s in mine) / judged))
    return tuple(rows)
