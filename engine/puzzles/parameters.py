"""All parameters of puzzle solving."""

from typing import Literal, get_args

from ..parameters import Parameters, parameter

Method = Literal["auto", "mst", "greedy", "loops", "lp", "matchlift", "diffusion"]
Measure = Literal["learned", "mgc", "mgc-root", "mgc-pt", "pt", "lpq", "ssd", "ssd-lab", "emd", "emd-lab"]
METHODS: tuple[str, ...] = get_args(Method)
MEASURES: tuple[str, ...] = get_args(Measure)
_MEASURE, _ASSEMBLE = "Measure", "Assembly"
_MATCHLIFT, _DIFFUSION = "MatchLift", "Diffusion pruning"


class PuzzleParameters(Parameters):
    """Every number of the puzzle pipeline. Symbols and equations are those of the thesis, chapters 4 and 5."""

    method: Method = parameter(
        "auto", "How pieces are assembled: a spanning tree, greedy growth, loops first, a linear programme, one of the "
        "thesis's two ways to confirm joins first, or whichever the judge prefers.", live=True, group=_ASSEMBLE)  # fmt: skip
    measure: Measure = parameter(
        "learned", "How unlike two sides are: a calibrated combination of all, or one measure alone.", group=_MEASURE)  # fmt: skip
    wear: Literal["auto", "clean", "worn"] = parameter(
        "auto", "Whether borders are as cut or have suffered (eroded, compressed, noisy); auto looks at how well they fit.",
        group=_MEASURE)  # fmt: skip
    listed: int = parameter(
        12, "Nearest sides by MGC that become candidates of each side.", low=4, high=64, unit="sides", group=_MEASURE)  # fmt: skip
    listed_by_colour: int = parameter(
        4, "Nearest sides by colour (SSD in L*a*b*) that become candidates besides.", low=1, high=64, unit="sides",
        group=_MEASURE)  # fmt: skip
    frame: Literal["known", "unknown"] = parameter(
        "known", "Whether the size of the picture may be used where it is known.", live=True, group=_ASSEMBLE)  # fmt: skip
    missing: bool = parameter(
        False, "Some pieces may be missing: a picture of unknown size is not taken for a whole rectangle.", live=True,
        group=_ASSEMBLE)  # fmt: skip
    hypotheses: int = parameter(
        60, "Other ways to put polygons together that are tried where joins contradict each other; squares take none.",
        low=0, high=1000, live=True, group=_ASSEMBLE)  # fmt: skip
    lift_threshold: float = parameter(
        0.5, "Least similarity of two halves of sides that MatchLift takes as an input.", low=0.0, high=1.0, step=0.05,
        symbol="t₁", equation="4.5", group=_MATCHLIFT, methods=("matchlift",))  # fmt: skip
    lift_accept: float = parameter(
        0.5, "Least lifted match, of both halves, that confirms a join.", low=0.05, high=1.0, step=0.05, symbol="t₂",
        equation="Section 4.4", group=_MATCHLIFT, methods=("matchlift",))  # fmt: skip
    lift_sparsity: float = parameter(
        0.1, "What a match costs in MatchLift: it must earn as much by its similarity.", low=0.01, high=0.9, step=0.01,
        symbol="λ", equation="4.3", group=_MATCHLIFT, methods=("matchlift",))  # fmt: skip
    lift_penalty: float = parameter(
        4.0, "Penalty of the alternating directions of MatchLift: changes the speed alone.", low=0.01, high=100.0,
        symbol="ρ", group=_MATCHLIFT, methods=("matchlift",))  # fmt: skip
    lift_tolerance: float = parameter(
        1e-3, "Relative residual at which MatchLift stops.", low=1e-6, high=0.1, group=_MATCHLIFT, methods=("matchlift",))  # fmt: skip
    lift_steps: int = parameter(
        300, "Most steps of MatchLift.", low=1, high=10_000, unit="steps", group=_MATCHLIFT, methods=("matchlift",))  # fmt: skip
    lift_whole: int = parameter(
        100, "Largest puzzle that is lifted as one, with the known number of grid points; larger ones fall into parts.",
        low=0, high=600, unit="pieces", group=_MATCHLIFT, methods=("matchlift",))  # fmt: skip
    prune_nearest: int = parameter(
        2, "Nearest partners of each half of a side that diffusion pruning looks at.", low=1, high=16, symbol="knn",
        equation="Section 5.2.2", group=_DIFFUSION, methods=("diffusion",))  # fmt: skip
    prune_similarity: float = parameter(
        0.1, "Least ratio of the best dissimilarity of a half to that of a partner.", low=0.0, high=1.0, step=0.05,
        symbol="t₁", equation="5.3", group=_DIFFUSION, methods=("diffusion",))  # fmt: skip
    prune_agreement: float = parameter(
        0.7, "Least agreement by which two correspondences of one join support each other.", low=0.0, high=1.0, step=0.05,
        symbol="t₂", equation="5.4", group=_DIFFUSION, methods=("diffusion",))  # fmt: skip
    prune_share: float = parameter(
        0.3, "Share of the correspondences, the most confident first, that a round of pruning looks at.", low=0.01,
        high=1.0, step=0.05, symbol="t₃", equation="Section 5.2.3", group=_DIFFUSION, methods=("diffusion",))  # fmt: skip
    prune_rounds: int = parameter(
        20, "Most rounds of diffusion pruning; it ends where nothing new is found.", low=1, high=100, unit="rounds",
        equation="Section 5.2.3", group=_DIFFUSION, methods=("diffusion",))  # fmt: skip
    prune_confidence: float = parameter(
        0.5, "Least confidence of a join that pruning confirms.", low=0.0, high=1.0, step=0.05, live=True, group=_DIFFUSION,
        methods=("diffusion",))  # fmt: skip
    half_length: float = parameter(
        0.5, "Length of a sub-edge as a share of its side.", low=0.1, high=1.0, step=0.05, symbol="len",
        equation="Section 5.2.1", group=_DIFFUSION, methods=("matchlift", "diffusion"))  # fmt: skip
