"""One self-contained HTML page: what was run with what, and what came out."""

import base64
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Protocol

import numpy as np

from .parameters import declared
from .shapes.parameters import PRESETS, MatchParameters
from .shapes.result import MatchResult, ShapeRecord
from .shapes.segmentation import SegmentedShape

Picture = tuple[str, bytes]  # title and PNG


class PictureMaker(Protocol):
    """Draws a result; `states` says by the ids of matches which are "correct" and which "wrong", where that is known."""

    def __call__(
        self, source: SegmentedShape, target: SegmentedShape, result: MatchResult, states: Mapping[str, str] | None = None
    ) -> list[Picture]: ...


_STYLE = """
:root { color-scheme: light dark; --paper: #fafaf7; --ink: #22252a; --faint: #8a8f98; --line: #dcdcd6; --accent: #0072b2 }
@media (prefers-color-scheme: dark) { :root { --paper: #1e2024; --ink: #e6e6e3; --line: #3a3d43; --accent: #56b4e9 } }
body { font: 15px/1.5 system-ui, sans-serif; background: var(--paper); color: var(--ink); max-width: 76rem;
  margin: 2rem auto; padding: 0 1.5rem }
h1 { font-size: 1.6rem; margin-bottom: 0 } h2 { font-size: 1.15rem; margin-top: 2.2rem }
p.lead { color: var(--faint); margin-top: .2rem }
table { border-collapse: collapse; font-variant-numeric: tabular-nums } td, th { padding: .25rem .9rem .25rem 0;
  text-align: left; border-bottom: 1px solid var(--line); vertical-align: top } td.n, th.n { text-align: right }
.wide { overflow-x: auto; white-space: nowrap; font-size: .87em } .wide th { white-space: normal; vertical-align: bottom }
@media print { .wide { overflow: visible; white-space: normal } }
figure { margin: 1rem 0 } figure img { max-width: 100%; border: 1px solid var(--line); border-radius: 6px }
figcaption { color: var(--faint) } .changed { color: var(--accent); font-weight: 600 } code { font-size: .9em }
ul { padding-left: 1.2rem } details summary { cursor: pointer }
"""


def report_page(
    result: MatchResult, pictures: Sequence[Picture] = (), extra: Sequence[tuple[str, str]] = ()
) -> str:
    """The report of a match as one HTML page.

    Parameters
    ----------
    pictures
        Titles and PNG bytes, embedded in the page. May be empty: pictures need VTK, which the engine does without.
    extra
        Further sections: heading and HTML that is already safe (made by `html_table`).
    """
    sections = [
        pictures_html(pictures), _matches(result), _wishes(result), *(f"<h2>{escape(head)}</h2>{body}" for head, body in extra),
        _notes(result), _parameters(result.parameters, result.preset), _seconds(result),
    ]  # fmt: skip
    return page(_title(result), _lead(result), sections)


def page(title: str, lead: str, sections: Sequence[str]) -> str:
    """A whole HTML page; `title` and `lead` are plain text, the sections safe HTML."""
    head = f'<meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>{escape(title)}</title>'
    body = f'<h1>{escape(title)}</h1><p class="lead">{escape(lead)}</p>' + "\n".join(sections)
    return f'<!doctype html>\n<html lang="en"><head>{head}<style>{_STYLE}</style></head><body>{body}</body></html>\n'


def html_table(head: Sequence[str], rows: Sequence[Sequence[object]], numeric: Sequence[bool] | None = None) -> str:
    """An HTML table of plain values, escaped; `numeric` columns are aligned to the right."""
    kinds = [' class="n"' if n else "" for n in (numeric or [False] * len(head))]

    def line(tag: str, cells: Sequence[object]) -> str:
        return "<tr>" + "".join(f"<{tag}{k}>{escape(str(c))}</{tag}>" for k, c in zip(kinds, cells, strict=True)) + "</tr>"

    return f"<table><thead>{line('th', head)}</thead><tbody>{''.join(line('td', r) for r in rows)}</tbody></table>"


