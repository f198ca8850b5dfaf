"""Plain cycle support: how far the matches of three and more objects lead back to where they came from.

A match i → j between objects A and B is supported by a third object C where i's matches into C, and those of C into B,
lead to about j. Objects have nodes, and nodes of one object may be nearly the same (unions that differ a little), so
every step counts by how alike two nodes are.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ..errors import BadInput

Pair = tuple[int, int]


def cycle_support(matches: Mapping[Pair, np.ndarray], alike: Sequence[np.ndarray]) -> dict[Pair, np.ndarray]:
    """Support in [0, 1] of each match, the mean over the third objects C of the best way around by C.

    The way i → x, x' → j', with the matches (i', x) of A and C and (x', j') of C and B, is worth
    alike_A(i, i') · alike_C(x, x') · alike_B(j', j). A cycle that closes exactly is worth 1, and 0 where no way is left.
    The support of a match is the same from either side.

    Parameters
    ----------
    matches
        For each pair of objects (a, b) that was matched, in either order, the matched nodes (p, 2) int64.
    alike
        For each object, (k, k) float64 in [0, 1]: how alike its nodes are, 1 on the diagonal.

    Returns
    -------
    dict
        For each pair (p,) float64; NaN where no third object was matched with both.

    Raises
    ------
    BadInput
        A pair of an object with itself or given twice, or a node that an object does not have.
    """
    _check(matches, alike)
    both = {**{pair: np.asarray(m).reshape(-1, 2) for pair, m in matches.items()}}
    both |= {(b, a): m[:, ::-1] for (a, b), m in list(both.items())}
    return {(a, b): _support(a, b, both, alike) for a, b in matches}


def _support(a: int, b: int, both: Mapping[Pair, np.ndarray], alike: Sequence[np.ndarray]) -> np.ndarray:
    thirds = [c for c in range(len(alike)) if c not in (a, b) and (a, c) in both and (c, b) in both]
    i, j = both[a, b].T
    if not thirds:
        return np.full(len(i), np.nan)
    closed = np.zeros((len(thirds), len(i)))
    for row, c in enumerate(thirds):
        (i_, x), (x_, j_) = both[a, c].T, both[c, b].T
        if len(x) and len(x_):
            there = best_product(alike[a][np.ix_(i, i_)], alike[c][np.ix_(x, x_)])
            closed[row] = (there * alike[b][np.ix_(j, j_)]).max(axis=1)
    return np.clip(closed.mean(axis=0), 0, 1)


def best_product(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Products of matrices with the maximum for the sum: (p, q), max over r of first (p, r) · second (r, q)."""
    out = np.zeros((len(first), second.shape[1]))
    for r in range(len(second)):
        np.maximum(out, first[:, r, None] * second[r], out=out)
    return out


def _check(matches: Mapping[Pair, np.ndarray], alike: Sequence[np.ndarray]) -> None:
    for (a, b), rows in matches.items():
        if a == b or ((b, a) in matches):
            raise BadInput(f"The pair ({a}, {b}) of a collection is matched twice or with itself; give each pair once.")
        for side, node in zip((a, b), np.asarray(rows).reshape(-1, 2).T, strict=True):
            if not 0 <= side < len(alike):
                raise BadInput(f"There is no object {side} in a collection of {len(alike)}; number objects from 0.")
            if len(node) and not (node.min() >= 0 and node.max() < len(alike[side])):
                raise BadInput(f"A match names a node that object {side} of the collection, with {len(alike[side])}, lacks.")
