"""The results of a study come out as they went in, and what it does not ask yet is counted."""

import pytest

from annotation.design.designing import Design, create_design
from annotation.records import Item, Proposal, Run
from annotation.results.proposals import add_run, run_id
from annotation.results.studyruns import Unasked, item_count, runs_of_study, shapes_of_study, unasked
from annotation.study import create_study, open_study


def a_run(method, names, pair="p"):
    side = {"file": "a.off", "sha256": pair, "segments": 2, "faces": 4}
    part = {"file": "a.off", "sha256": pair, "segments": [1]}
    items = [Item(name, "shape", {"source": part, "target": part}) for name in names]
    proposals = tuple(Proposal(item, 1.0 - k / 10, k, 1, 2) for k, item in enumerate(items))
    return Run("shape", method, "plain", {"K": 3}, "lamps", side, side, {"all": 0.5}, proposals)


@pytest.fixture
def runs():
    return [a_run("one", "abc"), a_run("two", "bd")]


def test_runs_come_out_as_they_went_in(tmp_path, runs):
    with create_study(tmp_path / "s.db", name="s") as handle:
        for run in runs:
            add_run(handle, run)
        found = {run.method: run for run in runs_of_study(handle)}
        assert found == {run.method: run for run in runs}
        assert item_count(handle) == 4
        assert shapes_of_study(handle, tuple(runs)) == {}
        assert {run_id(run) for run in found.values()} == {run_id(run) for run in runs}


def test_what_is_not_asked_is_counted(tmp_path, runs):
    with create_design(tmp_path / "s.db", runs[:1], Design()) as handle:
        assert unasked(handle) == Unasked(0, False)
        add_run(handle, runs[1])
        assert unasked(handle) == Unasked(1, False)
    with create_design(tmp_path / "t.db", runs, Design(most=2)) as handle:
        assert unasked(handle) == Unasked(2, True)
    with create_study(tmp_path / "u.db", name="all") as handle:
        add_run(handle, runs[0])
        assert unasked(handle) == Unasked(0, False)


def test_reading_runs_changes_nothing(tmp_path, runs):
    with create_study(tmp_path / "s.db", name="s") as handle:
        add_run(handle, runs[0])
    before = (tmp_path / "s.db").read_bytes()
    with open_study(tmp_path / "s.db", backup=False, writable=False) as handle:
        assert len(runs_of_study(handle)) == 1
    assert (tmp_path / "s.db").read_bytes() == before
