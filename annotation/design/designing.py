"""The design of a study: which matches are asked, how often, and what checks the answers."""

from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import Connection, delete, insert, select

from engine.parameters import Parameters, parameter
from engine.progress import Progress, silent

from ..records import Run
from ..results.proposals import batched, insert_run, pair_id
from ..storage import schema
from ..storage.blobs import insert_shapes
from ..storage.handle import StudyHandle
from ..storage.payloads import read_payload
from ..storage.stamps import now
from ..study import DEFAULT_QUESTION, create_study, study_name
from ..voting.answering import settle_seeds
from .sampling import NOTHING, Drawn, Known, balanced, gold_wanted, overlapped, sample

if TYPE_CHECKING:
    from pathlib import Path

    from engine.shapes.segmentation import SegmentedShape

_TEXTS, _VOTES, _SAMPLE, _CHECKS = "Texts", "Votes", "Sample", "Checks"
_IN_COLUMNS = ("name", "question", "guideline", "votes", "adaptive", "unsure")  # the study has a column of each
_HIDDEN = ("gold", "gold_least", "practice")  # nobody who votes is to know how answers are checked


class Design(Parameters):
    """Everything about a study but its results and its known answers."""

    name: str = parameter("", "Name of the study; that of the file if left out.", group=_TEXTS)
    question: str = parameter(DEFAULT_QUESTION, "The question that volunteers are asked, in one sentence.", group=_TEXTS)
    guideline: str = parameter("", "What volunteers are told of when to call a match correct or wrong.", group=_TEXTS)
    votes: int = parameter(
        3, "Votes that a match is to get; 0 for one of everybody.", low=0, high=99, symbol="k", unit="votes",
        group=_VOTES)  # fmt: skip
    adaptive: bool = parameter(
        True, "Ask no further about a match once more than half of its votes agree: a third volunteer only where two differ.",
        group=_VOTES)  # fmt: skip
    unsure: bool = parameter(True, "Take the answer 'unsure', which is kept as an abstention.", group=_VOTES)
    overlap: float = parameter(
        0.2, "Share of the matches that get all votes even so, to measure agreement on.", low=0.0, high=1.0, step=0.05,
        group=_VOTES)  # fmt: skip
    most: int = parameter(
        0, "Most matches that are asked: a sample in proportion from each pair of each set; 0 asks all.", low=0,
        high=1_000_000, step=50, unit="matches", group=_SAMPLE)  # fmt: skip
    seed: int = parameter(
        0, "Seed of the sample, of what is overlapped, gold and practice, and of everybody's order and sides.", low=0,
        high=2**31 - 1, group=_SAMPLE)  # fmt: skip
    gold: float = parameter(
        0.05, "Share of gold matches, whose answer is known and which everybody is asked, to see who pays attention.",
        low=0.0, high=0.5, step=0.01, group=_CHECKS)  # fmt: skip
    gold_least: int = parameter(
        10, "Fewest gold matches, where so many answers are known.", low=0, high=1000, unit="matches", group=_CHECKS)  # fmt: skip
    practice: int = parameter(
        5, "Matches of known answer to practise on, with an explanation; they count in no table.", low=0, high=100,
        unit="matches", group=_CHECKS)  # fmt: skip

    def settings(self) -> dict[str, Any]:
        """What the study keeps in its settings, which volunteers may read."""
        return self.model_dump(exclude={*_IN_COLUMNS, *_HIDDEN})


def create_design(
    where: "Path | str",
    runs: Iterable[Run],
    design: Design,
    *,
    gold: Known = NOTHING,
    practice: Known = NOTHING,
    shapes: Iterable["SegmentedShape"] = (),
    tell: Callable[[str], None] = lambda sentence: None,
    progress: Progress = silent,
) -> StudyHandle:
    """Make the study of results under a design, in a file, a project folder or on a server, and open it.

    It is made whole or not at all. `gold` and `practice` tell known answers by item (see `annotation.design.knownanswers`);
    `shapes` are kept in the study, so that it can be judged where its meshes are not (see `annotation.results.resultfiles`).
    What a person should know, such as too few gold items, is told in sentences.
    """
    found = tuple(runs)
    plan = draw_design(found, design, gold=gold, practice=practice)

    def fill(connection: Connection) -> None:
        for number, run in enumerate(found):
            progress(0.8 * number / len(found), "taking in results")
            insert_run(connection, run)
        put_asked(connection, plan.asked)
        progress(0.8, "keeping shapes")
        insert_shapes(connection, shapes)

    handle = create_study(
        where, name=design.name or study_name(where), question=design.question, guideline=design.guideline,
        seed=str(design.seed), votes=design.votes, adaptive=design.adaptive, unsure=design.unsure,
        settings={"design": design.settings()}, also=fill,
    )  # fmt: skip
    for note in plan.notes:
        tell(note)
    return handle


def put_asked(connection: Connection, rows: Iterable[Drawn]) -> None:
    """Put rows into the table of what is asked, in place of older ones of the same items."""
    stamped = [row._asdict() | {"overlapped": int(row.overlapped), "added_at": now()} for row in rows]
    for part in batched((row["item_id"] for row in stamped), 5000):
        connection.execute(delete(schema.asked).where(schema.asked.c.item_id.in_(part)))
    if stamped:
        connection.execute(insert(schema.asked), stamped)
    settle_seeds(connection)


