"""What a study knows of the questions of a Human Evaluation Datasheet (see `annotation.findings.datasheet`)."""

import statistics
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from sqlalchemy import func, select

from ..records import Study
from ..storage import schema
from ..storage.handle import StudyHandle
from ..storage.stamps import app_version
from ..study import about
from .datasheet import Known, Sheet, sheet_of
from .gathering import Findings, findings
from .overview import VolunteerRow, overview
from .precision import ALL_SETS, PrecisionRow
from .tabletext import number, percent, row_name, shown_range

_INPUT = {"shape": "other: 3D shapes as triangle meshes, cut into segments", "puzzle": "visual: pictures cut into pieces"}
_OUTPUT = {"shape": "other: correspondences between groups of segments of two shapes",
           "puzzle": "other: joins of two puzzle pieces, each with their relative place and turn"}  # fmt: skip
_TASK = {"shape": "other: finding consistent correspondences between the parts of two shapes",
         "puzzle": "other: putting a picture together again from its pieces"}  # fmt: skip


class Facts(NamedTuple):
    """What is read of a study for the sheet; `roles` counts the items that are asked in each role (none: all are)."""

    study: Study
    found: Findings
    people: tuple[VolunteerRow, ...]
    roles: Counter[str]
    overlapped: int
    kinds: Counter[str]


def answered(handle: StudyHandle) -> Sheet:
    """The sheet of a study."""
    facts = read_facts(handle)
    known = _left_to_people() | _systems(facts) | _sample(facts) | _evaluators(facts) | _design(facts) | _criterion(facts)
    return sheet_of(facts.study.name, f"Concord {app_version()}", known | _elicitation(facts) | _ethics())


def read_facts(handle: StudyHandle) -> Facts:
    """All that the sheet needs; nothing is written."""
    asked = schema.asked.c
    with handle.reading() as connection:
        roles = connection.execute(select(asked.role, func.count()).group_by(asked.role)).all()
        twice = connection.scalar(select(func.count()).where(asked.overlapped == 1)) or 0
        kinds = connection.execute(select(schema.item.c.kind, func.count()).group_by(schema.item.c.kind)).all()
    return Facts(about(handle), findings(handle), overview(handle), Counter(dict(map(tuple, roles))), twice,
                 Counter(dict(map(tuple, kinds))))  # fmt: skip


def _left_to_people() -> dict[str, Known]:
    return {
        "1.1": Known(left="link to the paper, or 'for preregistration'"),
        "1.2": Known(left="link to the data; `concord study export` and `concord study archive` write what can be published"),
        "1.3": Known(left="names, affiliations, e-mail addresses"),
        "3.2.2": Known(left="experts or not; paid or not; known to the authors or not; authors among them or not"),
        "3.2.3": Known(left="how they were found, who was let in and who was not"),
        "3.2.5": Known(left="education, age, experience with 3D programs, or whatever was asked; numbers for each group"),
        "3.3.1": Known(left="Yes or No; if yes, registry and link"),
        "3.3.7": Known(left="at a place of their own choosing, in a laboratory, or elsewhere"),
        "3.3.8": Known(left="unless at a place of their own choosing: what was the same and what was not"),
    }


def _systems(facts: Facts) -> dict[str, Known]:
    kinds = [kind for kind in ("shape", "puzzle") if facts.kinds[kind]]
    methods = sorted({row_name(row) for row in (*facts.found.rows, *facts.found.chosen)})
    told = f" Systems: {'; '.join(methods)}." if methods else ""
    return {
        "2.1": Known("; ".join(_INPUT[kind] for kind in kinds)),
        "2.2": Known("; ".join(_OUTPUT[kind] for kind in kinds)),
        "2.3": Known("; ".join(_TASK[kind] for kind in kinds) + f".{told}" if kinds else ""),
        "2.4": Known("N/A"),
        "2.5": Known("N/A"),
    }


def _sample(facts: Facts) -> dict[str, Known]:
    rows = totals((*facts.found.rows, *facts.found.chosen))
    counts = [f"{row_name(row)}: {row.seen} of {row.matches} proposed" for row in rows]
    widths = [f"{row_name(row)}: {number(row.micro)} ({shown_range(row.interval.low, row.interval.high)}), {counted_pairs(row.pairs)}"
              for row in rows if row.interval]  # fmt: skip
    if any(row.sampled for row in rows):
        how = ("by an automatic random process but using stratified sampling over given properties: every set and pair gives in "
               "proportion; the probability of each match is stored and figures are weighted by its inverse")  # fmt: skip
    else:
        how = "other: every distinct match of the results is evaluated, once whoever proposed it"
    power = "95 % intervals of precision in %: " + "; ".join(widths) if widths else ""
    return {
        "3.1.1": Known("\n".join(f"- {line}" for line in counts)),
        "3.1.2": Known(how if rows else ""),
        "3.1.3": Known(power, "a calculation of power made before the study, if there was one"),
    }


def counted_pairs(pairs: int) -> str:
    """How many pairs, in words."""
    return "1 pair" if pairs == 1 else f"{pairs} pairs"


def totals(rows: Sequence[PrecisionRow]) -> list[PrecisionRow]:
    """One row a method and preset: that of all sets where there are several."""
    last: dict[tuple[str, str], PrecisionRow] = {}
    for row in rows:
        if row.set_name == ALL_SETS or row[:2] not in last:
            last[row[:2]] = row
    return list(last.values())


