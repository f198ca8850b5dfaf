"""The methods that Concord is measured against: on the bottom layer alone, and the full rule of diffusion pruning."""

import numpy as np

from ..consistency.assignment import assign
from ..consistency.candidates import k_best
from ..consistency.diffusion import greedy, stationary
from ..consistency.growing import grow
from ..consistency.spectral import principal
from .agreement import affinity_degrees, affinity_table, isometry
from .hops import UNREACHABLE, diameter, hop_distances
from .judged import beside_pins
from .parameters import MatchParameters
from .proposing import Proposals, geometric_distance, looks_distance, open_rows

_HOPS = np.arange(UNREACHABLE + 1)

Matched = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def match_bottom(proposals: Proposals, p: MatchParameters) -> Matched:
    """The thesis's first stage by itself: diffusion pruning of segments, with hops in the segment graph.

    Rows of `proposals.pairs` that are accepted, best first, with score, similarity and votes (each (p,)), as all
    methods give them. Score is π relative to the best candidate.
    """
    similarity = np.exp(-geometric_distance(proposals, p) / p.sigma)
    possible = proposals.bottom & beside_pins(proposals) & open_rows(proposals)
    rows = np.flatnonzero(possible & (np.exp(-looks_distance(proposals, p) / p.sigma) >= p.lfd_threshold))
    rows = rows[k_best(proposals.pairs[rows], -similarity[rows], p.K, side=0)]
    rows = np.union1d(rows, np.flatnonzero(possible & proposals.pinned))
    hops = [hop_distances(len(s.graph.area), s.graph.edges) for s in (proposals.source, proposals.target)]
    walk = _Walk(proposals.pairs[rows], similarity[rows], hops, p.delta_1, p.c_0, power=1)
    fixed = np.flatnonzero(proposals.pinned[rows])

    def conflicts(a: int, others: np.ndarray) -> np.ndarray:
        by_source, by_target, k = walk.relate(a, others)
        return by_source & by_target & (k < p.c_2)

    accepted = greedy(walk.pairs, walk.confidence, conflicts, fixed=fixed)
    return _ranked(proposals, rows[accepted], walk.relative(accepted), p)


def match_diffusion(proposals: Proposals, p: MatchParameters) -> Matched:
    """The full rule of diffusion pruning (Tam et al. 2014) on all nodes; see `growing.grow`.

    Affinity is ((k - c₀)/(1 - c₀))² inside the local regions, with the similarity on the diagonal as in Eq 3.3, so that
    candidates without support are looked at, too. Score is π relative to the best candidate.
    """
    similarity = np.exp(-geometric_distance(proposals, p) / p.sigma)
    possible = beside_pins(proposals) & open_rows(proposals)
    rows = np.flatnonzero(possible & (np.exp(-looks_distance(proposals, p) / p.sigma) >= p.lfd_threshold))
    rows = rows[k_best(proposals.pairs[rows], -similarity[rows], p.K, side=0)]
    rows = np.union1d(rows, np.flatnonzero(proposals.pinned))
    hops = [proposals.source.hops, proposals.target.hops]
    walk = _Walk(proposals.pairs[rows], similarity[rows], hops, p.delta_2, p.c_0, power=2)
    accepted = grow(walk.pairs, walk.confidence, walk.relate, c_0=p.c_0, c_1=p.c_1, c_2=p.seed_min,
                    fixed=np.flatnonzero(proposals.pinned[rows]))  # fmt: skip
    return _ranked(proposals, rows[accepted], walk.relative(accepted), p)


class _Walk:
    """The random walk on some candidates: regions, isometric consistency, and the confidence π of Eq 3.4."""

    def __init__(self, pairs: np.ndarray, similarity: np.ndarray, hops: list[np.ndarray], delta: float, c_0: float, *,
                 power: int):  # fmt: skip
        self.pairs, self.hops = pairs, hops
        self.reach = [int(delta * diameter(d) + 1e-9) for d in hops]
        self.isometry = isometry(_HOPS[:, None], _HOPS)
        table = affinity_table(self.reach[0], self.reach[1], c_0) ** power
        self.confidence = stationary(affinity_degrees(pairs, similarity, hops[0], hops[1], table))

    def relate(self, a: int, others: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Whether the ends of `others` lie in the regions of a, and their isometric consistency m (Eq 3.3) with a."""
        p, q = (d[self.pairs[a, side], self.pairs[others, side]] for side, d in enumerate(self.hops))
        return p <= self.reach[0], q <= self.reach[1], self.isometry[p, q]

    def relative(self, rows: np.ndarray) -> np.ndarray:
        """π of some candidates, relative to the best of all."""
        return self.confidence[rows] / max(float(self.confidence.max(initial=0.0)), 1e-300)


def match_hungarian(proposals: Proposals, p: MatchParameters) -> Matched:
    """The assignment of segments with the least sum of geometric distances; those beyond `distance_max` stay unmatched.

    Score is 1 - distance / `distance_max`.
    """
    distance = geometric_distance(proposals, p)
    rows = np.flatnonzero(proposals.bottom & beside_pins(proposals) & open_rows(proposals) & ~proposals.pinned)
    rows = rows[assign(proposals.pairs[rows], distance[rows], p.distance_max)]
    return _ranked(proposals, rows, 1 - distance[rows] / p.distance_max, p)


def match_spectral(proposals: Proposals, p: MatchParameters) -> Matched:
    """Spectral matching of segments (Leordeanu & Hebert 2005), one-to-one.

    Candidates are the K nearest in both directions. Two support each other by 1 - (Δ/3σ)² where the geodesic distances
    of their segments differ by Δ < 3σ, weighted by how near they are; the principal eigenvector is their confidence.
    """
    distance = geometric_distance(proposals, p)
    rows = np.flatnonzero(proposals.bottom & beside_pins(proposals) & open_rows(proposals))
    pairs = proposals.pairs[rows]
    near = k_best(pairs, distance[rows], p.K, side=0) | k_best(pairs, distance[rows], p.K, side=1)
    rows = rows[near | proposals.pinned[rows]]
    i, j = proposals.pairs[rows].T
    g = np.exp(-distance[rows] / p.g_scale)
    apart = [shape.measures.geodesic[np.ix_(x, x)] for shape, x in ((proposals.source, i), (proposals.target, j))]
    support = np.maximum(1 - (np.subtract(*apart, dtype=np.float64) / (3 * p.geodesic_sigma)) ** 2, 0.0)
    support[(i[:, None] == i) | (j[:, None] == j)] = 0.0
    affinity = g[:, None] * support * g
    np.fill_diagonal(affinity, g)
    confidence = principal(affinity)
    confidence = np.where(confidence >= p.confidence_min, confidence, 0.0)
    accepted = greedy(proposals.pairs[rows], confidence, lambda a, others: np.zeros(len(others), dtype=bool),
                      fixed=np.flatnonzero(proposals.pinned[rows]))  # fmt: skip
    return _ranked(proposals, rows[accepted], confidence[accepted], p)


def _ranked(proposals: Proposals, rows: np.ndarray, score: np.ndarray, p: MatchParameters) -> Matched:
    """Accepted rows best first, with the pinned ones that the method did not look at (score 1) before all others."""
    missing = np.setdiff1d(np.flatnonzero(proposals.pinned), rows)
    rows, score = np.concatenate([missing, rows]), np.concatenate([np.ones(len(missing)), np.clip(score, 0, 1)])
    order = np.lexsort((rows, -score))
    rows = rows[order]
    return rows, score[order], np.exp(-proposals.lfd[rows] / p.sigma), np.zeros(len(rows), dtype=np.int64)
