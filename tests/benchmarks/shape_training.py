# ruff: noqa: E402  (threads are limited before NumPy is loaded)
"""Fit the learned matcher of shapes and print how well it does on classes of shapes that it was not fitted to.

    python tests/benchmarks/shape_training.py --work FOLDER [--generated 800] [--inventions 300] [--write]

Pairs come from the generated families (seeds from 20000), from invented species (`shape_inventions.py`), and, where the
folder CONCORD_DATA has them, from the Princeton benchmark (coarse against fine, median against median) and TOSCA. What
is known of each pair is kept in the work folder, so a second run is quick. The figures printed for every class of real
shapes come from networks that saw none of its kind (three folds); `--write` writes `engine/shapes/learned.json`, fitted
to everything but the fresh seeds.
"""

import argparse
import json
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

for _variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

import numpy as np
from shape_inventions import invented_pair

from engine.evaluation.correspondence import evaluate_tables
from engine.shapes.context import Neighbourhood
from engine.shapes.describing import DescribedShape, describe
from engine.shapes.families import FAMILIES, VARIANTS, make_pair
from engine.shapes.learned import FILE, Seen, average, later_inputs, look
from engine.shapes.learnedmatching import choose
from engine.shapes.meshfile import load_shape, read_labels
from engine.shapes.parameters import preset
from engine.shapes.segmentation import SegmentedShape
from engine.shapes.truth import label_table

DATA = Path(os.environ.get("CONCORD_DATA", Path(__file__).resolve().parents[3] / "shared" / "data")) / "shapes"
CATEGORIES = ("Airplane", "Vase", "Chair", "FourLeg", "Human")
TOSCA = ("wolf", "horse", "david")
FOLDS = (("Airplane", "Human", "wolf"), ("Vase", "FourLeg", "horse"), ("Chair", "david", "wolf"))
SEGMENTS = ((10, 16), (6, 10), (8, 20))
STAGES = 2
ROWS = 700
Labelled = tuple[SegmentedShape, np.ndarray]


@dataclass(frozen=True)
class Task:
    """A pair by name, the group that it belongs to, and how its shapes are made."""

    group: str
    name: str
    make: Callable[[], tuple[Labelled, Labelled]]


@dataclass
class Example:
    """What is seen of a pair, its truth (c, 3), and its tables of area per class; `found` (c, 3) of the last stage."""

    group: str
    name: str
    seen: Seen
    truth: np.ndarray
    tables: tuple[np.ndarray, np.ndarray]
    inputs: np.ndarray
    found: np.ndarray | None = None


# --- pairs --------------------------------------------------------------------------------------------------------


