"""The thesis's method: two-stage diffusion pruning with anchors, voting, and a second run (sections 3.4 and 3.5)."""

import numpy as np

from ..consistency.candidates import k_best
from ..consistency.diffusion import greedy, stationary
from ..consistency.voting import nesting, vote
from .agreement import affinity_degrees, affinity_table, affinity_total, hop_clashes, isometry
from .hops import UNREACHABLE, diameter
from .parameters import MatchParameters
from .proposing import Proposals, geometric_distance, looks_distance, open_rows


class _Stage:
    """One run of diffusion pruning over some of the proposed pairs: regions, affinity and confidence."""

    def __init__(self, proposals: Proposals, rows: np.ndarray, similarity: np.ndarray, delta: float, p: MatchParameters):
        self.pairs, self.similarity = proposals.pairs[rows], similarity[rows]
        self.pinned = proposals.pinned[rows]
        self.d_source, self.d_target = proposals.source.hops, proposals.target.hops
        self.reach = (int(delta * diameter(self.d_source) + 1e-9), int(delta * diameter(self.d_target) + 1e-9))
        self.table = affinity_table(self.reach[0], self.reach[1], p.c_0)
        hops = np.arange(UNREACHABLE + 1)
        inside = (hops[:, None] <= self.reach[0]) & (hops <= self.reach[1])
        self.clash = inside & (isometry(hops[:, None], hops) < p.c_2)
        degree = affinity_degrees(self.pairs, self.similarity, self.d_source, self.d_target, self.table)
        self.confidence = stationary(degree)

    def conflicts(self, a: int, others: np.ndarray) -> np.ndarray:
        """Which others have both ends inside the local regions of a, but an isometry with a below c₂."""
        i, j = self.pairs[a]
        return hop_clashes(i, j, self.pairs, others, self.d_source, self.d_target, self.clash)

    def accept(self, first: np.ndarray | None = None) -> np.ndarray:
        """Rows accepted greedily, those in `first` before all others, and what is pinned in any case."""
        return greedy(self.pairs, self.confidence, self.conflicts, first=first, fixed=np.flatnonzero(self.pinned))

    def coherence(self, rows: np.ndarray) -> float:
        """xᵀMx / xᵀx of the accepted rows: how well they support each other as a whole."""
        if not len(rows):
            return 0.0
        total = affinity_total(self.pairs[rows], self.d_source, self.d_target, self.table)
        return float((total + self.similarity[rows].sum()) / len(rows))


def match_thesis(proposals: Proposals, p: MatchParameters) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Rows of `proposals.pairs` that are accepted, best first, with score, similarity and votes (each (p,)).

    Score is π relative to the best candidate of the second stage. What people have pinned is an anchor of both stages,
    whatever its similarity, and outlives the voting.
    """
    similarity = np.exp(-geometric_distance(proposals, p) / p.sigma)
    distance = -similarity
    allowed = (np.exp(-looks_distance(proposals, p) / p.sigma) >= p.lfd_threshold) & open_rows(proposals)
    pins = np.flatnonzero(proposals.pinned)
    bottom = np.flatnonzero(allowed & proposals.bottom)
    anchors = np.union1d(bottom[k_best(proposals.pairs[bottom], distance[bottom], p.K, side=0)], pins)
    if p.anchors != "off" and len(anchors):
        anchors = anchors[_Stage(proposals, anchors, similarity, p.delta_1, p).accept()]
    rows = np.flatnonzero(allowed)
    rows = rows[k_best(proposals.pairs[rows], distance[rows], p.K, side=0)]
    rows = np.union1d(rows, anchors if p.anchors != "off" else pins)
    stage = _Stage(proposals, rows, similarity, p.delta_2, p)
    accepted = _second_stage(stage, np.searchsorted(rows, anchors), p)
    kept, votes = _vote(proposals, stage, accepted, p)
    if p.second_run:
        kept, votes = _vote(proposals, stage, stage.accept(kept), p)
    order = np.argsort(-stage.confidence[kept], kind="stable")
    kept, votes = kept[order], votes[order]
    best = max(float(stage.confidence.max(initial=0.0)), 1e-300)
    return rows[kept], stage.confidence[kept] / best, stage.similarity[kept], votes


def _second_stage(stage: _Stage, anchors: np.ndarray, p: MatchParameters) -> np.ndarray:
    if p.anchors == "off":
        return stage.accept()
    anchored = stage.accept(anchors)
    if p.anchors == "first":
        return anchored
    free = stage.accept()
    return anchored if stage.coherence(anchored) >= stage.coherence(free) else free


def _vote(
    proposals: Proposals, stage: _Stage, accepted: np.ndarray, p: MatchParameters
) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the stage that voting keeps, in order, and their votes; all of them where voting is switched off."""
    pairs = stage.pairs[accepted]
    source, target = proposals.source.layers.members[pairs[:, 0]], proposals.target.layers.members[pairs[:, 1]]
    kept, votes = vote(nesting(source), nesting(target), stage.confidence[accepted], fixed=stage.pinned[accepted])
    if not p.voting:
        kept = np.arange(len(accepted))
    return accepted[kept], votes[kept]

