"""From two segmented shapes to consistent matches: describe each, propose pairs, prune."""

import numpy as np

from ..progress import Progress, share, silent
from ..store import Cache
from .baselines import match_bottom, match_diffusion, match_hungarian, match_spectral
from .describing import DescribedShape, Stopwatch, describe
from .guided import with_wishes
from .identity import match_id, node_id
from .learnedmatching import match_learned
from .parameters import BOTTOM, DIFFUSION, HUNGARIAN, LEARNED, SHED, SPECTRAL, THESIS, TOP_DOWN, MatchParameters
from .proposing import Proposals, propose, widened, with_judgement
from .result import MatchResult
from .segmentation import SegmentedShape
from .shed import match_shed
from .thesis import match_thesis
from .topdown import match_top_down
from .wishes import NO_WISHES, Wishes

__all__ = ["DescribedShape", "Proposals", "describe", "match_shapes", "propose", "rematch"]

METHODS = {
    LEARNED: match_learned,
    THESIS: match_thesis,
    TOP_DOWN: match_top_down,
    BOTTOM: match_bottom,
    HUNGARIAN: match_hungarian,
    SPECTRAL: match_spectral,
    SHED: match_shed,
    DIFFUSION: match_diffusion,
}


def match_shapes(
    source: SegmentedShape,
    target: SegmentedShape,
    parameters: MatchParameters,
    *,
    preset: str = "",
    wishes: Wishes = NO_WISHES,
    progress: Progress = silent,
    cache: Cache | None = None,
) -> MatchResult:
    """Find consistent matches between the segments, and unions of segments, of two shapes.

    `preset` is the name that the parameters go by in the result; `wishes` are honoured exactly. Raises `BadInput` where
    a shape has one segment, or a wish names one that is not there.
    """
    first = describe(source, parameters, progress=share(progress, 0.0, 0.4), cache=cache)
    second = describe(target, parameters, progress=share(progress, 0.4, 0.8), cache=cache)
    proposals = propose(first, second, parameters, progress=share(progress, 0.8, 0.98), cache=cache)
    progress(0.98, "pruning")
    result = rematch(proposals, parameters, preset=preset, wishes=wishes)
    progress(1.0, f"{len(result.ids)} matches")
    return result


def rematch(
    proposals: Proposals, parameters: MatchParameters, *, preset: str = "", wishes: Wishes = NO_WISHES
) -> MatchResult:
    """Choose the matches anew under other live parameters and wishes; costs milliseconds.

    Every pinned match is among the result and no forbidden one.
    """
    watch = Stopwatch()
    with watch("pruning and voting"):
        proposals = with_judgement(proposals) if parameters.method == LEARNED else widened(proposals, parameters)
        proposals = with_wishes(proposals, wishes) if wishes else proposals
        rows, score, similarity, votes = METHODS[parameters.method](proposals, parameters)
    assert np.isin(np.flatnonzero(proposals.pinned), rows).all(), "a pinned match is missing"
    assert not proposals.barred[rows].any(), "a forbidden match was accepted"
    source, target = proposals.source, proposals.target
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
        notes=(*source.notes, *target.notes), wishes=wishes)  # fmt: skip


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

