"""What presets reach, by `concord evaluate`: on generated pairs of fresh seeds, or on pairs of the Princeton benchmark.

    python tests/benchmarks/presets.py --pairs 30 --seed-from 1000 --presets top-down thesis-rigid-size
    python tests/benchmarks/presets.py --princeton coarse-fine

Princeton pairs are read from the folder CONCORD_DATA (default ../shared/data beside the checkout). Results are kept in
--out, where a run that was stopped goes on; without it in a folder that is deleted at the end.
"""

import argparse
import os
import sys
import tempfile
from pathlib import Path

from engine.__main__ import main as concord
from engine.shapes.families import FAMILIES
from engine.shapes.parameters import PRESETS

ROOT = Path(__file__).resolve().parents[2]


def arguments(words: list[str] | None = None) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=30, help="generated pairs in all, of all families alike")
    parser.add_argument("--seed-from", type=int, default=1000, help="seed of the first generated pair")
    parser.add_argument("--presets", nargs="+", default=list(PRESETS))
    parser.add_argument("--princeton", choices=("coarse-fine", "median-median"), help="real pairs instead")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--cold", action="store_true", help="compute every descriptor anew: honest seconds")
    parser.add_argument("--out", type=Path, help="folder for the tables")
    return parser.parse_args(words)


def collection(options: argparse.Namespace) -> list[str]:
    """The words of the command that name the pairs."""
    if not options.princeton:
        return ["generated", "--pairs", str(max(1, options.pairs // len(FAMILIES))), "--seed", str(options.seed_from)]
    folder = Path(os.environ.get("CONCORD_DATA", ROOT.parent / "shared" / "data")) / "shapes" / "princeton"
    if not folder.is_dir():
        print(f"Skipped: {folder} does not exist; set CONCORD_DATA to the folder that holds shapes/princeton.")
        raise SystemExit(0)
    return [str(folder), "--case", options.princeton]


def main() -> int:
    """Run all pairs and print the table."""
    options = arguments()
    with tempfile.TemporaryDirectory() as temporary:
        return concord(["evaluate", *collection(options), "--methods", *options.presets, "--jobs", str(options.jobs),
                        *(["--cold"] if options.cold else []), "--out", str(options.out or temporary)])  # fmt: skip


if __name__ == "__main__":
    sys.exit(main())
