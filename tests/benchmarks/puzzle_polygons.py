"""Puzzles of polygons: pieces placed right on real pictures, and the fit of the numbers behind the probabilities.

    python tests/benchmarks/puzzle_polygons.py FOLDER [--images 5] [--seeds 1] [--no-frame] [--rotate] [--measure M]
    python tests/benchmarks/puzzle_polygons.py fit FOLDER FOLDER ...

The first prints, for each kind of cut, the share of pieces at their true place up to one shift of the whole, the share
of true places that show the right pixels whichever pieces lie there, and the seconds. The second fits logistic models
to all pictures of the folders and writes engine/puzzles/polygonmodels.json.
"""

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from engine.puzzles.alignments import alignments, contest_features, with_slid
from engine.puzzles.clusters import Layout
from engine.puzzles.contacts import FEATURES, WITHIN, all_odds
from engine.puzzles.cutting import cut
from engine.puzzles.imagefile import opaque, read_image
from engine.puzzles.parameters import MEASURES, PuzzleParameters
from engine.puzzles.pieces import Puzzle, Truth
from engine.puzzles.placedjoins import touching_sides
from engine.puzzles.polygonmodels import FILE, _numbers, triangle
from engine.puzzles.polygons import assemble_polygons, ground_for, prepare_polygons
from engine.puzzles.scoring import right_places, score
from engine.puzzles.solution import UNPLACED, PuzzleSolution

CUTS = {
    "rectangles 50": {"kind": "rectangles", "pieces": 50},
    "rectangles 150": {"kind": "rectangles", "pieces": 150},
    "merged 84 px": {"kind": "merged", "piece_size": 84},
    "merged 42 px": {"kind": "merged", "piece_size": 42},
    "triangles 84 px": {"kind": "triangles", "piece_size": 84},
    "triangles 42 px": {"kind": "triangles", "piece_size": 42},
}
FITTED_TO = [
    {"kind": "rectangles", "pieces": 25}, {"kind": "rectangles", "pieces": 50}, {"kind": "rectangles", "pieces": 100},
    {"kind": "merged", "piece_size": 42}, {"kind": "triangles", "piece_size": 42}, {"kind": "triangles", "piece_size": 64},
]  # fmt: skip
HARD = [
    {"kind": "rectangles", "pieces": 200},
    {"kind": "merged", "piece_size": 24},
    {"kind": "triangles", "piece_size": 28},
]


def pictures(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if path.suffix.lower() in (".png", ".jpg", ".jpeg"))


def shown(puzzle: Puzzle, truth: Truth, solution: PuzzleSolution) -> float:
    """The share of pieces whose true place shows the right pixels, whichever pieces lie there (no quarter turns)."""
    right = right_places(puzzle, truth, solution)
    on = np.flatnonzero(right) if right.any() else np.arange(1)
    x, y = (truth.position[on[0]] - solution.position[on[0]]).tolist()
    w, h = truth.sizes[0]
    canvas = np.full((h, w, 3), -1, dtype=np.int64)
    for i in np.flatnonzero(solution.picture == 0):
        paste(canvas, puzzle, i, solution.position[i] + (x, y))
    true = np.full((h, w, 3), -1, dtype=np.int64)
    good = 0
    for i in range(puzzle.count):
        paste(true, puzzle, i, truth.position[i])
        (u, v), mask = truth.position[i], puzzle.pieces[i].mask
        place = np.s_[v : v + mask.shape[0], u : u + mask.shape[1]]
        good += bool((canvas[place][mask] == true[place][mask]).all())
    return good / puzzle.count


def paste(canvas: np.ndarray, puzzle: Puzzle, i: int, place: np.ndarray) -> None:
    mask, (x, y) = puzzle.pieces[i].mask, place.tolist()
    h, w = mask.shape
    if x >= 0 and y >= 0 and x + w <= canvas.shape[1] and y + h <= canvas.shape[0]:
        canvas[y : y + h, x : x + w][mask] = puzzle.pieces[i].image[mask]


