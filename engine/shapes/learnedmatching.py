"""The learned method: pairs by their calibrated probability, those first that say most, each consistent with all before."""

import numpy as np

from ..consistency.diffusion import greedy
from ..consistency.voting import containment, nesting
from .agreement import overlap_clashes
from .context import Neighbourhood, neighbourhood_of
from .parameters import MatchParameters
from .proposing import Proposals, codes, open_rows


def match_learned(proposals: Proposals, p: MatchParameters) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Rows of `proposals.pairs` that are accepted, best first, with score, similarity and votes (each (p,)).

    The score is the probability that the match is right, 1 for pinned ones; see `learned.judge` and `choose`. Votes are
    the accepted matches that contain a match or are contained in it on both sides. Needs `proposals.judged`.
    """
    judged, pairs = proposals.judged, proposals.pairs
    assert judged is not None
    right, pure = np.zeros(len(pairs)), np.zeros(len(pairs))
    rows = np.searchsorted(codes(pairs), codes(judged.pairs))
    right[rows], pure[rows] = judged.right, judged.pure
    right[~open_rows(proposals)] = 0.0
    right[proposals.pinned] = pure[proposals.pinned] = 1.0
    rows = np.flatnonzero((right >= max(p.probability_min, 1e-9)) | proposals.pinned)
    around = neighbourhood_of(proposals.source, proposals.target, proposals.packed_source, proposals.packed_target)
    pins = np.searchsorted(rows, np.flatnonzero(proposals.pinned))
    accepted = rows[choose(pairs[rows], right[rows], pure[rows], around, p, pinned=pins)]
    accepted = accepted[np.argsort(-right[accepted], kind="stable")]
    i, j = pairs[accepted].T
    votes = containment(nesting(around.members_source[i]), nesting(around.members_target[j]))[0]
    return accepted, right[accepted], np.exp(-proposals.lfd[accepted] / p.sigma), votes


def choose(
    pairs: np.ndarray, right: np.ndarray, pure: np.ndarray, around: Neighbourhood, p: MatchParameters,
    *, pinned: np.ndarray | None = None,
) -> np.ndarray:  # fmt: skip
    """Rows of `pairs` (c, 2) that are accepted, in the order of acceptance.

    Candidates that are `right` with at least `probability_min` are taken in descending right · pure / size^λ, one-to-one,
    if they agree with every accepted one in overlap and distance. `size` is the geometric mean of the shares of area;
    `pinned` rows come first, whatever they exclude.
    """
    i, j = pairs.T
    sizes = (around.members_source.astype(np.float64) @ around.area_source, around.members_target.astype(np.float64) @ around.area_target)
    value = right * pure / np.sqrt(sizes[0][i] * sizes[1][j]) ** p.small_first

    def conflicts(a: int, others: np.ndarray) -> np.ndarray:
        return overlap_clashes(i[a], j[a], pairs, others, around.packed_source, around.packed_target, p.overlap_min, p.ratio_min)

    return greedy(pairs, np.where(right >= p.probability_min, value, 0.0), conflicts, fixed=pinned)
