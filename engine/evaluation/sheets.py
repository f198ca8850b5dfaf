"""The tables of an evaluation for people to read, and their rows for programs."""

from collections.abc import Sequence

from .correspondence import SIZE_CLASSES
from .intervals import Interval
from .summary import Comparison, Judged, SetRow, Share
from .tables import NOTHING, Table, percent

PAIR_HEAD = (
    "set", "pair", "method", "matches", "lenient", "strict", "chance_lenient", "chance_strict", "transfer_precision",
    "transfer_recall", "ceiling_precision", "ceiling_recall", "right_pair_exists",
    *(f"size_{name}_{what}" for name, _, _ in SIZE_CLASSES for what in ("matches", "lenient", "strict")), "seconds", "failure",
)  # fmt: skip
_SHARES = ("lenient", "chance_lenient", "strict", "chance_strict", "transfer_precision", "transfer_recall",
           "ceiling_precision", "ceiling_recall")  # fmt: skip
_WITH_INTERVAL = ("lenient", "strict", "transfer_precision", "transfer_recall")
SET_HEAD = (
    "set", "method", "pairs", "failed", "without_match", "matches", *(f"{s}_{kind}" for s in _SHARES for kind in Share._fields),
    *(f"{s}_interval_{end}" for s in _WITH_INTERVAL for end in Interval._fields), "right_pair_exists", "seconds",
)  # fmt: skip
SIZE_HEAD = ("set", "method", "segments_of_larger_node", "matches", "lenient", "strict")
TEST_HEAD = ("method", "against", "set", "measure", "pairs", "better", "worse", "equal", "mean_difference", "p_permutation",
             "p_wilcoxon", "p_permutation_holm", "p_wilcoxon_holm")  # fmt: skip

MEANS = ("Each pair counts alike. A pair without a match has a recall of 0 and no precision: it is in the mean of recall only. "
         "Chance: the same for random pairs of the matched nodes. Ceiling: precision / recall of transfer when "
         "every segment takes the node that the truth says serves it best; for precision, segments that get more wrong than "
         "right even so are left out. Lenient and strict precision could be 100. Seconds are "
         "those of all steps of a pair; descriptors that are kept from earlier runs cost nothing, but for --cold.")  # fmt: skip
POOLED = ("Precision over all matches of all pairs, so that pairs with many matches count more; label transfer over all area, "
          "each pair's area taken as 1. The intervals of 95 % take the pair as the unit of sampling.")  # fmt: skip
SIZES = "Segments of the larger node of a match; lenient / strict precision of all matches pooled (their number)."
TESTS = ("Mean difference in points, over the pairs where both methods have the figure; p of the permutation of methods within "
         "pairs and of Wilcoxon's signed ranks, two-sided, adjusted after Holm for the number of sets; none below 6 pairs.")  # fmt: skip


def tables(rows: Sequence[SetRow], comparisons: Sequence[Comparison]) -> list[Table]:
    """All tables but that of the pairs, in per cent."""
    found = [means(rows), pooled(rows), by_size(rows)]
    return [*found, against_first(comparisons)] if comparisons else found


def means(rows: Sequence[SetRow]) -> Table:
    """Macro figures beside chance and ceiling."""
    head = ("set", "method", "pairs", "lenient (chance)", "strict (chance)", "transfer precision", "transfer recall",
            "ceiling of transfer", "seconds")  # fmt: skip
    cells = [
        (r.set_name, r.method, _pairs(r), _beside(r.lenient.macro, r.chance_lenient.macro),
         _beside(r.strict.macro, r.chance_strict.macro), percent(r.transfer_precision.macro), percent(r.transfer_recall.macro),
         f"{percent(r.ceiling_precision.macro)} / {percent(r.ceiling_recall.macro)}",
         NOTHING if r.pairs == r.failed else f"{r.seconds:.1f}")
        for r in rows
    ]  # fmt: skip
    failed = " In brackets: pairs that could not be matched; they are in no figure." if any(r.failed for r in rows) else ""
    return Table("Means over pairs, in %", head, cells, 2, MEANS + failed)


def pooled(rows: Sequence[SetRow]) -> Table:
    """Micro figures with intervals of 95 %."""
    head = ("set", "method", "matches", "lenient", "chance", "strict", "chance", "transfer precision", "transfer recall")
    cells = [
        (r.set_name, r.method, str(r.matches), _with(r.lenient, r.lenient_interval), percent(r.chance_lenient.micro, 0),
         _with(r.strict, r.strict_interval), percent(r.chance_strict.micro, 0),
         _with(r.transfer_precision, r.transfer_precision_interval), _with(r.transfer_recall, r.transfer_recall_interval))
        for r in rows
    ]  # fmt: skip
    kinds = sorted({i.method for r in rows for name in _WITH_INTERVAL if (i := getattr(r, f"{name}_interval"))})
    return Table("All matches pooled, in %", head, cells, 2, POOLED + (f" They are: {'; '.join(kinds)}." if kinds else ""))


