"""Pairs of shapes with known truth as small values that another process can load: files, or a generator and its seed."""

import hashlib
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..shapes.families import make_pair
from ..shapes.meshfile import load_labellings
from ..shapes.oversegmentation import oversegment
from ..shapes.segmentation import SegmentedShape


class ShapeFiles(NamedTuple):
    """A mesh, its truth (one class a face), and its segments: a label file, or a random cut of the truth.

    `labels` is empty where the truth is over-segmented into `segments` (low, high) pieces by `seed`.
    """

    mesh: str
    truth: str
    labels: str = ""
    segments: tuple[int, int] = (10, 16)
    seed: int = 0


class FilePair(NamedTuple):
    """Two shapes from files, of one family."""

    family: str
    name: str
    source: ShapeFiles
    target: ShapeFiles


class MadePair(NamedTuple):
    """A generated pair; see `engine.shapes.families.make_pair`."""

    family: str
    name: str
    seed: int
    variant: str
    segments: tuple[int, int]
    pose: str


Pair = FilePair | MadePair


class LabelledPair(NamedTuple):
    """Two segmented shapes with the class of every face, (m,) int64."""

    source: SegmentedShape
    target: SegmentedShape
    source_label: np.ndarray
    target_label: np.ndarray


def load_pair(pair: Pair) -> LabelledPair:
    """Read or make the two shapes; raises `BadInput` where a file is missing, damaged, or does not fit its mesh."""
    if isinstance(pair, MadePair):
        made = make_pair(pair.family, pair.seed, variant=pair.variant, segments=pair.segments, pose=pair.pose)
        return LabelledPair(made.source, made.target, made.source_label, made.target_label)
    (source, first), (target, second) = load_labelled(pair.source), load_labelled(pair.target)
    return LabelledPair(source, target, first, second)


def load_labelled(files: ShapeFiles) -> tuple[SegmentedShape, np.ndarray]:
    """A shape and the class of each of its faces, (m,) int64; labels and truth may be one a polygon or one a triangle."""
    mesh, (classes, *cuts) = load_labellings(files.mesh, [files.truth, *([files.labels] if files.labels else [])])
    truth = np.array(classes.names, dtype=np.int64)[classes.labels]
    if cuts:
        return SegmentedShape(mesh, cuts[0], files.mesh), truth
    low, high = files.segments
    count = int(np.random.default_rng([files.seed, 15485863]).integers(low, high + 1))
    note = f"The segments of {mesh.name} are a random cut of its truth, seed {files.seed}."
    return SegmentedShape(mesh, oversegment(mesh, truth, segments=count, seed=files.seed), files.mesh, (note,)), truth


def content(pair: Pair) -> tuple[object, ...]:
    """All that a pair depends on: the bytes of its files, or what it is generated from."""
    if isinstance(pair, MadePair):
        return ("made", pair.family, pair.seed, pair.variant, pair.segments, pair.pose)
    return ("files", _shape_content(pair.source), _shape_content(pair.target))


def _shape_content(files: ShapeFiles) -> tuple[object, ...]:
    cut: tuple[object, ...] = (_sha256(files.labels),) if files.labels else (files.segments, files.seed)
    return (_sha256(files.mesh), _sha256(files.truth), *cut)


def _sha256(path: str) -> str:
    status = Path(path).stat()
    return _hashed(path, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=4096)
def _hashed(path: str, _modified: int, _size: int) -> str:
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()
