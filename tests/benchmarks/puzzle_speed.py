"""How long puzzles of squares take, and how many times faster comparing is than a plain loop over pairs beside it.

    python tests/benchmarks/puzzle_speed.py [--picture FILE] [--pieces 432 3300 22755] [--repeat 3]

Without a picture, a painted landscape is used. Each puzzle is cut to about 4:3 with 28 px pieces, shuffled, solved in this
process (loops compiled before), and scored.
"""

import argparse
import resource
import sys
import time
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[2]))

from engine.puzzles.cutting import cut
from engine.puzzles.imagefile import read_image
from engine.puzzles.measures import Strips, dissimilarity, gradient_statistics, side_strips
from engine.puzzles.parameters import PuzzleParameters
from engine.puzzles.pieces import LEFT, RIGHT
from engine.puzzles.scenery import landscape
from engine.puzzles.scoring import score
from engine.puzzles.solving import assemble, prepare

PX = 28


def resized(picture: np.ndarray, pieces: int) -> np.ndarray:
    """The picture scaled to cover about 4:3 of `pieces` squares of 28 px, its centre cropped."""
    columns = max(2, round((pieces * 4 / 3) ** 0.5))
    rows = max(2, round(pieces / columns))
    w, h = columns * PX, rows * PX
    scale = max(w / picture.shape[1], h / picture.shape[0])
    size = max(w, round(picture.shape[1] * scale)), max(h, round(picture.shape[0] * scale))
    large = np.asarray(Image.fromarray(picture).resize(size, Image.Resampling.LANCZOS if scale > 1 else Image.Resampling.BOX))
    y, x = (large.shape[0] - h) // 2, (large.shape[1] - w) // 2
    return np.ascontiguousarray(large[y : y + h, x : x + w])


def plain_mgc(strips: Strips, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """MGC (root) by a loop over pairs of sides, each pair with array arithmetic: what a first version would do."""
    mean, inverse = gradient_statistics(strips)
    result = np.empty((len(rows), len(columns)))
    for i, r in enumerate(rows):
        for j, c in enumerate(columns):
            step = strips.outer[c][::-1].astype(np.float64) - strips.outer[r]
            there, back = step - mean[r], -step - mean[c]
            result[i, j] = (np.sqrt(((there @ inverse[r]) * there).sum(1)) + np.sqrt(((back @ inverse[c]) * back).sum(1))).sum()
    return result


def compared(picture: np.ndarray) -> None:
    puzzle, _ = cut(resized(picture, 432), piece_size=PX, seed=1)
    strips, n = side_strips(puzzle.rasters()), puzzle.count
    rows, columns = 4 * np.arange(n) + RIGHT, 4 * np.arange(n) + LEFT
    began = time.perf_counter()
    plain = plain_mgc(strips, rows[:64], columns)
    loop = (time.perf_counter() - began) * n / 64
    dissimilarity("mgc-root", strips, rows[:2], columns[:2])  # compiles, if nothing has before
    began = time.perf_counter()
    fast = dissimilarity("mgc-root", strips, rows, columns)
    dense = time.perf_counter() - began
    assert np.allclose(plain, fast[:64], rtol=1e-6)
    print(f"MGC of all {n} × {n} pairs of one kind: loop over pairs {loop:.2f} s (64 rows timed), ours {dense:.3f} s, "
          f"{loop / dense:.0f} times faster")  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--picture", type=Path)
    parser.add_argument("--pieces", type=int, nargs="+", default=[432, 3300, 22755])
    parser.add_argument("--repeat", type=int, default=3)
    options = parser.parse_args()
    picture = np.ascontiguousarray(read_image(options.picture)[..., :3]) if options.picture else landscape(1344, 1008)
    compared(picture)
    for pieces in options.pieces:
        for turned in (False, True) if pieces < 5000 else (False,):
            puzzle, truth = cut(resized(picture, pieces), piece_size=PX, seed=1, turned=turned)
            best = (np.inf, 0.0, 0.0)
            for _ in range(options.repeat if pieces < 5000 else 1):
                began = time.perf_counter()
                prepared = prepare(puzzle, PuzzleParameters())
                middle = time.perf_counter()
                solution = assemble(prepared, PuzzleParameters())
                end = time.perf_counter()
                best = min(best, (end - began, middle - began, end - middle))
            found = score(puzzle, truth, solution)
            memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
            print(f"{puzzle.count} pieces{' turned' if turned else ''}: {best[0]:.2f} s (joins {best[1]:.2f}, assembly "
                  f"{best[2]:.2f}), direct {found.direct:.4f}, neighbour {found.neighbour:.4f}, peak {memory:.1f} GiB")  # fmt: skip


if __name__ == "__main__":
    main()
