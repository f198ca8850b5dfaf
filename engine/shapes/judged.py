"""What the pairs that people have judged leave open to a method."""

import numpy as np

from .proposing import Proposals


def beside_pins(proposals: Proposals) -> np.ndarray:
    """Which pairs (c,) bool can stand beside the pinned ones, or are pinned; none of them is barred.

    A pair cannot where its node is a proper part of a pinned node on one side only, or holds it on one side only.
    """
    possible = ~proposals.barred
    pinned = np.flatnonzero(proposals.pinned)
    if len(pinned):
        sides = [_nesting(shape.layers.members, proposals.pairs[:, side], proposals.pairs[pinned, side])
                 for side, shape in enumerate((proposals.source, proposals.target))]  # fmt: skip
        possible &= (sides[0] == sides[1]).all(axis=(0, 2))
        possible |= proposals.pinned
    return possible


def _nesting(members: np.ndarray, nodes: np.ndarray, pinned: np.ndarray) -> np.ndarray:
    """Whether a node is a proper part of a pinned one, and holds it, for all nodes and pinned, (2, c, pins) bool."""
    m = members.astype(np.float32)
    size, shared = m.sum(axis=1), m @ m[pinned].T
    inside = (shared >= size[:, None]) & (size[:, None] < size[pinned])
    holds = (shared >= size[pinned]) & (size[pinned] < size[:, None])
    return np.stack([inside[nodes], holds[nodes]])
