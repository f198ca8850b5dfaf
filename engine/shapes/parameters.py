"""All parameters of shape matching, and the presets."""

from typing import Any, Literal

from ..errors import BadParameter
from ..parameters import Parameters, checked, parameter

LEARNED, THESIS, TOP_DOWN = "learned", "thesis", "top-down"
BOTTOM, HUNGARIAN, SPECTRAL, SHED, DIFFUSION = "bottom", "hungarian", "spectral", "shed", "diffusion"
_T, _D, _L = (THESIS,), (TOP_DOWN,), (LEARNED,)
_WALKS = (THESIS, BOTTOM, DIFFUSION)  # diffusion pruning in one form or another
_MEASURED = (TOP_DOWN, THESIS, BOTTOM, HUNGARIAN, SPECTRAL, DIFFUSION)  # what looks alike by `geometric_distance`
_GRAPH, _MLG, _LFD = "Segment graph", "Multi-layer graph", "Descriptor"
_PROPOSE, _PRUNE, _VOTE, _FURTHER = "Candidates", "Pruning", "Voting", "Further descriptors"


def _weight(what: str) -> Any:
    """The weight of one more descriptor, whose distance is about 1 for true pairs."""
    return parameter(0.0, f"Weight of {what}; the distance of true pairs is about 1.", low=0.0, high=5.0, step=0.1, live=True,
                     methods=_MEASURED, group=_FURTHER)  # fmt: skip


