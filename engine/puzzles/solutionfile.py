"""`solution.json` (schema concord.solution/1) and `joins.csv`: solutions that other programs read, and read back."""

import csv
import io
import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import BadInput, BadParameter
from ..parameters import checked
from ..spreadsheet import safe_cell
from ..store import write_together
from .identity import puzzle_id, reading_id
from .imagefile import png_bytes
from .parameters import PuzzleParameters
from .pieces import SIDE_NAMES, Puzzle
from .rendering import assembled
from .scoring import Scores
from .solution import UNPLACED, Joins, PuzzleSolution

SCHEMA = "concord.solution/1"


def solution_to_json(
    puzzle: Puzzle, solution: PuzzleSolution, *, scores: Scores | None = None, source: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """The solution as the JSON object of schema concord.solution/1.

    Pieces are numbered from 0 in the order of `names`. `x`, `y` are the top-left pixel of the turned piece in the
    assembled picture `picture`; sides count clockwise from the topmost, leftmost corner of a piece as it was read
    (squares: 0 top, 1 right, 2 bottom, 3 left). In a join, `dx`, `dy`, `quarter_turns` say how b lies to a while a
    stands as it was read. `source` says what the puzzle was made of, so that the run can be repeated; `pieces_sha256` is
    the hash of the pieces in their order and turn, `puzzle_sha256` of the pieces in any.
    """
    where, order = solution.picture, np.flatnonzero(solution.placed)
    return {
        "schema": SCHEMA,
        "puzzle": puzzle.name,
        "source": dict(source or {}),
        "puzzle_sha256": puzzle_id(puzzle),
        "pieces_sha256": reading_id(puzzle),
        "pieces": puzzle.count,
        "pictures": [{"width": int(w), "height": int(h)} for w, h in solution.sizes],
        "placed": [
            {"piece": int(i), "x": int(solution.position[i, 0]), "y": int(solution.position[i, 1]),
             "quarter_turns": int(solution.turns[i]), "picture": int(where[i])} for i in order
        ],
        "unplaced": [int(i) for i in np.flatnonzero(where == UNPLACED)],
        "why_unplaced": {str(i): words for i, words in sorted(solution.why_unplaced.items())},
        "joins": joins_to_json(solution.joins),
        "scores": None if scores is None else {k: _rounded(v) for k, v in asdict(scores).items()},
        "method": solution.method,
        "measure": solution.measure,
        "parameters": solution.parameters.model_dump(),
        "seconds": {step: round(value, 4) for step, value in solution.seconds.items()},
        "judge": {name: _rounded(value) for name, value in solution.judge.items()},
        "notes": list(solution.notes),
        "names": [piece.name for piece in puzzle.pieces],
    }  # fmt: skip


def _rounded(value: float | bool) -> float | bool:
    return value if isinstance(value, bool) else round(float(value), 6)


def joins_to_json(joins: Joins) -> list[dict[str, Any]]:
    """Joins as JSON objects."""
    rows = zip(joins.sides.tolist(), joins.offset.tolist(), joins.turn.tolist(), joins.confidence.tolist(),
               joins.confirmed_by, strict=True)  # fmt: skip
    return [
        {"a": a, "side_a": side_a, "b": b, "side_b": side_b, "confidence": round(confidence, 6), "confirmed_by": by,
         "dx": dx, "dy": dy, "quarter_turns": turn}
        for (a, side_a, b, side_b), (dx, dy), turn, confidence, by in rows
    ]  # fmt: skip


def joins_to_csv(puzzle: Puzzle, joins: Joins, right: np.ndarray | None = None) -> str:
    """One line a join, the surest first; `right` (j,) bool adds whether it is true, where the truth is known."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    head = ["a", "side_a", "b", "side_b", "confidence", "confirmed_by", "name_a", "name_b"]
    writer.writerow(head if right is None else [*head, "right"])
    for k in np.argsort(-joins.confidence, kind="stable"):
        a, side_a, b, side_b = joins.sides[k].tolist()
        names = (safe_cell(_one_line(puzzle.pieces[i].name)) for i in (a, b))
        row = [a, side_name(puzzle, a, side_a), b, side_name(puzzle, b, side_b), f"{joins.confidence[k]:.6f}",
               safe_cell(joins.confirmed_by[k]), *names]  # fmt: skip
        writer.writerow(row if right is None else [*row, "yes" if right[k] else "no"])
    return text.getvalue()


def _one_line(text: str) -> str:
    return " ".join(text.split())


def side_name(puzzle: Puzzle, piece: int, side: int) -> str:
    """A side for people: top, right, bottom, left of an upright rectangle, else its number."""
    return SIDE_NAMES[side] if puzzle.pieces[piece].mask.all() and side < 4 else str(side)


def write_solution(
    folder: Path | str, puzzle: Puzzle, solution: PuzzleSolution, *, scores: Scores | None = None,
    source: Mapping[str, Any] | None = None, right: np.ndarray | None = None, report: str = "",
) -> list[Path]:  # fmt: skip
    """Write `solution.json`, `joins.csv`, `assembled.png` and, where given, `report.html`, all or none.

    Further pictures are `assembled-2.png` and so on. The folder exists. Returns the paths; raises `BadInput`.
    """
    folder = Path(folder)
    written = solution_to_json(puzzle, solution, scores=scores, source=source)
    contents: dict[Path, bytes | str] = {
        folder / "solution.json": compact(written),
        folder / "joins.csv": joins_to_csv(puzzle, solution.joins, right),
    }
    for k in range(len(solution.sizes)):
        name = "assembled.png" if k == 0 else f"assembled-{k + 1}.png"
        contents[folder / name] = png_bytes(assembled(puzzle, solution, k))
    if report:
        contents[folder / "report.html"] = report
    write_together(contents)
    return list(contents)


def compact(content: Mapping[str, Any]) -> str:
    """A JSON object with one line for each entry of its lists of objects, so that people can read it too."""
    lines = []
    for key, value in content.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            inner = ",\n  ".join(json.dumps(entry, ensure_ascii=False) for entry in value)
            lines.append(f" {json.dumps(key)}: [\n  {inner}\n ]")
        else:
            lines.append(f" {json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


def read_solution(path: Path | str) -> PuzzleSolution:
    """A solution that was written; raises `BadInput` where the file is not one."""
    content = read_json(Path(path), SCHEMA, "solution")
    try:
        return _solution(content)
    except (KeyError, TypeError, ValueError, OverflowError, BadInput, BadParameter):
        raise BadInput(f"The solution {path} is damaged; solve the puzzle again to write a new one.") from None


def read_json(path: Path, schema: str, what: str) -> dict[str, Any]:
    """A JSON object of the given schema, or `BadInput` in one sentence."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput(f"The {what} {path} cannot be read ({error.strerror}); check the name.") from None
    except (ValueError, RecursionError):
        raise BadInput(f"{path} is not JSON; give a {what} of schema {schema}.") from None
    if not isinstance(content, dict) or content.get("schema") != schema:
        raise BadInput(f"{path} is not a {what} of schema {schema}; give another file.")
    return content


def _solution(content: Mapping[str, Any]) -> PuzzleSolution:
    n = whole_number(content["pieces"])
    sizes = [(whole_number(p["width"]), whole_number(p["height"])) for p in content["pictures"]]
    if not 0 < n < 10**7 or any(w < 0 or h < 0 or w * h > 10**10 for w, h in sizes):
        raise ValueError
    picture, position, turns = np.full(n, UNPLACED), np.zeros((n, 2), dtype=np.int64), np.zeros(n, dtype=np.int64)
    for placed in content["placed"]:
        i, k = whole_number(placed["piece"]), whole_number(placed.get("picture", 0))
        if not (0 <= i < n and picture[i] == UNPLACED and 0 <= k < len(sizes)):
            raise ValueError
        picture[i], turns[i] = k, whole_number(placed["quarter_turns"]) % 4
        position[i] = whole_number(placed["x"]), whole_number(placed["y"])
    joins = joins_from_json(content["joins"])
    if len(joins) and not 0 <= joins.sides[:, ::2].min() <= joins.sides[:, ::2].max() < n:
        raise ValueError
    return PuzzleSolution(
        str(content["puzzle"]), picture, position, turns, np.array(sizes).reshape(-1, 2), joins, str(content["method"]),
        str(content["measure"]), checked(PuzzleParameters, _object(content["parameters"])),
        {str(k): float(v) for k, v in _object(content["seconds"]).items()},
        {str(k): float(v) for k, v in _object(content.get("judge", {})).items()},
        {int(k): str(v) for k, v in _object(content.get("why_unplaced", {})).items()},
        tuple(map(str, content.get("notes", ()))))  # fmt: skip


def _object(value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ValueError(f"{value!r} is not an object")
    return value


def whole_number(value: Any) -> int:
    """A whole number as JSON has it, or a `ValueError`."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or value != int(value) or abs(value) > 2**31:
        raise ValueError(f"{value!r} is not a whole number")
    return int(value)


def joins_from_json(rows: list[Mapping[str, Any]]) -> Joins:
    """Joins from JSON objects; raises what a damaged object raises."""
    numbers = [[whole_number(row[key]) for key in ("a", "side_a", "b", "side_b", "dx", "dy", "quarter_turns")] for row in rows]
    table = np.array(numbers, dtype=np.int64).reshape(-1, 7)
    confidence = np.array([float(row.get("confidence", 1.0)) for row in rows])
    by = tuple(str(row.get("confirmed_by", "")) for row in rows)
    return Joins(table[:, :4], table[:, 4:6], table[:, 6] % 4, confidence, by)
