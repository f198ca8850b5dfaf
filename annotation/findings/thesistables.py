"""A study's votes as the thesis's Tables 3.1 and 3.2 take them."""

from collections.abc import Iterable
from pathlib import Path

from engine.errors import BadInput
from engine.evaluation.tables import Table
from engine.evaluation.thesis_tables import SetPrecision

from ..storage.payloads import read_payload
from ..storage.places import study_file
from ..study import is_url, open_study, shown_place
from .precision import ALL_SETS, PrecisionRow, Proposed, ballots, proposed, proposed_later, sample, tabulate
from .tabletext import as_table, row_name


def voted_precision(place: Path | str) -> tuple[list[SetPrecision], Table] | None:
    """Precision by majority of each method and set of shapes, and the modern table; None where `place` is no study.

    A study is a file, a folder that holds a study.db, or the address of one on a server. Raises `BadInput` where it
    cannot be read or holds no shapes.
    """
    if not is_url(place) and not study_file(place).is_file():
        return None
    with open_study(place, backup=False, writable=False) as handle:
        results, votes, weights, later = proposed(handle), ballots(handle), sample(handle), proposed_later(handle)
    layers = _layers(results)
    rows = [row for row in tabulate(results, votes, weights, later=later) if row.set_name == ALL_SETS or layers.get(row[:3])]
    if not rows:
        raise BadInput(f"The study {shown_place(place)} holds no results of shapes; add some with `concord study add`.")
    return set_precisions(results, rows), as_table(rows, votes)


def set_precisions(results: Iterable[Proposed], rows: Iterable[PrecisionRow]) -> list[SetPrecision]:
    """What such a table shows of each row of a set: its precision, its pairs, and the layers of its shapes."""
    layers = _layers(results)
    return [
        SetPrecision(row_name(row), row.set_name or "–", float("nan") if row.micro is None else row.micro, row.pairs,
                     next(iter(layers[row[:3]])) if len(layers[row[:3]]) == 1 else 0)
        for row in rows
        if row.set_name != ALL_SETS
    ]  # fmt: skip


def _layers(results: Iterable[Proposed]) -> dict[tuple[str, str, str], set[int]]:
    """The numbers of layers that results were made with, by method, preset and set; nothing for puzzles."""
    found: dict[tuple[str, str, str], set[int]] = {}
    for result in results:
        layers = read_payload(result.parameters).get("layers")
        found.setdefault((result.method, result.preset, result.set_name), set()).update(
            [layers] if isinstance(layers, int) else []
        )
    return found