def measured(puzzle: Puzzle, truth: Truth, parameters: PuzzleParameters) -> tuple[float, float, float, float]:
    """Share placed right up to a shift, share that shows the right pixels, seconds of the slow and of the fast part."""
    began = time.perf_counter()
    prepared = prepare_polygons(puzzle, parameters)
    middle = time.perf_counter()
    solution = assemble_polygons(prepared, parameters)
    ended = time.perf_counter()
    free = replace(puzzle, frame=None)
    alike = shown(free, truth, solution) if not puzzle.turned else float("nan")
    return score(free, truth, solution).direct, alike, middle - began, ended - middle


def table(arguments: argparse.Namespace) -> None:
    parameters = PuzzleParameters(measure=arguments.measure, hypotheses=arguments.hypotheses)
    for name, how in CUTS.items():
        if arguments.only not in name:
            continue
        rows = []
        for path in pictures(arguments.folder)[: arguments.images]:
            for seed in range(arguments.seeds):
                image = opaque(read_image(path))
                puzzle, truth = cut(image, seed=seed, turned=arguments.rotate, **how)
                if arguments.no_frame:
                    puzzle = replace(puzzle, frame=None)
                rows.append(measured(puzzle, truth, parameters))
        right, alike, slow, fast = np.mean(rows, axis=0)
        print(f"{name:16} {puzzle.count:4} pieces: {right:.3f} right, {alike:.3f} by pixels, {slow:.2f} + {fast:.2f} s, "
              f"single: {' '.join(f'{row[0]:.2f}' for row in rows)}", flush=True)  # fmt: skip


# --- fitting -----------------------------------------------------------------------------------------------------------


def logistic(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, float]:
    """Weights of a logistic model (a column of ones in x), and its loss for each true row."""
    from scipy.optimize import minimize

    mean, scale = x.mean(axis=0), np.maximum(x.std(axis=0), 1e-9)
    mean[0], scale[0] = 0, 1
    z = (x - mean) / scale

    def loss(w):
        t = z @ w
        p = 1 / (1 + np.exp(-np.clip(t, -40, 40)))
        return (np.logaddexp(0, t) - y * t).sum() + 1e-3 * (w[1:] ** 2).sum(), z.T @ (p - y) + 2e-3 * np.r_[0, w[1:]]

    found = minimize(loss, np.zeros(x.shape[1]), jac=True, method="L-BFGS-B", options={"maxiter": 1000, "maxfun": 3000})
    w = found.x / scale
    w[0] -= (found.x * mean / scale)[1:].sum()
    return w, found.fun / y.sum()


def squares_of(features: np.ndarray) -> np.ndarray:
    """The columns of a quadratic form in (1, z)."""
    z = np.column_stack([np.ones(len(features)), features])
    i, j = np.triu_indices(z.shape[1])
    return z[:, i] * z[:, j]


def true_pairs(truth: Truth, piece: np.ndarray, side: np.ndarray, offset: np.ndarray) -> np.ndarray:
    a, b = piece[side].T
    return (truth.position[b] - truth.position[a] == offset).all(axis=1)


def reliability(x: np.ndarray, w: np.ndarray, y: np.ndarray) -> str:
    p = 1 / (1 + np.exp(-x @ w))
    bins = [(p >= low) & (p < low + 0.1) for low in np.arange(0, 1, 0.1)]
    return " ".join(f"{p[b].mean():.2f}→{y[b].mean():.2f}({b.sum()})" for b in bins if b.any())


def fit(arguments: argparse.Namespace) -> None:
    puzzles = []
    for folder in arguments.folders:
        for number, path in enumerate(pictures(folder)[: arguments.images]):
            for step in range(2):  # two of the cuts for each picture
                how = FITTED_TO[(2 * number + step) % len(FITTED_TO)]
                puzzles.append(cut(opaque(read_image(path)), seed=1000 + number, **how))
    print(len(puzzles), "puzzles")
    numbers = json.loads(FILE.read_text(encoding="utf-8")) if FILE.is_file() else {}
    for measure in [arguments.measure] if arguments.measure else MEASURES:
        if not arguments.placed:
            numbers[measure] = fitted(measure, puzzles)
        FILE.write_text(json.dumps(numbers, separators=(",", ":")) + "\n", encoding="utf-8")
        _numbers.cache_clear()
        numbers[measure]["placed"] = fitted_placed(measure, hard_puzzles(arguments))
        FILE.write_text(json.dumps(numbers, separators=(",", ":")) + "\n", encoding="utf-8")
        _numbers.cache_clear()


