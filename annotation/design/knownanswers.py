"""Known answers, for gold and practice items: from a table, from somebody's votes, or from a truth that came along."""

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from engine.errors import BadInput
from engine.progress import Progress, silent

from ..records import Practice, Run
from ..results.resultfiles import ResultFile
from ..storage.blobs import shape_key
from ..storage.handle import StudyHandle
from ..voting.answering import current_votes, known_volunteer, majority
from ..voting.majority import Answer
from .sampling import Known

if TYPE_CHECKING:
    from engine.puzzles.pieces import Puzzle, Truth
    from engine.puzzles.solution import Joins
    from engine.shapes.segmentation import SegmentedShape

CLEAR = 0.9  # of the area of both sides must be of the same classes where a match is known to be right, of others where wrong
ANSWERS: Mapping[str, Answer] = {"correct": "correct", "wrong": "wrong"}
_RIGHT = "The two parts are of the same kind."
_WRONG = "The two parts are of different kinds."
_JOINED = "The two pieces lie side by side like this in the picture."
_APART = "The two pieces do not lie side by side like this in the picture."


def read_known(path: Path | str) -> dict[str, Practice]:
    """The answers of a CSV table with the columns item, answer (correct or wrong) and, if wanted, reason.

    Raises `BadInput`, with the line, for anything else.
    """
    try:
        rows = list(csv.reader(io.StringIO(Path(path).read_text(encoding="utf-8-sig"))))
    except OSError as error:
        raise BadInput(f"{path} cannot be read ({error.strerror}); give a CSV table of known answers.") from None
    except (UnicodeDecodeError, csv.Error):
        raise BadInput(f"{path} is no CSV table in UTF-8; give one with the columns item, answer, reason.") from None
    head = [cell.strip().lower() for cell in rows[0]] if rows else []
    if "item" not in head or "answer" not in head:
        raise BadInput(f"{path} has no columns item and answer in its first line; name them there.")
    found: dict[str, Practice] = {}
    for line, cells in enumerate(rows[1:], start=2):
        if any(cell.strip() for cell in cells):
            item, known = _known_row(dict(zip(head, cells, strict=False)), f"{path}, line {line}")
            if found.setdefault(item, known).answer != known.answer:
                raise BadInput(f"{path}, line {line}: {item} is called correct and wrong; leave one of the two.")
    return found


def _known_row(cells: Mapping[str, str], where: str) -> tuple[str, Practice]:
    item, given, reason = (cells.get(name, "").strip() for name in ("item", "answer", "reason"))
    answer = ANSWERS.get(given.lower())
    if not item or answer is None:
        raise BadInput(f"{where}: an item with the answer correct or wrong is needed, not {item!r} with {given!r}.")
    escaped = reason[:1] == "'" and reason[1:2] in tuple("=+-@")  # as tables for spreadsheets are written
    return item, Practice(answer, reason[1:] if escaped else reason)


def known_by_votes(handle: StudyHandle, code: str = "") -> dict[str, Practice]:
    """The answers that a volunteer of a study gave, with the comments as reasons; those of the majority without a code.

    'unsure' and ties are no known answers. Raises `BadInput` for a code that the study does not have.
    """
    if code:
        votes = current_votes(handle, volunteer=known_volunteer(handle, code).code)
        return {v.item_id: Practice(v.answer, v.comment) for v in votes if v.answer in ANSWERS}
    verdicts = {item: ANSWERS.get(said.verdict) for item, said in majority(handle).items()}
    return {item: Practice(answer, "") for item, answer in verdicts.items() if answer is not None}


def known_by_truth(
    files: Sequence[ResultFile],
    runs: Sequence[Run],
    shapes: Mapping[str, "SegmentedShape"],
    *,
    progress: Progress = silent,
) -> dict[str, Practice]:
    """The answers that labels of classes (.sem files beside meshes) and the pictures of cut puzzles tell.

    Of shapes only what is clear: `CLEAR` of the area of the same classes, or of others. `shapes` are those of the
    results by key, as `annotation.results.resultfiles.find_shapes` gives them. Results without a truth tell nothing.
    """
    found: dict[str, Practice] = {}
    for number, (file, run) in enumerate(zip(files, runs, strict=True)):
        progress(number / len(files), f"truth of {file.path.name}")
        found |= _by_classes(run, shapes) if run.kind == "shape" else _by_picture(file.path)
    return found


def _by_classes(run: Run, shapes: Mapping[str, "SegmentedShape"]) -> dict[str, Practice]:
    """What the classes of every face tell of a run's matches."""
    from engine.shapes.truth import class_overlap

    sides: list[list[Any]] = [[p.item.payload[name] for p in run.proposals] for name in ("source", "target")]
    found: dict[str, Practice] = {}
    pairs: dict[tuple[str, str], list[int]] = {}
    for row, (one, other) in enumerate(zip(*sides, strict=True)):
        pairs.setdefault((shape_key(one), shape_key(other)), []).append(row)
    for keys, rows in pairs.items():
        labelled = [(shapes[key], _classes(shapes[key])) for key in keys if key in shapes]
        both = [(shape, label) for shape, label in labelled if label is not None]
        if len(both) < 2:
            continue
        (a, a_label), (b, b_label) = both
        members = tuple(_members(shape, [side[row]["segments"] for row in rows]) for shape, side in zip((a, b), sides, strict=True))
        overlap = class_overlap((a, b), (a_label, b_label), (members[0], members[1]))
        for row, share in zip(rows, overlap.tolist(), strict=True):
            if share >= CLEAR:
                found[run.proposals[row].item.id] = Practice("correct", _RIGHT)
            elif share <= 1 - CLEAR:
                found[run.proposals[row].item.id] = Practice("wrong", _WRONG)
    return found


def _classes(shape: "SegmentedShape") -> np.ndarray | None:
    """The class of every face, (m,), where a file of them lies beside the mesh and fits it."""
    from engine.shapes.meshfile import read_labels

    path = Path(shape.file).with_suffix(".sem")
    labels = read_labels(path) if path.is_file() else None
    return labels if labels is not None and len(labels) == len(shape.mesh.faces) else None


def _members(shape: "SegmentedShape", unions: Sequence[Sequence[int | str]]) -> np.ndarray:
    """Which segments each union of labels has, (p, s) bool."""
    rows = {name: row for row, name in enumerate(shape.segmentation.names)}
    found = np.zeros((len(unions), len(rows)), bool)
    for number, union in enumerate(unions):
        found[number, [rows[name] for name in union if name in rows]] = True
    return found


def _by_picture(path: Path) -> dict[str, Practice]:
    """What the picture that the pieces were cut from tells of a solution's joins; nothing of photographed pieces."""
    from engine.puzzles.reopening import reopen

    puzzle, truth, solution, _ = reopen(path)
    return known_by_picture(puzzle, truth, solution.joins) if truth is not None else {}


def known_by_picture(puzzle: "Puzzle", truth: "Truth", joins: "Joins") -> dict[str, Practice]:
    """What the picture that the pieces were cut from tells of joins (j,)."""
    from ..results.puzzlejoins import join_ids, truth_answers

    right = truth_answers(puzzle, truth, joins)
    answers = (Practice("correct", _JOINED) if true else Practice("wrong", _APART) for true in right)
    return dict(zip(join_ids(puzzle, joins), answers, strict=True))


def merged(*known: Known) -> dict[str, Practice]:
    """All of them; where they differ, the first that is named."""
    found: dict[str, Practice] = {}
    for one in known:
        found = {**one, **found}
    return found
