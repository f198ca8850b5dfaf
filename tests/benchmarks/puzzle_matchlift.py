"""How long MatchLift and diffusion pruning take, against plain ways run beside them.

    python tests/benchmarks/puzzle_matchlift.py [--quick]

Prints, for synthetic objects with known truth and for the corners of a drawn picture, the seconds of: the loop that
follows the positive eigenpairs in single precision; the same loop with a full double-precision decomposition in every
step; and, for corners, independent parts of at most sixty corners. Then diffusion pruning against a plain loop over all
pairs of correspondences. With every ratio stand the largest difference of the answers, and precision and recall.
"""

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "engine"))

from test_matchlift import cycles
from test_puzzle_confirming import all_rows, picture, truly

from engine.consistency.matchlift import matchlift
from engine.puzzles.confirming import confirm_matchlift
from engine.puzzles.corners import corner_matrix, corner_similarity, join_confidence, universe_of, unlike_corners
from engine.puzzles.cutting import cut
from engine.puzzles.halves import half_dissimilarity
from engine.puzzles.measures import side_strips
from engine.puzzles.pruning import correspondences, prune

LOOP = {"sparsity": 0.1, "penalty": 4.0, "tolerance": 1e-3, "max_steps": 300}
PRUNE = {"knn": 2, "t_1": 0.1, "t_2": 0.7, "t_3": 0.3, "iterations": 1}


def timed(action: Callable[[], object]) -> tuple[float, object]:
    """Seconds of one run, and what it returned."""
    start = time.perf_counter()
    result = action()
    return time.perf_counter() - start, result


def synthetic(count: int, size: int) -> None:
    """Objects that all see the same elements, a third of their matches shuffled; forty steps either way."""
    similarity, objects, _ = cycles(count, size, wrong=0.3, seen=0.99)
    how = LOOP | {"max_steps": 40}
    fast, followed = timed(lambda: matchlift(similarity, objects, universe=size, **how))
    slow, dense = timed(lambda: matchlift(similarity, objects, universe=size, follow=False, **how))
    print(f"{count:>4} objects of {size} elements, order {len(objects):>4}: followed {fast:7.2f} s, dense {slow:7.2f} s, "
          f"ratio {slow / fast:5.1f}; largest difference {np.abs(followed.matches - dense.matches).max():.4f}")  # fmt: skip


def corners(columns: int, rows_: int, *, dense: bool) -> None:
    """The corners of a drawn picture: known grid at once, dense and followed; and in parts without a bound."""
    made, truth = cut(picture(28 * columns, 28 * rows_, seed=7), piece_size=28, seed=0)
    n = made.count
    strips = side_strips(made.rasters())
    rows = all_rows(n)
    right = truly(rows, truth.position // 28)
    halves = half_dissimilarity("mgc-root", strips, rows)
    universe, kind = universe_of(columns, rows_), unlike_corners(n, turned=False)[1]
    matrix = corner_matrix(rows, corner_similarity(rows, halves), n, t_1=0.6)

    def lift(follow: bool) -> np.ndarray:
        found = matchlift(matrix, np.arange(4 * n) // 4, universe=universe, impossible=kind[:, None] == kind, follow=follow, **LOOP)
        return join_confidence(rows, found.matches).min(axis=1)

    def report(name: str, seconds: float, confidence: np.ndarray) -> None:
        kept = confidence >= 0.5
        print(f"{n:>5} pieces, {name:<32}{seconds:8.2f} s   precision {right[kept].mean():.4f} recall {kept[right].mean():.4f}", flush=True)

    seconds, confidence = timed(lambda: lift(True))
    report("followed, order " + str(4 * n + 1), seconds, confidence)
    if dense:
        slow, exact = timed(lambda: lift(False))
        report("dense", slow, exact)
        print(f"{'':>5} ratio {slow / seconds:.1f}, largest difference of a join's confidence {np.abs(exact - confidence).max():.4f}")
    fast, parts = timed(lambda: confirm_matchlift(rows, halves, count=n, t_1=0.6, t_2=0.5, at_once=0, **LOOP).confidence)
    report("in parts", fast, parts)
    print(f"{'':>5} ratio to followed {seconds / fast:.1f}, joins decided otherwise {((parts >= 0.5) != (confidence >= 0.5)).sum()}")


def plain_degrees(rows: np.ndarray, halves: np.ndarray) -> np.ndarray:
    """Row sums of M by a loop over all pairs of correspondences of valid ones, as the thesis writes it."""
    sim, valid = correspondences(rows, halves, knn=PRUNE["knn"], t_1=PRUNE["t_1"])
    join, s = np.repeat(np.arange(len(rows)), 4)[valid.ravel()], sim.ravel()[valid.ravel()]
    degree = np.zeros(len(s))
    for a in range(len(s)):
        for b in range(len(s)):
            if a == b:
                degree[a] += 1
            elif join[a] == join[b]:
                m = min(s[a] / s[b], s[b] / s[a]) / min(s[a], s[b])
                degree[a] += m if m >= PRUNE["t_2"] else 0
    return degree


def pruning(columns: int, rows_: int) -> None:
    """One round of diffusion pruning against the plain loop for its affinity alone."""
    made, _ = cut(picture(28 * columns, 28 * rows_, seed=7), piece_size=28, seed=0)
    rows = all_rows(made.count)
    halves = half_dissimilarity("mgc-root", side_strips(made.rasters()), rows)
    prune(rows, halves, **PRUNE)
    fast, _ = timed(lambda: prune(rows, halves, **PRUNE))
    slow, _ = timed(lambda: plain_degrees(rows, halves))
    print(f"{made.count:>5} pieces, one round of pruning {fast:.3f} s; plain affinity alone {slow:.2f} s, ratio {slow / fast:.0f}")


def main() -> None:
    """Print everything; `--quick` leaves out what takes minutes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    quick = parser.parse_args().quick
    matchlift(*cycles(4, 3, wrong=0.0)[:2], universe=3, **LOOP)  # compile first
    synthetic(60, 7)
    synthetic(100, 8)
    if not quick:
        synthetic(150, 10)
    corners(10, 10, dense=True)
    corners(14, 14, dense=not quick)
    if not quick:
        corners(24, 18, dense=True)
    pruning(8, 6)
    if not quick:
        pruning(16, 12)


if __name__ == "__main__":
    main()
