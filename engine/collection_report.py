"""The report of a collection as one HTML page: all shapes in the colours of their parts, pairs, and what was run."""

import math
from collections.abc import Callable, Sequence
from html import escape

import numpy as np

from .collectionfile import mean_support, supported
from .parameters import Parameters, declared
from .report import Picture, html_table, page, pictures_html
from .shapes.collection_result import KINDS, CollectionResult
from .shapes.parameters import PRESETS

CollectionDraw = Callable[[CollectionResult], list[Picture]]


def collection_page(found: CollectionResult, pictures: Sequence[Picture] = ()) -> str:
    """The whole page; `pictures` may be empty."""
    sections = [pictures_html(pictures), _left_out(found), _supports(found), _parts(found), _pairs(found), _notes(found),
                _parameters(found), _seconds(found)]  # fmt: skip
    return page("Collection: " + _listed(found.names), _lead(found), sections)


def _listed(names: Sequence[str], most: int = 5) -> str:
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def _lead(found: CollectionResult) -> str:
    matches = sum(len(result.ids) for result in found.results)
    return (f"{len(found.shapes)} shapes, {len(found.pairs)} pairs, {matches} matches by {found.match_parameters.method} "
            f"(preset {found.preset or 'none'}), {found.part_count} parts, in {sum(found.seconds.values()):.1f} s")  # fmt: skip


def _left_out(found: CollectionResult) -> str:
    items = "".join(f"<li>{escape(sentence)}</li>" for sentence in found.failures)
    return f"<h2>Left out</h2><ul>{items}</ul>" if items else ""


def _supports(found: CollectionResult) -> str:
    """How many matches each kind of support keeps at some thresholds."""
    rows = []
    for kind in KINDS:
        values = np.concatenate([np.zeros(0), *found.supports[kind]])
        known = values[np.isfinite(values)]
        if len(known):
            shares = [f"{(known >= least).mean():.2f}" for least in (0.25, 0.5, 0.75)]
            rows.append((kind + (" (chosen)" if kind == found.parameters.support else ""), len(known), f"{known.mean():.2f}", *shares))
    head = ("support", "matches", "mean", "at least .25", "at least .50", "at least .75")
    words = ("<p>The support of a match says how far the other shapes agree with it: <em>cycles</em> by the ways around by "
             "third shapes, <em>matchlift</em> by one consistent solution for all segments together.</p>")  # fmt: skip
    body = html_table(head, rows, [False] + [True] * 5) if rows else "<p>There is no third shape to support a match.</p>"
    return f"<h2>Support</h2>{words}{body}"


def _parts(found: CollectionResult) -> str:
    shares = found.shares()
    head = ("part", "shapes", "mean share", *found.names)
    rows = []
    for part in range(found.part_count):
        own = [", ".join(str(shape.segmentation.names[k]) for k in np.flatnonzero(of == part))
               for shape, of in zip(found.shapes, found.parts, strict=True)]  # fmt: skip
        rows.append((part, int((shares[:, part] > 0).sum()), f"{shares[:, part].mean():.2f}", *own))
    none = [", ".join(str(shape.segmentation.names[k]) for k in np.flatnonzero(of < 0))
            for shape, of in zip(found.shapes, found.parts, strict=True)]  # fmt: skip
    rows.append(("none", "", "", *none))
    table = html_table(head, rows, [True, True, True] + [False] * len(found.names))
    return f'<h2>Parts and their segments</h2><div style="overflow-x: auto">{table}</div>'


def _pairs(found: CollectionResult) -> str:
    rows = []
    for row, ((a, b), result) in enumerate(zip(found.pairs, found.results, strict=True)):
        mean = mean_support(found.support(row))
        rows.append((found.names[a], found.names[b], len(result.ids), supported(found.support(row)),
                     "" if math.isnan(mean) else f"{mean:.2f}"))  # fmt: skip
    head = ("source", "target", "matches", "supported (at least .50)", "mean support")
    return f"<h2>Pairs</h2>{html_table(head, rows, [False, False, True, True, True])}"


def _notes(found: CollectionResult) -> str:
    items = "".join(f"<li>{escape(note)}</li>" for note in found.notes)
    return f"<h2>Notes</h2><ul>{items}</ul>" if items else ""


def _parameters(found: CollectionResult) -> str:
    changed = found.match_parameters.differences(PRESETS[found.preset]) if found.preset in PRESETS else {}
    rows = _rows(found.parameters, found.parameters.differences(type(found.parameters)()), "")
    rows += _rows(found.match_parameters, changed, found.match_parameters.method)
    table = html_table(("step", "parameter", "symbol", "value", "unit", "meaning"), rows)
    return f"<h2>Parameters</h2><details><summary>all values; * differs from the preset</summary>{table}</details>"


def _rows(parameters: Parameters, changed: dict[str, object], method: str) -> list[tuple[object, ...]]:
    return [(info.group, info.name + ("*" if info.name in changed else ""), info.symbol, getattr(parameters, info.name),
             info.unit, info.doc)
            for info in declared(type(parameters)) if not info.methods or method in info.methods]  # fmt: skip


def _seconds(found: CollectionResult) -> str:
    rows = [(step, f"{value:.2f}") for step, value in found.seconds.items()]
    return f"<h2>Seconds by step</h2>{html_table(('step', 'seconds'), rows, [False, True])}"
