"""Hierarchical voting (thesis, Algorithm 1, mended): matches must nest on both sides alike."""

import numpy as np


def nesting(members: np.ndarray) -> np.ndarray:
    """Whether node a is a proper part of node b, (p, p) bool, from the memberships (p, s) bool of p nodes."""
    m = members.astype(np.float32)
    size = m.sum(axis=1)
    return ((m @ m.T) >= size[:, None]) & (size[:, None] < size[None])


def containment(inside_source: np.ndarray, inside_target: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Votes and conflicts of matches from strict containment.

    `inside_source[a, b]` (p, p) bool says that the source node of match a is a proper part of that of match b,
    `inside_target` the same for the targets. Returns votes (p,) int64, the number of matches that hold a on both
    sides, and conflicts (p, p) bool, where one side nests and the other does not, in either direction.
    """
    votes = (inside_source & inside_target).sum(axis=1)
    differ = inside_source != inside_target
    return votes, differ | differ.T


def vote(
    inside_source: np.ndarray, inside_target: np.ndarray, confidence: np.ndarray, *, fixed: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Accept matches by descending votes, ties by confidence, then index, where they conflict with none accepted.

    Those of `fixed` (p,) bool come first and are accepted even where they conflict with each other. Returns the
    accepted rows in order of acceptance, and the votes (p,) of all matches.
    """
    votes, conflict = containment(inside_source, inside_target)
    blocked = np.zeros(len(votes), dtype=bool)
    accepted = []
    certain = np.zeros(len(votes), dtype=bool) if fixed is None else fixed
    for a in np.lexsort((np.arange(len(votes)), -confidence, -votes, ~certain)):
        if certain[a] or not blocked[a]:
            accepted.append(int(a))
            blocked |= conflict[a]
    return np.array(accepted, dtype=np.int64), votes
