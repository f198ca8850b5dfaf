"""Precision of the presets, beside chance: on generated pairs of fresh seeds, or on pairs of the Princeton benchmark.

    python tests/benchmarks/presets.py --pairs 30 --seed-from 1000 --presets top-down thesis-rigid-size
    python tests/benchmarks/presets.py --princeton coarse-fine

Princeton pairs are read from the folder CONCORD_DATA (default ../shared/data beside the checkout). Every figure is the
mean over pairs; a pair without a match counts 0 in recall and is left out of the other columns. Seconds are those of
a whole match; descriptors come from the cache where it holds them, unless --cold.
"""

import argparse
import csv
import multiprocessing
import os
import time
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from engine.shapes.families import FAMILIES, POSES, VARIANTS, make_pair, parse_segments
from engine.shapes.matching import match_shapes
from engine.shapes.meshfile import load_shape, read_labels
from engine.shapes.parameters import PRESETS, preset
from engine.shapes.segmentation import SegmentedShape
from engine.shapes.truth import evaluate_result
from engine.store import default_cache

ROOT = Path(__file__).resolve().parents[2]
CATEGORIES = ("Airplane", "Vase", "Chair", "FourLeg", "Human")
COLUMNS = ("lenient", "strict", "chance len.", "chance str.", "LT prec.", "LT recall", "matches", "seconds")


class Task(NamedTuple):
    """One pair to be matched by every preset; what it takes to make or read it again in another process."""

    group: str
    source: str
    target: str
    presets: tuple[str, ...]
    seed: int = -1
    variant: str = ""
    segments: tuple[int, int] = (10, 16)
    cold: bool = False
    pose: str = "turned"


class Row(NamedTuple):
    """The figures of one pair under one preset, in the order of COLUMNS."""

    group: str
    pair: str
    preset: str
    figures: tuple[float, ...]