def hard_puzzles(arguments: argparse.Namespace) -> list[tuple[Puzzle, Truth]]:
    """Small pieces, every other picture: layouts without mistakes cannot tell how sure a join is."""
    made = []
    for folder in arguments.folders:
        for number, path in enumerate(pictures(folder)[: arguments.images : 2]):
            image = opaque(read_image(path))[:400, :400]
            puzzle, truth = cut(image, seed=2000 + number, **HARD[number % len(HARD)])
            made.append((replace(puzzle, frame=None), truth))
    return made


def fitted(measure: str, puzzles: list[tuple[Puzzle, Truth]]) -> dict[str, list[float]]:
    k = FEATURES if measure == "learned" else WITHIN
    found = []
    for puzzle, truth in puzzles:
        sides, ground = ground_for(puzzle, measure, np.zeros((k + 1, k + 1)))
        a = alignments(ground, sides.piece, features=k, turned=False)
        found.append((a, true_pairs(truth, sides.piece, a.side, a.offset), ground, sides, truth))
    y = np.concatenate([row[1] for row in found]).astype(float)
    form, loss = logistic(squares_of(np.concatenate([row[0].feature for row in found])), y)
    form = np.array([float(f"{v:.6g}") for v in form])
    print(f"{measure}: {len(y)} candidates, {int(y.sum())} true, loss per true one {loss:.3f}")
    xs, ys = [], []
    for a, _, ground, sides, truth in found:
        a, odds, edge = with_slid(ground._replace(form=triangle(form)), a, all_odds(triangle(form), a.feature))
        xs.append(contest_features(a, odds, edge, len(sides)))
        ys.append(true_pairs(truth, sides.piece, a.side, a.offset))
    x, t = np.concatenate(xs), np.concatenate(ys).astype(float)
    contest, loss = logistic(x, t)
    print(f"  with rivals: loss {loss:.3f}; {reliability(x, contest, t)}", flush=True)
    base = float(np.log(y.sum() / (len(y) - y.sum())))
    return {"form": list(form), "contest": [float(f"{v:.6g}") for v in contest],
            "placed": [0.0, 1.0, 0.0, 0.0, 0.0], "base": [round(base, 4)]}  # fmt: skip


def fitted_placed(measure: str, puzzles: list[tuple[Puzzle, Truth]]) -> list[float]:
    parameters, xs, ys = PuzzleParameters(measure=measure, hypotheses=0), [], []
    for puzzle, truth in puzzles:
        prepared = prepare_polygons(puzzle, parameters)
        solution = assemble_polygons(prepared, parameters)
        picture = np.where(solution.picture == UNPLACED, -1 - np.arange(puzzle.count), solution.picture)
        layout = Layout(picture, solution.position.copy(), solution.turns.copy())
        sides, _, _, offset, seen = touching_sides(
            prepared.ground, layout, prepared.candidates, prepared.odds, prepared.model.base
        )
        xs.append(seen)
        ys.append(true_pairs(truth, prepared.sides.piece, sides, offset))
    x, y = np.concatenate(xs), np.concatenate(ys).astype(float)
    weights, loss = logistic(x, y)
    print(f"  placed: {len(y)} joins, {y.mean():.3f} true, loss {loss:.3f}; {reliability(x, weights, y)}", flush=True)
    return [float(f"{v:.6g}") for v in weights]


def main() -> None:
    import sys

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    if sys.argv[1:2] == ["fit"]:
        parser.add_argument("command")
        parser.add_argument("folders", type=Path, nargs="+")
        parser.add_argument("--measure", default="", help="only this one; all if empty")
        parser.add_argument("--placed", action="store_true", help="only what the assembled neighbours say")
        parser.add_argument("--images", type=int, default=1000, help="at most so many of each folder")
        fit(parser.parse_args())
        return
    parser.add_argument("folder", type=Path)
    parser.add_argument("--images", type=int, default=5)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--no-frame", action="store_true")
    parser.add_argument("--rotate", action="store_true")
    parser.add_argument("--measure", default="learned")
    parser.add_argument("--hypotheses", type=int, default=PuzzleParameters().hypotheses)
    parser.add_argument("--only", default="", help="only the cuts whose name contains this")
    table(parser.parse_args())


if __name__ == "__main__":
    main()