class MatchParameters(Parameters):
    """Every number of the shape pipeline. Symbols and equations are those of the thesis, chapter 3."""

    method: Literal["learned", "thesis", "top-down", "bottom", "hungarian", "spectral", "shed", "diffusion"] = parameter(
        LEARNED, "How matches are chosen: by probabilities that were fitted to shapes with known truth, the thesis's "
        "two-stage diffusion pruning, or top-down agreement; of single segments by the thesis's first stage, the "
        "Hungarian method, spectral matching, or SHED (one-to-many); or of all nodes by the full rule of diffusion "
        "pruning.", live=True, group="Method")  # fmt: skip

    # Segment graph
    adjacency: Literal["auto", "shared", "proximity"] = parameter(
        "auto", "How touching segments are found: shared vertices, surface distance, or whichever fits the mesh.",
        group=_GRAPH)  # fmt: skip
    touch_distance: float = parameter(
        0.012, "Largest surface distance of touching segments where no vertices are shared.",
        low=0.0, high=0.1, step=0.001, unit="diagonal", group=_GRAPH)  # fmt: skip
    touch_samples: int = parameter(
        20_000, "Surface points that surface distances are measured between.", low=1000, high=200_000, step=1000,
        unit="points", group=_GRAPH)  # fmt: skip
    geodesic_points: int = parameter(
        700, "Surface points of the neighbour graph for geodesic distances.", low=100, high=5000, step=100,
        unit="points", group=_GRAPH)  # fmt: skip
    most_segments: int = parameter(
        1000, "Shapes with more segments are refused: their labels are most likely not segments.", low=10, high=5000,
        step=10, group=_GRAPH)  # fmt: skip
    size_measure: Literal["area", "volume"] = parameter(
        "area", "The measure of size in the layer rule: surface area, or volume of the capped segments.",
        symbol="VOL", equation="3.1", group=_GRAPH)  # fmt: skip

    # Multi-layer graph
    mode: Literal["auto", "literal", "relaxed", "connected", "beam"] = parameter(
        "auto", "Which unions become nodes: Eq 3.1 as printed or relaxed, all connected sets, or a beam of the "
        "best by normalised cut; auto takes connected sets up to 20 segments and the beam above.",
        equation="3.1", group=_MLG)  # fmt: skip
    layers: int = parameter(8, "Number of layers.", low=2, high=16, symbol="L", equation="3.1", group=_MLG)
    auto_segments: int = parameter(
        20, "Most segments for which the mode auto takes all connected sets.", low=2, high=100, group=_MLG)  # fmt: skip
    max_segments: int = parameter(
        0, "Most segments in a merged node (not the top); 0 stands for 6 in the mode connected and for any number in "
        "the others.", low=0, high=64, group=_MLG)  # fmt: skip
    node_cap: int = parameter(
        400, "Most nodes in the graph; sliders stay immediate up to about 1000.", low=10, high=5000, step=10,
        group=_MLG)  # fmt: skip

    # Descriptor
    light_fields: int = parameter(4, "Number of light fields (rotations of the ten cameras).", low=1, high=10, group=_LFD)
    resolution: int = parameter(
        256, "Side of a silhouette.", low=64, high=1024, multiple=64, unit="px", group=_LFD)  # fmt: skip
    own_scale: float = parameter(
        0.25, "Unions smaller than this share of the shape's radius are drawn at their own scale.", low=0.0, high=1.0,
        step=0.05, unit="radius", group=_LFD)  # fmt: skip
    seed: int = parameter(0, "Seed of the light field rotations and surface samples.", low=0, high=2**31 - 1, group=_LFD)

    # Candidates
    pool: int = parameter(
        40, "Nearest nodes that exact distances are computed for, by each of five quick distances; the K best are "
        "chosen from them.", low=30, high=300, step=10, group=_PROPOSE)  # fmt: skip
    K: int = parameter(
        7, "Best matches kept for each node.", low=1, high=30, symbol="K", live=True,
        methods=(*_WALKS, TOP_DOWN, SPECTRAL), group=_PROPOSE)  # fmt: skip
    lfd_threshold: float = parameter(
        0.8, "Least light field similarity of a candidate.", low=0.0, high=1.0, step=0.01, live=True,
        methods=_WALKS, group=_PROPOSE)  # fmt: skip
    sigma: float = parameter(
        8.0, "Scale of the similarity exp(-d/σ) of light field distances.", low=0.1, high=50.0, step=0.1,
        symbol="σ", equation="3.3", live=True, group=_PROPOSE)  # fmt: skip
    lfd: Literal["exact", "signature"] = parameter(
        "exact", "Light field distance: exact, or by the quantile signature, which needs no rotations and is far faster.",
        group=_PROPOSE)  # fmt: skip
    lfd_weight: float = parameter(
        1.0, "Weight of the light field distance, about 1.8 for true pairs; all other weights are beside it.", low=0.0,
        high=5.0, step=0.1, live=True, methods=_MEASURED, group=_PROPOSE)  # fmt: skip
    size_weight: float = parameter(
        0.0, "Weight of |Δ log relative size|.", low=0.0, high=5.0, step=0.1, live=True, methods=_MEASURED,
        group=_PROPOSE)  # fmt: skip
    extent_weight: float = parameter(
        0.5, "Weight of |Δ log relative extent|.", low=0.0, high=5.0, step=0.1, live=True, methods=_MEASURED,
        group=_PROPOSE)  # fmt: skip
    centrality_weight: float = parameter(
        2.0, "Weight of |Δ log mean geodesic distance|.", low=0.0, high=10.0, step=0.1, live=True, methods=_MEASURED,
        group=_PROPOSE)  # fmt: skip
    g_scale: float = parameter(
        0.5, "Scale of the weight exp(-distance/scale) of a candidate.", low=0.05, high=5.0, step=0.05, live=True,
        methods=(*_D, SPECTRAL), group=_PROPOSE)  # fmt: skip

    # Pruning: thesis
    delta_1: float = parameter(
        0.2, "Radius of the local regions in the anchor stage, as a share of the graph's diameter.",
        low=0.0, high=1.0, step=0.01, symbol="δ₁", unit="diameter", equation="3.3", live=True,
        methods=(*_T, BOTTOM), group=_PRUNE)  # fmt: skip
    delta_2: float = parameter(
        0.8, "Radius of the local regions in the second stage, or of all nodes, as a share of the graph's diameter.",
        low=0.0, high=1.0, step=0.01, symbol="δ₂", unit="diameter", equation="3.3", live=True,
        methods=(*_T, DIFFUSION), group=_PRUNE)  # fmt: skip
    c_0: float = parameter(
        0.7, "Least isometric consistency that counts in the affinity.", low=0.0, high=0.99, step=0.01,
        symbol="c₀", equation="3.3", live=True, methods=_WALKS, group=_PRUNE)  # fmt: skip
    c_2: float = parameter(
        0.5, "Least isometric consistency with every accepted match nearby.", low=0.0, high=1.0, step=0.01,
        symbol="c₂", live=True, methods=(*_T, BOTTOM), group=_PRUNE)  # fmt: skip
    anchors: Literal["checked", "first", "off"] = parameter(
        "checked", "Bottom matches of the first stage: accepted first as in the thesis, only where the whole agrees "
        "better with them than without, or not used.", live=True, methods=_T, group=_PRUNE)  # fmt: skip

    # Pruning: the baselines
    c_1: float = parameter(
        0.5, "Of the accepted matches near a candidate on one side, the share that must be near on both.", low=0.0,
        high=0.99, step=0.01, symbol="c₁", live=True, methods=(DIFFUSION,), group=_PRUNE)  # fmt: skip
    seed_min: float = parameter(
        0.7, "Least isometric consistency of a new seed with every other, where no accepted match is near.", low=0.0,
        high=1.0, step=0.01, symbol="c₂", live=True, methods=(DIFFUSION,), group=_PRUNE)  # fmt: skip
    distance_max: float = parameter(
        3.0, "Geometric distance from which segments rather stay unmatched.", low=0.1, high=20.0, step=0.1, live=True,
        methods=(HUNGARIAN,), group=_PRUNE)  # fmt: skip
    geodesic_sigma: float = parameter(
        0.2, "Scale of the difference of geodesic distances; beyond three of it segments do not support each other.",
        low=0.01, high=2.0, step=0.01, symbol="σ_d", unit="mean distance", live=True, methods=(SPECTRAL,),
        group=_PRUNE)  # fmt: skip
    confidence_min: float = parameter(
        0.0, "Least entry of a match in the principal eigenvector, relative to the greatest.", low=0.0, high=1.0,
        step=0.01, live=True, methods=(SPECTRAL,), group=_PRUNE)  # fmt: skip

    # Pruning: learned
    probability_min: float = parameter(
        0.5, "Least probability that a match is right.", low=0.0, high=1.0, step=0.01, live=True, methods=_L,
        group=_PRUNE)  # fmt: skip
    small_first: float = parameter(
        0.5, "How much sooner small nodes are taken: candidates are sorted by probability / size^λ.", low=0.0, high=2.0,
        step=0.05, symbol="λ", live=True, methods=_L, group=_PRUNE)  # fmt: skip

    # Pruning: top-down
    agree_from: float = parameter(
        0.7, "Agreement above which two candidates support each other.", low=0.0, high=0.99, step=0.01, live=True,
        methods=_D, group=_PRUNE)  # fmt: skip
    overlap_min: float = parameter(
        0.6, "Least agreement of overlaps with every accepted match.", low=0.0, high=1.0, step=0.01, symbol="r",
        live=True, methods=(*_D, LEARNED), group=_PRUNE)  # fmt: skip
    ratio_min: float = parameter(
        0.5, "Least ratio of geodesic distances with every accepted match.", low=0.0, high=1.0, step=0.01, live=True,
        methods=(*_D, LEARNED), group=_PRUNE)  # fmt: skip
    bottom_K: int = parameter(
        15, "Best bottom matches looked at for each bottom segment in the last step.", low=1, high=30, live=True,
        methods=_D, group=_PRUNE)  # fmt: skip
    bottom_min: float = parameter(
        0.6, "Least mean agreement of a bottom match with the accepted ones.", low=0.0, high=1.0, step=0.01,
        live=True, methods=_D, group=_PRUNE)  # fmt: skip

    # Voting
    voting: bool = parameter(True, "Hierarchical voting.", equation="Algorithm 1", live=True, methods=_T, group=_VOTE)
    second_run: bool = parameter(
        True, "Run pruning and voting again with the voted matches as anchors; this changes something only where "
        "voting dropped an anchor.", live=True, methods=_T,
        group=_VOTE)  # fmt: skip

    # Further descriptors
    d1_weight: float = _weight("D1, the distances of surface points from the middle")
    d2_weight: float = _weight("D2, the distances of two surface points")
    d3_weight: float = _weight("D3, the areas of triangles of three surface points")
    d4_weight: float = _weight("D4, the volumes of tetrahedra of four surface points")
    a3_weight: float = _weight("A3, the angles of three surface points")
    pca_weight: float = _weight("six features of the principal components, such as linearity and sphericity")
    hks_weight: float = _weight("the mean heat kernel signature")
    phks_weight: float = _weight("the persistent heat kernel signature")
    volume_weight: float = _weight("relative volume and area")