def generated(first: int, count: int, segments: tuple[tuple[int, int], ...] = SEGMENTS) -> Iterator[Task]:
    """Pairs of the families in turn, parts touching or welded, turned at random."""
    families = list(FAMILIES)
    for k in range(first, first + count):
        family, variant = families[k % len(families)], VARIANTS[k // 5 % 2]

        def make(family: str = family, variant: str = variant, k: int = k) -> tuple[Labelled, Labelled]:
            pair = make_pair(family, k, variant=variant, segments=segments[k // 10 % len(segments)])
            return (pair.source, pair.source_label), (pair.target, pair.target_label)

        yield Task(family, f"g_{family}_{k}", make)


def inventions(count: int) -> Iterator[Task]:
    """Pairs of invented species."""
    for k in range(count):

        def make(k: int = k) -> tuple[Labelled, Labelled]:
            pair = invented_pair(k)
            return (pair.source, pair.source_label), (pair.target, pair.target_label)

        yield Task("inventions", f"i_{k}", make)


def princeton(first: str, second: str, steps: tuple[int, ...]) -> Iterator[Task]:
    """Shape i with one segmentation against shape i + step with another."""
    for category in CATEGORIES:
        meshes = sorted((DATA / "princeton" / category).glob("*.off"), key=lambda path: int(path.stem))
        for step in steps:
            for a, b in zip(meshes, meshes[step:], strict=False):
                yield _files(category, (a, f".{first}.seg", ".sem"), (b, f".{second}.seg", ".sem"))


def tosca() -> Iterator[Task]:
    """Each shape's over-segmentation against the next shape's regions."""
    for category in TOSCA:
        meshes = sorted((DATA / "tosca" / category).glob("*.off"))
        for a, b in zip(meshes, meshes[1:] + meshes[:1], strict=True):
            yield _files(category, (a, ".over.seg", ".symseg"), (b, ".seg", ".symseg"))


def _files(group: str, a: tuple[Path, str, str], b: tuple[Path, str, str]) -> Task:
    def read(path: Path, segments: str, truth: str) -> Labelled:
        return load_shape(path, path.with_suffix(segments)), read_labels(path.with_suffix(truth))

    names = [path.stem + segments.removesuffix(".seg") for path, segments, _ in (a, b)]
    return Task(group, f"{group}_{names[0]}_{names[1]}", lambda: (read(*a), read(*b)))


# --- what is known of a pair --------------------------------------------------------------------------------------


def example(task: Task, work: Path) -> Example | None:
    """The pair, from the work folder where it has been there before; None where a shape has one single segment."""
    file = work / f"{task.name}.npz"
    if not file.exists():
        shapes = task.make()
        if min(shape.segmentation.count for shape, _ in shapes) < 2:
            return None
        store(file, *((describe(shape, preset("top-down")), label) for shape, label in shapes))
    with np.load(file) as kept:
        a = {name: kept[name] for name in kept.files}
    around = Neighbourhood(*(a[name].astype(np.float32) for name in ("packed_source", "packed_target")),
                           *(a[name] for name in ("members_source", "members_target", "area_source", "area_target")))  # fmt: skip
    seen = Seen(a["pairs"], a["inputs"], around)
    return Example(task.group, task.name, seen, a["truth"], (a["table_source"], a["table_target"]), a["inputs"])


def store(file: Path, source: tuple[DescribedShape, np.ndarray], target: tuple[DescribedShape, np.ndarray]) -> None:
    """Keep what is seen of a pair, with its truth."""
    seen, around = look(source[0], target[0]), None
    classes = np.unique(np.concatenate([source[1], target[1]]))
    tables = [label_table(shape.shape, label, classes) for shape, label in (source, target)]
    around = seen.around
    packed = {name: getattr(around, name).astype(np.float16) for name in ("packed_source", "packed_target")}
    other = {name: getattr(around, name) for name in ("members_source", "members_target", "area_source", "area_target")}
    truth = truth_of(seen.pairs, around.members_source @ tables[0], around.members_target @ tables[1], tables)
    part = file.with_suffix(".part.npz")
    np.savez(part, pairs=seen.pairs, inputs=seen.inputs, truth=truth, table_source=tables[0], table_target=tables[1],
             **packed, **other)  # fmt: skip
    part.rename(file)


def truth_of(pairs: np.ndarray, h: np.ndarray, g: np.ndarray, tables: list[np.ndarray]) -> np.ndarray:
    """Strictly right, leniently right, and the share of the area that gets its own class, (c, 3) float32."""
    all_h, all_g = (table.sum(axis=0) for table in tables)
    i, j = pairs.T
    p, q = (h / h.sum(axis=1, keepdims=True))[i], (g / g.sum(axis=1, keepdims=True))[j]
    x = np.divide(h, all_h, out=np.zeros_like(h), where=all_h > 0)[i]
    y = np.divide(g, all_g, out=np.zeros_like(g), where=all_g > 0)[j]
    w = all_h / all_h.sum() + all_g / all_g.sum()
    strict = np.minimum(x, y) @ w >= 0.5 * (np.maximum(x, y) @ w)
    return np.stack([strict, np.minimum(p, q).sum(axis=1) >= 0.5, (p * q).sum(axis=1)], axis=1).astype(np.float32)


# --- networks -----------------------------------------------------------------------------------------------------


def fit(inputs: np.ndarray, truth: np.ndarray, weight: np.ndarray, seed: int, options: argparse.Namespace) -> dict[str, Any]:
    """One network by stochastic gradients (Adam, falling rate); the loss is the weighted cross-entropy.

    Each step does without some inputs, so that no single one is relied on.
    """
    rng = np.random.default_rng(seed)
    mean, scale = inputs.mean(axis=0), inputs.std(axis=0) + 1e-6
    x = np.clip((inputs - mean) / scale, -4, 4).astype(np.float32)
    sizes = [x.shape[1], *options.hidden, truth.shape[1]]
    values = [(rng.normal(size=s) * np.sqrt(2 / s[0])).astype(np.float32) for s in pairwise(sizes)]
    values += [np.zeros(n, dtype=np.float32) for n in sizes[1:]]
    first, second = ([np.zeros_like(v) for v in values] for _ in range(2))
    layers, batch = len(sizes) - 1, 2048
    steps = options.epochs * (len(x) // batch)
    for step in range(1, steps + 1):
        if step % (len(x) // batch) == 1:
            order = rng.permutation(len(x))
        rows = order[(step - 1) % (len(x) // batch) * batch :][:batch]
        seen = x[rows] * (rng.random(x.shape[1]) >= options.drop)
        slopes = _slopes(values, layers, seen.astype(np.float32), truth[rows], weight[rows], options.decay)
        rate = options.rate * 0.5 * (1 + np.cos(np.pi * step / steps)) + 1e-5
        for v, m, s, slope in zip(values, first, second, slopes, strict=True):
            m += 0.1 * (slope - m)
            s += 0.001 * (slope**2 - s)
            v -= rate * (m / (1 - 0.9**step)) / (np.sqrt(s / (1 - 0.999**step)) + 1e-8)
    return {"mean": mean.astype(np.float32), "scale": scale.astype(np.float32), "clip": 4,
            "layers": [{"weights": w, "bias": b} for w, b in zip(values[:layers], values[layers:], strict=True)]}  # fmt: skip


def _slopes(values: list, layers: int, x: np.ndarray, y: np.ndarray, weight: np.ndarray, decay: float) -> list[np.ndarray]:
    active = [x]
    for w, b in zip(values[: layers - 1], values[layers:-1], strict=True):
        active.append(np.maximum(active[-1] @ w + b, 0))
    back = (1 / (1 + np.exp(-(active[-1] @ values[layers - 1] + values[-1]))) - y) * weight[:, None] / len(x)
    found: list[np.ndarray] = [np.zeros(0)] * (2 * layers)
    for k in range(layers - 1, -1, -1):
        found[k] = active[k].T @ back + decay * values[k]
        found[layers + k] = back.sum(axis=0)
        back = (back @ values[k].T) * (active[k] > 0) if k else back
    return found


def stage(examples: list[Example], options: argparse.Namespace, skip: tuple[str, ...] = (), half: int = -1) -> list[dict[str, Any]]:
    """The networks of one stage, fitted to the examples of all groups but `skip`; of drawn ones to one half, if asked."""
    nets = []
    for seed in range(options.nets):
        rng = np.random.default_rng([seed, 3])
        x, y, w = [], [], []
        for number, one in enumerate(examples):
            if one.group in skip or (half >= 0 and is_drawn(one) and number % 2 == half):
                continue
            rows = rng.permutation(len(one.inputs))[:ROWS]
            x.append(one.inputs[rows])
            y.append(one.truth[rows])
            w.append(np.full(len(rows), 1 / np.sqrt(len(rows)), dtype=np.float32))
        weight = np.concatenate(w)
        nets.append(fit(np.concatenate(x), np.concatenate(y), weight / weight.mean(), seed, options))
    return nets


def is_drawn(one: Example) -> bool:
    """Whether a pair was drawn at random and not read from files."""
    return one.name.startswith(("g_", "i_"))


def crossed(examples: list[Example], others: list[Example], options: argparse.Namespace) -> list[list[dict[str, Any]]]:
    """All stages fitted to all examples; each example's `found` comes from networks that did not see its like.

    Every real class is judged by networks fitted without it, and what was drawn by networks fitted to the other half, in
    each stage, so a later stage learns from what the earlier ones say of pairs they have not seen. `others` are judged by
    the networks fitted to everything.
    """
    stages = []
    for number in range(STAGES):
        stages.append(stage(examples, options))
        for one in others:
            one.found = average(stages[-1], one.inputs)
        for fold in FOLDS:
            nets = stage(examples, options, fold)
            for one in examples:
                if one.group in fold:
                    one.found = average(nets, one.inputs)
        for half in (0, 1):
            nets = stage(examples, options, (), half)
            for k, one in enumerate(examples):
                if is_drawn(one) and k % 2 == half:
                    one.found = average(nets, one.inputs)
        print(f"stage {number + 1} of {STAGES}, log loss: {losses([*examples, *others])}", flush=True)
        for one in (*examples, *others) if number < STAGES - 1 else ():
            one.inputs = later_inputs(one.seen, one.found)  # type: ignore[arg-type]
    return stages


# --- figures ------------------------------------------------------------------------------------------------------


def losses(examples: list[Example]) -> str:
    """Mean cross-entropy of the three outputs by group of pairs."""
    groups: dict[str, list[np.ndarray]] = {}
    for one in examples:
        p = np.clip(one.found, 1e-4, 1 - 1e-4)  # type: ignore[call-overload]
        kind = "drawn" if is_drawn(one) else "TOSCA" if one.group in TOSCA else "Princeton"
        groups.setdefault(kind, []).append(-(one.truth * np.log(p) + (1 - one.truth) * np.log(1 - p)).mean(axis=0))
    return "; ".join(f"{kind} " + " ".join(f"{x:.3f}" for x in np.mean(rows, axis=0)) for kind, rows in groups.items())


def figures(title: str, examples: list[Example]) -> None:
    """Lenient and strict precision, label transfer precision and recall, and the number of matches, by group."""
    rows: dict[str, list[tuple[float, ...]]] = {}
    for one in examples:
        around, found = one.seen.around, one.found
        chosen = choose(one.seen.pairs, found[:, :2].min(axis=1), found[:, 2], around, preset("learned"))  # type: ignore[index]
        members = around.members_source, around.members_target
        e = evaluate_tables(*one.tables, [tuple(np.flatnonzero(m[k]) for m, k in zip(members, pair, strict=True))
                                          for pair in one.seen.pairs[chosen]])  # type: ignore[misc]  # fmt: skip
        recall = e.transfer_recall if e.judged else 0.0
        rows.setdefault(one.group, []).append((e.lenient, e.strict, e.transfer_precision, recall, e.judged))
    rows["all"] = [row for group in rows.values() for row in group]
    print(f"{title}\n{'':12}{'pairs':>6}{'lenient':>9}{'strict':>9}{'LT prec.':>9}{'LT rec.':>9}{'matches':>9}")
    for group, own in rows.items():
        print(f"{group:12}{len(own):>6}" + "".join(f"{x:>9.3f}" for x in np.nanmean(own, axis=0)), flush=True)


def as_lists(entry: Any) -> Any:
    """Arrays as lists of numbers with five digits."""
    if isinstance(entry, np.ndarray):
        return [as_lists(row) for row in entry] if entry.ndim > 1 else [float(f"{x:.5g}") for x in entry.tolist()]
    if isinstance(entry, dict):
        return {k: as_lists(v) for k, v in entry.items()}
    return [as_lists(x) for x in entry] if isinstance(entry, list) else entry


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--work", type=Path, required=True, help="folder for what is known of each pair")
    parser.add_argument("--generated", type=int, default=800, help="pairs of the families, seeds from 20000")
    parser.add_argument("--inventions", type=int, default=300, help="pairs of invented species")
    parser.add_argument("--test", type=int, default=30, help="generated pairs of fresh seeds, from 9000, only judged")
    parser.add_argument("--hidden", type=int, nargs="+", default=[32])
    parser.add_argument("--epochs", type=int, default=8)
    parser.add_argument("--rate", type=float, default=2e-3)
    parser.add_argument("--decay", type=float, default=1e-3)
    parser.add_argument("--drop", type=float, default=0.1, help="share of the inputs that each step does without")
    parser.add_argument("--nets", type=int, default=2, help="networks of each stage")
    parser.add_argument("--only-prepare", action="store_true", help="fill the work folder and stop")
    parser.add_argument("--write", action="store_true", help="write the fit to engine/shapes/learned.json")
    return parser.parse_args()


def main() -> None:
    """Prepare, judge crosswise, and write."""
    options = arguments()
    options.work.mkdir(parents=True, exist_ok=True)

    def read(tasks: Iterator[Task]) -> list[Example]:
        found = []
        for task in tasks:
            one = example(task, options.work)
            found += [one] if one is not None else []
        print(f"{len(found)} pairs", flush=True)
        return found

    test = read(generated(9000, options.test, SEGMENTS[:1]))
    drawn = read(generated(20_000, options.generated)) + read(inventions(options.inventions))
    coarse, median = read(princeton("coarse", "fine", (1, 3))), read(princeton("median", "median", (1, 2)))
    moving = read(tosca())
    if options.only_prepare:
        return
    everything = [*drawn, *coarse, *median, *moving]
    stages = crossed(everything, test, options)
    for title, examples in (("Princeton, coarse against fine", coarse), ("Princeton, median against median", median),
                            ("TOSCA", moving), ("generated, fresh seeds", test)):  # fmt: skip
        figures(title, examples)
    if options.write:
        FILE.write_text(json.dumps(as_lists({"stages": stages}), separators=(",", ":")) + "\n")
        print(f"written: {FILE}, {FILE.stat().st_size:,} bytes")


if __name__ == "__main__":
    main()
