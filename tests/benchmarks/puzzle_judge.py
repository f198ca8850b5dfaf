"""How well the judge, which sees no truth, chooses among assemblers: beside counting best buddies, and beside the truth.

    python tests/benchmarks/puzzle_judge.py FOLDER [--measures mgc pt ...] [--limit N] [--seed S]

Single measures are used, for which assemblers differ. Prints the mean direct and neighbour scores of every assembler, of
the choice by the judge, of the choice by the number of best buddies that touch, and of the choice by the truth.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from engine.puzzles.assembly import best_buddies
from engine.puzzles.cutting import cut
from engine.puzzles.gridwishes import PreparedGrid
from engine.puzzles.imagefile import read_image
from engine.puzzles.parameters import PuzzleParameters
from engine.puzzles.scoring import score
from engine.puzzles.solution import PuzzleSolution
from engine.puzzles.solving import assemble, prepare

METHODS = ("mst", "greedy", "loops", "lp")


def buddies(prepared: PreparedGrid, solution: PuzzleSolution) -> int:
    """How many touching pairs are best buddies by the measure."""
    found = prepared.candidates
    chosen = found.pairs[best_buddies(-prepared.value, found)]
    sides = 4 * solution.joins.sides[:, [0, 2]] + solution.joins.sides[:, [1, 3]]
    known = {tuple(row) for row in chosen.tolist()}
    return sum(tuple(sorted(row)) in known for row in sides.tolist())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--measures", nargs="+", default=["mgc", "pt", "ssd-lab"])
    parser.add_argument("--limit", type=int, default=None)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    rows: dict[str, list[tuple[float, float]]] = {}
    for path in sorted(p for p in options.folder.iterdir() if p.suffix in (".png", ".jpg"))[: options.limit]:
        puzzle, truth = cut(np.ascontiguousarray(read_image(path)[..., :3]), piece_size=28, seed=options.seed)
        for measure in options.measures:
            values = PuzzleParameters(measure=measure)
            prepared = prepare(puzzle, values)
            made = {m: assemble(prepared, values.changed(method=m)) for m in METHODS}
            right = {m: score(puzzle, truth, s) for m, s in made.items()}
            chosen = {
                **{m: m for m in METHODS},
                "judge": max(METHODS, key=lambda m: made[m].judge[m]),
                "best buddies": max(METHODS, key=lambda m: buddies(prepared, made[m])),
                "truth": max(METHODS, key=lambda m: (right[m].neighbour, right[m].direct)),
            }
            for name, method in chosen.items():
                rows.setdefault(name, []).append((right[method].direct, right[method].neighbour))
    print(f"{len(rows['truth'])} puzzles   direct  neighbour")
    for name, values in rows.items():
        direct, neighbour = np.mean(values, axis=0)
        print(f"{name:<14} {100 * direct:6.2f} {100 * neighbour:9.2f}")


if __name__ == "__main__":
    main()
