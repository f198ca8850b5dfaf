"""How often the 95 % intervals of study tables hold the truth: `python tests/benchmarks/study_coverage.py [TRIALS]`.

Also at a share of .95, where a few pairs that are wrong as a whole can be missed by any sample: there it is lower.
"""

import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).parents[2]), str(Path(__file__).parents[1] / "annotation")]

from coverage_world import PAIRS, SHARES, cells  # noqa: E402


def main() -> None:
    """Print the coverage and mean width for each number of pairs, then of every cell."""
    trials = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    found = list(cells(trials, shares=(*SHARES, 0.95)))
    for sampled in (False, True):
        for pairs in PAIRS:
            mine = [c for c in found if (c.sampled, c.pairs) == (sampled, pairs)]
            usual = [c.coverage for c in mine if c.share in SHARES]
            hard = [c.coverage for c in mine if c.share not in SHARES]
            print(f"{'sampled' if sampled else 'whole  '} {pairs:3d} pairs: {np.mean(usual):.3f} ({min(usual):.3f} – {max(usual):.3f}); "
                  f"at a share of .95: {np.mean(hard):.3f} ({min(hard):.3f} – {max(hard):.3f})")  # fmt: skip
    print("sampled pairs size correlation share coverage width")
    for c in found:
        print(f"{c.sampled:d} {c.pairs:3d} {c.size:3d} {c.correlation:.1f} {c.share:.2f} {c.coverage:.3f} {c.width:.2f}")


if __name__ == "__main__":
    main()
