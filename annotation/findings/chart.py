"""Precision with its intervals as a drawing that a page can hold: plain SVG in the page's own colours."""

from collections.abc import Sequence
from html import escape

from .precision import PrecisionRow
from .tabletext import marked_name, number, shown_range

_LABEL, _PLOT, _NUMBERS, _LINE, _HEAD, _GAP = 330, 460, 200, 24, 32, 10
_LEAST = 700  # pixels; on narrower screens the drawing scrolls, or its words could not be read
_WIDTH = _LABEL + _PLOT + _NUMBERS


def precision_chart(rows: Sequence[PrecisionRow]) -> str:
    """An SVG of one line a row: a dot at the precision, a line for its interval, a band for the bounds; "" without rows.

    Colours are the variables --ink, --faint, --line and --accent of the page around it.
    """
    shown = [row for row in rows if row.micro is not None]
    if not shown:
        return ""
    places, y = [], float(_HEAD)
    for k, row in enumerate(shown):
        y += _GAP if k and row[:2] != shown[k - 1][:2] else 0
        places.append(y + _LINE / 2)
        y += _LINE
    height = y + 8
    marks = [_text(_at(share), 16, f"{share:.0%}".replace("%", " %"), "middle", "faint") + _grid(share, height)
             for share in (0.0, 0.25, 0.5, 0.75, 1.0)]  # fmt: skip
    lines = [_row(row, place) for row, place in zip(shown, places, strict=True)]
    style = f"max-width:100%;min-width:{_LEAST}px;height:auto;font-size:13px"
    return (
        f'<svg viewBox="0 0 {_WIDTH} {height:g}" width="{_WIDTH}" role="img" style="{style}">'
        f"<title>Precision with 95 % intervals</title>{''.join(marks)}{''.join(lines)}</svg>"
    )


def _row(row: PrecisionRow, y: float) -> str:
    parts = [_text(0, y + 4, _shortened(f"{marked_name(row)} · {row.set_name or '–'}"), "start", "ink")]
    if row.bound_low is not None and row.bound_high is not None:
        parts.append(_stroke(row.bound_low, row.bound_high, y, "line", 9))
    interval = ""
    if row.interval is not None:
        parts.append(_stroke(row.interval.low, row.interval.high, y, "accent", 2))
        interval = f"  ({shown_range(row.interval.low, row.interval.high)})"
    parts.append(f'<circle cx="{_at(row.micro or 0.0):.1f}" cy="{y:.1f}" r="4.5" style="fill:var(--accent)"/>')
    parts.append(_text(_LABEL + _PLOT + 16, y + 4, number(row.micro) + interval, "start", "ink"))
    return "<g>" + "".join(parts) + "</g>"


def _at(share: float) -> float:
    return _LABEL + share * _PLOT


def _grid(share: float, height: float) -> str:
    x = _at(share)
    return f'<line x1="{x:.1f}" x2="{x:.1f}" y1="24" y2="{height:g}" style="stroke:var(--line);stroke-width:1"/>'


def _stroke(low: float, high: float, y: float, colour: str, width: int) -> str:
    style = f"stroke:var(--{colour});stroke-width:{width}"
    return f'<line x1="{_at(low):.1f}" x2="{_at(high):.1f}" y1="{y:.1f}" y2="{y:.1f}" style="{style}"/>'


def _text(x: float, y: float, words: str, anchor: str, colour: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" style="fill:var(--{colour})">{escape(words)}</text>'


def _shortened(words: str, most: int = 46) -> str:
    return words if len(words) <= most else words[: most - 1] + "…"
