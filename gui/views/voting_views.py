"""From where a volunteer first sees two marked parts: both well visible, the shapes recognisable, alike where possible."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .cameras import Camera, candidate_directions, fitting_distance, look_from, visibility
from .scene import Scene

_HEIGHTS = {20.0: 0.12, -15.0: 0.0, 45.0: 0.06, 75.0: -0.25, -60.0: -0.35}  # what looking from there is worth by itself
_RINGS = (14, 10, 10, 4, 4)  # of `candidate_directions`, in the same order: 20°, -15°, 45°, 75°, -60°
_USUAL, _WHOLE = 0.08, 0.3
_ALIKE = 0.84  # one direction for both shapes, if each is seen at least so well in it as in its own best one
_SMALL, _NEAREST = 0.005, 1.35  # parts below this share of the picture are shown from nearer, at most so much


class PartView(NamedTuple):
    """A direction (3,), the middle of the part (3,), and how much nearer than the whole shape it is shown."""

    towards: np.ndarray
    middle: np.ndarray
    zoom: float


def part_scores(scene: Scene, segments: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """How good each candidate direction is (42,), and the share of the picture that the part fills in it (42,).

    The part counts as one, however many segments it has; then the outline of the whole shape, which should be large,
    and how usual it is to look from there.
    """
    directions = candidate_directions()
    seen = visibility(scene, range(scene.count), directions)
    part, whole = seen[:, list(segments)].sum(axis=1), seen.sum(axis=1)
    height = np.repeat(list(_HEIGHTS.values()), _RINGS)
    usual = _USUAL * directions @ directions[0]
    return part / max(part.max(), 1e-12) + _WHOLE * whole / max(whole.max(), 1e-12) + height + usual, part


def best_views(scenes: Sequence[Scene], segments: Sequence[Sequence[int]]) -> tuple[PartView, PartView]:
    """The view of each of two shapes in which its part is seen best: the same direction where that serves both."""
    directions = candidate_directions()
    found = [part_scores(scene, part) for scene, part in zip(scenes, segments, strict=True)]
    shares = np.array([score / score.max() for score, _ in found])
    together = int(np.argmax(shares.min(axis=0)))
    alike = shares[:, together].min() >= _ALIKE
    chosen = [together if alike else int(np.argmax(share)) for share in shares]
    zoom = min(_zoom(part[k]) for (_, part), k in zip(found, chosen, strict=True))
    views = [PartView(directions[k], _middle(scene, part), zoom)
             for k, scene, part in zip(chosen, scenes, segments, strict=True)]  # fmt: skip
    return views[0], views[1]


def part_cameras(scenes: Sequence[Scene], views: Sequence[PartView], aspect: float) -> tuple[Camera, Camera]:
    """The cameras of two views in panes of this width / height, at the same distance, so at the same scale."""
    pairs = list(zip(scenes, views, strict=True))
    distance = max(fitting_distance(scene, view.towards, aspect) for scene, view in pairs)
    first, second = (_nearer(look_from(view.towards, distance), view) for view in views)
    return first, second


def _nearer(camera: Camera, view: PartView) -> Camera:
    """The camera come nearer to the part, which stays where it was in the picture."""
    focal = view.middle * (1 - 1 / view.zoom)
    return camera._replace(position=focal + camera.position / view.zoom, focal=focal)


def _zoom(share: float) -> float:
    return float(np.clip(np.sqrt(_SMALL / max(share, 1e-6)), 1.0, _NEAREST))


def _middle(scene: Scene, segments: Sequence[int]) -> np.ndarray:
    """The middle (3,) of the surface of some segments."""
    rows = np.isin(scene.sample_labels, list(segments))
    return scene.samples[rows].mean(axis=0) if rows.any() else np.zeros(3)
