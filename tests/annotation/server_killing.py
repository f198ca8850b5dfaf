"""Volunteers, a merge, or the whole server killed in the middle: what a server had confirmed must be there."""

import os
import random
import signal
import time
from collections.abc import Sequence
from pathlib import Path

from judging_world import study_of
from killing import MERGER, VOTER, Outcome, Told, add_many, begin, started, told
from postgres_server import Server

from annotation import study
from annotation.exchange.merging import merge
from annotation.server.invitations import invite
from annotation.server.publishing import publish


def crash(server: Server) -> None:
    """Kill every process of the server at once and start it again: it recovers by its log."""
    first = int((server.folder / "data" / "postmaster.pid").read_text().split()[0])
    os.kill(first, signal.SIGSTOP)  # it starts no more children
    children = Path(f"/proc/{first}/task/{first}/children").read_text().split()
    for process in (*map(int, children), first):
        os.kill(process, signal.SIGKILL)
    while any(Path(f"/proc/{process}").exists() and "Z" not in _state(process) for process in (first, *children)):
        time.sleep(0.01)
    for lock in (server.folder / "data" / "postmaster.pid", *server.folder.glob(".s.PGSQL.*.lock")):
        lock.unlink()  # where nobody buries the dead, their numbers look alive
    server.control("start")


def _state(process: object) -> str:
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return "Z"


def kill_voting(server: Server, draw: random.Random) -> Outcome:
    """Three volunteers vote, each with a login of their own; two are killed, or the server is."""
    address, clients = server.database(), draw.random() < 0.5
    with study_of(address) as handle:
        add_many(handle)
        people = {f"v{n}": invite(handle, f"v{n}") for n in range(3)}
    voters = [started(VOTER, personal, code, 60) for code, personal in people.items()]
    begin(voters)
    time.sleep(draw.uniform(0.0, 0.5))
    for voter in voters[: 2 if clients else 0]:
        voter.send_signal(signal.SIGKILL)
    if not clients:
        crash(server)
    for voter in voters[2 if clients else 3 :]:
        voter.send_signal(signal.SIGKILL)
    ends = [voter.communicate(timeout=60) for voter in voters]
    cut = all(voter.returncode != 0 for voter in voters)
    found = judged(address, [one for output, _ in ends for one in told(output)], cut, unsaid=len(voters))
    server.drop(address)
    return found


def kill_merging(server: Server, folder: Path, draw: random.Random, votes: int = 500) -> Outcome:
    """The server takes in a file; afterwards it has all of it or none, and merging again gives the rest."""
    address, source = server.database(), folder / "b.db"
    with study_of(source) as handle:
        publish(handle, address)
        add_many(handle, 4 * votes)
        given = study.record_votes(handle, "anna", {f"join-{n}": draw.choice(study.ANSWERS) for n in range(votes)})
    theirs = [Told(vote.uuid, vote.item_id, vote.volunteer, vote.answer, 0.0) for vote in given]
    merger = started(MERGER, address, source)
    begin([merger])
    time.sleep(draw.uniform(0.0, 0.6))
    if draw.random() < 0.5:
        merger.send_signal(signal.SIGKILL)
    else:
        crash(server)
    merger.communicate(timeout=60)
    cut, begun = merger.returncode != 0, len(_kept(address))
    assert begun in (0, len(theirs)), "half a merge"
    merge(address, source)
    found = judged(address, theirs, cut)
    server.drop(address)
    return found


def judged(address: str, confirmed: Sequence[Told], cut: bool, *, unsaid: int = 0) -> Outcome:
    """Compare a study with what was confirmed, and vote once more as anybody would."""
    found = _kept(address)
    with study.open_study(address) as handle:
        mine = study.record_vote(handle, next(iter(study.ordered_ids(handle, "after"))), "after", "wrong")
        assert mine in study.current_votes(handle, volunteer="after")
    lost = sum(one.uuid not in found for one in confirmed)
    wrong = sum(found.get(one.uuid, one[1:4]) != one[1:4] for one in confirmed)
    assert len(found) - len(confirmed) + lost <= unsaid, "votes that nobody gave"
    return Outcome(len(confirmed), lost, wrong, 0, cut)


def _kept(address: str) -> dict[str, tuple[str, str, str]]:
    """Item, volunteer and answer of every vote, by its id."""
    with study.open_study(address) as handle, handle.reading() as connection:
        rows = connection.exec_driver_sql("SELECT uuid, item_id, volunteer, answer FROM event WHERE kind = 'vote'")
        return {uuid: tuple(row) for uuid, *row in rows}
