"""What the judging layer hands out: frozen records, none of which tells a volunteer who proposed a match."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from .voting.majority import Answer

Kind = Literal["shape", "puzzle"]


@dataclass(frozen=True, slots=True)
class Study:
    """What a study says of itself; `seed` orders its items for each volunteer.

    `votes` is k, how many votes an item is to get, 0 for one of everybody; `adaptive` asks no further once more than
    k / 2 agree; `unsure` allows that answer.
    """

    id: str
    name: str
    question: str
    guideline: str
    seed: str
    settings: Mapping[str, Any]
    created_at: str
    votes: int = 0
    adaptive: bool = True
    unsure: bool = True


@dataclass(frozen=True, slots=True)
class Item:
    """One distinct match to be judged, whoever proposed it.

    `id` is the content hash of the match. The payload of a "shape" item is `{"source": side, "target": side}` with
    side = `{"file", "sha256", "segments": [label, ...]}`, enough to show the match again; which side is called source
    does not depend on the direction in which the match was found. That of a "puzzle" item holds the pictures of its two
    pieces (see `annotation.results.puzzlejoins.join_items`).
    """

    id: str
    kind: Kind
    payload: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Volunteer:
    """Somebody who votes, known by a code alone; `seed` orders the items and chooses the sides.

    One who `adjudicates` is asked about unresolved items alone.
    """

    code: str
    seed: str
    adjudicates: bool = False


class OpenItem(NamedTuple):
    """An item that a volunteer is still to be asked about; practice items have round 0, all others 1."""

    item_id: str
    round: int


class Practice(NamedTuple):
    """The known answer of a practice item, and what to tell the volunteer after the vote."""

    answer: Answer
    reason: str


@dataclass(frozen=True, slots=True)
class Vote:
    """One answer as it was given. `clock` counts the events of its volunteer; times are milliseconds."""

    uuid: str
    item_id: str
    volunteer: str
    round: int
    answer: Answer
    comment: str
    supersedes: str | None
    clock: int
    shown_ms: int | None
    active_ms: int | None
    presentation: Mapping[str, Any]
    created_at: str


@dataclass(frozen=True, slots=True)
class Proposal:
    """That a run proposed an item, with what it thought of it."""

    item: Item
    score: float
    votes: int
    source_layer: int | None = None
    target_layer: int | None = None


@dataclass(frozen=True, slots=True)
class Run:
    """One method with one set of parameters on one pair, and its distinct proposals, best first.

    `source` and `target` are `{"file", "sha256", "segments", "faces"}`, the last two being numbers, and, where known,
    `"segmentation"`, the hash of the labels. A puzzle is one input, `source` = `{"file", "sha256", "pieces"}`; its
    `preset` is the measure and its `target` empty.
    """

    kind: Kind
    method: str
    preset: str
    parameters: Mapping[str, Any]
    set_name: str
    source: Mapping[str, Any]
    target: Mapping[str, Any]
    seconds: Mapping[str, float]
    proposals: tuple[Proposal, ...]


class VotingProgress(NamedTuple):
    """How far a volunteer is, and how long the rest may take (None before the first timed vote)."""

    done: int
    total: int
    seconds_left: float | None
