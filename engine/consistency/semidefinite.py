"""The nearest positive semidefinite matrix: by a full decomposition, or by following the few positive eigenpairs.

Iterations that project slowly changing matrices need not start afresh: the positive eigenvectors of the last matrix
span nearly those of the next. A block of them is filtered by a Chebyshev polynomial that damps the negative part of
the spectrum, made orthonormal, and diagonalised within itself (Zhou, Saad, Tiago & Chelikowsky 2006).
"""

from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

DENSE_BELOW = 600  # orders at which a full decomposition is the faster way
LARGEST_SHARE = 0.55  # of the order: blocks beyond it cost as much as a full decomposition
_FRESH = 4  # random vectors in every block: they find directions that the last block did not hold
_LANCZOS = 8  # steps that bound the spectrum from below


def one_thread() -> AbstractContextManager[Any]:
    """Keeps decompositions on one thread: on a busy machine several wait for each other a hundred times longer."""
    return _controller().limit(limits=1, user_api="blas")


@lru_cache(maxsize=1)
def _controller() -> Any:
    import scipy.linalg  # noqa: F401  (its library must be loaded to be found)
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def nearest_semidefinite(matrix: np.ndarray) -> tuple[np.ndarray, int]:
    """The nearest positive semidefinite matrix (Frobenius) to a symmetric one (n, n), and its rank."""
    values, vectors = _decompose(matrix)
    return _from_part(matrix, values, vectors)


def _decompose(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    from scipy.linalg import eigh

    return eigh(matrix, driver="evd", check_finite=False)


def _from_part(matrix: np.ndarray, values: np.ndarray, vectors: np.ndarray) -> tuple[np.ndarray, int]:
    """The positive part of a decomposed matrix, by the smaller of its two parts."""
    rank = int((values > 0).sum())
    if 2 * rank <= len(values):
        return _product(vectors[:, len(values) - rank :], values[len(values) - rank :]), rank
    return matrix + _product(vectors[:, : len(values) - rank], -values[: len(values) - rank]), rank


def _product(vectors: np.ndarray, values: np.ndarray) -> np.ndarray:
    """V diag(w) Vᵀ for w ≥ 0, exactly symmetric."""
    root = vectors * np.sqrt(np.maximum(values, 0))
    return root @ root.T


@dataclass(slots=True)
class Follower:
    """Projects one slowly changing symmetric matrix after another; the first, and any that has jumped, in full.

    `degree` is that of the filter: a higher one follows faster changes and costs one more product each.
    `dense` counts the full decompositions made, `was_full` says whether the last was one. The random
    vectors are seeded: the same matrices give the same answers.
    """

    degree: int = 2
    dense: int = 0
    was_full: bool = False
    _block: np.ndarray | None = None
    _edge: float = 0.0  # the smallest eigenvalue in the block: the filter damps all below
    _random: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))

    def __call__(self, matrix: np.ndarray) -> tuple[np.ndarray, int]:
        """The nearest positive semidefinite matrix (n, n) and its rank."""
        block = self._block
        if block is not None and len(matrix) >= DENSE_BELOW and block.shape[1] <= LARGEST_SHARE * len(matrix):
            found = self._followed(matrix, block)
            if found is not None:
                self.was_full = False
                return found
        return self.full(matrix)

    def restart(self) -> None:
        """Decompose the next matrix in full."""
        self._block = None

    def full(self, matrix: np.ndarray) -> tuple[np.ndarray, int]:
        """The same by a full decomposition, from which the next matrices are followed."""
        self.dense, self.was_full = self.dense + 1, True
        values, vectors = _decompose(matrix)
        projected, rank = _from_part(matrix, values, vectors)
        self._keep(values, vectors, rank)
        return projected, rank

    def _followed(self, matrix: np.ndarray, block: np.ndarray) -> tuple[np.ndarray, int] | None:
        block = block.copy()
        fresh = self._random.standard_normal((len(matrix), _FRESH)).astype(matrix.dtype) / np.sqrt(len(matrix))
        block[:, :_FRESH] = fresh - block[:, _FRESH:] @ (block[:, _FRESH:].T @ fresh)
        low = min(lower_bound(matrix, self._random), self._edge - 1e-3)
        try:
            filtered = _orthonormal(_filtered(matrix, block, low, min(self._edge, 1e-4 * low), self.degree))
        except np.linalg.LinAlgError:
            return None
        inner, rotation = _decompose(filtered.T @ (matrix @ filtered))
        rank = int((inner > 0).sum())
        if rank + _FRESH >= len(inner):  # all of the block is positive: there may be more outside
            return None
        vectors = filtered @ rotation
        self._keep(inner, vectors, rank)
        return _product(vectors[:, len(inner) - rank :], inner[len(inner) - rank :]), rank

    def _keep(self, values: np.ndarray, vectors: np.ndarray, rank: int) -> None:
        count = min(len(values), rank + rank // 10 + 2 * _FRESH)
        self._block = vectors[:, len(values) - count :]
        self._edge = float(min(values[len(values) - count], 0.0))


def lower_bound(matrix: np.ndarray, random: np.random.Generator) -> float:
    """A number below the smallest eigenvalue of a symmetric matrix, by a few Lanczos steps (Zhou & Li 2011)."""
    from scipy.linalg import eigvalsh_tridiagonal

    v = random.standard_normal(len(matrix)).astype(matrix.dtype)
    v /= np.linalg.norm(v)
    before, diagonal, beside = np.zeros_like(v), [], [0.0]
    for _ in range(min(_LANCZOS, len(matrix))):
        f = matrix @ v - beside[-1] * before
        diagonal.append(float(f @ v))
        f -= diagonal[-1] * v
        beside.append(float(np.linalg.norm(f)))
        if beside[-1] <= 1e-6 * abs(diagonal[0]) + 1e-12:
            break
        before, v = v, f / beside[-1]
    smallest = eigvalsh_tridiagonal(np.array(diagonal), np.array(beside[1:-1]))[0]
    return float(smallest - beside[-1])


def _filtered(matrix: np.ndarray, block: np.ndarray, low: float, high: float, degree: int) -> np.ndarray:
    """T_degree of the matrix with [low, high] mapped to [-1, 1], times the block: eigenvalues above high grow."""
    centre, half = (low + high) / 2, (high - low) / 2
    last, now = block, (matrix @ block - centre * block) / half
    for _ in range(degree - 1):
        last, now = now, (2 / half) * (matrix @ now - centre * now) - last
    return now / np.linalg.norm(now, axis=0)


def _orthonormal(block: np.ndarray) -> np.ndarray:
    """Orthonormal columns of the same span, by Cholesky factors of the Gram matrix; again where rounding would show."""
    from scipy.linalg import solve_triangular

    for _ in range(3):
        factor = np.linalg.cholesky(block.T @ block)
        block = solve_triangular(factor, block.T, lower=True, check_finite=False).T
        if factor.diagonal().min() > 0.2:
            break
    return block
