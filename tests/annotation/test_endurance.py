"""Many processes on one study, and processes killed in the middle: no vote that was confirmed is ever lost.

`tests/benchmarks/study_safety.py` and `study_load.py` do the same for longer and print their figures.
"""

import random
import time

import pytest
from judging_world import study_of
from killing import (
    VOTER,
    add_many,
    begin,
    kept,
    kill_backing_up,
    kill_merging,
    kill_migrating,
    kill_voting,
    started,
    told,
    whole,
)

from annotation import study


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
        said = [one for output, _ in ends for one in told(output)]
        found = kept(window.path)
        assert {one.uuid for one in said} | set(own) == set(found)
        assert all(found[one.uuid] == one[1:4] for one in said)
        assert len({one.uuid for one in said}) == len(said) > 100
        assert whole(window.path)
        seconds = sorted(one.seconds for one in said)
        assert seconds[int(0.5 * len(seconds))] < 1


@pytest.mark.parametrize("work", [kill_voting, kill_merging, kill_migrating, kill_backing_up], ids=lambda work: work.__name__)
def test_no_confirmed_vote_is_lost_by_a_kill(tmp_path, work):
    outcomes = []
    for trial in range(4):
        (tmp_path / str(trial)).mkdir()
        outcomes.append(work(tmp_path / str(trial), random.Random(trial)))
    assert {(one.lost, one.misattached, one.damaged) for one in outcomes} == {(0, 0, 0)}
    assert any(one.cut for one in outcomes)
