"""CSV that is safe to open in a spreadsheet: text that would start a formula is shown as text."""

import csv
import io
from collections.abc import Iterable, Sequence


def safe_cell(value: object) -> object:
    """Text that starts with = + - @ (or a tab or return) gets a leading apostrophe; None is an empty cell."""
    if isinstance(value, str) and value[:1] in ("=", "+", "-", "@", "\t", "\r"):
        return "'" + value
    return "" if value is None else value


def csv_text(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A header and rows as CSV with safe cells."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([safe_cell(value) for value in row] for row in rows)
    return out.getvalue()
