"""Matches of shapes against the known class of every face."""

from collections.abc import Iterable, Sequence

import numpy as np

from ..arrays import frozen_array
from ..errors import BadInput
from ..evaluation.correspondence import WHOLE, Evaluation, evaluate_tables
from .mesh import face_areas
from .result import MatchResult
from .segmentation import SegmentedShape


def label_table(shape: SegmentedShape, label: np.ndarray, classes: np.ndarray) -> np.ndarray:
    """Area of each class in each segment, (s, c) float64; `label` (m,) a face, `classes` (c,) sorted.

    Raises `BadInput` where the labels do not fit the faces or name an unlisted class.
    """
    label = frozen_array(label, np.int64, (None,), "The semantic labels")
    if len(label) != len(shape.mesh.faces):
        raise BadInput(
            f"{shape.mesh.name} has {len(shape.mesh.faces)} faces but {len(label)} semantic labels; give one a face."
        )
    column = np.searchsorted(classes, label)
    if (column >= len(classes)).any() or (classes[column] != label).any():
        raise BadInput(f"The semantic labels of {shape.mesh.name} name a class that is not listed.")
    table = np.zeros((shape.segmentation.count, len(classes)))
    np.add.at(table, (shape.segmentation.labels, column), face_areas(shape.mesh))
    return table


def evaluate_matches(
    source: SegmentedShape,
    target: SegmentedShape,
    source_label: np.ndarray,
    target_label: np.ndarray,
    matches: Iterable[tuple[Sequence[int], Sequence[int]]],
) -> Evaluation:
    """Judge matches (rows of source segments, rows of target segments) by the class of each face, (m,) int64.

    The classes are instances of nothing: left and right legs share one, so a symmetric match is correct.
    """
    classes = np.unique(np.concatenate([source_label, target_label]))
    return evaluate_tables(
        label_table(source, source_label, classes), label_table(target, target_label, classes), matches
    )


def evaluate_result(
    result: MatchResult,
    source: SegmentedShape,
    target: SegmentedShape,
    source_label: np.ndarray,
    target_label: np.ndarray,
) -> Evaluation:
    """Judge all matches of a result."""
    pairs = [(match.source, match.target) for match in result.matches()]
    return evaluate_matches(source, target, source_label, target_label, pairs)


def counts(source: SegmentedShape, target: SegmentedShape, result: MatchResult) -> list[bool]:
    """Whether each match of a result is judged, best first: matches of a (nearly) whole shape never are."""
    judged = np.ones(len(result.ids), dtype=bool)
    for shape, members in ((source, result.source_members), (target, result.target_members)):
        area = np.bincount(shape.segmentation.labels, face_areas(shape.mesh), minlength=shape.segmentation.count)
        judged &= members @ area <= WHOLE * area.sum()
    return judged.tolist()


def lenient_answers(
    source: SegmentedShape, target: SegmentedShape, source_label: np.ndarray, target_label: np.ndarray, result: MatchResult
) -> list[bool]:
    """Whether each match of a result is right by the lenient rule (class overlap of at least one half), best first."""
    members = result.source_members, result.target_members
    return (class_overlap((source, target), (source_label, target_label), members) >= 0.5).tolist()


def class_overlap(
    shapes: tuple[SegmentedShape, SegmentedShape], labels: tuple[np.ndarray, np.ndarray], members: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """How much of their area the two sides of each match have of the same classes, (p,) float64 in [0, 1].

    `labels` are the class of each face (m,) of the two shapes, `members` the segments of each match's sides (p, s).
    """
    classes = np.unique(np.concatenate(labels))
    h, g = (
        side @ label_table(shape, label, classes) for shape, label, side in zip(shapes, labels, members, strict=True)
    )
    p, q = h / h.sum(axis=1, keepdims=True), g / g.sum(axis=1, keepdims=True)
    overlap: np.ndarray = np.minimum(p, q).sum(axis=1)
    return overlap
