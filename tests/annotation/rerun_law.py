"""Re-runs keep votes: a match that was voted on before has its vote, whatever its segments are called now, and no other has."""

import random
import tempfile
from pathlib import Path

import numpy as np
from exchange_world import PARTS, match, run_of, strip

from annotation import study
from engine.shapes.segmentation import Segmentation, SegmentedShape

Faces = frozenset[int]


def relabelled(shape: SegmentedShape, rng: random.Random) -> SegmentedShape:
    """The same segments in another order and under other names."""
    rows = rng.sample(range(PARTS), PARTS)
    names = rng.choice([[f"part {k}" for k in range(PARTS)], rng.sample(range(50), PARTS)])
    return SegmentedShape(shape.mesh, Segmentation(np.array(rows)[shape.segmentation.labels], tuple(names)))


def recut(shape: SegmentedShape, rng: random.Random) -> SegmentedShape:
    """Other segments of the same mesh under the same names: each begins one triangle later."""
    labels = np.roll(np.repeat(np.arange(PARTS), 2), rng.choice([1, 3]))
    return SegmentedShape(shape.mesh, Segmentation(labels, shape.segmentation.names))


def faces(shape: SegmentedShape, rows: tuple[int, ...]) -> Faces:
    return frozenset(np.flatnonzero(np.isin(shape.segmentation.labels, rows)).tolist())


def reruns(count: int, seed: int = 7) -> tuple[int, int]:
    """Add runs one after another; how many matches had the votes of the same parts before, and how many others'.

    What was voted is known here by the sets of triangles alone; the study knows it by its own ids.
    """
    rng = random.Random(seed)
    right = wrong = 0
    base = strip(1), strip(2)
    told: dict[tuple[frozenset, ...], str] = {}
    with tempfile.TemporaryDirectory() as folder, study.create_study(Path(folder) / "a.db", name="Re-runs") as handle:
        for number in range(count):
            shapes = [rng.choice([relabelled, relabelled, relabelled, recut])(shape, rng) for shape in base]
            swapped = rng.random() < 0.5
            chosen = []
            for _ in range(8):
                nodes = [tuple(rng.sample(range(PARTS), rng.choice([1, 1, 2]))) for _ in shapes]
                parts = tuple(faces(shape, node) for shape, node in zip(shapes, nodes, strict=True))
                ends = list(zip(shapes, nodes, strict=True))[:: -1 if swapped else 1]
                chosen.append((match(*ends[0], *ends[1], files=(f"{rng.random()}.off", "x.off")), parts))
            sources = shapes[:: -1 if swapped else 1]
            items = {item.id: item for item, _ in chosen}
            study.add_run(handle, run_of(*sources, list(items.values()), method=rng.choice(["shed", "learned"]), parameters={"K": number}))
            answers = study.answers(handle, "anna")
            for item, parts in chosen:
                expected, found = told.get(parts), answers.get(item.id)
                right += expected is not None and found == expected
                wrong += found != expected
            for item, parts in chosen:
                if parts not in told and rng.random() < 0.5:
                    told[parts] = rng.choice(study.ANSWERS)
                    study.record_vote(handle, item.id, "anna", told[parts])
    return right, wrong
