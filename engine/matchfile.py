"""`matches.json` (schema concord.matches/1) and `matches.csv`: results that other programs read."""

import csv
import io
import json
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .shapes.result import MatchResult, ShapeRecord
from .shapes.wishes import Pair
from .spreadsheet import safe_cell
from .store import write_together

SCHEMA = "concord.matches/1"


class Support(NamedTuple):
    """How far other shapes of a collection support each match: `kind` of support, `values` (p,) in [0, 1] or NaN."""

    kind: str
    values: np.ndarray


def result_to_json(result: MatchResult, support: Support | None = None) -> dict[str, Any]:
    """The result as the JSON object of schema concord.matches/1.

    Segments are numbered by the sorted order of the labels in the input, and listed by those labels. `sha256` is the
    hash of the arrays as they were read and `segmentation` that of the segments (see `engine.shapes.identity`). With a
    support every match has a `support`, null where nothing can be said, and `supported_by` names its kind. Where wishes
    were honoured, `wishes` holds what was pinned and what was forbidden, and every match says whether it is `pinned`.
    """
    content: dict[str, Any] = {
        "schema": SCHEMA,
        "source": _shape(result.source),
        "target": _shape(result.target),
        "method": result.method,
        "preset": result.preset,
        "parameters": result.parameters.model_dump(),
        "matches": [
            {"id": m.id, "source": _labels(result.source, m.source), "target": _labels(result.target, m.target),
             "score": round(m.score, 6), "votes": m.votes, "source_layer": m.source_layer,
             "target_layer": m.target_layer} for m in result.matches()
        ],
        "unmatched": {
            "source": _labels(result.source, np.flatnonzero(~result.source_members.any(axis=0))),
            "target": _labels(result.target, np.flatnonzero(~result.target_members.any(axis=0))),
        },
        "graph": {"source_nodes": result.source_nodes, "target_nodes": result.target_nodes},
        "seconds": {step: round(value, 4) for step, value in result.seconds.items()},
    }  # fmt: skip
    if result.wishes:
        content["wishes"] = {"pinned": _wish_labels(result, result.wishes.pinned),
                             "forbidden": _wish_labels(result, result.wishes.forbidden)}  # fmt: skip
        for match, pinned in zip(content["matches"], result.pinned.tolist(), strict=True):
            match["pinned"] = pinned
    if support is not None:
        content["supported_by"] = support.kind
        for match, value in zip(content["matches"], support.values.tolist(), strict=True):
            match["support"] = None if math.isnan(value) else round(value, 6)
    return content


def _shape(record: ShapeRecord) -> dict[str, Any]:
    return {"file": record.file, "sha256": record.sha256, "segments": len(record.segments), "faces": record.faces,
            "segmentation": record.segmentation}  # fmt: skip


def _wish_labels(result: MatchResult, pairs: Iterable[Pair]) -> list[dict[str, list[int | str]]]:
    return [{"source": _labels(result.source, a), "target": _labels(result.target, b)} for a, b in pairs]


def _labels(record: ShapeRecord, segments: Iterable[int]) -> list[int | str]:
    return [record.segments[int(i)] for i in segments]


def result_to_csv(result: MatchResult, support: Support | None = None) -> str:
    """One line a match, segments joined by semicolons; cells that a spreadsheet would run as a formula are escaped.

    The last columns, `support` and `pinned`, are there where there is a support, or where wishes were honoured.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    head = ["id", "source", "target", "score", "votes", "source_layer", "target_layer", "similarity"]
    writer.writerow([*head, *(["support"] if support is not None else []), *(["pinned"] if result.wishes else [])])
    for row, m in enumerate(result.matches()):
        source, target = (";".join(map(str, _labels(record, segments))) for record, segments in
                          ((result.source, m.source), (result.target, m.target)))  # fmt: skip
        writer.writerow([m.id, safe_cell(source), safe_cell(target), f"{m.score:.6f}", m.votes, m.source_layer,
                         m.target_layer, f"{m.similarity:.6f}", *_support_cell(support, row),
                         *(["pinned" if m.pinned else ""] if result.wishes else [])])  # fmt: skip
    return text.getvalue()


def _support_cell(support: Support | None, row: int) -> list[str]:
    """The last cell of a line, empty where nothing can be said; no cell without a support."""
    if support is None:
        return []
    return ["" if math.isnan(support.values[row]) else f"{support.values[row]:.6f}"]


def write_matches(
    result: MatchResult, folder: Path | str, *, report: str = "", support: Support | None = None
) -> list[Path]:
    """Write `matches.json`, `matches.csv`, `parameters.json` and, where given, `report.html` into a folder that exists.

    All are written, or none; returns their paths. Raises `BadInput`.
    """
    folder = Path(folder)
    contents = match_contents(result, folder, support)
    if report:
        contents[folder / "report.html"] = report
    write_together(contents)
    return list(contents)


def match_contents(result: MatchResult, folder: Path, support: Support | None = None) -> dict[Path, bytes | str]:
    """The files of a result and what they hold."""
    return {
        folder / "matches.json": json.dumps(result_to_json(result, support), indent=1, ensure_ascii=False) + "\n",
        folder / "matches.csv": result_to_csv(result, support),
        folder / "parameters.json": json.dumps(result.parameters.model_dump(), indent=1) + "\n",
    }
