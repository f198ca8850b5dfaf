"""Joins of a puzzle's solution as items of a study: what two pieces look like together, and nothing of who proposed it."""

import base64
from collections.abc import Mapping
from typing import Any

import numpy as np

from engine.puzzles.identity import join_frame, join_ids, join_views, piece_ids, puzzle_id, standing_ids
from engine.puzzles.imagefile import png_bytes
from engine.puzzles.pieces import Puzzle, Truth
from engine.puzzles.scoring import TOLERANCE
from engine.puzzles.solution import Joins, PuzzleSolution
from engine.puzzles.turning import turned_raster

from ..records import Item, Proposal, Run
from ..storage.handle import StudyHandle
from .proposals import add_run, distinct

LONGEST = 160  # pixels of a stored join along its longer side; larger ones are reduced by a whole number

_NEAR = [(x, y) for x in (0, -1, 1) for y in (0, -1, 1) if x * x + y * y <= TOLERANCE**2]

__all__ = [
    "LONGEST", "add_solution", "join_ids", "join_items", "piece_ids", "puzzle_id", "solution_items", "solution_run",
    "truth_answers",
]  # fmt: skip


def add_solution(
    handle: StudyHandle, puzzle: Puzzle, solution: PuzzleSolution, *, set_name: str = "", guided: bool = False
) -> str:
    """Register a solution and its joins in a study, and return the id of the run (see `add_run`).

    `guided` says that people's wishes were honoured; such a run is counted apart from what the method finds alone.
    """
    return add_run(handle, solution_run(puzzle, solution, set_name, guided=guided))


def solution_run(puzzle: Puzzle, solution: PuzzleSolution, set_name: str = "", *, guided: bool = False) -> Run:
    """The run that a solution stands for: its joins as proposals, the surest first, scored by their confidence.

    The method is the one that was asked for ("auto" stays so, whatever it chose), and the measure stands where shapes
    have their preset, so that a table has a row for each. A join confirmed by a person makes a run guided.
    """
    joins, items = solution.joins, solution_items(puzzle, solution)
    surest = np.argsort(-joins.confidence, kind="stable").tolist()
    proposals = (
        Proposal(items[row], float(joins.confidence[row]), int(bool(joins.confirmed_by[row]))) for row in surest
    )
    told = guided or "person" in joins.confirmed_by
    return Run(
        "puzzle", solution.parameters.method + (" (guided)" if told else ""), solution.measure, solution.parameters.model_dump(),
        set_name, {"file": puzzle.name, "sha256": puzzle_id(puzzle), "pieces": puzzle.count}, {}, solution.seconds,
        distinct(proposals),
    )  # fmt: skip


def solution_items(puzzle: Puzzle, solution: PuzzleSolution) -> tuple[Item, ...]:
    """The item of each of a solution's joins (j,), shown as it lies in the assembled picture."""
    return join_items(puzzle, solution.joins, solution.turns[solution.joins.sides[:, 0]])


def join_items(puzzle: Puzzle, joins: Joins, turns: np.ndarray | None = None) -> tuple[Item, ...]:
    """The item of each join (j,): the same whichever piece is named first, and for pieces that look the same.

    `turns` (j,) are the clockwise quarter turns after which piece a is shown, none if left out. The payload of an item
    is `{"size": [w, h], "pieces": [{"piece", "x", "y", "png"}, …]}`, its two pieces in reading order, "png" an image in
    base 64, positions and size in its pixels; `LONGEST` bounds them.
    """
    shown: dict[tuple[int, int], str] = {}
    upright = np.zeros(len(joins), int) if turns is None else turns
    ids, payloads = join_ids(puzzle, joins), (_payload(puzzle, joins, k, int(t), shown) for k, t in enumerate(upright))
    return tuple(Item(found, "puzzle", payload) for found, payload in zip(ids, payloads, strict=True))


