"""The service of the judging layer: create or open a study file, add results, vote, undo, count.

One study is one SQLite file that any number of processes and windows may hold open. The functions take the handle
that `create_study` and `open_study` return; every failure that a person can meet is a `BadInput` or `BadParameter`.
"""

import json
import uuid
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, insert, select

from engine.errors import BadParameter

from .records import Item, OpenItem, Practice, Proposal, Run, Study, Volunteer, Vote, VotingProgress
from .results.matchesfile import add_result
from .results.proposals import add_items, add_run, canonical, shape_item
from .server.postgres import create_server, is_url, named, open_server, server_url
from .storage import schema
from .storage.database import BUSY_SECONDS, StudyFile, create_file, open_file
from .storage.handle import StudyHandle
from .storage.stamps import app_version, now
from .voting.answering import (
    answers,
    current_votes,
    item,
    items,
    majority,
    next_item,
    open_items,
    ordered_ids,
    practice,
    progress,
    record_vote,
    record_votes,
    sides_swapped,
    still_open,
    undo_vote,
    volunteer,
    volunteers,
)
from .voting.majority import ANSWERS, Answer, Majority, Verdict

__all__ = [
    "ANSWERS",
    "DEFAULT_QUESTION",
    "Answer",
    "Item",
    "Majority",
    "OpenItem",
    "Practice",
    "Proposal",
    "Run",
    "Study",
    "StudyFile",
    "StudyHandle",
    "Verdict",
    "Volunteer",
    "Vote",
    "VotingProgress",
    "about",
    "add_items",
    "add_result",
    "add_run",
    "answers",
    "create_study",
    "current_votes",
    "is_url",
    "item",
    "items",
    "majority",
    "next_item",
    "open_items",
    "open_study",
    "ordered_ids",
    "practice",
    "progress",
    "record_vote",
    "record_votes",
    "shape_item",
    "shown_place",
    "sides_swapped",
    "still_open",
    "study_name",
    "undo_vote",
    "volunteer",
    "volunteers",
]  # fmt: skip

DEFAULT_QUESTION = "Do the two marked parts correspond?"


def create_study(
    path: Path | str,
    *,
    name: str,
    question: str = DEFAULT_QUESTION,
    guideline: str = "",
    seed: str | None = None,
    votes: int = 0,
    adaptive: bool = True,
    unsure: bool = True,
    settings: Mapping[str, Any] | None = None,
    study_id: str | None = None,
    also: Callable[[Connection], None] | None = None,
) -> StudyHandle:
    """Make a new study and open it; an existing one is refused. `seed` (drawn if None) fixes all orders.

    A `path` that begins with "postgresql:" is the address of a database on a server, which holds one study.

    A `path` that ends in ".concord" is made a project folder: the study, the results it is of, and its backups.

    For `votes`, `adaptive` and `unsure` see `Study`; `settings` is whatever else the design has to remember, as JSON.
    `also` puts more into the study in the transaction that makes it: where that fails, there is no study.
    """
    if not name.strip():
        raise BadParameter("A study needs a name; give one.")
    values = {
        "id": study_id or str(uuid.uuid4()), "name": name.strip(), "question": question, "guideline": guideline,
        "seed": seed if seed is not None else uuid.uuid4().hex, "settings": canonical(settings or {}),
        "app_version": app_version(), "created_at": now(), "votes": votes, "adaptive": int(adaptive), "unsure": int(unsure),
    }  # fmt: skip

    def fill(connection: Connection) -> None:
        connection.execute(insert(schema.study).values(values))
        if also is not None:
            also(connection)

    if is_url(path):
        create_server(str(path), fill)
    else:
        create_file(Path(path), fill)
    return open_study(path, backup=False)


def open_study(
    path: Path | str, *, busy_seconds: float = BUSY_SECONDS, backup: bool = True, writable: bool = True
) -> StudyHandle:
    """Check a study file, keep a backup beside it, and open it; use as a context manager or `close()` it.

    `path` may be a project folder `name.concord`. Without `writable` nothing of the study is changed, and it may lie on
    a read-only disk. Raises `BadInput` in one sentence if the file is missing, empty, damaged, foreign, read-only, of a
    newer version, or held by another program for longer than `busy_seconds`.
    """
    if is_url(path):
        return open_server(str(path))
    return open_file(Path(path), busy_seconds=busy_seconds, backup=backup, writable=writable)


def study_name(place: Path | str) -> str:
    """What a study is called by its file, folder or database."""
    return server_url(str(place)).database or "" if is_url(place) else Path(place).stem


def shown_place(place: Path | str) -> str:
    """The file, folder or address as it may be shown: never with a password."""
    return named(server_url(str(place))) if is_url(place) else str(place)


def about(handle: StudyHandle) -> Study:
    """What the study says of itself."""
    with handle.reading() as connection:
        row = connection.execute(select(schema.study)).one()
    return Study(
        row.id, row.name, row.question, row.guideline, row.seed, json.loads(row.settings), row.created_at, row.votes,
        bool(row.adaptive), bool(row.unsure),
    )  # fmt: skip
