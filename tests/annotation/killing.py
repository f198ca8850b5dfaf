"""Processes that vote, merge, migrate and back up one study, and what must be there after any of them is killed."""

import contextlib
import random
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from judging_world import study_of
from version1 import write_version1

from annotation import study
from annotation.exchange.merging import merge

ROOT = Path(__file__).parents[2]
_READY = 'print("ready", flush=True)\nsys.stdin.readline()\n'
_TOLD = 'print("vote", vote.uuid, vote.item_id, vote.volunteer, vote.answer, time.monotonic() - began, flush=True)\n'

VOTER = f"""
import random, sys, time
from annotation import study
place, code, seconds = sys.argv[1], sys.argv[2], float(sys.argv[3])
draw = random.Random(code)
with study.open_study(place, backup=False) as handle:
    ids = [item.id for item in study.items(handle, code)]
    {_READY.replace(chr(10), chr(10) + "    ")}
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if draw.random() < 0.1:
            study.undo_vote(handle, code)
            continue
        began = time.monotonic()
        vote = study.record_vote(handle, draw.choice(ids), code, draw.choice(study.ANSWERS))
        {_TOLD}"""
"""Votes on random items for some seconds and prints each vote once it was confirmed; a tenth is undos."""

MERGER = f"import sys\nfrom annotation.exchange.merging import merge\n{_READY}merge(sys.argv[1], sys.argv[2])\n"

MIGRATOR = f"""
import sys, time
from annotation import study
from annotation.storage import database, migrations
import alembic.operations, alembic.runtime.migration
pause = float(sys.argv[2])
def slowly(connection, version):
    migrations.migrate(connection, version)
    time.sleep(pause)  # the transaction is still open
database.migrate = slowly
{_READY}study.open_study(sys.argv[1]).close()
"""

KEEPER = f"""
import random, sys, time
from annotation import study
from annotation.storage import backup
backup.EVERY_SECONDS = 0.0
path, code = sys.argv[1], sys.argv[2]
draw = random.Random(code)
{_READY}while True:
    with study.open_study(path) as handle:
        began = time.monotonic()
        vote = study.record_vote(handle, f"join-{{draw.randrange(50)}}", code, draw.choice(study.ANSWERS))
        {_TOLD}"""
"""Opens the study, which keeps a copy each time, votes once, closes it, and begins again."""


class Told(NamedTuple):
    """A vote as a process confirmed it, and after how many seconds."""

    uuid: str
    item: str
    volunteer: str
    answer: str
    seconds: float


class Outcome(NamedTuple):
    """What one kill did: `cut` tells whether the work had begun and was not finished."""

    confirmed: int
    lost: int
    misattached: int
    damaged: int
    cut: bool


def started(script: str, *arguments: object) -> subprocess.Popen:
    """A process that waits for a line before it begins."""
    pipe = subprocess.PIPE
    command = [sys.executable, "-c", script, *map(str, arguments)]
    return subprocess.Popen(command, cwd=ROOT, stdin=pipe, stdout=pipe, stderr=pipe, text=True)


def begin(processes: Sequence[subprocess.Popen]) -> None:
    for process in processes:
        assert process.stdout.readline() == "ready\n", process.stderr.read()
    for process in processes:
        process.stdin.write("\n")
        process.stdin.flush()


def told(output: str) -> list[Told]:
    """The votes whose line came through whole."""
    lines = [line.split() for line in output.splitlines(keepends=True) if line.startswith("vote ") and line.endswith("\n")]
    return [Told(*words[1:5], float(words[5])) for words in lines if len(words) == 6]


def kept(path: Path) -> dict[str, tuple[str, str, str]]:
    """Item, volunteer and answer of every vote in a file, by its id."""
    with contextlib.closing(sqlite3.connect(path)) as raw:
        rows = raw.execute("SELECT uuid, item_id, volunteer, answer FROM event WHERE kind = 'vote'")
        return {uuid: tuple(row) for uuid, *row in rows}


def whole(path: Path) -> bool:
    with contextlib.closing(sqlite3.connect(path)) as raw:
        return raw.execute("PRAGMA integrity_check").fetchone() == ("ok",)


def killed(processes: Sequence[subprocess.Popen], after: float) -> tuple[list[Told], bool]:
    """Let them work, kill them all; what they confirmed, and whether they were still at work."""
    begin(processes)
    time.sleep(after)
    for process in processes:
        process.send_signal(signal.SIGKILL)
    ends = [process.communicate() for process in processes]
    assert not any("Traceback" in errors for _, errors in ends), ends
    return [one for output, _ in ends for one in told(output)], any(process.returncode < 0 for process in processes)