def truth_answers(puzzle: Puzzle, truth: Truth, joins: Joins) -> tuple[bool, ...]:
    """Whether each join (j,) looks like one of the true picture.

    Where equal pieces are exchanged it is still right, and polygons may be off by `engine.puzzles.scoring.TOLERANCE`.
    """
    ids, names = standing_ids(puzzle), join_ids(puzzle, joins)
    standing = [pieces[turn] for pieces, turn in zip(ids, truth.turns.tolist(), strict=True)]
    places = list(zip(truth.picture.tolist(), *truth.position.T.tolist(), strict=True))
    found, alike = set(zip(standing, places, strict=True)), _places_of(standing, places)
    known: dict[str, bool] = {}
    for row, join in enumerate(names):
        if join not in known:
            known[join] = any(
                (b, (picture, x + dx + ex, y + dy + ey)) in found
                for a, b, (dx, dy) in join_views(puzzle, joins, row)
                for picture, x, y in alike.get(a, ())
                for ex, ey in _NEAR
            )
    return tuple(known[join] for join in names)


def _places_of(standing: list[str], places: list[tuple[int, int, int]]) -> dict[str, list[tuple[int, int, int]]]:
    """The true places (picture, x, y) of all pieces that look the same as they stand."""
    found: dict[str, list[tuple[int, int, int]]] = {}
    for look, place in zip(standing, places, strict=True):
        found.setdefault(look, []).append(place)
    return found


def _payload(
    puzzle: Puzzle, joins: Joins, row: int, turns: int, shown: dict[tuple[int, int], str]
) -> Mapping[str, Any]:
    """What a volunteer sees of a join; `shown` keeps the pictures of pieces that are not reduced."""
    (w, h), turned, corners = join_frame(puzzle, joins, row, turns)
    by = -(-max(w, h) // LONGEST)
    sides = [
        _side(puzzle, piece, quarters, at, by, shown)
        for piece, quarters, at in zip(joins.sides[row, ::2].tolist(), turned, corners, strict=True)
    ]
    return {"size": [-(-w // by), -(-h // by)], "pieces": sorted(sides, key=lambda s: (s["y"], s["x"], s["piece"]))}


def _side(
    puzzle: Puzzle, piece: int, turns: int, at: tuple[int, int], by: int, shown: dict[tuple[int, int], str]
) -> dict[str, Any]:
    """One piece of a join: its hash, its picture and where that stands."""
    png = shown.get((piece, turns)) if by == 1 else None
    if png is None:
        png = base64.b64encode(png_bytes(_reduced(_pixels(puzzle, piece, turns), at, by))).decode()
        if by == 1:
            shown[piece, turns] = png
    return {"piece": min(standing_ids(puzzle)[piece]), "x": at[0] // by, "y": at[1] // by, "png": png}


def _pixels(puzzle: Puzzle, piece: int, turns: int) -> np.ndarray:
    """A piece after quarter turns as (h, w, 4) uint8, nothing outside its mask; without alpha where all is inside."""
    image, mask = puzzle.pieces[piece].image, puzzle.pieces[piece].mask
    rgba = np.dstack((np.where(mask[..., None], image, 0), np.where(mask, 255, 0)))
    return turned_raster((image if mask.all() else rgba).astype(np.uint8), turns)


def _reduced(pixels: np.ndarray, at: tuple[int, int], by: int) -> np.ndarray:
    """The means of blocks of `by` × `by` pixels of the common grid in which the piece stands at `at`.

    A block belongs to the piece if that has half of it or more. At the sides of its raster the piece is continued to
    whole blocks, so that two pieces that touch still do.
    """
    if by == 1:
        return pixels
    h, w = pixels.shape[:2]
    alpha = pixels[..., 3] > 0 if pixels.shape[2] == 4 else np.ones((h, w), bool)
    weighed = np.dstack((pixels[..., :3] * alpha[..., None], alpha)).astype(np.float64)
    before_x, before_y = at[0] % by, at[1] % by
    around = (before_y, -(before_y + h) % by), (before_x, -(before_x + w) % by), (0, 0)
    padded = np.pad(weighed, around, mode="edge")
    rows, columns = padded.shape[0] // by, padded.shape[1] // by
    total = padded.reshape(rows, by, columns, by, 4).sum(axis=(1, 3))
    colour = total[..., :3] / np.maximum(total[..., 3:], 1)
    inside = 2 * total[..., 3] >= by * by
    inside = inside if inside.any() else total[..., 3] > 0
    return np.round(np.dstack((colour * inside[..., None], inside * 255.0))).astype(np.uint8)
