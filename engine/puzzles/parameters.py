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
