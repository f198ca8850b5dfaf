"""The parameters of automatic segmentation."""

from typing import Literal

from ..parameters import Parameters, parameter

PARTS, PATCHES, CONVEX = "parts", "patches", "convex"


class SegmentationParameters(Parameters):
    """How a mesh without labels is cut into segments."""

    method: Literal["parts", "patches", "convex"] = parameter(
        PARTS, "Small geodesic patches joined to nearly convex parts, plain geodesic patches of like size, or CoACD's "
        "approximate convex decomposition carried back to the surface (slow).", group="Segmentation")  # fmt: skip
    segments: int = parameter(
        14, "Number of segments; fewer only where the mesh has fewer faces.", low=2, high=200, live=True,
        group="Segmentation")  # fmt: skip
    crease: float = parameter(
        2.0, "How far patches keep from each other's side of a concave crease of one radian.", low=0.0, high=10.0,
        step=0.5, unit="patch radii", methods=(PARTS, PATCHES), group="Segmentation")  # fmt: skip
    concavity: float = parameter(
        0.05, "Concavity that CoACD tolerates in a part before parts are joined.", low=0.01, high=0.5, step=0.01,
        methods=(CONVEX,), group="Segmentation")  # fmt: skip
    seed: int = parameter(0, "Seed of the first patch and of CoACD's search.", low=0, high=2**31 - 1, group="Segmentation")


DEFAULT = SegmentationParameters()
