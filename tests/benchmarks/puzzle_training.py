"""Fit the probability of a join to pictures with known truth, and print how it does on pictures left out.

    python tests/benchmarks/puzzle_training.py --data FOLDER [--write] [--kinds clean worn placed]

FOLDER holds the picture folders kodak12, bsds40 and large. The fit is first made without one picture in four and judged
on those; with `--write` it is then made on all of them and written to engine/puzzles/learned.json. Pictures are also
brightened and darkened beyond what their pixels can hold, so that some pieces are flat, and smoothed. Needs scikit-learn.
"""

import argparse
import json
import sys
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[2]))

from engine.progress import silent
from engine.puzzles.candidates import (
    Candidates,
    border_features,
    context_features,
    exclusive,
    gallagher_ratio,
    looks_of,
    shortlist,
)  # fmt: skip
from engine.puzzles.cutting import cut
from engine.puzzles.learned import FILE, MOST, network
from engine.puzzles.measures import CODES, Strips, dissimilarity_of_pairs, side_strips
from engine.puzzles.scoring import true_partners
from engine.puzzles.wearing import WEAR, worn

LARGEST_FIT = 3_000_000 if "--quick" not in sys.argv else 800_000  # wrong candidates of a fit; of more, a part with more weight


class Sample(NamedTuple):
    """One puzzle of the training: its candidates, their features and which are right."""

    name: str
    candidates: Candidates
    strips: Strips
    features: np.ndarray
    right: np.ndarray


def picture(path: Path, mode: str, columns: int, px: int, rng: np.random.Generator) -> np.ndarray:
    image = Image.open(path).convert("RGB")
    if columns:
        image = image.resize((columns * px, round(image.height * columns * px / image.width)), Image.Resampling.BOX)
    pixels = np.asarray(image)
    if mode == "bright":
        return np.clip(pixels * rng.uniform(1.3, 2.2), 0, 255).astype(np.uint8)
    if mode == "dark":
        return np.clip((pixels - rng.uniform(20, 70)) * 1.2, 0, 255).astype(np.uint8)
    if mode == "smooth":
        import cv2

        return cv2.bilateralFilter(np.ascontiguousarray(pixels), 9, 40, 9)
    return pixels


def sample(path: Path, mode: str, columns: int, px: int, seed: int, turned: bool, wear: str) -> Sample:
    pixels = picture(path, mode, columns, px, np.random.default_rng(seed))
    puzzle, truth = cut(pixels, piece_size=px, turned=turned, seed=seed)
    if wear:
        puzzle, truth = worn(puzzle, truth, wear, seed)
        px = puzzle.square or px
    rasters = puzzle.rasters()
    strips = side_strips(rasters)
    found = shortlist(strips, turned=turned, by_mgc=12, by_ssd=4, worn=bool(wear), progress=silent)
    features = border_features(found, looks_of(rasters, bool(wear)), turned, silent)
    right = true_partners(truth, px)[found.pairs[:, 0]] == found.pairs[:, 1]
    name = f"{path.stem} {mode or 'plain'} {px} px{' turned' if turned else ''} {wear}"
    return Sample(name, found, strips, features, right)


def recipes(data: Path, kind: str) -> list[tuple[bool, tuple]]:
    """(left out of the first fit?, arguments of `sample`) of every puzzle of the training."""
    made = []
    names = list(WEAR)
    sizes = {"kodak12": (20, 42, 35, 24), "bsds40": (28, 20, 14, 42), "large": (28, 28, 28, 28)}
    modes = ("bright", "dark", "smooth")
    for folder in sizes:
        for i, path in enumerate(sorted(p for p in (data / folder).iterdir() if p.suffix in (".png", ".jpg"))):
            left_out, size = i % 4 == 1, sizes[folder][i % 4]
            columns = 30 if folder == "large" else 0
            if kind == "worn":
                for k in range(3 if folder != "bsds40" else 1):
                    made.append(
                        (
                            left_out,
                            (path, "", columns, (28, size, 28)[k], i + k, False, names[(3 * i + k) % len(names)]),
                        )
                    )
                continue
            made.append((left_out, (path, "", columns, 28, i, False, "")))
            made.append((left_out, (path, modes[i % 3], columns, 28, i + 100, False, "")))
            if folder != "bsds40" or i % 2:
                made.append((left_out, (path, "", columns and 50, size, i + 200, False, "")))
            if folder != "bsds40" or i % 3 == 0:
                made.append((left_out, (path, modes[(i + 1) % 3] if i % 2 else "", columns, 28, i + 300, True, "")))
    return made


def fitted(inputs: np.ndarray, right: np.ndarray) -> dict:
    from sklearn.neural_network import MLPClassifier

    kept = right | (np.random.default_rng(0).random(len(right)) < min(1.0, LARGEST_FIT / len(right)))
    weight = np.where(right, 1.0, len(right) / min(LARGEST_FIT, len(right)))[kept]
    inputs, right = inputs[kept], right[kept]
    mean, scale = inputs.mean(axis=0), inputs.std(axis=0) + 1e-6
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = MLPClassifier(
            (24, 12), max_iter=12, batch_size=1024, learning_rate_init=2e-3, alpha=1e-3, random_state=0
        )
        model.fit((inputs - mean) / scale, right, sample_weight=weight)
    layers = [{"weights": w.astype(np.float32), "bias": b.astype(np.float32)}
              for w, b in zip(model.coefs_, model.intercepts_, strict=True)]  # fmt: skip
    return {"mean": mean, "scale": scale, "layers": layers}


def with_context(s: Sample, probability: np.ndarray) -> np.ndarray:
    return np.concatenate([context_features(probability, s.candidates, MOST), s.features], axis=1)


