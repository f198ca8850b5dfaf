"""A small study to vote on: unions of two bars, joins of a puzzle, practice and gold, and words that nobody may see."""

import numpy as np
from puzzle_world import cut_up, joins_of, solved, touching
from PySide6.QtWidgets import QApplication
from sqlalchemy import insert

from annotation import study
from annotation.records import Proposal, Run
from annotation.results.proposals import add_run
from annotation.results.puzzlejoins import add_solution
from annotation.storage import schema
from annotation.storage.blobs import keep_shapes
from annotation.storage.stamps import now
from engine.shapes.identity import match_id, mesh_id, node_id, segment_ids
from engine.shapes.mesh import Mesh
from engine.shapes.segmentation import SegmentedShape

SECRETS = {
    "method": "zq-method", "preset": "zq-preset", "parameter": "zq-parameter", "set": "zq-set", "file": "zq-file",
    "other": "zq-other", "comment": "zq-comment", "stratum": "zq-stratum", "score": "0.8712345",
}  # fmt: skip
REASON = "Both are the left end."


def sides(shape, segments, name=""):
    ids = segment_ids(shape.mesh, shape.segmentation)
    side = {"file": name, "sha256": mesh_id(shape.mesh), "segmentation": node_id(ids), "segments": list(segments)}
    return side, node_id(ids[k] for k in segments)


def match_items(a, b, pairs, name=""):
    """One item for each pair of unions."""
    found = []
    for left, right in pairs:
        (one, i), (two, j) = sides(a, left, name), sides(b, right, name)
        found.append(study.shape_item(match_id(i, j), one, two))
    return found


def two_bars(make_bar, name="bar"):
    a = make_bar(4, name)
    b = SegmentedShape(Mesh(make_bar(3).mesh.vertices * [1.0, 1.3, 1.0], make_bar(3).mesh.faces, name), make_bar(3).segmentation)
    return a, b


def make_study(path, make_bar, *, practice=2, gold=1, joins=2, secrets=SECRETS, blobs=True, **options):
    """A study of eight matches and some joins, its first matches to practise on, the next gold; the items' ids by role."""
    a, b = two_bars(make_bar, secrets["file"])
    pairs = [((i,), (j,)) for i in range(4) for j in range(2)]
    items = match_items(a, b, pairs, f"/{secrets['file']}/{secrets['file']}.off")
    with study.create_study(path, name="Bars", seed="7", guideline="Ends go with ends.", **options) as handle:
        for item in items:
            inputs = [{**item.payload[side], "segments": 4, "faces": 9} for side in ("source", "target")]
            add_run(handle, Run("shape", secrets["method"], secrets["preset"], {secrets["parameter"]: 1}, secrets["set"],
                                *inputs, {}, (Proposal(item, float(secrets["score"]), 3),)))  # fmt: skip
        if blobs:
            keep_shapes(handle, (a, b))
        puzzle, truth = cut_up()
        if joins:
            add_solution(handle, puzzle, solved(puzzle, truth, joins_of(truth, touching(truth)[:joins])), set_name=secrets["set"])
        roles = {item.id: "practice" if k < practice else "gold" if k < practice + gold else "judged"
                 for k, item in enumerate(items)}  # fmt: skip
        if practice or gold:
            put_roles(handle, roles, secrets["stratum"])
        study.record_vote(handle, items[-1].id, secrets["other"], "wrong", comment=secrets["comment"])
    return {role: [i for i, r in roles.items() if r == role] for role in ("practice", "gold", "judged")}


def put_roles(handle, roles, stratum=""):
    """Write what is asked, and why; items without a role are judged."""
    with handle.writing() as connection:
        ids = connection.scalars(schema.item.select().with_only_columns(schema.item.c.id)).all()
        rows = [{"item_id": i, "role": roles.get(i, "judged"), "answer": None if roles.get(i, "judged") == "judged" else "correct",
                 "reason": REASON if roles.get(i) == "practice" else "", "stratum": stratum, "probability": 0.5,
                 "overlapped": 0, "added_at": now()} for i in ids]  # fmt: skip
        connection.execute(insert(schema.asked), rows)


def settle(qtbot, desk):
    """Until nothing is read or written and all signals have come."""
    qtbot.waitUntil(lambda: not desk.busy, timeout=20_000)
    QApplication.processEvents()
    qtbot.waitUntil(lambda: not desk.busy, timeout=20_000)


def same(one, two):
    return np.allclose(one, two, atol=1e-6)