def _name(record: ShapeRecord) -> str:
    return Path(record.file).stem or "shape"


def _title(result: MatchResult) -> str:
    return f"{_name(result.source)} and {_name(result.target)}"


def _lead(result: MatchResult) -> str:
    seconds = sum(result.seconds.values())
    return (
        f"{len(result.ids)} consistent matches by {result.method} (preset {result.preset or 'none'}) between "
        f"{len(result.source.segments)} and {len(result.target.segments)} segments, in {seconds:.2f} s"
    )


def pictures_html(pictures: Sequence[Picture]) -> str:
    """The pictures with their titles, embedded."""
    return "".join(
        f'<figure><img alt="{escape(title)}" src="data:image/png;base64,{base64.b64encode(png).decode()}">'
        f"<figcaption>{escape(title)}</figcaption></figure>"
        for title, png in pictures
    )


def _matches(result: MatchResult) -> str:
    listed, told = _listed, bool(result.wishes)
    rows = [
        (k + 1, listed(result.source, m.source), listed(result.target, m.target), f"{m.score:.3f}", m.votes,
         f"{m.source_layer} / {m.target_layer}", f"{m.similarity:.3f}", *(["pinned" if m.pinned else ""] if told else []))
        for k, m in enumerate(result.matches())
    ]  # fmt: skip
    sides = ((result.source, result.source_members), (result.target, result.target_members))
    left = [listed(record, tuple(np.flatnonzero(~members.any(axis=0)))) or "none" for record, members in sides]
    head = ("#", _name(result.source), _name(result.target), "score", "votes", "layers", "similarity", *([""] if told else []))
    table = html_table(head, rows, [True, False, False, True, True, False, True, *([False] if told else [])])
    unmatched = f"<p>Segments in no match: {escape(left[0])} (left); {escape(left[1])} (right).</p>"
    return f"<h2>Matches</h2>{table if rows else '<p>No matches were found.</p>'}{unmatched}"


def _listed(record: ShapeRecord, segments: tuple[int, ...]) -> str:
    return ", ".join(str(record.segments[i]) for i in segments)


def _wishes(result: MatchResult) -> str:
    """What people had pinned and forbidden, where they had."""
    if not result.wishes:
        return ""
    rows = [(word, _listed(result.source, a), _listed(result.target, b))
            for word, pairs in (("pinned", result.wishes.pinned), ("forbidden", result.wishes.forbidden))
            for a, b in pairs]  # fmt: skip
    table = html_table(("wish", _name(result.source), _name(result.target)), rows)
    return f"<h2>Wishes that were honoured</h2>{table}"


def _notes(result: MatchResult) -> str:
    items = "".join(f"<li>{escape(note)}</li>" for note in result.notes)
    return f"<h2>Notes</h2><ul>{items}</ul>" if items else ""


def _parameters(parameters: MatchParameters, preset: str) -> str:
    changed = parameters.differences(PRESETS[preset]) if preset in PRESETS else {}
    rows = []
    for info in declared(type(parameters)):
        if info.methods and parameters.method not in info.methods:
            continue
        star = "*" if info.name in changed else ""
        value = getattr(parameters, info.name)
        rows.append((info.group, info.name + star, info.symbol, value, info.unit, info.doc))
    table = html_table(("step", "parameter", "symbol", "value", "unit", "meaning"), rows)
    star = "<p>* differs from the preset</p>" if changed else ""
    return f"<h2>Parameters</h2>{table}{star}"


def _seconds(result: MatchResult) -> str:
    rows = [(step, f"{value:.3f}") for step, value in result.seconds.items()]
    rows.append(("graph nodes", f"{result.source_nodes} / {result.target_nodes}"))
    return f"<h2>Seconds by step</h2>{html_table(('step', 'seconds'), rows, [False, True])}"
