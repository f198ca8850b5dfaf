"""The report of a solved puzzle: one HTML page with the pieces, the picture, its joins and how sure they are."""

import base64
import io
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from .parameters import declared
from .puzzles.parameters import PuzzleParameters
from .puzzles.pieces import Puzzle
from .puzzles.rendering import SCALE, assembled, close_up, marked, sheet, thumbnail, typical_side
from .puzzles.scoring import Scores
from .puzzles.solution import PuzzleSolution
from .puzzles.solutionfile import side_name
from .report import html_table, page

LISTED = 60  # the most doubtful joins that the page lists; joins.csv has all
SHOWN = 12  # the most doubtful joins that it shows close by
LONGEST = 1600  # pixels of a picture in the page
BINS = np.array([0.0, 0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0])


def puzzle_report(
    puzzle: Puzzle, solution: PuzzleSolution, *, scores: Scores | None = None, right: np.ndarray | None = None,
    right_joins: np.ndarray | None = None, source: Mapping[str, Any] | None = None,
) -> str:  # fmt: skip
    """The page. Where the truth is known, `right` (n,) bool says which pieces lie right, `right_joins` (j,) which joins.

    `right` serves the marks, and had better allow for one shift of the whole picture.
    """
    sections = [
        _pictures(puzzle, solution, right), _scores(scores), _reliability(solution, right_joins),
        _doubtful(puzzle, solution, right_joins), _unplaced(puzzle, solution), _pieces(puzzle), _judge(solution),
        _notes([*puzzle.notes, *solution.notes]), _source(source or {}), _parameters(solution.parameters), _seconds(solution),
    ]  # fmt: skip
    return page(puzzle.name, _lead(puzzle, solution), sections)


def _lead(puzzle: Puzzle, solution: PuzzleSolution) -> str:
    placed = int(solution.placed.sum())
    pictures = f" in {len(solution.sizes)} pictures" if len(solution.sizes) > 1 else ""
    return (
        f"{placed} of {puzzle.count} pieces placed{pictures}, {len(solution.joins)} joins, by {solution.method} on the "
        f"measure {solution.measure}, in {sum(solution.seconds.values()):.2f} s"
    )


def figure(title: str, pixels: np.ndarray, note: str = "") -> str:
    """An image in the page, scaled down where it is large, with a caption in plain text; `note` is safe HTML."""
    from PIL import Image

    buffer = io.BytesIO()
    if pixels.shape[2] == 3 and pixels.size > 1_000_000:
        Image.fromarray(pixels).save(buffer, "JPEG", quality=92, subsampling=0)
    else:
        Image.fromarray(pixels).save(buffer, "PNG")
    kind = "jpeg" if buffer.getvalue()[:2] == b"\xff\xd8" else "png"
    data = base64.b64encode(buffer.getvalue()).decode()
    return (
        f'<figure><img alt="{escape(title)}" src="data:image/{kind};base64,{data}">'
        f"<figcaption>{escape(title)}{note}</figcaption></figure>"
    )


def _pictures(puzzle: Puzzle, solution: PuzzleSolution, right: np.ndarray | None) -> str:
    parts = []
    for k in range(len(solution.sizes)):
        number = f" {k + 1}" if len(solution.sizes) > 1 else ""
        canvas = assembled(puzzle, solution, k)
        parts.append(figure(f"The assembled picture{number}", thumbnail(canvas, longest=LONGEST)))
        scale = min(1.0, LONGEST / max(canvas.shape[:2]))
        shown = thumbnail(marked(canvas, puzzle, solution, picture=k, right=right), longest=LONGEST)
        words = f"Its joins{number}, coloured by confidence"
        wrong = 0 if right is None else int((~right & (solution.picture == k)).sum())
        if right is not None:
            words += f"; the {wrong} wrongly placed pieces are hatched" if wrong else "; every piece is placed rightly"
        if typical_side(puzzle) * scale >= 6:
            parts.append(figure(words, shown, _legend()))
    return "".join(parts)


def _legend() -> str:
    stops = ", ".join(f"rgb({r:.0f} {g:.0f} {b:.0f})" for r, g, b in SCALE)
    bar = f'<span style="display:inline-block;width:9rem;height:.6rem;border-radius:3px;background:linear-gradient(90deg,{stops})"></span>'
    return f"<br>doubtful 0 {bar} 1 certain"


def _scores(scores: Scores | None) -> str:
    if scores is None:
        return ""
    rows = [
        ("pieces at their true place (direct)", _percent(scores.direct), _percent(scores.direct_tie_aware)),
        ("true neighbours kept (neighbour)", _percent(scores.neighbour), _percent(scores.neighbour_tie_aware)),
        ("pieces in the largest correct group", _percent(scores.largest_component), ""),
        ("perfect", "yes" if scores.perfect else "no", "yes" if scores.perfect_tie_aware else "no"),
    ]
    head = ("against the truth", "strict", "identical pieces taken for equal")
    return f"<h2>Scores</h2>{html_table(head, rows, [False, True, True])}"


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %"


def reliability(confidence: np.ndarray, right: np.ndarray | None) -> list[tuple[str, int, float, float | None]]:
    """For each range of confidence that occurs: its name, how many joins (j,), their mean confidence, the share right."""
    which = np.clip(np.searchsorted(BINS, confidence, side="right") - 1, 0, len(BINS) - 2)
    rows = []
    for k in range(len(BINS) - 1)[::-1]:
        inside = which == k
        if inside.any():
            share = None if right is None else float(right[inside].mean())
            name = f"{BINS[k]:.2g} to {BINS[k + 1]:.2g}"
            rows.append((name, int(inside.sum()), float(confidence[inside].mean()), share))
    return rows


