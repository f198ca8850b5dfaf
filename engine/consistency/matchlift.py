"""MatchLift: matches among many objects that agree around every cycle, by one convex programme.

Chen, Guibas & Huang (2014), "Near-optimal joint object matching via convex relaxation"; thesis, section 4.3.
Objects have elements, and every element is one of m elements of a universe. With X[a, b] = 1 where the elements a and
b are the same one of the universe, the programme is (Eq 4.3; λ the cost of a match, W the input similarity)

    minimise ⟨λ - W, X⟩   subject to   [m 1ᵀ; 1 X] ⪰ 0,  X ≥ 0,  X = I within an object.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import DTypeLike

from ..arrays import frozen_array
from ..errors import BadInput
from ..progress import Progress, silent
from .semidefinite import Follower, nearest_semidefinite, one_thread

Projection = Callable[[np.ndarray], tuple[np.ndarray, int]]
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
    universe: float | None,
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
        m: how many distinct elements there are; an upper bound will do. See `estimate_universe`. None is no bound.
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
    project = Follower() if follow else nearest_semidefinite
    with one_thread():
        y, steps, rank, primal, dual = _alternate(
            free, fixed, shift, len(fixed) - len(similarity), project, tolerance, max_steps, progress
        )
    return LiftedMatches(
        frozen_array(y, np.float64, similarity.shape, "Matches"), steps, primal, dual, rank,
        project.dense if isinstance(project, Follower) else steps, residuals_small(primal, dual, tolerance))  # fmt: skip


def _alternate(
    free: np.ndarray, fixed: np.ndarray, shift: np.ndarray, row: int, project: Projection, tolerance: float,
    max_steps: int, progress: Progress,
) -> tuple[np.ndarray, int, int, float, float]:  # fmt: skip
    """The loop: X in [0, 1], steps, rank, primal and dual residual. `row` is 1 where the universe has a row, else 0."""
    z, u, y, a = fixed.copy(), np.zeros_like(fixed), fixed.copy(), fixed.copy()
    primal = dual = np.inf
    first, step, rank = 0.0, 0, 0
    while step < max_steps:
        step += 1
        prox_matching(z, u, free, shift, y, a)
        projected, rank = project(a)
        primal, dual = _advance(projected, y, a, z, u, row)
        z = projected
        if residuals_small(primal, dual, tolerance):
            if not isinstance(project, Follower) or project.was_full:
                break
            project.restart()  # the end is judged by a full decomposition
        first = first or max(primal, dual)
        progress(_share(max(primal, dual), first, tolerance, step / max_steps), "lifting matches")
    return np.clip(y[row:, row:], 0, 1), step, rank, primal, dual


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
def _advance(projected, y, a, z, u, row):  # type: ignore[no-untyped-def]
    """Writes U = Z - A; returns the primal and dual residuals, relative to the norm of the matches."""
    primal = dual = norm = 0.0
    for i in range(len(z)):
        for j in range(len(z)):
            p = projected[i, j]
            u[i, j] = p - a[i, j]
            primal += (p - y[i, j]) ** 2
            dual += (p - z[i, j]) ** 2
            if i >= row and j >= row:
                norm += y[i, j] ** 2
    return np.sqrt(primal / norm), np.sqrt(dual / norm)


def _lifted(
    similarity: np.ndarray,
    free: np.ndarray,
    universe: float | None,
    sparsity: float,
    penalty: float,
    dtype: DTypeLike,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What is free, the fixed values, and (λ - W)/ρ: (n+1, n+1), or (n, n) where the universe has no bound.

    The first row and column are scaled by m^-¼, which keeps the cone and makes no eigenvalue much larger than others.
    """
    fixed: np.ndarray = np.eye(len(similarity), dtype=dtype)
    shift: np.ndarray = ((sparsity - similarity) / penalty).astype(dtype)
    if universe is None:
        return free, fixed, shift
    scale = universe**-0.25
    fixed = np.pad(fixed, (1, 0), constant_values=scale)
    fixed[0, 0] = universe * scale**2
    return np.pad(free, (1, 0)), fixed, np.pad(shift, (1, 0))


def _share(residual: float, first: float, tolerance: float, steps: float) -> float:
    """How much of the work is done, by the logarithm of the residual or by steps, whichever is further."""
    if not first > tolerance:
        return steps
    return float(np.clip(max(np.log(first / max(residual, tolerance)) / np.log(first / tolerance), steps), 0, 1))


def _checked(
    similarity: np.ndarray, objects: np.ndarray, universe: float | None, impossible: np.ndarray | None
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
    if universe is not None and not universe >= largest:
        raise BadInput(f"A universe of {universe:g} elements is too small: one object alone has {largest}.")
    return similarity, objects


def estimate_universe(similarity: np.ndarray, objects: np.ndarray) -> int:
    """m from the input alone: where the eigenvalues of the similarity (unit diagonal) drop most (Chen et al., Alg 1).

    At least as large as the largest object; reliable where most input is right and most pairs of objects have some.
    """
    similarity, objects = _checked(similarity, objects, None, None)
    within = objects[:, None] == objects[None]
    full = np.where(within, np.eye(len(objects)), similarity)
    values = np.sort(np.linalg.eigvalsh(full))[::-1]
    least = max(2, int(np.unique(objects, return_counts=True)[1].max()))
    if least >= len(values):
        return least
    return least + int(np.argmax(values[least - 1 : -1] - values[least:]))