def train(samples: list[Sample], judged: list[Sample], rounds: int) -> dict:
    right = np.concatenate([s.right for s in samples])
    nets = {"border": fitted(np.concatenate([s.features for s in samples]), right), "context": []}
    chances = {id(s): exclusive(network(nets["border"], s.features), s.candidates) for s in [*samples, *judged]}
    report("borders", judged, chances)
    for number in range(rounds):
        inputs = {id(s): with_context(s, chances[id(s)]) for s in [*samples, *judged]}
        net = fitted(np.concatenate([inputs[id(s)] for s in samples]), right)
        chances = {id(s): exclusive(network(net, inputs[id(s)]), s.candidates) for s in [*samples, *judged]}
        nets["context"].append(net)
        report(f"round {number + 1}", judged, chances)
    return nets


def report(step: str, judged: list[Sample], chances: dict) -> None:
    if not judged:
        return
    for turned in (False, True):
        chosen = [s for s in judged if bool(s.features[0, -1]) == turned]
        if not chosen:
            continue
        p = np.concatenate([chances[id(s)] for s in chosen]).clip(1e-7, 1 - 1e-7)
        y = np.concatenate([s.right for s in chosen])
        loss = -(np.log(p[y]).sum() + np.log(1 - p[~y]).sum()) / y.sum()
        bins = [(p >= a) & (p < b) for a, b in ((0.3, 0.5), (0.5, 0.7), (0.7, 0.9), (0.9, 0.99), (0.99, 1.0))]
        table = " ".join(f"{p[b].mean():.2f}:{y[b].mean():.2f}({b.sum()})" for b in bins if b.any())
        print(f"{step}{' turned' if turned else ''}: loss a true join {loss:.4f}, recall at .9 {(y & (p > .9)).sum() / y.sum():.4f}; "
              f"said:right(joins) {table}", flush=True)  # fmt: skip


def single(samples: list[Sample]) -> dict[str, list[float]]:
    """Constant and slope of each measure alone, logistic in log N."""
    from sklearn.linear_model import LogisticRegression

    result = {}
    for measure in CODES.keys() | {"mgc-pt"}:
        n = [
            gallagher_ratio(dissimilarity_of_pairs(measure, s.strips, s.candidates.pairs, parts=2), s.candidates)
            for s in samples
        ]
        model = LogisticRegression(C=1e4).fit(
            np.log(np.concatenate(n))[:, None], np.concatenate([s.right for s in samples])
        )
        result[measure] = [float(model.intercept_[0]), float(model.coef_[0, 0])]
    return dict(sorted(result.items()))


def placed(data: Path) -> list[float]:
    """Constant and slopes of the confidence of placed joins, fitted to assembled pictures of the training."""
    from sklearn.linear_model import LogisticRegression

    from engine.puzzles.gridreading import contact_odds
    from engine.puzzles.learned import contact_inputs
    from engine.puzzles.parameters import PuzzleParameters
    from engine.puzzles.scoring import right_joins
    from engine.puzzles.solving import assemble, prepare

    inputs, right = [], []
    chosen = [row for kind in ("clean", "worn") for _, row in recipes(data, kind) if row[3] == 28 and not row[5]]
    for path, mode, columns, px, seed, _, wear in (row for row in chosen if row[1] in ("bright", "dark") or row[6]):
        puzzle, truth = cut(picture(path, mode, columns, px, np.random.default_rng(seed)), piece_size=px, seed=seed + 50)
        if wear:
            puzzle, truth = worn(puzzle, truth, wear, seed)
        prepared = prepare(puzzle, PuzzleParameters())
        solution = assemble(prepared, PuzzleParameters(method="mst"))
        sides = 4 * solution.joins.sides[:, [0, 2]] + solution.joins.sides[:, [1, 3]]
        inputs.append(contact_inputs(*contact_odds(prepared.evidence, sides)))
        right.append(right_joins(puzzle, truth, solution))
    model = LogisticRegression(C=10, max_iter=3000).fit(np.concatenate(inputs), np.concatenate(right))
    return [float(model.intercept_[0]), *map(float, model.coef_[0])]


def plain(value: object) -> object:
    if isinstance(value, np.ndarray):
        return [plain(v) for v in value] if value.ndim > 1 else [float(f"{v:.5g}") for v in value]
    if isinstance(value, dict):
        return {k: plain(v) for k, v in value.items()}
    return [plain(v) for v in value] if isinstance(value, list) else value


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--kinds", nargs="+", default=["clean", "worn", "placed"])
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--quick", action="store_true", help="fit on fewer wrong candidates, with more weight")
    parser.add_argument("--no-judging", action="store_true", help="do not make the first fit")
    options = parser.parse_args()
    content = json.loads(FILE.read_text()) if FILE.exists() else {}
    for kind in options.kinds:
        if kind == "placed":
            content["placed"] = placed(options.data)
            print("placed", np.round(content["placed"], 3))
            FILE.write_text(json.dumps(content, separators=(",", ":")) + "\n", encoding="utf-8")
            continue
        made = [(left_out, sample(*arguments)) for left_out, arguments in recipes(options.data, kind)]
        print(f"{kind}: {len(made)} puzzles, {sum(len(s.right) for _, s in made)} candidates", flush=True)
        if not options.no_judging:
            train([s for out, s in made if not out], [s for out, s in made if out], 3)
        if options.write:
            content[kind] = plain(train([s for _, s in made], [], 3))
            if kind == "clean":
                content["single"] = plain(single([s for _, s in made if not s.features[0, -1]]))
            FILE.write_text(json.dumps(content, separators=(",", ":")) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
