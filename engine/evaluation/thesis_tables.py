"""Tables 3.1 and 3.2 of the thesis: the precision of methods, set by set, with an average over the sets."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from .averages import thesis_average
from .tables import NOTHING, Table

TITLES = {"3.1": "Table 3.1: precision (std. dev.) on the rigid (man-made) sets",
          "3.2": "Table 3.2: precision (std. dev.) on the non-rigid sets"}  # fmt: skip
REMARK = ("Precision is that of all matches of a set. The average weighs each set by its pairs; the standard deviation is the "
          "unweighted sample one (n - 1) of the sets, so it is the spread between them.")  # fmt: skip
HEAD = ("method", "set", "precision", "pairs", "layers")


class SetPrecision(NamedTuple):
    """Precision in [0, 1] of one method on one set, NaN where nothing was decided; `layers` is 0 where they differ."""

    method: str
    set_name: str
    precision: float
    pairs: int
    layers: int


def thesis_table(number: str, found: Sequence[SetPrecision]) -> Table:
    """The table as the thesis has it: a row a set, a column a method, pairs and layers, and the average below."""
    return set_table(TITLES[number], found)


def set_table(title: str, found: Sequence[SetPrecision], digits: int = 1) -> Table:
    """The same for other sets; `digits` are those of the averages."""
    methods = list(dict.fromkeys(f.method for f in found))
    sets = list(dict.fromkeys(f.set_name for f in found))
    cell = {(f.method, f.set_name): f for f in found}
    rows = []
    for name in sets:
        mine = [cell[method, name] for method in methods if (method, name) in cell]
        shown = [_percent(cell[m, name].precision) if (m, name) in cell else NOTHING for m in methods]
        rows.append((name, *shown, _equal([f.pairs for f in mine]), _equal([f.layers for f in mine]) if mine[0].layers else NOTHING))
    averages = [_average(mean, deviation, digits) for _, mean, deviation in set_averages(found)]
    return Table(title, ("set", *methods, "pairs", "layers"), [*rows, ("average", *averages, "", "")], 1, REMARK)


def set_averages(found: Sequence[SetPrecision]) -> list[tuple[str, float | None, float | None]]:
    """Each method with its average and deviation over the sets, in [0, 1]; None where nothing is decided, of a single set."""
    averages: list[tuple[str, float | None, float | None]] = []
    for method in dict.fromkeys(f.method for f in found):
        known = [f for f in found if f.method == method and not math.isnan(f.precision) and f.pairs]
        if known:
            mean, spread = thesis_average([100 * f.precision for f in known], [f.pairs for f in known])
            averages.append((method, mean / 100, None if math.isnan(spread) else spread / 100))
        else:
            averages.append((method, None, None))
    return averages


def _average(mean: float | None, deviation: float | None, digits: int) -> str:
    if mean is None:
        return NOTHING
    spread = "" if deviation is None else f" ({100 * deviation:.{digits}f})"
    return f"{100 * mean:.{digits}f} %{spread}"


def _percent(share: float) -> str:
    return NOTHING if math.isnan(share) else f"{100 * share:.1f} %"


def _equal(values: Sequence[int]) -> str:
    """The value, or all of them where they differ between the methods."""
    return ", ".join(map(str, dict.fromkeys(values)))
