"""The files of a collection: collection.json (schema concord.collection/1), tables, and matches.json for each pair."""

import csv
import io
import json
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .matchfile import Support, match_contents
from .shapes.collection_result import KINDS, SUPPORTED, CollectionResult
from .spreadsheet import safe_cell
from .store import output_folder, write_together

SCHEMA = "concord.collection/1"


def write_collection(found: CollectionResult, folder: Path, *, report: str = "") -> list[Path]:
    """Write collection.json, collection.csv, parts.csv, the report where given, and the files of each pair.

    All are written, or none; returns their paths. Raises `BadInput`.
    """
    contents: dict[Path, bytes | str] = {}
    for row, name in enumerate(pair_folders(found)):
        own = output_folder(folder / "pairs" / name)
        contents |= match_contents(found.results[row], own, Support(found.parameters.support, found.support(row)))
    contents |= {
        folder / "collection.json": json.dumps(collection_to_json(found), indent=1, ensure_ascii=False) + "\n",
        folder / "collection.csv": matches_csv(found),
        folder / "parts.csv": parts_csv(found),
    }
    if report:
        contents[folder / "report.html"] = report
    write_together(contents, synced=len(contents) < 200)
    return list(contents)


def pair_folders(found: CollectionResult) -> list[str]:
    """A folder's name for each pair, of the names of its two shapes, each once."""
    safe = [re.sub(r"[^\w.()-]+", "_", name).strip("._") or "shape" for name in found.names]
    names = [f"{safe[a]}-{safe[b]}" for a, b in found.pairs]
    return [name if names.index(name) == row else f"{name}-{row + 1}" for row, name in enumerate(names)]


def collection_to_json(found: CollectionResult) -> dict[str, Any]:
    """The collection as a JSON object: shapes with the part of each segment, parts, pairs, and what was run."""
    records = {b: r.target for (_, b), r in zip(found.pairs, found.results, strict=True)}
    records |= {a: r.source for (a, _), r in zip(found.pairs, found.results, strict=True)}
    return {
        "schema": SCHEMA,
        "shapes": [
            {"name": name, "file": records[k].file, "sha256": records[k].sha256, "segmentation": records[k].segmentation,
             "segments": list(records[k].segments), "parts": _or_null(found.parts[k])}
            for k, name in enumerate(found.names)
        ],
        "parts": [
            {"part": part, "shapes": int((share > 0).sum()), "share": round(float(share.mean()), 6)}
            for part, share in enumerate(found.shares().T)
        ],
        "pairs": [_pair(found, row, name) for row, name in enumerate(pair_folders(found))],
        "support": found.parameters.support,
        "method": found.match_parameters.method,
        "preset": found.preset,
        "parameters": found.match_parameters.model_dump(),
        "collection_parameters": found.parameters.model_dump(),
        "left_out": list(found.failures),
        "notes": list(found.notes),
        "seconds": {step: round(value, 4) for step, value in found.seconds.items()},
    }  # fmt: skip


def _pair(found: CollectionResult, row: int, folder: str) -> dict[str, Any]:
    a, b = found.pairs[row]
    return {"source": a, "target": b, "matches": len(found.results[row].ids), "supported": supported(found.support(row)),
            "mean_support": _value(mean_support(found.support(row))), "file": f"pairs/{folder}/matches.json"}  # fmt: skip


def supported(values: np.ndarray) -> int:
    """How many matches have a support of at least one half."""
    return int((values >= SUPPORTED).sum())


def mean_support(values: np.ndarray) -> float:
    """Mean of the supports that are known; NaN where none is."""
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else math.nan


def matches_csv(found: CollectionResult) -> str:
    """One line a match of any pair, with both supports; empty where nothing can be said."""
    head = ["source_shape", "target_shape", "source", "target", "score", *(f"support_{kind}" for kind in KINDS), "id"]
    rows = []
    for row, ((a, b), result) in enumerate(zip(found.pairs, found.results, strict=True)):
        supports = [found.supports[kind][row] for kind in KINDS]
        for k, m in enumerate(result.matches()):
            left, right = (";".join(str(record.segments[i]) for i in segments) for record, segments in
                           ((result.source, m.source), (result.target, m.target)))  # fmt: skip
            rows.append([safe_cell(found.names[a]), safe_cell(found.names[b]), safe_cell(left), safe_cell(right),
                         f"{m.score:.6f}", *(_cell(values[k]) for values in supports), m.id])  # fmt: skip
    return _csv(head, rows)


def parts_csv(found: CollectionResult) -> str:
    """One line a segment: its shape, its label, its part (empty for none) and its share of the shape's area."""
    rows = []
    for name, shape, part, area in zip(found.names, found.shapes, found.parts, found.areas, strict=True):
        for label, own, share in zip(shape.segmentation.names, part, area / max(area.sum(), 1e-300), strict=True):
            rows.append([safe_cell(name), safe_cell(str(label)), "" if own < 0 else str(own), f"{share:.6f}"])
    return _csv(["shape", "segment", "part", "share"], rows)


def _csv(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return text.getvalue()


def _cell(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.6f}"


def _value(value: float) -> float | None:
    return None if math.isnan(value) else round(value, 6)


def _or_null(part: np.ndarray) -> list[int | None]:
    return [None if own < 0 else own for own in part.tolist()]
