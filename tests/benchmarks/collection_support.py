"""What support is worth: strict precision of supported matches, what it costs, and label transfer by consistent parts.

    python tests/benchmarks/collection_support.py --shapes 5 --collections 2 --seed-from 9000
    python tests/benchmarks/collection_support.py --princeton

Generated: collections of one family, each shape cut at random into 10 to 16 segments, turned at random. Princeton: 5
shapes of a category, cut by different people, coarse, median and fine in turn; read from the folder CONCORD_DATA
(default ../shared/data beside the checkout). Columns: matches judged; strict precision of all; of those with a support
of at least one half, and which share of the right ones they hold; label transfer (precision / recall) of the pairs
one by one, and by the parts of the whole collection.
"""

import argparse
import os
from pathlib import Path
from typing import NamedTuple

import numpy as np

from engine.evaluation.correspondence import WHOLE, transfer, verdicts
from engine.shapes.collection_matching import match_collection
from engine.shapes.collection_parameters import CollectionParameters
from engine.shapes.collection_result import KINDS, SUPPORTED, CollectionResult
from engine.shapes.families import FAMILIES, make_shape
from engine.shapes.families.pairs import MERGE, segmented
from engine.shapes.meshfile import load_shape, read_labels
from engine.shapes.parameters import DEFAULT_PRESET, PRESETS, preset
from engine.shapes.segmentation import SegmentedShape
from engine.shapes.truth import label_table
from engine.store import default_cache

ROOT = Path(__file__).resolve().parents[2]
CATEGORIES = ("Airplane", "Vase", "Chair", "FourLeg", "Human")
CUTS = ("coarse", "median", "fine")
Labelled = tuple[SegmentedShape, np.ndarray]


class Judged(NamedTuple):
    """Of the matches of a collection: whether each is strictly right, its support of each kind; areas of transfer."""

    right: np.ndarray
    support: dict[str, np.ndarray]
    pairwise: np.ndarray
    by_parts: np.ndarray
    parts: int


def generated(family: str, first: int, count: int) -> list[Labelled]:
    """Shapes `first`, `first` + 1, … of a family."""
    found = []
    for seed in range(first, first + count):
        shape = make_shape(family, seed, pose="turned")
        segments = int(np.random.default_rng([seed, 77]).integers(10, 17))
        found.append((segmented(shape, segments, seed, MERGE), shape.label))
    return found


def princeton(category: str, count: int, skip: int) -> list[Labelled]:
    """Shapes of a category with cuts in turn; those in one single segment are left out."""
    folder = Path(os.environ.get("CONCORD_DATA", ROOT.parent / "shared" / "data")) / "shapes" / "princeton"
    if not folder.is_dir():
        raise SystemExit(f"Skipped: {folder} does not exist; set CONCORD_DATA to the folder that holds shapes/princeton.")
    found = []
    for k, file in enumerate(sorted((folder / category).glob("*.off"))[skip:]):
        shape = load_shape(file, file.with_suffix(f".{CUTS[k % 3]}.seg"))
        if shape.segmentation.count > 1 and len(found) < count:
            found.append((shape, read_labels(file.with_suffix(".sem"))))
    return found


def judge(found: CollectionResult, labels: list[np.ndarray]) -> Judged:
    """Judge every match of every pair, and the parts, by the classes of the faces."""
    classes = np.unique(np.concatenate(labels))
    tables = [label_table(shape, label, classes) for shape, label in zip(found.shapes, labels, strict=True)]
    right, kept, areas = [], [], np.zeros(3)
    for (a, b), result in zip(found.pairs, found.results, strict=True):
        h, g = result.source_members @ tables[a], result.target_members @ tables[b]
        partial = (h.sum(axis=1) <= WHOLE * tables[a].sum()) & (g.sum(axis=1) <= WHOLE * tables[b].sum())
        strict = verdicts(h, g, tables[a].sum(axis=0), tables[b].sum(axis=0))[1].diagonal()
        right.append(strict[partial])
        kept.append(partial)
        both = np.minimum(tables[a].sum(axis=0), tables[b].sum(axis=0)) > 0
        areas += transfer(tables[a], result.source_members[partial], h[partial], g[partial], both)
        areas += transfer(tables[b], result.target_members[partial], g[partial], h[partial], both)
    support = {kind: np.concatenate([s[k] for s, k in zip(found.supports[kind], kept, strict=True)]) for kind in KINDS}
    return Judged(np.concatenate(right), support, areas, parts_transfer(found, tables), found.part_count)


