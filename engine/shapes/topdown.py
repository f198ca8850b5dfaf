"""The top-down method: unions are matched by how they overlap and how far apart they are, segments last."""

import numpy as np

from ..consistency.candidates import k_best
from ..consistency.diffusion import greedy
from ..consistency.voting import containment, nesting
from .agreement import overlap_agreement, overlap_clashes, overlap_scores
from .parameters import MatchParameters
from .proposing import Proposals, geometric_distance, open_rows


def match_top_down(proposals: Proposals, p: MatchParameters) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Rows of `proposals.pairs` that are accepted, best first, with score, similarity and votes (each (p,)).

    1. distance = that of `geometric_distance`; g = exp(-distance/scale); K best both ways.
    2. score(a) = g_a Σ_b relu((m_ab - from)/(1 - from)) g_b, where m = r · ratio of geodesic distances.
    3. Greedy, one-to-one; a match must agree with every accepted one (r and ratio).
    4. Bottom pairs last, by (mean m to the accepted)² · √g.

    What people have pinned comes before 3 and is taken as certain: its g is 1, and candidates that disagree with it
    support nothing.

    The score reported is the mean agreement m with the other accepted matches, in [0, 1].
    """
    distance = geometric_distance(proposals, p)
    g = np.where(proposals.pinned, 1.0, np.exp(-distance / p.g_scale))
    pairs = proposals.pairs
    rows = np.flatnonzero(open_rows(proposals))
    rows = rows[k_best(pairs[rows], distance[rows], p.K, side=0) | k_best(pairs[rows], distance[rows], p.K, side=1)]
    pins = np.flatnonzero(proposals.pinned)
    rows = np.union1d(_fitting(proposals, rows, pins, p), pins)
    near = pairs[rows]
    scores = overlap_scores(near, g[rows], proposals.packed_source, proposals.packed_target, p.agree_from)

    def conflicts(a: int, others: np.ndarray) -> np.ndarray:
        (i, j), source, target = near[a], proposals.packed_source, proposals.packed_target
        return overlap_clashes(i, j, near, others, source, target, p.overlap_min, p.ratio_min)

    accepted = rows[greedy(near, scores, conflicts, fixed=np.searchsorted(rows, pins))]
    accepted = np.concatenate([accepted, _bottom_last(proposals, accepted, distance, g, p)])
    r, ratio = _agree(proposals, pairs[accepted][:, None], pairs[accepted][None])
    m = r * ratio
    score = (m.sum(axis=1) - m.diagonal()) / max(len(accepted) - 1, 1)
    source, target = proposals.source.layers.members, proposals.target.layers.members
    votes = containment(nesting(source[pairs[accepted, 0]]), nesting(target[pairs[accepted, 1]]))[0]
    order = np.argsort(-score, kind="stable")
    return accepted[order], np.clip(score[order], 0, 1), np.exp(-proposals.lfd[accepted[order]] / p.sigma), votes[order]


def _bottom_last(
    proposals: Proposals, accepted: np.ndarray, distance: np.ndarray, g: np.ndarray, p: MatchParameters
) -> np.ndarray:
    """Bottom pairs that fit what is accepted, between segments that are no end of an accepted match yet.

    The `bottom_K` nearest free targets of each free source segment are looked at.
    """
    pairs = proposals.pairs
    taken = pairs[accepted]
    free = proposals.bottom & ~proposals.barred
    rows = np.flatnonzero(free & ~np.isin(pairs[:, 0], taken[:, 0]) & ~np.isin(pairs[:, 1], taken[:, 1]))
    if not len(accepted) or not len(rows):
        return np.zeros(0, dtype=np.int64)
    rows = rows[k_best(pairs[rows], distance[rows], p.bottom_K, side=0)]
    rows = _fitting(proposals, rows, np.flatnonzero(proposals.pinned), p)
    r, ratio = _agree(proposals, pairs[rows][:, None], taken[None])
    mean = (r * ratio).mean(axis=1)
    confidence = np.where(mean >= p.bottom_min, mean**2 * np.sqrt(g[rows]), 0.0)
    return rows[greedy(pairs[rows], confidence, lambda a, others: np.zeros(len(others), dtype=bool))]


def _fitting(proposals: Proposals, rows: np.ndarray, pins: np.ndarray, p: MatchParameters) -> np.ndarray:
    """Those of the rows that agree with every pinned one."""
    r, ratio = _agree(proposals, proposals.pairs[rows][:, None], proposals.pairs[pins][None])
    return rows[((r >= p.overlap_min) & (ratio >= p.ratio_min)).all(axis=1)]


def _agree(proposals: Proposals, a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return overlap_agreement(proposals.packed_source, proposals.packed_target, a, b)
