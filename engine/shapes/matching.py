"""From two segmented shapes to consistent matches: describe each, propose pairs, prune."""

import numpy as np

from ..progress import Progress, share, silent
from ..store import Cache
from .describing import DescribedShape, Stopwatch, describe
from .identity import match_id, node_id
from .parameters import THESIS, MatchParameters
from .proposing import Proposals, propose
from .result import MatchResult
from .segmentation import SegmentedShape
from .thesis import match_thesis
from .topdown import match_top_down

__all__ = ["DescribedShape", "Proposals", "describe", "match_shapes", "propose", "rematch"]


def match_shapes(
    source: SegmentedShape,
    target: SegmentedShape,
    parameters: MatchParameters,
    *,
    preset: str = "",
    progress: Progress = silent,
    cache: Cache | None = None,
) -> MatchResult:
    """Find consistent matches between the segments, and unions of segments, of two shapes.

    `preset` is the name that the parameters go by in the result. Raises `BadInput` where a shape has one segment.
    """
    first = describe(source, parameters, progress=share(progress, 0.0, 0.4), cache=cache)
    second = describe(target, parameters, progress=share(progress, 0.4, 0.8), cache=cache)
    proposals = propose(first, second, parameters, progress=share(progress, 0.8, 0.98), cache=cache)
    progress(0.98, "pruning")
    result = rematch(proposals, parameters, preset=preset)
    progress(1.0, f"{len(result.ids)} matches")
    return result


def rematch(proposals: Proposals, parameters: MatchParameters, *, preset: str = "") -> MatchResult:
    """Choose the matches anew under other live parameters; costs milliseconds."""
    source, target = proposals.source, proposals.target
    watch = Stopwatch()
    with watch("pruning and voting"):
        method = match_thesis if parameters.method == THESIS else match_top_down
        rows, score, similarity, votes = method(proposals, parameters)
    pairs = proposals.pairs[rows]
    members = [shape.layers.members[pairs[:, side]] for side, shape in enumerate((source, target))]
    return MatchResult(
        method=parameters.method, preset=preset, parameters=parameters, source=source.record, target=target.record,
        pairs=pairs, score=score, similarity=similarity, votes=votes,
        source_members=members[0], target_members=members[1],
        source_layer=source.layers.layer[pairs[:, 0]], target_layer=target.layers.layer[pairs[:, 1]],
        ids=_ids(source, target, *members),
        source_nodes=len(source.layers.members), target_nodes=len(target.layers.members),
        seconds=_seconds(source.seconds, target.seconds, proposals.seconds, watch.seconds),
        notes=(*source.notes, *target.notes))  # fmt: skip


def _ids(source: DescribedShape, target: DescribedShape, a: np.ndarray, b: np.ndarray) -> tuple[str, ...]:
    def node(shape: DescribedShape, row: np.ndarray) -> str:
        return node_id(shape.segment_ids[i] for i in np.flatnonzero(row))

    return tuple(match_id(node(source, i), node(target, j)) for i, j in zip(a, b, strict=True))


def _seconds(*parts: dict[str, float]) -> dict[str, float]:
    total: dict[str, float] = {}
    for part in parts:
        for step, value in part.items():
            total[step] = total.get(step, 0.0) + value
    return total