def _evaluators(facts: Facts) -> dict[str, Known]:
    voters = [row for row in facts.people if row.judged]
    adjudicators = sum(row.adjudicates for row in voters)
    told = f" ({adjudicators} of them asked about disputed matches alone)" if adjudicators else ""
    lessons = facts.roles["practice"]
    practice = f"{lessons} practice matches with the answer explained after each vote; they count in no figure." if lessons else ""
    guideline = "A guideline, one key away while voting:" if facts.study.guideline else "No guideline."
    return {
        "3.2.1": Known(f"{len(voters)}{told}"),
        "3.2.4": Known(f"{practice or 'No practice matches.'} {guideline}", "what was explained in person, if anything",
                       facts.study.guideline),
    }


def _design(facts: Facts) -> dict[str, Known]:
    study, gold = facts.study, facts.roles["gold"]
    asked = "every volunteer is asked about every match" if not study.votes else f"{study.votes} votes a match"
    if study.votes and study.adaptive:
        asked += ", further ones only until more than half agree"
        asked += f" ({facts.overlapped} matches get all votes, for agreement)" if facts.overlapped else ""
    flagged = sum(bool(row.flags) for row in facts.people)
    checks = (f"automatic quality checking: {gold} gold matches of known answer among those asked" if gold else
              "automatic quality checking without gold matches") + (
        f"; volunteers who {'fail them, ' if gold else ''}are much faster than the others or always answer the same are flagged "
        f"({flagged} flagged) for the researcher. No vote is excluded automatically. {asked[0].upper()}{asked[1:]}.")  # fmt: skip
    paces = [row.seconds for row in facts.people if row.seconds is not None]
    times = f" Median time of a vote: {statistics.median(paces):.1f} s (median of the volunteers)." if paces else ""
    comments = sum(row.comments for row in facts.people)
    return {
        "3.3.2": Known(f"With the program Concord {app_version()}, on a computer; every answer is stored before the next match shows, "
                       "and every change of mind is stored as a new answer."),
        "3.3.3": Known(checks, "manual checks, and whether anybody's votes were left out of what is reported"),
        "3.3.4": Known("One match a screen: two shapes side by side that can be turned, with the matched parts marked, or two puzzle "
                       "pieces put together and apart; the question; one button and key for each answer; progress. Order and side "
                       "are random for each volunteer. No method, parameter, score or other vote is shown.", "link to a screenshot"),
        "3.3.5": Known(f"neither a set time nor one sitting: progress is kept and answers may be changed.{times}"),
        "3.3.6": Known(f"A comment may be written with every vote ({comments} were).", "whether questions were invited, and when"),
    }  # fmt: skip


def _criterion(facts: Facts) -> dict[str, Known]:
    check = "check against the question that was asked"
    return {
        "4.1.1": Known("Correctness", check), "4.1.2": Known("Content of output", check),
        "4.1.3": Known("Quality of output relative to the input", check), "4.2.1": Known("Subjective"),
        "4.2.2": Known("Absolute: one match of one or several systems is shown at a time, blind to which"),
        "4.2.3": Known("Intrinsic"),
    }  # fmt: skip


def _elicitation(facts: Facts) -> dict[str, Known]:
    values = ["correct", "wrong", *(["unsure"] if facts.study.unsure else [])]
    unsure = "; unsure is an abstention" if facts.study.unsure else ""
    sampled = any(row.sampled for row in (*facts.found.rows, *facts.found.chosen))
    weighted = " Every match of the sample counts 1 / p, p being its probability of being drawn." if sampled else ""
    joins = "the question for joins of puzzles, where the window has one of its own"
    return {
        "4.3.1": Known("N/A"),
        "4.3.2": Known("" if facts.study.guideline else "N/A", verbatim=facts.study.guideline),
        "4.3.3": Known(str(len(values))),
        "4.3.4": Known(", ".join(values)),
        "4.3.5": Known("Multiple-choice options"),
        "4.3.6": Known("N/A"),
        "4.3.7": Known(left=joins if facts.kinds["puzzle"] else "", verbatim=facts.study.question),
        "4.3.8": Known("output classification or labelling"),
        "4.3.9": Known(f"Majority of the current votes of each match; a tie stays a tie{unsure}. Gold matches count like all others. "
                       "Precision is correct / (correct + wrong), over all matches (micro) and as the mean over pairs (macro); "
                       f"bounds take the undecided as all wrong and all right.{weighted}"),
        "4.3.10": Known("95 % intervals with the pair as the unit of sampling (cluster-robust binomial model with t; Clopper-Pearson with "
                        "an adjusted number at 0 and 100 %; Wilson's of a single pair); methods by permutation and Wilcoxon's tests of "
                        "differences pair by pair, McNemar's test of the correct matches that one of two methods alone finds; adjusted "
                        "after Holm over sets; no p below 6 pairs.", "those that the paper reports"),
        "4.3.11": Known(_agreement(facts.found)),
    }  # fmt: skip


def _agreement(found: Findings) -> str:
    lines = [
        f"- {row.of}: {percent(row.raw)} raw, Krippendorff's alpha "
        f"{'not defined' if row.alpha is None else f'{row.alpha:.3f}'}, on {row.items} matches"
        for row in found.agreement
        if row.items
    ]
    between = "Between volunteers:\n\n" + "\n".join(lines) if lines else "No match has two votes yet."
    return between + "\n\nWithin volunteers: not measured."


def _ethics() -> dict[str, Known]:
    return {
        "5.1": Known(left="the committee and its number, or No"),
        "5.2": Known("The study stores a code for each volunteer, the answers, comments and times; no names or addresses unless codes or "
                     "comments hold them. Codes can be replaced, and a volunteer deleted on request.",
                     "whether codes can be traced to people, who keeps that list, and for how long"),
        "5.3": Known(left="No, or what and how it was dealt with"),
        "5.4": Known(left="No, or a summary and a link"),
    }  # fmt: skip
