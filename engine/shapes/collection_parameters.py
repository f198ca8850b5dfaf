"""The parameters of collections: which pairs are matched, and how their matches are made consistent."""

from typing import Literal

from ..parameters import Parameters, parameter

_PAIRS, _SUPPORT, _PARTS = "Pairs of a collection", "Support", "Parts"


class CollectionParameters(Parameters):
    """Every number of a collection beside those of the matching of its pairs."""

    partners: int = parameter(
        12, "Most shapes that each shape is matched with; collections up to one more are matched in all pairs.",
        low=2, high=100, unit="shapes", group=_PAIRS)  # fmt: skip
    pair_seed: int = parameter(
        0, "Seed of the pairs that are matched where these are not all.", low=0, high=2**31 - 1, group=_PAIRS)  # fmt: skip

    support: Literal["cycles", "matchlift"] = parameter(
        "cycles", "What a match is supported by: the ways around by third shapes, or MatchLift on the segments.",
        live=True, group=_SUPPORT)  # fmt: skip
    alike_power: float = parameter(
        1.0, "How quickly nodes that differ count less on the way around: power of their Jaccard index.",
        low=0.5, high=8.0, step=0.5, group=_SUPPORT)  # fmt: skip
    lift_sparsity: float = parameter(
        0.4, "Cost of a match in MatchLift.", low=0.05, high=0.95, step=0.05, symbol="λ", equation="4.3",
        group=_SUPPORT)  # fmt: skip
    lift_tolerance: float = parameter(
        1e-3, "Relative residual at which MatchLift stops.", low=1e-6, high=0.1, group=_SUPPORT)  # fmt: skip
    lift_steps: int = parameter(
        400, "Most steps of MatchLift.", low=1, high=10_000, unit="steps", group=_SUPPORT)  # fmt: skip
    lift_most: int = parameter(
        1000, "Collections with more segments in all are not lifted: their parts come from the matches alone.",
        low=0, high=4000, unit="segments", group=_SUPPORT)  # fmt: skip

    part_from: float = parameter(
        0.4, "How alike groups of segments are matched that become one part; higher makes more and smaller parts.",
        low=0.05, high=0.95, step=0.05, live=True, group=_PARTS)  # fmt: skip
