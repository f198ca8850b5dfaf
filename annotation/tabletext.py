"""The precision table as text, Markdown or CSV."""

from collections.abc import Sequence
from typing import Literal

from engine.evaluation.averages import thesis_average
from engine.evaluation.intervals import ONE_CLUSTER
from engine.evaluation.tables import Table

from .agreement import krippendorff_alpha, raw_agreement
from .csvtext import csv_text
from .precision import ALL_SETS, Ballot, PrecisionRow

TableFormat = Literal["text", "csv", "markdown"]
_HEADER = (
    "method", "set", "pairs", "judged", "correct", "wrong", "tie", "precision %", "95 % interval", "macro %",
    "bounds %", "votes", "unsure %",
)  # fmt: skip
_WORDS = 2  # how many columns hold words, to be set to the left
_CSV_HEADER = (
    "method", "preset", "set", "parameter_sets", "pairs", "matches", "judged", "correct", "wrong", "tie", "unjudged",
    "micro_precision", "macro_precision", "interval_low", "interval_high", "interval_method", "bound_low",
    "bound_high", "volunteers", "votes", "unsure_share",
)  # fmt: skip


def render(rows: Sequence[PrecisionRow], votes: Sequence[Ballot], style: TableFormat = "text") -> str:
    """The table with its notes; shares as per cent for people, in [0, 1] in CSV (which has no notes)."""
    if style == "csv":
        return csv_text(_CSV_HEADER, (_csv_cells(row) for row in rows))
    table = [_HEADER, *(_cells(row) for row in rows)]
    lines = _aligned(table) if style == "text" else _markdown(table)
    return "\n".join([*lines, "", *_notes(rows, votes, "- " if style == "markdown" else "")]) + "\n"


def as_table(rows: Sequence[PrecisionRow], votes: Sequence[Ballot]) -> Table:
    """The table with its notes below it."""
    return Table("Precision by majority of the votes", _HEADER, [_cells(row) for row in rows], _WORDS,
                 " ".join(_notes(rows, votes, "")))  # fmt: skip


def percent(share: float | None, digits: int = 1) -> str:
    """A share of 1 as per cent; a dash for what is not known."""
    return "–" if share is None else f"{100 * share:.{digits}f} %"


def agreement_line(votes: Sequence[Ballot]) -> str:
    """Raw agreement beside alpha over all items of at least two decisive votes; abstentions are left out."""
    units: dict[str, list[str]] = {}
    for vote in votes:
        if vote.answer != "unsure":
            units.setdefault(vote.item, []).append(vote.answer)
    raw, alpha = raw_agreement(units.values()), krippendorff_alpha(units.values())
    if raw is None:
        return "Agreement: no match has been judged by two volunteers yet."
    shown = "not defined (all answers are equal)" if alpha is None else f"{alpha:.3f}"
    both = sum(len(unit) > 1 for unit in units.values())
    return f"Agreement on {both} matches with two votes or more: {percent(raw)} raw, Krippendorff's alpha {shown}."


def _cells(row: PrecisionRow) -> tuple[str, ...]:
    interval = _range(row.interval.low, row.interval.high) if row.interval else "–"
    return (
        row_name(row) + ("*" if row.parameter_sets > 1 else ""), row.set_name or "–", str(row.pairs),
        f"{row.judged} of {row.matches}", str(row.correct), str(row.wrong), str(row.tie), _number(row.micro), interval,
        _number(row.macro), _range(row.bound_low, row.bound_high), f"{row.votes} by {row.volunteers}",
        _number(row.unsure),
    )  # fmt: skip


def row_name(row: PrecisionRow) -> str:
    """Method and preset, once where they have the same name."""
    return row.method if row.preset in ("", row.method) else f"{row.method}, {row.preset}"


def _csv_cells(row: PrecisionRow) -> tuple[object, ...]:
    low, high, method = row.interval or (None, None, None)
    return (
        row.method, row.preset, row.set_name, row.parameter_sets, row.pairs, row.matches, row.judged, row.correct,
        row.wrong, row.tie, row.unjudged, row.micro, row.macro, low, high, method, row.bound_low, row.bound_high,
        row.volunteers, row.votes, row.unsure,
    )  # fmt: skip


def _notes(rows: Sequence[PrecisionRow], votes: Sequence[Ballot], mark: str) -> list[str]:
    notes = [] if rows else ["The study has no results yet; add some with `concord study add`."]
    if any(row.parameter_sets > 1 for row in rows):
        notes.append("* The pairs of this row were matched with different parameters.")
    methods = sorted({row.interval.method for row in rows if row.interval})
    if methods:
        notes.append(f"Intervals: {'; '.join(methods)}. The pair, or the puzzle, is the unit of sampling.")
        if any(row.interval and row.interval.method == ONE_CLUSTER for row in rows):
            notes.append("The interval of a single pair or puzzle speaks of its own matches only, not of others.")
        notes.append(
            "Precision is correct / (correct + wrong) by majority; a tie stays a tie and counts in the bounds."
        )
    return [mark + note for note in [*notes, agreement_line(votes), *_thesis_notes(rows)]]


def _thesis_notes(rows: Sequence[PrecisionRow]) -> list[str]:
    """The averages as in the thesis's Tables 3.1 and 3.2, for each method with several sets."""
    notes = []
    for total in (row for row in rows if row.set_name == ALL_SETS):
        sets = [r for r in rows if r[:2] == total[:2] and r.set_name != ALL_SETS and r.micro is not None]
        if len(sets) > 1:
            mean, spread = thesis_average([100 * (r.micro or 0) for r in sets], [r.pairs for r in sets])
            notes.append(f"As in Tables 3.1/3.2, {row_name(total)}: {mean:.3f} % ± {spread:.3f} over {len(sets)} sets.")
    return notes


def _aligned(table: Sequence[Sequence[str]]) -> list[str]:
    """Columns as wide as their widest cell: words to the left, figures to the right, a rule below the header."""
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    sides = ["<"] * _WORDS + [">"] * (len(widths) - _WORDS)
    lines = [
        "  ".join(f"{cell:{side}{width}}" for cell, width, side in zip(row, widths, sides, strict=True)).rstrip()
        for row in table
    ]
    return [lines[0], "-" * max(map(len, lines)), *lines[1:]]


def _markdown(table: Sequence[Sequence[str]]) -> list[str]:
    lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in table]
    return [lines[0], "|" + "---|" * _WORDS + "--:|" * (len(table[0]) - _WORDS), *lines[1:]]


def _number(share: float | None) -> str:
    return percent(share).removesuffix(" %")


def _range(low: float | None, high: float | None) -> str:
    return "–" if low is None else f"{_number(low)} – {_number(high)}"
