"""Which matches of a result say something new, and which follow from smaller ones."""

import numpy as np


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
