"""Of joins that are said to be right with probability p, how many are: the reliability table of assembled pictures.

    python tests/benchmarks/puzzle_reliability.py FOLDER [--seed S] [--turned]

Every picture is cut into 28 px squares and solved, once as it is and once worn in one of six ways.
"""

import argparse
import itertools
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from engine.puzzles.cutting import cut
from engine.puzzles.imagefile import opaque, read_image
from engine.puzzles.parameters import PuzzleParameters
from engine.puzzles.scoring import right_joins
from engine.puzzles.solving import solve
from engine.puzzles.wearing import WEAR, worn

EDGES = (0.0, 0.1, 0.3, 0.5, 0.7, 0.85, 0.95, 0.99, 1.01)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, default=8)
    parser.add_argument("--turned", action="store_true")
    options = parser.parse_args()
    said, right = [], []
    files = sorted(p for p in options.folder.iterdir() if p.suffix.lower() in (".png", ".jpg"))
    for number, path in enumerate(files):
        whole = cut(opaque(read_image(path)), piece_size=28, seed=options.seed, turned=options.turned)
        for puzzle, truth in (whole, worn(*whole, list(WEAR)[number % len(WEAR)], number)):
            solution = solve(puzzle, PuzzleParameters())
            said.append(solution.joins.confidence)
            right.append(right_joins(puzzle, truth, solution))
    p, y = np.concatenate(said), np.concatenate(right)
    print(f"{2 * len(files)} puzzles, {len(p)} joins\n{'said':>12} {'mean':>6} {'right':>6} {'joins':>7}")
    for low, high in itertools.pairwise(EDGES):
        here = (p >= low) & (p < high)
        if here.any():
            print(f"{low:.2f} - {min(high, 1):.2f}  {p[here].mean():6.3f} {y[here].mean():6.3f} {here.sum():7d}")


if __name__ == "__main__":
    main()
