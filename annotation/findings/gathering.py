"""Everything that a study's votes say: the one thing that tables, reports and the window's page of results are made of."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Literal, NamedTuple

from sqlalchemy import func, select

from engine.evaluation.thesis_tables import SetPrecision

from ..design.flags import evenness
from ..storage import schema
from ..storage.handle import StudyHandle
from ..voting.majority import Majority
from .agreement import AgreementRow, VolunteerAgreement, agreement_rows, overlapped_items, volunteer_agreement
from .comparing import Compared, LeftOut, Modelled, compared, leave_one_out, modelled
from .dawidskene import DawidSkene, dawid_skene
from .precision import (
    Ballot,
    Cast,
    PrecisionRow,
    Proposed,
    Weights,
    ballots,
    counted,
    proposed,
    proposed_later,
    sample,
    tabulate,
)
from .thesistables import set_precisions

Preset = Literal["modern", "thesis"]
MOST_DISPUTED = 24


class Disputed(NamedTuple):
    """A match on which volunteers are divided; `sets` and `pair` are names for people, `comments` what was said of it."""

    item: str
    kind: str
    sets: tuple[str, ...]
    pair: str
    majority: Majority
    comments: tuple[str, ...]


class Findings(NamedTuple):
    """What the votes say; `preset` is the table that was asked for ("thesis": as in Tables 3.1 and 3.2).

    `rows` are the methods with fixed parameters, `chosen` those in whose parameters or results votes, wishes or a truth had
    a part: they are reported apart. `compared` has every two methods, `left_out` a line for each of `rows` and `chosen`,
    `modelled` the same under Dawid and Skene's `model` (None with fewer than three volunteers), `disputed` the most
    divided matches, most divided first, `sets` what the thesis's tables show of `rows`. `adaptive` says that further votes
    are asked where the first ones differ (by the design, at ties, of adjudicators), `held_out` that the pairs are those on
    which nothing was chosen.
    """

    study: str
    preset: Preset
    rows: tuple[PrecisionRow, ...]
    chosen: tuple[PrecisionRow, ...]
    agreement: tuple[AgreementRow, ...]
    volunteers: tuple[VolunteerAgreement, ...]
    compared: tuple[Compared, ...]
    left_out: tuple[LeftOut, ...]
    modelled: tuple[Modelled, ...]
    model: DawidSkene | None
    disputed: tuple[Disputed, ...]
    sets: tuple[SetPrecision, ...]
    adaptive: bool
    held_out: bool = False


class Votes(NamedTuple):
    """What is read of a study, once; all figures are pure functions of it."""

    study: str
    adaptive: bool
    results: tuple[Proposed, ...]
    ballots: tuple[Ballot, ...]
    weights: Weights | None
    overlapped: frozenset[str]
    comments: Mapping[str, tuple[str, ...]]
    kinds: Mapping[str, str]
    later: frozenset[str] = frozenset()
    held_out: bool = False


def findings(handle: StudyHandle, *, preset: Preset = "modern", chosen: Collection[str] = ()) -> Findings:
    """Read a study and work out all its figures; `chosen` names methods or presets whose parameters were tuned."""
    return worked_out(read_votes(handle), preset=preset, chosen=chosen)


def read_votes(handle: StudyHandle) -> Votes:
    """All that the figures need of a study; nothing is written."""
    results, cast, weights = proposed(handle), ballots(handle), sample(handle)
    twice, later = overlapped_items(handle), proposed_later(handle)
    with handle.reading() as connection:  # last, for it has to know every item of the results
        study = connection.execute(select(schema.study)).one()
        vote = schema.current_vote.c
        said = connection.execute(
            select(vote.item_id, vote.comment).where(vote.round == 1, vote.comment != "").order_by(vote.created_at, vote.uuid)
        ).all()
        referees = connection.scalar(select(func.count()).where(schema.volunteer.c.adjudicates == 1))
        kinds = {row.id: row.kind for row in connection.execute(select(schema.item.c.id, schema.item.c.kind))}
    # An even number of votes can be tied, and a tie gets one more.
    disputed_more = bool((study.votes and (study.adaptive or study.votes % 2 == 0)) or referees)
    comments: dict[str, tuple[str, ...]] = {}
    for row in said:
        comments[row.item_id] = (*comments.get(row.item_id, ()), row.comment)
    return Votes(study.name, disputed_more, results, cast, weights, twice, comments, kinds, later)


def worked_out(votes: Votes, *, preset: Preset = "modern", chosen: Collection[str] = ()) -> Findings:
    """The figures of what was read; pure. Agreement and disputes are of matches that some method proposes."""
    results, cast = votes.results, counted(votes.ballots)
    sets = items_of_sets(results)
    items = frozenset[str]().union(*sets.values())
    mine = [vote for vote in votes.ballots if vote.item in items]
    rows, model = tabulate(results, cast, votes.weights, chosen, later=votes.later), dawid_skene(mine)
    fixed = tuple(r for r in rows if not r.chosen)
    return Findings(
        votes.study, preset, fixed, tuple(r for r in rows if r.chosen),
        agreement_rows(mine, votes.overlapped & items, sets), volunteer_agreement(mine), compared(results, cast, votes.weights),
        leave_one_out(results, mine, votes.weights), modelled(results, rows, model, votes.weights), model,
        disputed(votes, {item: cast[item] for item in items if item in cast}), tuple(set_precisions(results, fixed)),
        votes.adaptive, votes.held_out,
    )  # fmt: skip


def items_of_sets(results: Iterable[Proposed]) -> dict[str, set[str]]:
    """The distinct matches of each set, whoever proposed them."""
    sets: dict[str, set[str]] = {}
    for result in results:
        sets.setdefault(result.set_name, set()).update(result.items)
    return sets


def disputed(votes: Votes, cast: Mapping[str, Cast], most: int = MOST_DISPUTED) -> tuple[Disputed, ...]:
    """The matches with votes for and against, the most evenly divided and most voted on first."""
    divided = {item: one.majority for item, one in cast.items() if one.majority.correct and one.majority.wrong}
    order = sorted(divided, key=lambda item: (evenness(divided[item]), -sum(divided[item][:2]), item))[:most]
    sets, pairs = _places(votes.results, frozenset(order))
    return tuple(
        Disputed(item, votes.kinds[item], tuple(sorted(sets[item])), pairs[item], divided[item], votes.comments.get(item, ()))
        for item in order
    )


def _places(results: Sequence[Proposed], items: frozenset[str]) -> tuple[dict[str, set[str]], dict[str, str]]:
    """The sets and the name of the pair of each item."""
    sets: dict[str, set[str]] = {}
    pairs: dict[str, str] = {}
    for result in results:
        for item in items.intersection(result.items):
            sets.setdefault(item, set()).add(result.set_name or "–")
            pairs.setdefault(item, result.name)
    return sets, pairs