def _reliability(solution: PuzzleSolution, right: np.ndarray | None) -> str:
    if not len(solution.joins):
        return ""
    table = reliability(solution.joins.confidence, right)
    head = ["confidence", "joins", "mean confidence", *(["share right"] if right is not None else [])]
    rows = [(name, count, f"{mean:.3f}", *([f"{share:.3f}"] if share is not None else [])) for name, count, mean, share in table]
    words = "<p>Of joins at confidence .9, nine in ten should be right.</p>" if right is not None else ""
    return f"<h2>How sure the joins are</h2>{words}{html_table(head, rows, [False] + [True] * (len(head) - 1))}"


def _doubtful(puzzle: Puzzle, solution: PuzzleSolution, right: np.ndarray | None) -> str:
    joins = solution.joins
    if not len(joins):
        return ""
    rows = []
    for k in np.argsort(joins.confidence, kind="stable")[:LISTED]:
        a, side_a, b, side_b = joins.sides[k].tolist()
        truth = () if right is None else ("right" if right[k] else "wrong",)
        rows.append((puzzle.pieces[a].name or a, side_name(puzzle, a, side_a), puzzle.pieces[b].name or b,
                     side_name(puzzle, b, side_b), f"{joins.confidence[k]:.3f}", joins.confirmed_by[k], *truth))  # fmt: skip
    head = ["piece", "side", "piece", "side", "confidence", "confirmed by", *(["truth"] if right is not None else [])]
    table = html_table(head, rows, [False] * 4 + [True] + [False] * (len(head) - 5))
    words = f"The {len(rows)} most doubtful of {len(joins)} joins" if len(rows) < len(joins) else f"All {len(joins)} joins, doubtful first"
    near = [k for k in np.argsort(joins.confidence, kind="stable")[:SHOWN] if joins.confidence[k] < 0.9]
    cards = "".join(_card(puzzle, solution, int(k), right) for k in near)
    cards = f'<div style="display:flex;flex-wrap:wrap;gap:0 1.2rem">{cards}</div>' if cards else "<p>No join is doubtful.</p>"
    return f"<h2>The most doubtful joins</h2>{cards}<details><summary>{words}</summary>{table}</details>"


def _card(puzzle: Puzzle, solution: PuzzleSolution, join: int, right: np.ndarray | None) -> str:
    """One join close by, with the names of its pieces and sides."""
    a, side_a, b, side_b = solution.joins.sides[join].tolist()
    ends = [f"{puzzle.pieces[i].name or i} {side_name(puzzle, i, side)}" for i, side in ((a, side_a), (b, side_b))]
    truth = "" if right is None else (", right" if right[join] else ", wrong")
    words = f"{solution.joins.confidence[join]:.2f}{truth}"
    return figure(words, close_up(puzzle, solution, join), f"<br>{escape(ends[0])}<br>{escape(ends[1])}")


def _unplaced(puzzle: Puzzle, solution: PuzzleSolution) -> str:
    left = np.flatnonzero(~solution.placed)
    if not len(left):
        return ""
    rows = [(puzzle.pieces[i].name or i, solution.why_unplaced.get(int(i), "")) for i in left]
    return f"<h2>Pieces that were not placed</h2>{html_table(('piece', 'why'), rows)}"


def _pieces(puzzle: Puzzle) -> str:
    words = f"The {puzzle.count} pieces as they were read"
    return f"<h2>Pieces</h2>{figure(words, sheet(puzzle))}"


def _judge(solution: PuzzleSolution) -> str:
    if len(solution.judge) < 2:
        return ""
    rows = [(name, f"{value:.4g}", "taken" if name == solution.method else "") for name, value in solution.judge.items()]
    return f"<h2>What the judge gave each assembler</h2>{html_table(('assembler', 'worth', ''), rows, [False, True, False])}"


def _notes(notes: Sequence[str]) -> str:
    items = "".join(f"<li>{escape(note)}</li>" for note in notes)
    return f"<h2>Notes</h2><ul>{items}</ul>" if items else ""


def _source(source: Mapping[str, Any]) -> str:
    if not source:
        return ""
    rows = [(key, _files(value) if key == "files" else value) for key, value in source.items() if value is not None]
    return f"<h2>Input</h2>{html_table(('', ''), rows)}"


def _files(files: Sequence[Mapping[str, str]]) -> str:
    named = "; ".join(f"{file['name']} ({file['sha256'][:12]})" for file in files[:5])
    return named + (f"; and {len(files) - 5} more" if len(files) > 5 else "")


def _parameters(parameters: PuzzleParameters) -> str:
    changed = parameters.differences(PuzzleParameters())
    rows = [
        (info.group, info.name + ("*" if info.name in changed else ""), info.symbol, getattr(parameters, info.name),
         info.unit, info.doc)
        for info in declared(PuzzleParameters) if not info.methods or parameters.method in info.methods
    ]  # fmt: skip
    table = html_table(("step", "parameter", "symbol", "value", "unit", "meaning"), rows)
    star = "<p>* differs from the default</p>" if changed else ""
    return f"<h2>Parameters</h2>{table}{star}"


def _seconds(solution: PuzzleSolution) -> str:
    rows = [(step, f"{value:.3f}") for step, value in solution.seconds.items()]
    return f"<h2>Seconds by step</h2>{html_table(('step', 'seconds'), rows, [False, True])}"
