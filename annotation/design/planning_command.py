"""`concord study plan`: how many matches have to be judged."""

from collections.abc import Container, Iterable
from typing import Annotated

from cyclopts import Parameter

from ..findings.tabletext import method_name
from ..storage.handle import StudyHandle
from ..study import about, open_study
from .designing import Design
from .planning import Expectations, Held, Needed, estimated, held, needed

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
    there: tuple[Held, ...] = ()
    if study is not None:
        with open_study(study, backup=False, writable=False) as handle:
            told = {name: value for name, value in estimated(handle).items() if name not in expected.model_fields_set}
            design, there = design.changed(**_asked(handle, design)), held(handle)
    assumed = expected.changed(**told)
    found = needed(assumed, design)
    print("\n".join([*sentences(assumed, found, told), *against(there, found)]))


def _asked(handle: StudyHandle, design: Design) -> dict[str, object]:
    """The rule of a study's own votes, as far as the command line does not say otherwise."""
    study = about(handle)
    own = {"votes": study.votes, "adaptive": study.adaptive}
    return {name: value for name, value in own.items() if name not in design.model_fields_set}


def against(there: Iterable[Held], found: Needed) -> list[str]:
    """What the study has of each method, beside what is needed."""
    lines = [
        f"  {method_name((one.method, one.preset))}: {one.judged} of {found.matches} judged; its {one.matches} matches are of "
        f"{one.pairs} of {found.pairs} pairs" for one in there
    ]  # fmt: skip
    return ["", "The study has:", *lines] if lines else []


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
