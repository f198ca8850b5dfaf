"""Wishes put into proposals: pinned pairs that are missing are added, and all are marked for the methods."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from .describing import DescribedShape
from .extending import with_nodes
from .proposing import Proposals, codes, with_pairs
from .wishes import Node, Pair, Wishes, check_segments


@lru_cache(maxsize=2)  # a slider that moves asks for the same again
def with_wishes(proposals: Proposals, wishes: Wishes) -> Proposals:
    """The proposals with the rows of all wishes marked as pinned or barred.

    A pinned pair that was not proposed is added with its exact distances, its nodes too where the graphs lack them; a
    forbidden pair that was not proposed needs nothing. Raises `BadInput` where a wish names a segment that is not there.
    """
    source, target = proposals.source, proposals.target
    check_segments(wishes, len(source.segment_ids), len(target.segment_ids))
    source = with_nodes(source, _members((s for s, _ in wishes.pinned), len(source.segment_ids)))
    target = with_nodes(target, _members((t for _, t in wishes.pinned), len(target.segment_ids)))
    pinned, barred = (_pairs(pairs, source, target) for pairs in (wishes.pinned, wishes.forbidden))
    extra = pinned[_rows(proposals, pinned) < 0]
    if len(extra) or source is not proposals.source or target is not proposals.target:
        proposals = with_pairs(proposals, source, target, extra)
    marks = np.zeros((2, len(proposals.pairs)), dtype=bool)
    for mark, pairs in zip(marks, (pinned, barred), strict=True):
        rows = _rows(proposals, pairs)
        mark[rows[rows >= 0]] = True
    return replace(proposals, pinned=marks[0], barred=marks[1])


def _members(nodes: Iterable[Node], count: int) -> np.ndarray:
    """Memberships (q, s) bool of unions given by the rows of their segments."""
    return np.array([np.isin(np.arange(count), node) for node in nodes], dtype=bool).reshape(-1, count)


def _pairs(pairs: Sequence[Pair], source: DescribedShape, target: DescribedShape) -> np.ndarray:
    """Rows of the nodes of those pairs (q, 2) that both graphs have."""
    found = np.full((len(pairs), 2), -1, dtype=np.int64)
    for side, shape in enumerate((source, target)):
        known = {row.tobytes(): k for k, row in enumerate(np.packbits(shape.layers.members, axis=1))}
        wanted = np.packbits(_members((pair[side] for pair in pairs), len(shape.segment_ids)), axis=1)
        found[:, side] = [known.get(row.tobytes(), -1) for row in wanted]
    return found[(found >= 0).all(axis=1)]


def _rows(proposals: Proposals, pairs: np.ndarray) -> np.ndarray:
    """Rows (q,) of pairs (q, 2) among the proposals, -1 for those that are not there."""
    known, wanted = (codes(p) for p in (proposals.pairs, pairs))
    rows = np.minimum(np.searchsorted(known, wanted), len(known) - 1)
    return np.where(known[rows] == wanted, rows, -1)
