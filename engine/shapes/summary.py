"""Which matches of a result to show first: those that say something new, in groups that do not overlap."""

import numpy as np

from .result import MatchResult


def implied(source_members: np.ndarray, target_members: np.ndarray) -> np.ndarray:
    """Which matches follow from smaller ones, (p,) bool.

    A match is implied where the other matches inside it, on both sides, unite to exactly its source and its target.
    `source_members` (p, s) and `target_members` (p, t) bool.
    """
    s, t = source_members.astype(np.float32), target_members.astype(np.float32)
    inside = ((s @ s.T) >= s.sum(axis=1)[:, None]) & ((t @ t.T) >= t.sum(axis=1)[:, None])
    size = s.sum(axis=1) + t.sum(axis=1)
    inside &= size[:, None] < size[None]  # inside[a, b]: a is a smaller match within b
    united = [(inside.T.astype(np.float32) @ m > 0) >= (m > 0) for m in (s, t)]
    return united[0].all(axis=1) & united[1].all(axis=1)


def overviews(result: MatchResult, most: int = 3) -> list[np.ndarray]:
    """Rows of a result in groups that can be drawn without clutter.

    The first group holds all one-to-one matches. Each further one, at most `most`, holds matches of merged segments
    that are not implied by smaller ones and share no segment within the group, fewest segments first.
    """
    s, t = result.source_members, result.target_members
    size = s.sum(axis=1) + t.sum(axis=1)
    groups = [np.flatnonzero(size == 2)]
    left = np.flatnonzero((size > 2) & ~implied(s, t))
    left = left[np.lexsort((-result.score[left], size[left]))]
    for _ in range(most):
        used_s, used_t, taken = np.zeros(s.shape[1], bool), np.zeros(t.shape[1], bool), []
        for row in left:
            if not (used_s & s[row]).any() and not (used_t & t[row]).any():
                taken.append(row)
                used_s |= s[row]
                used_t |= t[row]
        if not taken:
            break
        groups.append(np.array(taken, dtype=np.int64))
        left = left[~np.isin(left, taken)]
    return groups
