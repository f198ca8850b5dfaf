"""The precision table as text, Markdown or CSV, and any table as text."""

from collections.abc import Sequence
from typing import Literal

from engine.evaluation.averages import thesis_average
from engine.evaluation.intervals import ONE_CLUSTER
from engine.evaluation.tables import Table

from ..exchange.csvtext import csv_text
from .agreement import agreement_rows
from .precision import ALL_SETS, GUIDED, Ballot, PrecisionRow

TableFormat = Literal["text", "csv", "markdown"]
_HEADER = (
    "method", "set", "pairs", "judged", "correct", "wrong", "tie", "precision %", "95 % interval", "macro %",
    "bounds %", "unresolved %", "votes", "unsure %",
)  # fmt: skip
_WORDS = 2  # how many columns hold words, to be set to the left
PRECISION_HEAD = (
    "method", "preset", "set", "parameter_sets", "pairs", "matches", "judged", "correct", "wrong", "tie", "unjudged",
    "micro_precision", "macro_precision", "interval_low", "interval_high", "interval_method", "bound_low",
    "bound_high", "volunteers", "votes", "unsure_share", "seen", "unresolved_share", "drawn", "sampled",
    "pooled_recall", "recall_pairs", "chosen_parameters", "proposed_after_draw",
)  # fmt: skip


def render(rows: Sequence[PrecisionRow], votes: Sequence[Ballot], style: TableFormat = "text") -> str:
    """The table with its notes; shares as per cent for people, in [0, 1] in CSV (which has no notes)."""
    if style == "csv":
        return csv_text(PRECISION_HEAD, (precision_values(row) for row in rows))
    table = [_HEADER, *(_cells(row) for row in rows)]
    lines = aligned(table, _WORDS) if style == "text" else _markdown(table)
    mark = "- " if style == "markdown" else ""
    return "\n".join([*lines, "", *(mark + note for note in [*notes(rows), agreement_line(votes), *_thesis_notes(rows)])]) + "\n"


def as_table(rows: Sequence[PrecisionRow], votes: Sequence[Ballot]) -> Table:
    """The table with its notes below it."""
    told = " ".join([*notes(rows), agreement_line(votes), *_thesis_notes(rows)])
    return plain_table("Precision by majority of the votes", rows)._replace(remark=told)


def plain_table(title: str, rows: Sequence[PrecisionRow]) -> Table:
    """The table with the notes on its own figures."""
    return Table(title, _HEADER, [_cells(row) for row in rows], _WORDS, " ".join(notes(rows)))


def percent(share: float | None, digits: int = 1) -> str:
    """A share of 1 as per cent; a dash for what is not known."""
    return "–" if share is None else f"{100 * share:.{digits}f} %"


def agreement_line(votes: Sequence[Ballot]) -> str:
    """Raw agreement beside alpha over all items of at least two decisive votes; abstentions are left out."""
    (row,) = agreement_rows(votes)
    if row.raw is None:
        return "Agreement: no match has been judged by two volunteers yet."
    shown = "not defined (all answers are equal)" if row.alpha is None else f"{row.alpha:.3f}"
    return f"Agreement on {row.items} matches with two votes or more: {percent(row.raw)} raw, Krippendorff's alpha {shown}."


def _cells(row: PrecisionRow) -> tuple[str, ...]:
    interval = shown_range(row.interval.low, row.interval.high) if row.interval else "–"
    return (
        row_name(row) + ("*" if row.parameter_sets > 1 else ""), row.set_name or "–", str(row.pairs),
        f"{row.judged} of {row.matches}", str(row.correct), str(row.wrong), str(row.tie), number(row.micro), interval,
        number(row.macro), shown_range(row.bound_low, row.bound_high), number(row.unresolved),
        f"{row.votes} by {row.volunteers}", number(row.unsure),
    )  # fmt: skip


def row_name(row: PrecisionRow) -> str:
    """Method and preset, once where they have the same name."""
    return method_name((row.method, row.preset))


def marked_name(row: PrecisionRow) -> str:
    """The same with a mark where the parameters were chosen and the name does not say that people guided it."""
    return row_name(row) + ("†" if row.chosen and not row.method.endswith(GUIDED) else "")


