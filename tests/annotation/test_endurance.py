"""Many processes on one study, and processes killed in the middle: no vote that was confirmed is ever lost."""

import contextlib
import random
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import pytest
from judging_world import study_of

from annotation import study
from annotation.exchange import merge

ROOT = Path(__file__).parents[2]

VOTER = """
import random, sys, time
from annotation import study
path, code, seconds = sys.argv[1], sys.argv[2], float(sys.argv[3])
draw = random.Random(code)
with study.open_study(path) as handle:
    ids = [item.id for item in study.items(handle, code)]
    print("ready", flush=True)
    sys.stdin.readline()
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if draw.random() < 0.1:
            study.undo_vote(handle, code)
            continue
        began = time.monotonic()
        vote = study.record_vote(handle, draw.choice(ids), code, draw.choice(study.ANSWERS))
        print(vote.uuid, time.monotonic() - began, flush=True)
"""

MERGER = """
import sys
from annotation.exchange import merge
print("ready", flush=True)
sys.stdin.readline()
merge(sys.argv[1], sys.argv[2])
"""


def started(script: str, *arguments: object) -> subprocess.Popen:
    """A process that waits for a line before it begins."""
    pipe = subprocess.PIPE
    command = [sys.executable, "-c", script, *map(str, arguments)]
    return subprocess.Popen(command, cwd=ROOT, stdin=pipe, stdout=pipe, stderr=pipe, text=True)


def begin(processes: list[subprocess.Popen]) -> None:
    for process in processes:
        assert process.stdout.readline() == "ready\n", process.stderr.read()
    for process in processes:
        process.stdin.write("\n")
        process.stdin.flush()


def confirmed(output: str) -> list[str]:
    """Ids of the votes whose line came through whole."""
    return [line.split()[0] for line in output.splitlines() if len(line.split()) == 2]


def kept(path: Path) -> set[str]:
    with contextlib.closing(sqlite3.connect(path)) as raw:
        return {uuid for (uuid,) in raw.execute("SELECT uuid FROM event WHERE kind = 'vote'")}


def add_many(handle: study.StudyFile, count: int = 50) -> None:
    study.add_items(handle, [study.Item(f"join-{n}", "puzzle", {"n": n}) for n in range(count)])


def test_eight_processes_and_a_window_on_one_file(tmp_path):
    with study_of(tmp_path / "a.db") as window:
        add_many(window)
        voters = [started(VOTER, window.path, f"v{n}", 3) for n in range(8)]
        begin(voters)
        own = []
        while any(voter.poll() is None for voter in voters[:1]):
            own.append(study.record_vote(window, "join-1", "window", "correct").uuid)
            assert study.majority(window)["join-1"].correct >= 1
            time.sleep(0.02)
        ends = [voter.communicate() for voter in voters]
        assert [(voter.returncode, errors) for voter, (_, errors) in zip(voters, ends, strict=True)] == [(0, "")] * 8
        said = [uuid for output, _ in ends for uuid in confirmed(output)]
        assert set(said) | set(own) == kept(window.path)
        assert len(set(said)) == len(said) > 100
        with window.reading() as connection:
            assert connection.exec_driver_sql("PRAGMA quick_check").scalar() == "ok"
        seconds = sorted(float(line.split()[1]) for output, _ in ends for line in output.splitlines())
        assert seconds[int(0.5 * len(seconds))] < 1


@pytest.mark.parametrize("trial", range(10))
def test_no_confirmed_vote_is_lost_by_a_kill(tmp_path, trial):
    path = tmp_path / "a.db"
    with study_of(path) as handle:
        add_many(handle)
    voters = [started(VOTER, path, f"v{n}", 60) for n in range(2)]
    begin(voters)
    time.sleep(random.Random(trial).uniform(0.02, 0.4))
    for voter in voters:
        voter.send_signal(signal.SIGKILL)
    said = {uuid for voter in voters for uuid in confirmed(voter.communicate()[0])}
    with study.open_study(path, busy_seconds=5) as handle:
        assert said <= kept(path)
        assert len(kept(path) - said) <= len(voters)  # killed between the commit and the line that tells of it
        study.record_vote(handle, "join-1", "after", "wrong")
        assert study.answers(handle, "after") == {"join-1": "wrong"}


@pytest.mark.parametrize("trial", range(4))
def test_a_killed_merge_is_whole_or_not_there(tmp_path, trial):
    into, source = tmp_path / "a.db", tmp_path / "b.db"
    with study_of(into) as handle:
        add_many(handle, 3)
    source.write_bytes(into.read_bytes())
    with study.open_study(source, backup=False) as handle:
        add_many(handle, 2000)
        for n in range(100):
            study.record_vote(handle, f"join-{n}", "anna", "correct")
    merger = started(MERGER, into, source)
    begin([merger])
    time.sleep(random.Random(trial).uniform(0.0, 0.15))
    merger.send_signal(signal.SIGKILL)
    merger.communicate()
    with study.open_study(into, busy_seconds=5) as handle:
        assert (study.progress(handle, "anna").done, study.progress(handle, "anna").total) in ((0, 6), (100, 2003))
    assert len(kept(source)) == 100
    merge(into, source)
    assert kept(into) == kept(source)