def generated_tasks(options: argparse.Namespace) -> list[Task]:
    """Pairs of all families and both variants in turn."""
    tasks = []
    segments = parse_segments(options.segments)
    for k in range(options.pairs):
        family = options.families[k % len(options.families)]
        variant = options.variants[(k // len(options.families)) % len(options.variants)]
        seed = options.seed_from + k
        tasks.append(Task(family, "", "", tuple(options.presets), seed, variant, segments, options.cold, options.pose))
    return tasks


def princeton_tasks(options: argparse.Namespace) -> list[Task]:
    """Shape i against shape i+1 of each category, each with the segmentation that was asked for."""
    folder = Path(os.environ.get("CONCORD_DATA", ROOT.parent / "shared" / "data")) / "shapes" / "princeton"
    if not folder.is_dir():
        print(f"Skipped: {folder} does not exist; set CONCORD_DATA to the folder that holds shapes/princeton.")
        raise SystemExit(0)
    first, second = options.princeton.split("-")
    tasks = []
    for category in options.categories:
        meshes = sorted((folder / category).glob("*.off"))
        consecutive = list(pairwise(meshes))[: options.pairs_each]
        tasks += [
            Task(category, f"{a}:{first}", f"{b}:{second}", tuple(options.presets), cold=options.cold)
            for a, b in consecutive
        ]
    return tasks


def read_princeton(text: str) -> tuple[SegmentedShape, np.ndarray]:
    """A shape and its classes from PATH.off:SEGMENTATION."""
    path, which = text.rsplit(":", 1)
    file = Path(path)
    return load_shape(file, file.with_suffix(f".{which}.seg")), read_labels(file.with_suffix(".sem"))


def run(task: Task) -> list[Row]:
    """Match one pair by every preset and judge it."""
    if task.seed >= 0:
        pair = make_pair(task.group, task.seed, variant=task.variant, segments=task.segments, pose=task.pose)
        source, target, truth = pair.source, pair.target, (pair.source_label, pair.target_label)
        name = f"{task.seed} {task.variant}"
    else:
        (source, a), (target, b) = read_princeton(task.source), read_princeton(task.target)
        truth, name = (a, b), f"{source.mesh.name}-{target.mesh.name}"
    if min(source.segmentation.count, target.segmentation.count) < 2:
        print(f"Left out: {task.group} {name}, a shape in one single segment.")
        return []
    rows = []
    for chosen in task.presets:
        start = time.perf_counter()
        result = match_shapes(
            source, target, preset(chosen), preset=chosen, cache=None if task.cold else default_cache()
        )
        seconds = time.perf_counter() - start
        e = evaluate_result(result, source, target, *truth)
        recall = e.transfer_recall if e.judged else 0.0
        rows.append(Row(task.group, name, chosen, (e.lenient, e.strict, e.chance_lenient, e.chance_strict,
                                                   e.transfer_precision, recall, e.judged, seconds)))  # fmt: skip
    return rows


def table(rows: list[Row], presets: list[str]) -> str:
    """Means per preset and group, and over all groups, as text."""
    lines = [f"{'preset':<22}{'group':<12}{'pairs':>6}" + "".join(f"{c:>12}" for c in COLUMNS)]
    for chosen in presets:
        own = [r for r in rows if r.preset == chosen]
        groups = list(dict.fromkeys(r.group for r in own))
        for group in [*groups, "all"] if len(groups) > 1 else groups:
            figures = np.array([r.figures for r in own if group in (r.group, "all")])
            known = np.isfinite(figures)
            mean = np.where(known, figures, 0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
            cells = [f"{x:>12.2f}" if c != "matches" else f"{x:>12.1f}" for x, c in zip(mean, COLUMNS, strict=True)]
            lines.append(f"{chosen:<22}{group:<12}{len(figures):>6}" + "".join(cells))
    return "\n".join(lines)


def arguments(words: list[str] | None = None) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=30, help="generated pairs in all")
    parser.add_argument("--seed-from", type=int, default=1000, help="seed of the first generated pair")
    parser.add_argument("--families", nargs="+", choices=tuple(FAMILIES), default=list(FAMILIES))
    parser.add_argument("--variants", nargs="+", choices=VARIANTS, default=list(VARIANTS))
    parser.add_argument("--segments", default="10-16", help="fewest and most segments of a generated shape")
    parser.add_argument("--pose", choices=POSES, default="turned", help="turned: every shape is rotated at random")
    parser.add_argument("--presets", nargs="+", choices=tuple(PRESETS), default=list(PRESETS))
    parser.add_argument("--princeton", choices=("coarse-fine", "median-median"), help="real pairs instead")
    parser.add_argument("--categories", nargs="+", choices=CATEGORIES, default=list(CATEGORIES))
    parser.add_argument("--pairs-each", type=int, default=13, help="pairs of each Princeton category")
    parser.add_argument("--jobs", type=int, choices=(1, 2), default=1, help="processes")
    parser.add_argument("--cold", action="store_true", help="compute every descriptor anew: honest seconds")
    parser.add_argument("--verbose", action="store_true", help="one line a pair and preset as it is done")
    parser.add_argument("--csv", type=Path, help="also write one line a pair and preset")
    return parser.parse_args(words)


def main() -> None:
    """Run all pairs and print the table."""
    options = arguments()
    for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ.setdefault(variable, "1")
    tasks = princeton_tasks(options) if options.princeton else generated_tasks(options)
    rows: list[Row] = []
    with multiprocessing.get_context("spawn").Pool(options.jobs) as pool:
        for done in pool.imap(run, tasks):
            rows += done
            for row in done if options.verbose else ():
                print(f"{row.group:<12}{row.pair:<20}{row.preset:<22}"
                      + " ".join(f"{x:6.2f}" for x in row.figures), flush=True)  # fmt: skip
    print(table(rows, options.presets))
    if options.csv:
        with options.csv.open("w", newline="") as handle:
            writer = csv.writer(handle)
            writer.writerow(["group", "pair", "preset", *COLUMNS])
            writer.writerows([r.group, r.pair, r.preset, *r.figures] for r in rows)


if __name__ == "__main__":
    main()
