"""CSV that is safe to open in a spreadsheet: text that would start a formula is shown as text."""

import csv
import io
from collections.abc import Iterable, Sequence

from engine.spreadsheet import safe_cell


def csv_text(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A header and rows as CSV with safe cells; None is an empty one."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([safe_cell(value) if isinstance(value, str) else value for value in row] for row in rows)
    return out.getvalue()
