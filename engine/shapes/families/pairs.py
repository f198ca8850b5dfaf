"""Two shapes of one family whose segmentations disagree."""

from dataclasses import dataclass

import numpy as np

from ...errors import BadParameter
from ..oversegmentation import oversegment
from ..segmentation import SegmentedShape
from .generated import GeneratedShape, make_shape

MERGE = 0.12


@dataclass(frozen=True, slots=True, eq=False)
class GeneratedPair:
    """Source and target with their semantic classes, (m,) int64 a face, indices into `label_names`."""

    source: SegmentedShape
    target: SegmentedShape
    source_label: np.ndarray
    target_label: np.ndarray
    label_names: tuple[str, ...]


def make_pair(
    family: str, seed: int, *, variant: str = "touching", segments: tuple[int, int] = (10, 16), pose: str = "turned"
) -> GeneratedPair:
    """Shapes 2·seed and 2·seed+1 of the family, each cut at random into `segments` (low, high) pieces."""
    low, high = segments
    if not 2 <= low <= high:
        raise BadParameter(f"The range of segments must be LOW-HIGH with 2 <= LOW <= HIGH, not {low}-{high}.")
    shapes = [make_shape(family, 2 * seed + k, variant=variant, pose=pose) for k in (0, 1)]
    rng = np.random.default_rng([seed, 104729])
    source, target = (segmented(s, int(rng.integers(low, high + 1)), 2 * seed + k, MERGE) for k, s in enumerate(shapes))
    return GeneratedPair(source, target, shapes[0].label, shapes[1].label, shapes[0].label_names)


def segmented(shape: GeneratedShape, segments: int, seed: int, merge: float) -> SegmentedShape:
    """The shape with a random segmentation."""
    segmentation = oversegment(shape.mesh, shape.part, segments=segments, seed=seed, merge=merge)
    return SegmentedShape(shape.mesh, segmentation, "", ("The shape and its segmentation were generated.",))
