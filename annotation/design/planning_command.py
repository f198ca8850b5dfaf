"""`concord study plan`: how many matches have to be judged."""

from collections.abc import Container
from typing import Annotated

from cyclopts import Parameter

from ..storage.handle import StudyHandle
from ..study import about, open_study
from .designing import Design
from .planning import Expectations, Needed, estimated, needed

EXPECTED, DEFAULT = Expectations(), Design()


def plan(
    study: str | None = None,
    /,
    *,
    expected: Annotated[Expectations, Parameter(name="*")] = EXPECTED,
    design: Annotated[Design, Parameter(name="*")] = DEFAULT,
) -> None:
    """Say how many matches have to be judged for an interval of a wanted width, and how many votes and hours that is.

    Parameters
    ----------
    study
        A study whose votes so far tell what is to be expected; what is given here counts more.
    """
    told: dict[str, float] = {}
    if study is not None:
        with open_study(study, backup=False, writable=False) as handle:
            told = {name: value for name, value in estimated(handle).items() if name not in expected.model_fields_set}
            design = design.changed(**_asked(handle, design))
    assumed = expected.changed(**told)
    print("\n".join(sentences(assumed, needed(assumed, design), told)))


def _asked(handle: StudyHandle, design: Design) -> dict[str, object]:
    """The rule of a study's own votes, as far as the command line does not say otherwise."""
    study = about(handle)
    own = {"votes": study.votes, "adaptive": study.adaptive}
    return {name: value for name, value in own.items() if name not in design.model_fields_set}


def sentences(expected: Expectations, found: Needed, told: Container[str] = ()) -> list[str]:
    """What was found, and what it rests on, each value of `told` marked as the study's own."""

    def shown(name: str, text: str) -> str:
        return text + (" (as in the study)" if name in told else "")

    people = "1 volunteer" if expected.volunteers == 1 else f"{expected.volunteers} volunteers"
    return [
        f"{found.matches} judged matches of {found.pairs} pairs are needed for each method in the table.",
        f"The {100 * expected.confidence:g} % interval is then expected to be {100 * found.low:.1f} % to {100 * found.high:.1f} %.",
        f"That is {found.votes} votes, {found.votes_each:.2f} for each match ({found.gold} of them gold, which everybody "
        "is asked), and practice.",
        f"It takes {found.hours:.1f} hours" + (f", {found.hours_each:.1f} for each of {people}." if expected.volunteers > 1 else "."),
        "",
        "Expected:",
        "  " + shown("precision", f"precision {100 * expected.precision:.1f} %"),
        "  " + shown("per_pair", f"{expected.per_pair:.3g} matches of one method on a pair"),
        "  " + shown("correlation", f"intraclass correlation {expected.correlation:.3f}, design effect {found.design_effect:.2f}"),
        "  " + shown("disagreement", f"two volunteers differ on {100 * expected.disagreement:.1f} % of the matches"),
        "  " + shown("abstention", f"{100 * expected.abstention:.1f} % of the votes are unsure"),
        "  " + shown("seconds", f"{expected.seconds:.1f} s for a vote"),
        "  " + shown("volunteers", people),
    ]
