"""Wishes carried over to other labels of the same meshes: a union stays where its faces are whole segments again."""

from collections.abc import Sequence

import numpy as np

from .segmentation import SegmentedShape
from .wishes import NO_WISHES, Node, Wishes


def carried(
    wishes: Wishes, before: Sequence[SegmentedShape], after: Sequence[SegmentedShape]
) -> tuple[Wishes, int]:
    """The wishes of one pair of shapes for another, and how many of them no longer fit.

    All are lost where a mesh is another one; else a wish stays if the faces of both its unions are those of some of the
    new segments.
    """
    count = len(wishes.pinned) + len(wishes.forbidden)
    if not all(_same_mesh(a, b) for a, b in zip(before, after, strict=True)):
        return NO_WISHES, count
    kept = []
    for pairs in (wishes.pinned, wishes.forbidden):
        moved = [tuple(_union(u, a, b) for u, a, b in zip(pair, before, after, strict=True)) for pair in pairs]
        kept.append(tuple((s, t) for s, t in moved if s and t))
    found = Wishes(*kept)
    return found, count - len(found.pinned) - len(found.forbidden)


def _same_mesh(a: SegmentedShape, b: SegmentedShape) -> bool:
    return a.mesh is b.mesh or (
        np.array_equal(a.mesh.faces, b.mesh.faces) and np.array_equal(a.mesh.vertices, b.mesh.vertices, equal_nan=True))  # fmt: skip


def _union(union: Node, before: SegmentedShape, after: SegmentedShape) -> Node:
    """The rows of the new segments that make up a union, or none."""
    faces = np.isin(before.segmentation.labels, union)
    labels, count = after.segmentation.labels, after.segmentation.count
    inside = np.bincount(labels[faces], minlength=count)
    rows = np.flatnonzero(inside)
    return tuple(rows.tolist()) if np.array_equal(inside[rows], np.bincount(labels, minlength=count)[rows]) else ()