class Plan(NamedTuple):
    """What a study asks, and what a person should know about it, in sentences."""

    asked: tuple[Drawn, ...]
    notes: tuple[str, ...]


def draw_design(runs: Sequence[Run], design: Design, *, gold: Known = NOTHING, practice: Known = NOTHING) -> Plan:
    """What a study of these results asks under a design; pure, and the same for the same seed.

    Gold items are drawn from the matches whose answer `gold` tells, those of the sample first. Practice items are drawn
    from `practice`, or else from what is left of `gold`, those outside the sample first.
    """
    seed, strata = str(design.seed), strata_of(runs)
    drawn = sample(strata, design.most, seed)
    told, lesson = known_of(gold, strata), known_of(practice if practice else gold, strata)
    wanted = gold_wanted(len(drawn), design.gold, design.gold_least)
    golden, taught = set[str](), set[str]()
    enough = bool(practice) or len(told) >= wanted + design.practice  # else gold goes first
    for role in ("practice", "gold") if enough else ("gold", "practice"):
        if role == "gold":
            left = {item: known for item, known in told.items() if item not in taught}
            golden = set(balanced(left, wanted, seed, "gold", lambda item: item in drawn))
        else:
            left = {item: known for item, known in lesson.items() if item not in golden}
            taught = set(balanced(left, design.practice, seed, "practice", lambda item: item not in drawn))
    judged = [item for item in drawn if item not in taught and item not in golden]
    twice = overlapped(judged, design.overlap if design.adaptive and design.votes > 2 else 0.0, seed)
    rows = [Drawn(item, "judged", None, "", strata[item], drawn[item], item in twice) for item in judged]
    rows += [Drawn(item, "gold", *told[item], strata[item], drawn.get(item), False) for item in sorted(golden)]
    rows += [Drawn(item, "practice", *lesson[item], strata[item], None, False) for item in sorted(taught)]
    return Plan(tuple(rows), _notes(strata, design, len(golden), wanted, len(taught), drawn))


def strata_of(runs: Iterable[Run]) -> dict[str, str]:
    """The stratum of every distinct match: its set and its pair; the first by name where it is of several."""
    found: dict[str, str] = {}
    for run in runs:
        stratum = stratum_of(run.set_name, pair_id(run.source, run.target))
        for proposal in run.proposals:
            found[proposal.item.id] = min(stratum, found.get(proposal.item.id, stratum))
    return found


def stratum_of(set_name: str, pair: str) -> str:
    """How the stratum of a pair in a set is written."""
    return f"{set_name}/{pair}"


def known_of(known: Known, items: Container[str]) -> Known:
    """What is known of these items."""
    return {item: told for item, told in known.items() if item in items}


def _notes(
    strata: Mapping[str, str], design: Design, golden: int, wanted: int, taught: int, drawn: Container[str]
) -> tuple[str, ...]:
    """What a person should know of what was drawn."""
    asked, groups = sum(item in drawn for item in strata), len(set(strata.values()))
    notes = []
    if asked < len(strata):
        notes.append(f"A sample of {asked} of {len(strata)} matches is asked.")
    if 0 < design.most < groups:
        notes.append(f"The sample has no room for all {groups} pairs; {design.most} of them were drawn too.")
    if golden < wanted:
        found = f"Only {golden} of {wanted} gold matches were found" if golden else "There are no gold matches"
        notes.append(f"{found}, so it is hard to see who pays attention; name more known answers.")
    if taught < design.practice:
        known = f"Only {taught} of {design.practice} practice matches were found" if taught else "There is no practice"
        notes.append(f"{known}: more known answers are needed for it.")
    return tuple(notes)


class JudgedCount(NamedTuple):
    """Of the distinct matches of one run, how many are asked and how many have a vote that decides (n of m judged)."""

    run_id: str
    method: str
    preset: str
    set_name: str
    pair: str
    source: str
    target: str
    matches: int
    asked: int
    judged: int


def judged_counts(handle: StudyHandle) -> tuple[JudgedCount, ...]:
    """The counts of every run, by set, pair and method, the newest of each first; practice items are never judged."""
    run, match, tally, asked = schema.run.c, schema.run_match, schema.tally.c, schema.asked.c
    with handle.reading() as connection:
        roles = {row.item_id: row.role for row in connection.execute(select(asked.item_id, asked.role))}
        decided = set(connection.scalars(select(tally.item_id).where(tally.correct + tally.wrong > 0)))
        items: dict[str, list[str]] = {}
        for row in connection.execute(select(match)):
            items.setdefault(row.run_id, []).append(row.item_id)
        rows = connection.execute(select(schema.run).order_by(
            run.set_name, run.pair, run.method, run.preset, run.added_at.desc(), run.id)).all()  # fmt: skip
    found = []
    for row in rows:
        of = items.get(row.id, [])
        open_to = [item for item in of if not roles or roles.get(item, "practice") != "practice"]
        judged = sum(item in decided and roles.get(item) != "practice" for item in of)
        source, target = (str(read_payload(side).get("file", "")) for side in (row.source, row.target))
        found.append(JudgedCount(row.id, row.method, row.preset, row.set_name, row.pair, source, target, len(of),
                                 len(open_to), judged))  # fmt: skip
    return tuple(found)