def judged(path: Path, confirmed: Sequence[Told], cut: bool, *, unsaid: int = 0, damaged: int = 0) -> Outcome:
    """Compare a study with what was confirmed, after opening it and voting once more as anybody would.

    `unsaid` votes may be there beside them: committed, and killed before the line that tells of it.
    """
    with study.open_study(path, busy_seconds=10, backup=False) as handle:
        found = kept(path)
        mine = study.record_vote(handle, next(iter(study.items(handle, "after"))).id, "after", "wrong")
        assert mine in study.current_votes(handle, volunteer="after")
    lost = sum(one.uuid not in found for one in confirmed)
    wrong = sum(found.get(one.uuid, one[1:4]) != one[1:4] for one in confirmed)
    assert len(found) - len(confirmed) + lost <= unsaid, "votes that nobody gave"
    return Outcome(len(confirmed), lost, wrong, damaged + (not whole(path)), cut)


def add_many(handle: study.StudyHandle, count: int = 50) -> None:
    study.add_items(handle, [study.Item(f"join-{n}", "puzzle", {"n": n}) for n in range(count)])


def kill_voting(folder: Path, draw: random.Random) -> Outcome:
    """Two processes vote on one file."""
    path = folder / "a.db"
    with study_of(path) as handle:
        add_many(handle)
    voters = [started(VOTER, path, f"v{n}-{draw.random()}".replace(".", "-"), 60) for n in range(2)]
    confirmed, cut = killed(voters, draw.uniform(0.0, 0.4))
    return judged(path, confirmed, cut, unsaid=len(voters))


def kill_merging(folder: Path, draw: random.Random) -> Outcome:
    """One file takes in another; afterwards it has all of it or none, and merging again gives the rest."""
    into, source = folder / "a.db", folder / "b.db"
    with study_of(into) as handle:
        add_many(handle, 3)
    source.write_bytes(into.read_bytes())
    with study.open_study(into, backup=False) as handle:
        own = [study.record_vote(handle, f"join-{n}", "bert", draw.choice(study.ANSWERS)) for n in range(3)]
    with study.open_study(source, backup=False) as handle:
        add_many(handle, 2000)
        answers = {f"join-{n}": draw.choice(study.ANSWERS) for n in range(500)}
        theirs = study.record_votes(handle, "anna", answers)
    mine, their = ([Told(v.uuid, v.item_id, v.volunteer, v.answer, 0.0) for v in votes] for votes in (own, theirs))
    _, cut = killed([started(MERGER, into, source)], 0.35 * draw.random() ** 2)
    begun = len(kept(into))
    assert begun in (len(mine), len(mine) + len(their)), "half a merge"
    first = judged(into, mine if begun == len(mine) else [*mine, *their], cut)
    merge(into, source)
    again = judged(into, [*mine, *their], cut, unsaid=2, damaged=not whole(source))
    return Outcome(again.confirmed, first.lost + again.lost, first.misattached + again.misattached,
                   first.damaged + again.damaged, cut)  # fmt: skip


def kill_migrating(folder: Path, draw: random.Random) -> Outcome:
    """A file of version 1 is led on; afterwards it is of one version or the other, whole."""
    path = folder / "a.db"
    said = write_version1(path, items=400, votes=400)
    confirmed = [Told(uuid, item, "anna", answer, 0.0) for uuid, (item, answer) in said.items()]
    pause = draw.choice((0.0, 0.1))
    _, cut = killed([started(MIGRATOR, path, pause)], draw.uniform(0.0, 0.07 + pause))
    copies = list((folder / "backups").glob("a.db.version-1.*")) if (folder / "backups").exists() else []
    assert all(len(kept(copy)) == len(said) for copy in copies)
    return judged(path, confirmed, cut, damaged=sum(not whole(copy) for copy in copies))


def kill_backing_up(folder: Path, draw: random.Random) -> Outcome:
    """A process opens the study again and again, each time with a copy; every copy is whole."""
    path = folder / "a.db"
    with study_of(path) as handle:
        add_many(handle)
    confirmed, cut = killed([started(KEEPER, path, "anna")], draw.uniform(0.0, 0.5))
    copies = list((folder / "backups").glob("a.db.2*"))
    votes = kept(path)
    assert all(kept(copy).items() <= votes.items() for copy in copies)
    return judged(path, confirmed, cut, unsaid=1, damaged=sum(not whole(copy) for copy in copies))
