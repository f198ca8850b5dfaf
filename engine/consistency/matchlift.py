"""MatchLift: matches among many objects that agree around every cycle, by one convex programme.

Chen, Guibas & Huang (2014), "Near-optimal joint object matching via convex relaxation"; thesis, section 4.3.
Objects have elements, and every element is one of m elements of a universe. With X[a, b] = 1 where the elements a and
b are the same one of the universe, the programme is (Eq 4.3; λ the cost of a match, W the input similarity)

    minimise ⟨λ - W, X⟩   subject to   [m 1ᵀ; 1 X] ⪰ 0,  X ≥ 0,  X = I within an object.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import DTypeLike

from ..arrays import frozen_array
from ..errors import BadInput
from ..progress import Progress, silent
from .semidefinite import Follower, nearest_semidefinite

RELAXATION = 1.6  # of the alternating directions: 1 is none
_SINGLE_FROM = 1e-4  # tolerances from which single precision is enough


@dataclass(frozen=True, slots=True, eq=False)
class LiftedMatches:
    """The matches (n, n) in [0, 1], symmetric with unit diagonal, and how the loop ended.

    `primal` and `dual` are the last residuals relative to the norm of X, `rank` that of the lifted matrix,
    `dense` how many of the `steps` took a full eigendecomposition.
    """

    matches: np.ndarray
    steps: int
    primal: float
    dual: float
    rank: int
    dense: int
    converged: bool


def matchlift(
    similarity: np.ndarray,
    objects: np.ndarray,
    *,
    universe: float,
    sparsity: float,
    penalty: float,
    tolerance: float,
    max_steps: int,
    impossible: np.ndarray | None = None,
    follow: bool = True,
    progress: Progress = silent,
) -> LiftedMatches:
    """Solve the programme of MatchLift by the alternating direction method of multipliers.

    Parameters
    ----------
    similarity
        W (n, n), symmetric, in [0, 1]: 0 where there is no input. Entries within an object are ignored.
    objects
        (n,) int64: which object each element belongs to.
    universe
        m: how many distinct elements there are; an upper bound will do. See `estimate_universe`.
    sparsity, penalty
        λ in [0, 1], and ρ > 0, which changes the speed alone.
    tolerance, max_steps
        The loop ends by `residuals_small`, or after so many steps.
    impossible
        (n, n) bool: pairs that cannot be the same element; their X is 0.
    follow
        Follow the positive eigenpairs from step to step; without it every step decomposes in full, in double precision.

    Raises
    ------
    BadInput
        Shapes that do not fit, an asymmetric or unbounded similarity, or a universe smaller than an object.
    """
    similarity, objects = _checked(similarity, objects, universe, impossible)
    dtype = np.float32 if follow and tolerance >= _SINGLE_FROM else np.float64
    free = objects[:, None] != objects[None]
    if impossible is not None:
        free &= ~(impossible | impossible.T)
    free, fixed, shift = _lifted(similarity, free, universe, sparsity, penalty, dtype)
    z, u, y, a = fixed.copy(), np.zeros_like(fixed), fixed.copy(), fixed.copy()
    project = Follower() if follow else nearest_semidefinite
    primal = dual = np.inf
    first, step, rank = 0.0, 0, 0
    while step < max_steps:
        step += 1
        prox_matching(z, u, free, shift, y, a)
        projected, rank = project(a)
        primal, dual = _advance(projected, y, a, z, u)
        z = projected
        if residuals_small(primal, dual, tolerance):
            if not isinstance(project, Follower) or project.was_full:
                break
            project.restart()  # the end is judged by a full decomposition
        first = first or max(primal, dual)
        progress(_share(max(primal, dual), first, tolerance, step / max_steps), "lifting matches")
    return LiftedMatches(
        frozen_array(np.clip(y[1:, 1:], 0, 1), np.float64, similarity.shape, "Matches"), step, primal, dual, rank,
        project.dense if isinstance(project, Follower) else step, residuals_small(primal, dual, tolerance))  # fmt: skip


def residuals_small(primal: float, dual: float, tolerance: float) -> bool:
    """The stopping criterion: the two sets' points are as near as `tolerance`, and moved no further in the last step.

    Both are Frobenius norms relative to that of the matches: primal |Z - Y| / |X|, dual |Z - Z'| / |X|.
    """
    return max(primal, dual) <= tolerance


@njit(cache=True, nogil=True)
def prox_matching(z, u, free, shift, y, a):  # type: ignore[no-untyped-def]
    """Prox of the linear cost within the box: Y = max(Z + U - (λ - W)/ρ, 0) where free; elsewhere Y stays as it is.

    Writes Y, and A = Y' - U, which is to be projected, with Y' the over-relaxed Y. All (n, n).
    """
    for i in range(len(z)):
        for j in range(len(z)):
            if free[i, j]:
                value = z[i, j] + u[i, j] - shift[i, j]
                y[i, j] = value if value > 0 else 0
            a[i, j] = RELAXATION * y[i, j] + (1 - RELAXATION) * z[i, j] - u[i, j]


@njit(cache=True, nogil=True)
def _advance(projected, y, a, z, u):  # type: ignore[no-untyped-def]
    """Writes U = Z - A; returns the primal and dual residuals, relative to the norm of the matches."""
    primal = dual = norm = 0.0
    for i in range(len(z)):
        for j in range(len(z)):
            p = projected[i, j]
            u[i, j] = p - a[i, j]
            primal += (p - y[i, j]) ** 2
            dual += (p - z[i, j]) ** 2
            if i and j:
                norm += y[i, j] ** 2
    return np.sqrt(primal / norm), np.sqrt(dual / norm)


def _lifted(
    similarity: np.ndarray, free: np.ndarray, universe: float, sparsity: float, penalty: float, dtype: DTypeLike
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What is free, the fixed values, and (λ - W)/ρ, all (n+1, n+1).

    The first row and column are scaled by m^-¼, which keeps the cone and makes no eigenvalue much larger than others.
    """
    n = len(similarity)
    scale = universe**-0.25
    is_free = np.zeros((n + 1, n + 1), dtype=bool)
    is_free[1:, 1:] = free
    fixed: np.ndarray = np.eye(n + 1, dtype=dtype)
    fixed[0, 1:] = fixed[1:, 0] = scale
    fixed[0, 0] = universe * scale**2
    shift: np.ndarray = np.zeros((n + 1, n + 1), dtype=dtype)
    shift[1:, 1:] = (sparsity - similarity) / penalty
    return is_free, fixed, shift


