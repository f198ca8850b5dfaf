"""Text in the cells of CSV files that spreadsheets open."""

import re


def safe_cell(text: str) -> str:
    """Text that no spreadsheet takes for a formula: those that begin with = + - @ get a leading apostrophe."""
    return "'" + text if text[:1] in ("=", "+", "-", "@", "\t", "\r") and not _is_number(text) else text


def _is_number(text: str) -> bool:
    """Whether the text is a number, or whole numbers joined by semicolons."""
    return re.fullmatch(r"[+-]?\d+(\.\d*)?|[+-]?\d+(;[+-]?\d+)*", text) is not None
