"""The full rule of diffusion pruning: accepted matches grow from seeds to what lies near them.

After Tam, Martin, Rosin & Lai (2014), "Diffusion pruning for rapidly and robustly selecting global correspondences
using local isometry". The simple rule of the thesis is `diffusion.greedy`.
"""

from collections.abc import Callable

import numpy as np

Relation = Callable[[int, np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]


def grow(
    pairs: np.ndarray,
    confidence: np.ndarray,
    relate: Relation,
    *,
    c_0: float,
    c_1: float,
    c_2: float,
    fixed: np.ndarray | None = None,
) -> np.ndarray:
    """Accept candidates one-to-one in descending confidence, ties by index, where they fit what is accepted nearby.

    B₁ and B₂ are the accepted matches whose source, and whose target, is near that of a candidate, B those of both. If
    |B| / max(|B₁|, |B₂|) > c₁, the candidate is accepted iff k > c₀ with all of B. If B₁ and B₂ are empty, it is
    accepted as a new seed iff k >= c₂ with every seed. Else it waits, and is looked at again after each acceptance.
    So at any time the surest candidate that meets one of the two conditions is next. Candidates with a confidence of
    0 are never accepted.

    Parameters
    ----------
    pairs, confidence
        (c, 2) int64 and (c,) float64.
    relate
        `relate(a, others)`: whether the sources of a and of `others` (rows) are near each other, whether the targets
        are, both bool, and the isometric consistency k in [0, 1] of a with each of them.
    fixed
        Rows accepted before all others, whatever they are; each is a seed where none that came before it is near.

    Returns
    -------
    Rows of the accepted candidates, in the order of acceptance.
    """
    left = np.argsort(-confidence, kind="stable")
    left = left[confidence[left] > 0]
    near = np.zeros((3, len(left)), dtype=np.int64)  # |B₁|, |B₂|, |B|
    far = np.zeros(len(left), dtype=bool)  # k < c₂ with some seed
    accepted: list[int] = []

    def accept(a: int, is_seed: bool) -> None:
        nonlocal left, near, far
        accepted.append(a)
        stays = (pairs[left, 0] != pairs[a, 0]) & (pairs[left, 1] != pairs[a, 1])
        left, near, far = left[stays], near[:, stays], far[stays]
        by_source, by_target, k = relate(a, left)
        both = by_source & by_target
        near, far = near + np.stack([by_source, by_target, both]), far | (is_seed & (k < c_2))
        stays = ~both | (k > c_0)
        left, near, far = left[stays], near[:, stays], far[stays]

    for a in () if fixed is None else fixed.tolist():
        source, target, _ = relate(a, np.array(accepted, dtype=np.int64))
        accept(a, is_seed=not (source | target).any())
    while len(left):
        seed = (near[0] + near[1] == 0) & ~far
        fits = near[2] > c_1 * np.maximum(near[0], near[1])
        at = int(np.argmax(seed | fits))
        if not (seed[at] or fits[at]):
            break
        accept(int(left[at]), bool(seed[at]))
    return np.array(accepted, dtype=np.int64)
