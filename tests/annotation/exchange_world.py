"""A small study that can be handed out: strips of triangles as shapes, kept in the study, and matches between them."""

import sqlite3
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from sqlalchemy import insert

from annotation import study
from annotation.records import Item, Proposal, Run
from annotation.results.proposals import shape_item
from annotation.storage import schema
from annotation.storage.blobs import keep_shapes
from engine.shapes.identity import match_id, mesh_id, node_id, segment_ids
from engine.shapes.mesh import Mesh
from engine.shapes.segmentation import Segmentation, SegmentedShape

PARTS = 6
TABLES = ("study", "item", "run", "run_match", "volunteer", "asked", "assignment", "blob", "forgotten", "event")


def strip(seed: int, labels: Sequence[int] | None = None, names: Sequence[int | str] | None = None) -> SegmentedShape:
    """A strip of 2 · PARTS triangles, two a segment."""
    vertices = np.random.default_rng(seed).normal(size=(2 * PARTS + 2, 3))
    faces = [(k, k + 1, k + 2) for k in range(2 * PARTS)]
    chosen = np.repeat(np.arange(PARTS), 2) if labels is None else np.asarray(labels)
    known = tuple(range(int(chosen.max()) + 1)) if names is None else tuple(names)
    return SegmentedShape(Mesh(vertices, faces, f"strip {seed}"), Segmentation(chosen, known))


def union(shape: SegmentedShape, segments: Sequence[int]) -> str:
    ids = segment_ids(shape.mesh, shape.segmentation)
    return node_id(ids[k] for k in segments)


def record(shape: SegmentedShape, file: str) -> dict[str, Any]:
    whole = node_id(segment_ids(shape.mesh, shape.segmentation))
    return {"file": file, "sha256": mesh_id(shape.mesh), "segments": PARTS, "faces": 2 * PARTS, "segmentation": whole}


def match(a: SegmentedShape, one: Sequence[int], b: SegmentedShape, other: Sequence[int], files=("a.off", "b.off")) -> Item:
    """The item of a match of rows of segments."""
    sides = []
    for shape, rows, file in ((a, one, files[0]), (b, other, files[1])):
        names = [shape.segmentation.names[k] for k in rows]
        sides.append(record(shape, file) | {"segments": names})
        del sides[-1]["faces"]
    return shape_item(match_id(union(a, one), union(b, other)), *sides)


def run_of(a: SegmentedShape, b: SegmentedShape, items: Sequence[Item], files=("a.off", "b.off"), **more: Any) -> Run:
    values = {"kind": "shape", "method": "shed", "preset": "plain", "parameters": {"K": 9}, "set_name": "strips",
              "source": record(a, files[0]), "target": record(b, files[1]), "seconds": {"voting": 1.0}} | more  # fmt: skip
    return Run(**values, proposals=tuple(Proposal(item, 1 / (k + 1), k, 1, 1) for k, item in enumerate(items)))


def ask(handle: study.StudyHandle, roles: dict[str, str], *, answer: str = "correct", reason: str = "", stratum: str = "",
        at: str = "2026-05-01T10:00:00.000000+00:00") -> None:  # fmt: skip
    """Ask about items in these roles."""
    rows = [
        {"item_id": item, "role": role, "answer": None if role == "judged" else answer, "reason": reason, "stratum": stratum,
         "probability": 0.5 if role == "judged" else None, "overlapped": 0, "added_at": at}
        for item, role in roles.items()
    ]  # fmt: skip
    with handle.writing() as connection:
        connection.execute(insert(schema.asked), rows)


def diagonal(a: SegmentedShape, b: SegmentedShape, count: int = PARTS, files=("a.off", "b.off")) -> list[Item]:
    """Matches of single segments, those that lie alike first."""
    pairs = sorted(((i, j) for i in range(PARTS) for j in range(PARTS)), key=lambda p: ((p[0] - p[1]) % PARTS, p))
    return [match(a, (i,), b, (j,), files) for i, j in pairs[:count]]


def strip_study(path: Path, count: int = PARTS, *, kept: bool = True, files=("a.off", "b.off"), **more: Any) -> study.StudyHandle:
    """A study of matches between two strips; nothing is designed."""
    a, b = strip(1), strip(2)
    handle = study.create_study(path, name="Strips", seed="seed", **more)
    study.add_run(handle, run_of(a, b, diagonal(a, b, count, files), files))
    if kept:
        keep_shapes(handle, (a, b))
    return handle


def ids_of(handle: study.StudyHandle) -> list[str]:
    return sorted(item.id for item in study.items(handle, "nobody"))


def content(path: Path) -> dict[str, list]:
    """Every row of every table, of the votes that count and of what is open, in a fixed order."""
    with closing(sqlite3.connect(path)) as raw:
        views = (*TABLES, "current_vote", "open_item")
        return {table: sorted(raw.execute(f"SELECT * FROM {table}").fetchall(), key=repr) for table in views}


def cells(path: Path) -> str:
    """All texts and numbers of a file, in one."""
    with closing(sqlite3.connect(path)) as raw:
        return "\n".join(repr(row) for table in TABLES if table != "blob" for row in raw.execute(f"SELECT * FROM {table}"))
