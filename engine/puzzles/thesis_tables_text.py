"""Tables 4.1 and 5.2 as tables of texts for people, and as CSV."""

import csv
import io
from collections.abc import Callable, Sequence

import numpy as np

from ..spreadsheet import safe_cell
from .benching import Table
from .thesis_tables import WAYS, Lifted, Outcome, Pruned

LEAD_4_1 = (
    "Corners with MatchLift against the spanning tree alone (thesis, Table 4.1): per cent of pieces at their true places "
    "/ of true neighbours kept. The best of the grid was chosen by the truth, so it says what the method could do; the "
    "parameter-free choice is the assembly with the lowest mean of min(N, 5) over its touching pieces, and saw no truth."
)
LEAD_5_2 = (
    "Diffusion pruning against the spanning tree alone (thesis, Table 5.2) at one fixed setting: per cent of pieces at "
    "their true places / of true neighbours kept; for the joins that pruning confirmed, precision and recall."
)


def table_of_4_1(rows: Sequence[Lifted]) -> list[Table]:
    """One table for each number of pieces, the last row being the mean."""
    head = ("image", "spanning tree", "MatchLift, best of the grid", "its t₁, t₂", "MatchLift, parameter-free", "its t₁, t₂",
            "seconds a lift")  # fmt: skip
    tables = []
    for pieces in dict.fromkeys(row.pieces for row in rows):
        mine = [row for row in rows if row.pieces == pieces]
        lines = [
            (row.image, _two(row.tree), _two(row.best), _thresholds(row.best), _two(row.chosen), _thresholds(row.chosen),
             f"{row.lift_seconds:.2f}") for row in mine
        ]  # fmt: skip
        seconds = f"{np.mean([row.lift_seconds for row in mine]):.2f}"
        means = [_mean(mine, kind) for kind in ("tree", "best", "chosen")]
        tables.append(Table(f"{pieces} pieces", head, [*lines, ("mean", means[0], means[1], "", means[2], "", seconds)]))
    return tables


def _two(outcome: Outcome) -> str:
    return f"{100 * outcome.direct:.0f} / {100 * outcome.neighbour:.0f}"


def _thresholds(outcome: Outcome) -> str:
    return f"{outcome.t_1:.2f}, {outcome.t_2:.2f}"


def _mean(rows: Sequence[Lifted], kind: str) -> str:
    direct, neighbour = np.mean([[getattr(row, kind).direct, getattr(row, kind).neighbour] for row in rows], axis=0)
    return f"{100 * direct:.1f} / {100 * neighbour:.1f}"


def csv_of_4_1(rows: Sequence[Lifted]) -> str:
    """One line a picture and number of pieces."""
    head = ["image", "pieces"]
    for kind in ("tree", "best", "chosen"):
        head += [f"{kind}_direct", f"{kind}_neighbour", f"{kind}_judge"]
        head += [] if kind == "tree" else [f"{kind}_t_1", f"{kind}_t_2"]
    lines = [[*head, "lift_seconds", "assembly_seconds"]]
    for row in rows:
        line: list[str] = [safe_cell(row.image), str(row.pieces)]
        for outcome in (row.tree, row.best, row.chosen):
            line += [f"{outcome.direct:.6f}", f"{outcome.neighbour:.6f}", f"{outcome.judge:.6f}"]
            line += [] if outcome is row.tree else [f"{outcome.t_1:g}", f"{outcome.t_2:g}"]
        lines.append([*line, f"{row.lift_seconds:.4f}", f"{row.assembly_seconds:.4f}"])
    return _csv(lines)


def table_of_5_2(rows: Sequence[Pruned]) -> list[Table]:
    """One table, the last row being the mean."""
    head = ["image", "pieces"]
    for label, _, pruned in WAYS:
        head += [label, f"{label}: confirmed"] if pruned else [label]

    def line(name: str, pieces: str, value: Callable[[str, str], float]) -> tuple[str, ...]:
        cells = [name, pieces]
        for label, _, pruned in WAYS:
            cells.append(f"{100 * value(label, 'direct'):.1f} / {100 * value(label, 'neighbour'):.1f}")
            if pruned:
                cells.append(f"{value(label, 'precision'):.3f} at {value(label, 'recall'):.3f}")
        return tuple(cells)

    lines = [line(row.image, str(row.pieces), lambda way, key, row=row: float(getattr(row.ways[way], key))) for row in rows]  # type: ignore[misc]
    mean = line("mean", "", lambda way, key: float(np.mean([getattr(row.ways[way], key) for row in rows])))
    return [Table("Direct / neighbour", tuple(head), [*lines, mean])]


def csv_of_5_2(rows: Sequence[Pruned]) -> str:
    """One line a picture and way."""
    lines = [["image", "pieces", "way", "direct", "neighbour", "precision", "recall"]]
    for row in rows:
        for label, way in row.ways.items():
            lines.append([safe_cell(row.image), str(row.pieces), label, *("" if np.isnan(v) else f"{v:.6f}" for v in way)])
    return _csv(lines)


def _csv(lines: Sequence[Sequence[str]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(lines)
    return text.getvalue()
