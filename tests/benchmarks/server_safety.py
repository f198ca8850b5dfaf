"""Kills volunteers, merges and whole PostgreSQL servers with kill -9; counts confirmed votes that are gone or belong elsewhere.

    python tests/benchmarks/server_safety.py [--trials 100] [--seed 1]
"""

import argparse
import random
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "annotation"))

from postgres_server import running
from server_killing import kill_merging, kill_voting


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args(arguments)
    began, voting, merging = time.monotonic(), [], []
    with running(fsync="on") as server, tempfile.TemporaryDirectory() as folder:
        for trial in range(chosen.trials):
            draw = random.Random(f"{chosen.seed} {trial}")
            if trial % 2:
                (Path(folder) / str(trial)).mkdir()
                merging.append(kill_merging(server, Path(folder) / str(trial), draw))
            else:
                voting.append(kill_voting(server, draw))
    bad = 0
    for name, outcomes in (("voting", voting), ("merging", merging)):
        confirmed, lost, wrong, _, cut = (sum(column) for column in zip(*outcomes, strict=True)) if outcomes else (0,) * 5
        print(f"killed while {name}: {len(outcomes)} trials, {cut} in the middle, {confirmed} confirmed votes, {lost} lost, "
              f"{wrong} mis-attached")  # fmt: skip
        bad += lost + wrong
    print(f"{time.monotonic() - began:.0f} s")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