DEFAULT_PRESET = "learned"
_LFD_ALONE: dict[str, Any] = {"extent_weight": 0.0, "centrality_weight": 0.0}
_THESIS_RIGID: dict[str, Any] = {"method": THESIS, **_LFD_ALONE}
_THESIS_NONRIGID: dict[str, Any] = {**_THESIS_RIGID, "delta_1": 0.8, "delta_2": 0.2}
PRESETS: dict[str, MatchParameters] = {
    name: checked(MatchParameters, values)
    for name, values in {
        "learned": {"method": LEARNED},
        "top-down": {"method": TOP_DOWN},
        "thesis-rigid": _THESIS_RIGID,
        "thesis-nonrigid": _THESIS_NONRIGID,
        "thesis-rigid-size": {**_THESIS_RIGID, "size_weight": 1.0},
        "thesis-nonrigid-size": {**_THESIS_NONRIGID, "size_weight": 1.0},
        "bottom": {"method": BOTTOM, **_LFD_ALONE, "size_weight": 1.0},
        "hungarian": {"method": HUNGARIAN, "size_weight": 1.0},
        "spectral": {"method": SPECTRAL, "size_weight": 1.0},
        "shed": {"method": SHED},
        "diffusion": {"method": DIFFUSION, **_LFD_ALONE, "size_weight": 1.0, "delta_2": 0.2},
    }.items()
}


def method_preset(method: str) -> str:
    """The preset that a method starts from: the first that has it; raises `BadParameter` with the methods there are."""
    found = [name for name, values in PRESETS.items() if values.method == method]
    if not found:
        methods = dict.fromkeys(values.method for values in PRESETS.values())
        raise BadParameter(f"There is no method named '{method}'; the methods are: {', '.join(methods)}.")
    return found[0]


def preset(name: str) -> MatchParameters:
    """The parameters of a preset; raises `BadParameter` with the names that there are."""
    if name not in PRESETS:
        raise BadParameter(f"There is no preset named '{name}'; the presets are: {', '.join(PRESETS)}.")
    return PRESETS[name]
