"""300 random histories of the copies of a study, merged in any order, and 500 re-runs that must keep votes where they belong.

    python tests/benchmarks/study_merging.py --histories 300 --reruns 500
"""

import argparse
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from hypothesis import HealthCheck, Phase, given, seed, settings

sys.path.insert(0, str(Path(__file__).parents[1] / "annotation"))
from merge_histories import HISTORIES, Copies, template
from rerun_law import reruns


def histories(count: int) -> None:
    """Live, merge and compare; any difference is an error."""
    lived: Counter[str] = Counter()
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        start = Path(folder) / "study.db"
        template(start)

        @seed(5)
        @settings(max_examples=count, deadline=None, database=None, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
        @given(HISTORIES)
        def merge_all(history: tuple) -> None:
            steps, rng = history
            with tempfile.TemporaryDirectory() as inner:
                world = Copies(start, Path(inner))
                try:
                    world.live(steps)
                    world.check(rng)
                finally:
                    world.close()
                lived.update(world.done)
                lived["histories"] += 1

        merge_all()
    total = lived.pop("histories")
    print(f"{total} histories, each merged in three orders and again: 0 differences, 0 votes lost, {time.monotonic() - began:.0f} s")
    print("what they held:", ", ".join(f"{number} × {kind}" for kind, number in sorted(lived.items())))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--histories", type=int, default=300)
    parser.add_argument("--reruns", type=int, default=500)
    chosen = parser.parse_args()
    histories(chosen.histories)
    right, wrong = reruns(chosen.reruns)
    print(f"{chosen.reruns} re-runs, relabelled, turned round, re-cut: {right} matches kept their votes, {wrong} have others'")
