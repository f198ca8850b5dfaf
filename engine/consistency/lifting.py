"""MatchLift for matches between unions: lifted are the atoms, of which unions are made, so that the programme stays small.

Unions of one object overlap, which the elements of MatchLift may not; its atoms do not. An atom of one object can be
several of another: with the unit vectors √size along its atoms, a union has the inner product |i ∩ j| / √(|i| |j|) with
another in any common refinement, which is what the lifted matrix holds between atoms.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import frozen_array
from ..progress import Progress, silent
from .cycles import Pair
from .matchlift import LiftedMatches, matchlift

Members = tuple[np.ndarray, np.ndarray]  # of the p matches of a pair: atoms of the one side (p, s) and the other (p, t)


@dataclass(frozen=True, slots=True, eq=False)
class LiftedAtoms:
    """What was put in and what came out: both (n, n) over all atoms of all objects, `start` (objects + 1,) their rows.

    `evidence` is how far the matches of each pair put two atoms together (0 between objects that were not matched),
    `matches` that made consistent around cycles, also between those; where nothing was lifted (`lift` is None) they are
    the evidence beyond one half, stretched to [0, 1].
    """

    evidence: np.ndarray
    matches: np.ndarray
    start: np.ndarray
    lift: LiftedMatches | None

    @property
    def objects(self) -> np.ndarray:
        """Which object each atom belongs to, (n,) int64."""
        return np.repeat(np.arange(len(self.start) - 1), np.diff(self.start))

    def block(self, a: int, b: int) -> np.ndarray:
        """Lifted matches between the atoms of two objects, (s, t)."""
        return self.matches[self.start[a] : self.start[a + 1], self.start[b] : self.start[b + 1]]


def lift_atoms(
    members: Mapping[Pair, Members],
    counts: Sequence[int],
    *,
    sparsity: float,
    penalty: float,
    tolerance: float,
    max_steps: int,
    most: int,
    progress: Progress = silent,
) -> LiftedAtoms:
    """Make what the matches say of atoms consistent around all cycles; see `matchlift` for the numbers.

    `counts` are the atoms of each object. Objects that were not matched with each other have neither a cost nor a gain.
    Where there are more than `most` atoms in all, fewer than 2 objects, or no match, nothing is lifted.
    """
    start = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    evidence, similarity = np.zeros((start[-1], start[-1])), np.full((start[-1], start[-1]), sparsity)
    for (a, b), (left, right) in members.items():
        block = together(left, right)
        for matrix in (evidence, similarity):
            matrix[start[a] : start[a + 1], start[b] : start[b + 1]] = block
            matrix[start[b] : start[b + 1], start[a] : start[a + 1]] = block.T
    evidence = frozen_array(evidence, np.float64, evidence.shape, "The evidence")
    if not 2 <= len(counts) <= start[-1] <= most or not evidence.any():
        return LiftedAtoms(evidence, np.clip(2 * evidence - 1, 0, 1), start, None)
    objects = np.repeat(np.arange(len(counts)), counts)
    found = matchlift(similarity, objects, universe=None, sparsity=sparsity, penalty=penalty, tolerance=tolerance,
                      max_steps=max_steps, progress=progress)  # fmt: skip
    return LiftedAtoms(evidence, found.matches, start, found)


def together(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """How far matches put an atom of one side and one of the other together, (s, t) in [0, 1].

    Of the matches that hold either atom, the share that holds both. `left` (p, s) and `right` (p, t) bool.
    """
    x, y = left.astype(np.float64), right.astype(np.float64)
    both = x.T @ y
    either = x.sum(axis=0)[:, None] + y.sum(axis=0) - both
    return np.divide(both, either, out=np.zeros_like(both), where=either > 0)


def lifted_support(
    block: np.ndarray, left: np.ndarray, right: np.ndarray, left_size: np.ndarray, right_size: np.ndarray
) -> np.ndarray:
    """Inner product (p,) in [0, 1] of the two unions of each match by the lifted matches of their atoms.

    `block` (s, t); `left` (p, s) and `right` (p, t) bool; sizes (s,) and (t,) > 0.
    """
    u, v = _unit(left, left_size), _unit(right, right_size)
    return np.clip(((u @ block) * v).sum(axis=1), 0, 1)


def _unit(members: np.ndarray, size: np.ndarray) -> np.ndarray:
    """√size along the atoms of each union, of length 1, (p, s)."""
    x = members * np.sqrt(np.maximum(size, 1e-300))
    return x / np.maximum(np.linalg.norm(x, axis=1, keepdims=True), 1e-300)
