"""Parts that are the same in all objects of a collection: groups of atoms, cut from how they match."""

import numpy as np

NONE = -1


def consistent_parts(matches: np.ndarray, objects: np.ndarray, size: np.ndarray, *, part_from: float) -> np.ndarray:
    """The part of each atom, (n,) int64: 0 is the largest in all; -1 where it is matched with nothing elsewhere.

    Two atoms, of one object or of two, belong together where their ways of up to two steps lead to the same atoms: the
    cosine of the rows of (I + B)², with B the matches between objects. Groups are joined by mean cosine (average linkage) down
    to `part_from`. A group within a single object is no part. As parts are groups, they agree around every cycle.

    Parameters
    ----------
    matches
        (n, n) symmetric, in [0, 1]; entries within an object are ignored.
    objects, size
        (n,) the object and the size of each atom.
    part_from
        Least mean cosine in [0, 1] of two groups that are joined: higher makes more and smaller parts.
    """
    out = np.full(len(objects), NONE, dtype=np.int64)
    between = np.where(objects[:, None] != objects, matches, 0.0)
    known = np.flatnonzero(between.any(axis=1))
    if not len(known):
        return out
    step = np.eye(len(between)) + between
    groups = _linked(_cosines(step @ step[:, known]), part_from)
    shared = [g for g in range(groups.max() + 1) if len(np.unique(objects[known[groups == g]])) > 1]
    weight = [-size[known[groups == g]].sum() for g in shared]
    for part, g in enumerate(np.array(shared, dtype=np.int64)[np.argsort(weight, kind="stable")]):
        out[known[groups == g]] = part
    return out


def _cosines(steps: np.ndarray) -> np.ndarray:
    """Cosines (k, k) of the columns of the ways (n, k)."""
    unit = steps / np.linalg.norm(steps, axis=0)
    return np.clip(unit.T @ unit, 0, 1)


def _linked(alike: np.ndarray, part_from: float) -> np.ndarray:
    """Groups (k,) int64 from 0 by average linkage; sizes of the atoms do not count."""
    if len(alike) == 1:
        return np.zeros(1, dtype=np.int64)
    from scipy.cluster.hierarchy import fcluster, linkage
    from scipy.spatial.distance import squareform

    apart = 1 - (alike + alike.T) / 2
    np.fill_diagonal(apart, 0)
    tree = linkage(squareform(apart, checks=False), "average")
    return fcluster(tree, 1 - part_from + 1e-12, "distance").astype(np.int64) - 1