def _share(residual: float, first: float, tolerance: float, steps: float) -> float:
    """How much of the work is done, by the logarithm of the residual or by steps, whichever is further."""
    if not first > tolerance:
        return steps
    return float(np.clip(max(np.log(first / max(residual, tolerance)) / np.log(first / tolerance), steps), 0, 1))


def _checked(
    similarity: np.ndarray, objects: np.ndarray, universe: float, impossible: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    n = len(objects)
    similarity = frozen_array(similarity, np.float64, (n, n), "The similarity of the elements")
    objects = frozen_array(objects, np.int64, (n,), "The objects of the elements")
    if n < 2 or len(np.unique(objects)) < 2:
        raise BadInput("MatchLift matches the elements of at least 2 objects; give more objects.")
    if not (np.isfinite(similarity).all() and similarity.min() >= 0 and similarity.max() <= 1):
        raise BadInput("The similarity of the elements must lie in [0, 1]; scale it first.")
    if not np.array_equal(similarity, similarity.T):
        raise BadInput("The similarity of the elements must be symmetric; take (W + Wᵀ)/2.")
    if impossible is not None and np.shape(impossible) != (n, n):
        raise BadInput(f"The impossible pairs must have the shape ({n}, {n}), not {np.shape(impossible)}.")
    largest = int(np.unique(objects, return_counts=True)[1].max())
    if not universe >= largest:
        raise BadInput(f"A universe of {universe:g} elements is too small: one object alone has {largest}.")
    return similarity, objects


def estimate_universe(similarity: np.ndarray, objects: np.ndarray) -> int:
    """m from the input alone: where the eigenvalues of the similarity (unit diagonal) drop most (Chen et al., Alg 1).

    At least as large as the largest object; reliable where most input is right and most pairs of objects have some.
    """
    similarity, objects = _checked(similarity, objects, np.inf, None)
    within = objects[:, None] == objects[None]
    full = np.where(within, np.eye(len(objects)), similarity)
    values = np.sort(np.linalg.eigvalsh(full))[::-1]
    least = max(2, int(np.unique(objects, return_counts=True)[1].max()))
    if least >= len(values):
        return least
    return least + int(np.argmax(values[least - 1 : -1] - values[least:]))
