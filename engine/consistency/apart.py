"""MatchLift on sparse input of any size: without a bound on the universe it falls apart into independent programmes.

Every match costs λ > 0 and only the input W earns it back, so where no input leads from one set of elements to another
the optimum has X = 0 between them, and each connected component can be lifted alone.
"""

from collections.abc import Sequence

import numpy as np

from ..errors import BadInput
from ..progress import Progress, silent
from .matchlift import matchlift


def matchlift_apart(
    edges: np.ndarray,
    similarity: np.ndarray,
    unlike: Sequence[np.ndarray],
    queries: np.ndarray,
    *,
    largest: int,
    sparsity: float,
    penalty: float,
    tolerance: float,
    max_steps: int,
    progress: Progress = silent,
) -> np.ndarray:
    """The lifted matches X of some pairs of elements, (q,) in [0, 1], component by component.

    Parameters
    ----------
    edges, similarity
        The input: pairs of elements (e, 2) int64 and their similarity (e,) in (0, 1].
    unlike
        Labels (n,) of the elements: two that share a label, such as that of their object, are never the same.
    queries
        (q, 2) int64: the pairs wanted.
    largest
        No component has more elements: the weakest links that would make it larger are left out.
    sparsity, penalty, tolerance, max_steps
        As for `matchlift`.

    Raises
    ------
    BadInput
        Where an edge joins two elements that share a label.
    """
    if any((label[edges[:, 0]] == label[edges[:, 1]]).any() for label in unlike):
        raise BadInput("The input of MatchLift joins two elements that can never be the same; leave such pairs out.")
    component = capped_components(edges, similarity, len(unlike[0]), largest)
    inside = component[edges[:, 0]] == component[edges[:, 1]]
    edges, similarity = edges[inside], similarity[inside]
    asked = np.flatnonzero(component[queries[:, 0]] == component[queries[:, 1]])
    found, local = np.zeros(len(queries)), np.zeros(len(component), dtype=np.int64)
    members = _split(np.arange(len(component)), component)
    own_edges, own_queries = _split(np.arange(len(edges)), component[edges[:, 0]]), _split(asked, component[queries[asked, 0]])
    done = 0
    for name, wanted in own_queries.items():
        here = members[name]
        local[here] = np.arange(len(here))
        apart = _either([label[here] for label in unlike])
        rows = own_edges.get(name, np.zeros(0, dtype=np.int64))
        x = _lift(local[edges[rows]], similarity[rows], apart, sparsity, penalty, tolerance, max_steps)
        found[wanted] = x[local[queries[wanted, 0]], local[queries[wanted, 1]]]
        done += len(wanted)
        progress(done / len(asked), "lifting matches")
    return found


def _lift(
    edges: np.ndarray, weight: np.ndarray, apart: np.ndarray, sparsity: float, penalty: float, tolerance: float, max_steps: int
) -> np.ndarray:
    """X of one component."""
    n = len(apart)
    similarity = np.zeros((n, n))
    np.maximum.at(similarity, (np.r_[edges[:, 0], edges[:, 1]], np.r_[edges[:, 1], edges[:, 0]]), np.r_[weight, weight])
    if apart.sum() == n and all_the_same(similarity, sparsity):
        return np.ones((n, n))
    return matchlift(similarity, np.arange(n), universe=None, impossible=apart, sparsity=sparsity, penalty=penalty,
                     tolerance=tolerance, max_steps=max_steps).matches  # fmt: skip


def all_the_same(similarity: np.ndarray, sparsity: float) -> bool:
    """Whether X = 1 is the one optimum of n elements that may all be the same.

    It is where the Laplacian of W - λ is positive semidefinite, which is then the dual solution, of rank n - 1.
    """
    gain = similarity - sparsity
    np.fill_diagonal(gain, 0)
    values = np.linalg.eigvalsh(np.diag(gain.sum(axis=1)) - gain)
    return bool(values[0] > -1e-9 and (len(values) < 2 or values[1] > 1e-6))


def _either(labels: list[np.ndarray]) -> np.ndarray:
    """Pairs of rows that share any label, (n, n) bool."""
    return np.any([label[:, None] == label[None] for label in labels], axis=0)


def _split(items: np.ndarray, group: np.ndarray) -> dict[int, np.ndarray]:
    """The items of each group, by its number."""
    order = np.argsort(group, kind="stable")
    names, starts = np.unique(group[order], return_index=True)
    return dict(zip(names.tolist(), np.split(items[order], starts[1:]), strict=True)) if len(items) else {}


def capped_components(edges: np.ndarray, weight: np.ndarray, count: int, largest: int) -> np.ndarray:
    """Which component each of n elements is in, (n,) int64: joined by the heaviest edges first, never above `largest`."""
    parent, size = list(range(count)), [1] * count

    def root(a: int) -> int:
        while parent[a] != a:
            parent[a] = parent[parent[a]]
            a = parent[a]
        return a

    for a, b in edges[np.argsort(-weight, kind="stable")].tolist():
        a, b = root(a), root(b)
        if a != b and size[a] + size[b] <= largest:
            parent[b], size[a] = a, size[a] + size[b]
    return np.array([root(a) for a in range(count)], dtype=np.int64)