def parts_transfer(found: CollectionResult, tables: list[np.ndarray]) -> np.ndarray:
    """Area given its own class, area covered, all area (3,), where each segment takes the classes of its part in
    another shape, over all pairs of shapes in both directions."""
    total = np.zeros(3)
    of_part = [np.array([table[part == p].sum(axis=0) for p in range(found.part_count)]).reshape(found.part_count, -1)
               for table, part in zip(tables, found.parts, strict=True)]  # fmt: skip
    for pair in found.pairs:
        for a, b in (pair, pair[::-1]):
            both = np.minimum(tables[a].sum(axis=0), tables[b].sum(axis=0)) > 0
            given = of_part[b][found.parts[a]] * (found.parts[a] >= 0)[:, None]
            known = given.sum(axis=1) > 0
            share = given[known] / given[known].sum(axis=1, keepdims=True)
            total += ((tables[a][known] * share).sum(), tables[a][known].sum(), tables[a][:, both].sum())
    return total


def line(name: str, judged: list[Judged]) -> str:
    """One row of the table."""
    right = np.concatenate([j.right for j in judged])
    cells = [f"{len(right):>8}", f"{right.mean():>7.3f}"]
    for kind in KINDS:
        strong = np.concatenate([j.support[kind] for j in judged]) >= SUPPORTED
        cells.append(f"{right[strong].mean():>9.3f} at {right[strong].sum() / right.sum():.2f}")
    for areas in (sum(j.pairwise for j in judged), sum(j.by_parts for j in judged)):
        cells.append(f"{areas[0] / areas[1]:>8.2f}/{areas[0] / areas[2]:.2f}")
    return f"{name:<12}" + "".join(cells) + f"{np.mean([j.parts for j in judged]):>7.1f}"


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shapes", type=int, default=5, help="shapes of each collection")
    parser.add_argument("--collections", type=int, default=2, help="collections of each family or category")
    parser.add_argument("--seed-from", type=int, default=9000, help="seed of the first generated shape")
    parser.add_argument("--families", nargs="+", choices=tuple(FAMILIES), default=list(FAMILIES))
    parser.add_argument("--princeton", action="store_true", help="real shapes instead")
    parser.add_argument("--categories", nargs="+", choices=CATEGORIES, default=list(CATEGORIES))
    parser.add_argument("--preset", choices=tuple(PRESETS), default=DEFAULT_PRESET)
    return parser.parse_args()


def main() -> None:
    """Match, judge and print."""
    options = arguments()
    print(f"{'':<12}{'matches':>8}{'strict':>7}{'cycles ≥.5':>17}{'matchlift ≥.5':>17}{'pairs LT':>13}{'parts LT':>13}{'parts':>7}")
    everything = []
    for name in options.categories if options.princeton else options.families:
        judged = []
        for k in range(options.collections):
            first = k * options.shapes
            shapes = (princeton(name, options.shapes, first) if options.princeton
                      else generated(name, options.seed_from + first, options.shapes))  # fmt: skip
            if len(shapes) < 3:
                continue
            found = match_collection([s for s, _ in shapes], preset(options.preset), CollectionParameters(),
                                     preset=options.preset, cache=default_cache())  # fmt: skip
            judged.append(judge(found, [label for _, label in shapes]))
        everything += judged
        print(line(name, judged), flush=True)
    print(line("all", everything))


if __name__ == "__main__":
    main()