def method_name(method: tuple[str, str]) -> str:
    """Method and preset, once where they have the same name."""
    return method[0] if method[1] in ("", method[0]) else f"{method[0]}, {method[1]}"


def precision_values(row: PrecisionRow) -> tuple[object, ...]:
    """The values of `PRECISION_HEAD`."""
    low, high, method = row.interval or (None, None, None)
    return (
        row.method, row.preset, row.set_name, row.parameter_sets, row.pairs, row.matches, row.judged, row.correct,
        row.wrong, row.tie, row.unjudged, row.micro, row.macro, low, high, method, row.bound_low, row.bound_high,
        row.volunteers, row.votes, row.unsure, row.seen, row.unresolved, row.drawn, int(row.sampled), row.recall,
        row.recall_pairs, int(row.chosen), row.later,
    )  # fmt: skip


def notes(rows: Sequence[PrecisionRow]) -> list[str]:
    """What has to be said of these rows."""
    told = [] if rows else ["The study has no results yet; add some with `concord study add`."]
    if any(row.parameter_sets > 1 for row in rows):
        told.append("* The pairs of this row were matched with different parameters.")
    methods = sorted({row.interval.method for row in rows if row.interval})
    if methods:
        told.append(f"Intervals: {'; '.join(methods)}. The pair, or the puzzle, is the unit of sampling.")
        if any(row.interval and row.interval.method.startswith(ONE_CLUSTER) for row in rows):
            told.append("The interval of a single pair or puzzle speaks of its own matches only, not of others.")
        weighted = ", of what these stand for" if any(row.sampled for row in rows) else ""
        told.append(f"Precision is correct / (correct + wrong) by majority{weighted}; a tie stays a tie and counts in the bounds.")
    if any(row.sampled for row in rows):
        told.append(
            "The study asks about a sample: every drawn match counts for 1 / p, p being the chance that it was drawn, and the "
            "bounds take the undecided drawn ones as all wrong and all right. Judged matches that were not drawn, as gold ones may "
            "be, are in the counts alone."
        )
        if any(row.later for row in rows):
            told.append(
                f"Of matches proposed after the sample was drawn ({max(row.later for row in rows)} at most in a row) the figures "
                "know nothing but that the bounds allow for them; ask them too with `concord study top-up`."
            )
    elif any(row.seen < row.matches for row in rows):
        told.append("Matches that nobody has seen are unknown, not wrong; the bounds take them as all wrong and all right.")
    return told


def _thesis_notes(rows: Sequence[PrecisionRow]) -> list[str]:
    """The averages as in the thesis's Tables 3.1 and 3.2, for each method with several sets."""
    told = []
    for total in (row for row in rows if row.set_name == ALL_SETS):
        sets = [r for r in rows if r[:2] == total[:2] and r.set_name != ALL_SETS and r.micro is not None]
        if len(sets) > 1:
            mean, spread = thesis_average([100 * (r.micro or 0) for r in sets], [r.pairs for r in sets])
            told.append(f"As in Tables 3.1/3.2, {row_name(total)}: {mean:.3f} % ± {spread:.3f} over {len(sets)} sets.")
    return told


def aligned(table: Sequence[Sequence[str]], words: int) -> list[str]:
    """Columns as wide as their widest cell: words to the left, figures to the right, a rule below the header."""
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    sides = ["<"] * words + [">"] * (len(widths) - words)
    lines = [
        "  ".join(f"{cell:{side}{width}}" for cell, width, side in zip(row, widths, sides, strict=True)).rstrip()
        for row in table
    ]
    return [lines[0], "-" * max(map(len, lines)), *lines[1:]]


def _markdown(table: Sequence[Sequence[str]]) -> list[str]:
    lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in table]
    return [lines[0], "|" + "---|" * _WORDS + "--:|" * (len(table[0]) - _WORDS), *lines[1:]]


def number(share: float | None) -> str:
    """A share in per cent without the sign; a dash for what is not known."""
    return percent(share).removesuffix(" %")


def shown_range(low: float | None, high: float | None) -> str:
    """Two shares in per cent without the sign; a dash for what is not known."""
    return "–" if low is None else f"{number(low)} – {number(high)}"
