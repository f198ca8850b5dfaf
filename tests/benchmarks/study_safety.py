"""Kills processes at work on a study with kill -9, and counts the confirmed votes that are gone or belong elsewhere.

    python tests/benchmarks/study_safety.py [--trials 200] [--seed 1]

The trials are spread evenly over voting, merging, migrating and backing up.
"""

import argparse
import random
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "annotation"))

from killing import Outcome, kill_backing_up, kill_merging, kill_migrating, kill_voting

WORK: dict[str, Callable[[Path, random.Random], Outcome]] = {
    "voting": kill_voting, "merging": kill_merging, "migrating": kill_migrating, "backing up": kill_backing_up,
}  # fmt: skip


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args(arguments)
    each, bad, began = -(-chosen.trials // len(WORK)), 0, time.monotonic()
    print(f"{'killed while':14}{'trials':>8}{'in the middle':>15}{'confirmed votes':>17}{'lost':>6}{'mis-attached':>14}{'damaged':>9}")
    for name, kill in WORK.items():
        outcomes = []
        for trial in range(each):
            with tempfile.TemporaryDirectory() as folder:
                outcomes.append(kill(Path(folder), random.Random(f"{chosen.seed} {name} {trial}")))
        confirmed, lost, wrong, damaged, cut = (sum(column) for column in zip(*outcomes, strict=True))
        print(f"{name:14}{each:8}{cut:15}{confirmed:17}{lost:6}{wrong:14}{damaged:9}", flush=True)
        bad += lost + wrong + damaged
    print(f"{time.monotonic() - began:.0f} s")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
