"""Tables of words and figures as CSV, Markdown and LaTeX."""

import csv
import io
import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from ..spreadsheet import safe_cell

NOTHING = "–"
_LATEX = str.maketrans({
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "–": "--", "±": r"$\pm$", "≥": r"$\ge$", "<": r"$<$", ">": r"$>$",
})  # fmt: skip


class Table(NamedTuple):
    """A table for people: a title, column heads, rows of texts, how many first columns hold words, and a remark."""

    title: str
    head: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    words: int = 1
    remark: str = ""

    @property
    def numeric(self) -> list[bool]:
        """Which columns are set to the right."""
        return [k >= self.words for k in range(len(self.head))]


def to_markdown(tables: Sequence[Table], lead: str, notes: Sequence[str] = ()) -> str:
    """Headings and tables; `notes` become a list at the end."""
    parts = [lead]
    for table in tables:
        rule = "|" + "".join("--:|" if right else "---|" for right in table.numeric)
        lines = [_piped(table.head), rule, *(_piped(row) for row in table.rows)]
        parts += [f"## {table.title}", "\n".join(lines), *([table.remark] if table.remark else [])]
    parts += ["## Notes", "\n".join(f"- {note}" for note in notes)] if notes else []
    return "\n\n".join(parts) + "\n"


def to_latex(tables: Sequence[Table], lead: str, *, long: bool = False) -> str:
    """One `table` environment each, or a `longtable` (of the package of that name) that runs over pages; in UTF-8."""
    parts = ["\n".join(f"% {line}" for line in lead.splitlines())]
    for table in tables:
        head, *rows = [" & ".join(cell.translate(_LATEX) for cell in row) + r" \\" for row in (table.head, *table.rows)]
        columns = "".join("r" if right else "l" for right in table.numeric)
        caption = r"\caption{" + " ".join([table.title + ".", table.remark]).strip().translate(_LATEX) + "}"
        if long:
            lines = [rf"\begin{{longtable}}{{{columns}}}", caption + r" \\", r"\hline", head, r"\hline", r"\endhead",
                     *rows, r"\hline", r"\end{longtable}"]  # fmt: skip
        else:
            lines = [r"\begin{table}", r"\centering", r"\small", rf"\begin{{tabular}}{{{columns}}}", r"\hline", head, r"\hline",
                     *rows, r"\hline", r"\end{tabular}", caption, r"\end{table}"]  # fmt: skip
        parts.append("\n".join(lines))
    return "\n\n".join(parts) + "\n"


def split_wide(table: Table, width: int) -> list[Table]:
    """The table, or several with the same words and a part of the figures each, none of more than `width` characters
    where that can be (two between columns)."""
    widths = [max(map(len, column)) + 2 for column in zip(table.head, *table.rows, strict=True)]
    parts: list[list[int]] = [[]]
    fixed, used = sum(widths[: table.words]), 0
    for column in range(table.words, len(widths)):
        if parts[-1] and fixed + used + widths[column] > width + 2:
            parts.append([])
            used = 0
        parts[-1].append(column)
        used += widths[column]
    if len(parts) == 1:
        return [table]
    cut = [[(*row[: table.words], *(row[k] for k in part)) for row in (table.head, *table.rows)] for part in parts]
    last = len(parts) - 1
    return [Table(f"{table.title} ({k + 1} of {len(parts)})", lines[0], lines[1:], table.words, table.remark if k == last else "")
            for k, lines in enumerate(cut)]  # fmt: skip


def to_csv(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """One line a row; shares stay shares of 1; what is not known is empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    writer.writerows([_plain(value) for value in row] for row in rows)
    return text.getvalue()


def percent(share: float | None, digits: int = 1) -> str:
    """A share of 1 in per cent without the sign; a dash for what is not known."""
    return NOTHING if share is None or math.isnan(share) else f"{100 * share:.{digits}f}"


def _plain(value: object) -> object:
    if isinstance(value, str):
        return safe_cell(value)
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.6g}"
    return "" if value is None else value


def _piped(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
