"""How well automatic segments agree with people's labels, and what matching makes of them.

    python tests/benchmarks/segmentations.py --shapes 3
    python tests/benchmarks/segmentations.py --match 14 --methods parts patches

For each way and number of segments the purity: the share of the surface on which a segment has the label that most of
it has; the processor seconds of a first cut and people's own fine cut stand beside it. With `--match N` all pairs of
`concord evaluate` are matched on N automatic segments of both shapes, beside people's median cut. The Princeton
benchmark is read from the folder CONCORD_DATA (default ../shared/data beside the checkout).
"""

import argparse
import os
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np

from engine.__main__ import main as concord
from engine.shapes.mesh import Mesh, face_areas
from engine.shapes.meshfile import load_mesh, read_labels
from engine.shapes.segmentationparameters import DEFAULT
from engine.shapes.segmenting import auto_segment, segment_file_text
from engine.store import Cache

ROOT = Path(__file__).resolve().parents[2]


def arguments(words: list[str] | None = None) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--methods", nargs="+", default=["parts", "patches", "convex"])
    parser.add_argument("--segments", nargs="+", type=int, default=[8, 14, 20, 30])
    parser.add_argument("--shapes", type=int, default=3, help="shapes of each family, the last of them by name")
    parser.add_argument("--match", type=int, default=0, help="match the shapes on so many automatic segments instead")
    parser.add_argument("--preset", default="", help="preset of the matching; the default without it")
    return parser.parse_args(words)


def families() -> list[Path]:
    """The folders of labelled shapes."""
    folder = Path(os.environ.get("CONCORD_DATA", ROOT.parent / "shared" / "data")) / "shapes" / "princeton"
    if not folder.is_dir():
        print(f"Skipped: {folder} does not exist; set CONCORD_DATA to the folder that holds shapes/princeton.")
        raise SystemExit(0)
    return sorted(path for path in folder.iterdir() if path.is_dir())


def purity(labels: np.ndarray, truth: np.ndarray, area: np.ndarray) -> float:
    """Share of the area on which a segment has its most frequent label of the truth."""
    table = np.zeros((int(labels.max()) + 1, int(truth.max()) + 1))
    np.add.at(table, (labels, truth), area)
    return float(table.max(axis=1).sum() / area.sum())


def numbered(path: Path) -> np.ndarray:
    """The labels of a file as 0..s-1."""
    return np.unique(read_labels(path), return_inverse=True)[1].ravel()


def purities(options: argparse.Namespace) -> None:
    """Print the table of purities and seconds."""
    columns = [str(k) for k in options.segments]
    print(f"{'family':<10}{'way':<10}" + "".join(f"{c:>8}" for c in columns) + f"{'seconds':>10}{'fine cut':>16}")
    total: dict[str, list[list[float]]] = {method: [] for method in options.methods}
    for family in families():
        files = sorted(family.glob("*.off"), key=lambda path: int(path.stem))[-options.shapes :]
        meshes = [(load_mesh(path)[0], numbered(path.with_suffix(".sem")), path) for path in files]
        people = [purity(numbered(p.with_suffix(".fine.seg")), t, face_areas(m)) for m, t, p in meshes]
        fine = np.mean([len(np.unique(numbered(path.with_suffix(".fine.seg")))) for path in files])
        for method in options.methods:
            found, seconds = zip(*(cuts(mesh, truth, method, options.segments) for mesh, truth, _ in meshes), strict=True)
            total[method] += [list(row) for row in found]
            cells = "".join(f"{value:8.3f}" for value in np.mean(found, axis=0))
            print(f"{family.name:<10}{method:<10}{cells}{np.mean(seconds):10.1f}{np.mean(people):9.3f} ({fine:.0f})", flush=True)
    for method, rows in total.items():
        print(f"{'all':<10}{method:<10}" + "".join(f"{value:8.3f}" for value in np.mean(rows, axis=0)))


def cuts(mesh: Mesh, truth: np.ndarray, method: str, counts: list[int]) -> tuple[list[float], float]:
    """The purity for each number of segments, and the seconds of the first cut, with nothing in the cache."""
    with tempfile.TemporaryDirectory() as folder:
        cache, area, began = Cache(folder), face_areas(mesh), sum(os.times()[:4])
        first = auto_segment(mesh, DEFAULT.changed(method=method, segments=counts[0]), cache=cache).labels
        seconds = sum(os.times()[:4]) - began  # of the processor, child processes too: other work does not count
        rest = [auto_segment(mesh, DEFAULT.changed(method=method, segments=k), cache=cache).labels for k in counts[1:]]
        return [purity(labels, truth, area) for labels in (first, *rest)], seconds


def matched(options: argparse.Namespace) -> int:
    """Match the shapes on automatic segments, and on people's median cut, by `concord evaluate`."""
    with tempfile.TemporaryDirectory() as temporary:
        for way in ("median", *options.methods):
            folder = Path(temporary) / way
            for family in families():
                for path in sorted(family.glob("*.off"), key=lambda path: int(path.stem))[-options.shapes :]:
                    put(path, folder / family.name, way, options.match)
            print(f"\n{way}: {'people' if way == 'median' else f'{options.match} segments'}", flush=True)
            words = ["evaluate", str(folder), "--source-labels", ".cut.seg", "--out", str(Path(temporary) / f"{way}-results")]
            code = concord([*words, *(["--methods", options.preset] if options.preset else [])])
            if code:
                return code
    return 0


def put(path: Path, folder: Path, way: str, count: int) -> None:
    """A shape with its truth and one segmentation, `NAME.cut.seg`, in a folder of its own."""
    folder.mkdir(parents=True, exist_ok=True)
    for ending in (".off", ".sem"):
        shutil.copy(path.with_suffix(ending), folder)
    target = folder / f"{path.stem}.cut.seg"
    if way == "median":
        shutil.copy(path.with_suffix(".median.seg"), target)
    else:
        found = auto_segment(load_mesh(path)[0], DEFAULT.changed(method=way, segments=count))
        target.write_text(segment_file_text(found.labels))


def main() -> int:
    """Print what is asked for."""
    options = arguments()
    if options.match:
        return matched(options)
    purities(options)
    return 0


if __name__ == "__main__":
    sys.exit(main())
