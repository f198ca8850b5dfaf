"""A small world drawn by hand: two shapes of three parts, results whose matches are known by name."""

import contextlib
import hashlib
import sqlite3
from pathlib import Path

import numpy as np

from annotation.storage import schema
from annotation.study import StudyHandle, add_result, create_study
from engine.shapes.identity import match_id
from engine.shapes.parameters import MatchParameters
from engine.shapes.result import MatchResult, ShapeRecord

LAMP = ShapeRecord("lamp.off", "a" * 64, ("foot", "stem", "shade"), 30)
VASE = ShapeRecord("vase.off", "b" * 64, (4, 7, 9), 40)
CANDLE = ShapeRecord("candle.off", "c" * 64, (0, 1, 2), 20)


def node(shape: ShapeRecord, segments: tuple[int, ...]) -> str:
    return hashlib.sha256(f"{shape.sha256}{sorted(segments)}".encode()).hexdigest()


def identity(source: ShapeRecord, one: tuple[int, ...], target: ShapeRecord, other: tuple[int, ...]) -> str:
    return match_id(node(source, one), node(target, other))


def result(
    *matches: tuple[tuple[int, ...], tuple[int, ...]],
    source: ShapeRecord = LAMP,
    target: ShapeRecord = VASE,
    preset: str = "top-down",
    seconds: float = 1.0,
    **parameters: object,
) -> MatchResult:
    """A result whose matches unite the given rows of segments, best first."""
    count = len(matches)
    members = [np.zeros((count, len(shape.segments)), bool) for shape in (source, target)]
    for row, sides in enumerate(matches):
        for side, segments in enumerate(sides):
            members[side][row, list(segments)] = True
    chosen = MatchParameters().changed(**{"method": "top-down", **parameters})
    zeros = np.zeros(count, int)
    return MatchResult(
        chosen.method, preset, chosen, source, target, np.zeros((count, 2), int), np.linspace(1, 0.5, count),
        np.full(count, 0.5), zeros, members[0], members[1], zeros, zeros,
        tuple(identity(source, one, target, other) for one, other in matches), 3, 3, {"voting": seconds},
    )  # fmt: skip


ONE_TO_ONE = (((0,), (0,)), ((1,), (1,)), ((2,), (2,)))


def study_of(path: Path | str, *results: MatchResult, set_name: str = "") -> StudyHandle:
    handle = create_study(path, name="Lamps", seed="seed")
    for one in results or (result(*ONE_TO_ONE),):
        add_result(handle, one, set_name=set_name)
    return handle


def forged(path: Path, *statements: str, values: tuple[object, ...] = ()) -> None:
    """Change a closed study file behind the program's back; its rules are as before afterwards."""
    with contextlib.closing(sqlite3.connect(path)) as raw:
        for rule in schema.SQLITE_TRIGGERS:
            raw.execute(f"DROP TRIGGER {rule.split()[2]}")
        for statement in statements:
            raw.execute(statement, values)
        for rule in schema.SQLITE_TRIGGERS:
            raw.execute(rule)
        raw.commit()
