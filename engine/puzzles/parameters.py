"""All parameters of puzzle solving."""

from typing import Literal

from ..parameters import Parameters, parameter

METHODS = ("auto", "mst", "greedy", "loops", "lp", "matchlift", "diffusion")
MEASURES = ("learned", "mgc", "mgc-root", "mgc-pt", "pt", "lpq", "ssd", "ssd-lab", "emd", "emd-lab")
_MEASURE, _CONSIST, _ASSEMBLE = "Measure", "Consistency", "Assembly"


class PuzzleParameters(Parameters):
    """Every number of the puzzle pipeline. Symbols and equations are those of the thesis, chapters 4 and 5."""

    method: Literal["auto", "mst", "greedy", "loops", "lp", "matchlift", "diffusion"] = parameter(
        "auto", "How pieces are assembled: a spanning tree, greedy growth, loops first, a linear programme, one of the "
        "thesis's two ways to confirm joins first, or whichever the judge prefers.", live=True, group=_ASSEMBLE)  # fmt: skip
    measure: Literal[
        "learned", "mgc", "mgc-root", "mgc-pt", "pt", "lpq", "ssd", "ssd-lab", "emd", "emd-lab"
    ] = parameter(
        "learned", "How unlike two sides are: a calibrated combination of all, or one measure alone.", group=_MEASURE)  # fmt: skip
    seed: int = parameter(0, "Seed of what is chosen at random.", low=0, high=2**31 - 1, group=_ASSEMBLE)
