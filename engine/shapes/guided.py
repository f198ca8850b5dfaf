"""Wishes put into proposals: pinned pairs that are missing are added, and all are marked for the methods."""

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache

import numpy as np

from .describing import DescribedShape
from .extending import with_nodes
from .proposing import Proposals, with_pairs
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
    pinned = _pairs(wishes.pinned, source, target)
    extra = pinned[~np.isin(_code(pinned), _code(proposals.pairs))]
    if len(extra) or source is not proposals.source or target is not proposals.target:
        proposals = with_pairs(proposals, source, target, extra)
    code = _code(proposals.pairs)
    barred = np.isin(code, _code(_pairs(wishes.forbidden, source, target)))
    return replace(proposals, pinned=np.isin(code, _code(pinned)), barred=barred)


def _members(nodes: Iterable[Node], count: int) -> np.ndarray:
    """Memberships (q, s) bool of unions given by the rows of their segments."""
    return np.array([np.isin(np.arange(count), node) for node in nodes], dtype=bool).reshape(-1, count)


def _pairs(pairs: Iterable[Pair], source: DescribedShape, target: DescribedShape) -> np.ndarray:
    """Rows of the nodes of those pairs (q, 2) that both graphs have."""
    rows = [{tuple(np.flatnonzero(m).tolist()): k for k, m in enumerate(shape.layers.members)} for shape in (source, target)]
    found = [(rows[0][s], rows[1][t]) for s, t in pairs if s in rows[0] and t in rows[1]]
    return np.array(found, dtype=np.int64).reshape(-1, 2)


def _code(pairs: np.ndarray) -> np.ndarray:
    """One number for each pair."""
    return pairs[:, 0] << 32 | pairs[:, 1]