def by_size(rows: Sequence[SetRow]) -> Table:
    """Precision by the size of the matched nodes."""
    names = [name for name, _, _ in SIZE_CLASSES]
    head = ("set", "method", *("1 segment" if name == "1" else f"{name} segments" for name in names))
    cells = []
    for r in rows:
        known = {s.name: f"{percent(s.lenient)} / {percent(s.strict)} ({s.matches})" for s in r.sizes}
        cells.append((r.set_name, r.method, *(known.get(name, NOTHING) for name in names)))
    return Table("By size, in %", head, cells, 2, SIZES)


def against_first(comparisons: Sequence[Comparison]) -> Table:
    """Every other method against the first one named."""
    head = ("method", "set", "measure", "pairs", "better / worse / equal", "difference", "p (permutation)", "p (Wilcoxon)")
    cells = [
        (c.method, c.set_name, c.measure, str(c.test.pairs), f"{c.test.better} / {c.test.worse} / {c.test.equal}",
         NOTHING if not c.test.pairs else f"{100 * c.test.difference:+.1f}", _p(c.holm_permutation), _p(c.holm_wilcoxon))
        for c in comparisons
    ]  # fmt: skip
    return Table(f"Against {comparisons[0].against}, pair by pair", head, cells, 3, TESTS)


def pair_table(judged: Sequence[Judged]) -> Table:
    """One row a pair and method, in per cent."""
    head = ("set", "pair", "method", "matches", "lenient (chance)", "strict (chance)", "transfer precision", "transfer recall",
            "ceiling of transfer", "seconds")  # fmt: skip
    return Table("Pairs, in %", head, [_pair_cells(j) for j in judged], 3)


def _pair_cells(j: Judged) -> tuple[str, ...]:
    if j.figures is None or j.ceiling is None:
        return (j.set_name, j.pair, j.method, "failed", *(NOTHING,) * 6)
    e = j.figures
    return (j.set_name, j.pair, j.method, str(e.judged), _beside(e.lenient, e.chance_lenient),
            _beside(e.strict, e.chance_strict), percent(e.transfer_precision), percent(e.transfer_recall),
            f"{percent(j.ceiling.precision)} / {percent(j.ceiling.recall)}", f"{j.seconds:.1f}")  # fmt: skip


def pair_values(j: Judged) -> tuple[object, ...]:
    """The values of PAIR_HEAD."""
    if j.figures is None or j.ceiling is None:
        return (j.set_name, j.pair, j.method, *(None,) * (len(PAIR_HEAD) - 4), j.failure)
    e = j.figures
    sizes = {s.name: (s.judged, s.lenient / s.judged, s.strict / s.judged) for s in e.sizes}
    return (j.set_name, j.pair, j.method, e.judged, e.lenient, e.strict, e.chance_lenient, e.chance_strict,
            e.transfer_precision, e.transfer_recall, j.ceiling.precision, j.ceiling.recall, int(j.ceiling.strict),
            *(value for name, _, _ in SIZE_CLASSES for value in sizes.get(name, (0, None, None))), j.seconds, "")  # fmt: skip


def set_values(r: SetRow) -> tuple[object, ...]:
    """The values of SET_HEAD."""
    bounds = [value for name in _WITH_INTERVAL for value in (getattr(r, f"{name}_interval") or (None, None, None))]
    return (r.set_name, r.method, r.pairs, r.failed, r.empty, r.matches, *(value for s in _SHARES for value in getattr(r, s)),
            *bounds, r.right_exists, r.seconds)  # fmt: skip


def size_values(rows: Sequence[SetRow]) -> list[tuple[object, ...]]:
    """The rows of SIZE_HEAD."""
    return [(r.set_name, r.method, *size) for r in rows for size in r.sizes]


def comparison_values(c: Comparison) -> tuple[object, ...]:
    """The values of TEST_HEAD."""
    return (c.method, c.against, c.set_name, c.measure, *c.test, c.holm_permutation, c.holm_wilcoxon)


def _pairs(row: SetRow) -> str:
    return f"{row.pairs - row.failed} ({row.failed})" if row.failed else str(row.pairs)


def _beside(share: float, chance: float) -> str:
    return f"{percent(share)} ({percent(chance, 0)})"


def _with(share: Share, interval: Interval | None) -> str:
    return percent(share.micro) + (f" ({percent(interval.low)} – {percent(interval.high)})" if interval else "")


def _p(value: float | None) -> str:
    return NOTHING if value is None else "< .001" if value < 0.001 else f"{value:.3f}".removeprefix("0")
