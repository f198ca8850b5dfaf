"""From where a volunteer first sees two marked parts: both well visible, the shapes recognisable, alike where possible."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .cameras import Camera, candidate_directions, fitting_distance, look_from, visibility
from .scene import Scene

_HEIGHTS = {20.0: 0.12, -15.0: 0.0, 45.0: 0.06, 75.0: -0.25, -60.0: -0.35}  # what looking from there is worth by itself
_RINGS = (14, 10, 10, 4, 4)  # of `candidate_directions`, in the same order: 20°, -15°, 45°, 75°, -60°
_USUAL, _WHOLE = 0.08, 0.3
_ALIKE = 0.84  # one direction for both shapes, if each is seen at least so well in it as in its own best one


def part_scores(scene: Scene, segments: Sequence[int]) -> np.ndarray:
    """How good each candidate direction is, (42,).

    The part counts as one, however many segments it has: the share of the picture that it fills, then the outline of
    the whole shape, which should be large, and how usual it is to look from there.
    """
    directions = candidate_directions()
    seen = visibility(scene, range(scene.count), directions)
    part, whole = seen[:, list(segments)].sum(axis=1), seen.sum(axis=1)
    height = np.repeat(list(_HEIGHTS.values()), _RINGS)
    usual = _USUAL * directions @ directions[0]
    return part / max(part.max(), 1e-12) + _WHOLE * whole / max(whole.max(), 1e-12) + height + usual


def best_views(scenes: Sequence[Scene], segments: Sequence[Sequence[int]]) -> tuple[np.ndarray, np.ndarray]:
    """The direction (3,) in which the part of each of two shapes is seen best: the same one where that serves both."""
    directions = candidate_directions()
    scores = [part_scores(scene, part) for scene, part in zip(scenes, segments, strict=True)]
    shares = np.array([score / score.max() for score in scores])
    together = int(np.argmax(shares.min(axis=0)))
    alike = shares[:, together].min() >= _ALIKE
    first, second = (together if alike else int(np.argmax(share)) for share in shares)
    return directions[first], directions[second]


def part_cameras(scenes: Sequence[Scene], views: Sequence[np.ndarray], aspect: float) -> tuple[Camera, Camera]:
    """The cameras in two directions (3,) in panes of this width / height, at one distance, so at the same scale."""
    distance = max(fitting_distance(scene, view, aspect) for scene, view in zip(scenes, views, strict=True))
    return look_from(views[0], distance), look_from(views[1], distance)
