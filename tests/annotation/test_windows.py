"""Two windows on one study, and a clock that is set back: no vote is lost, mixed up, or ordered by the computer's time."""

import contextlib
import os
import sqlite3
import threading
import time

import pytest
from judging_world import LAMP, VASE, identity, study_of

from annotation import study
from annotation.storage import backup
from annotation.voting import answering as voting
from annotation.voting import asking

FOOT, STEM, SHADE = (identity(LAMP, (n,), VASE, (n,)) for n in range(3))


@pytest.fixture
def path(tmp_path):
    study_of(tmp_path / "lamps.db").close()
    return tmp_path / "lamps.db"


def clocks(path) -> list[int]:
    with contextlib.closing(sqlite3.connect(path)) as raw:
        return [clock for (clock,) in raw.execute("SELECT clock FROM event WHERE volunteer = 'anna' ORDER BY clock")]


def test_two_windows_of_one_volunteer_see_each_other(path):
    with study.open_study(path) as left, study.open_study(path) as right:
        first = study.record_vote(left, FOOT, "anna", "correct")
        asked = {one.item_id for one in study.open_items(right, "anna")}
        assert asked == {STEM, SHADE}
        second = study.record_vote(right, FOOT, "anna", "wrong")  # its screen had asked before
        assert second.supersedes == first.uuid
        assert study.answers(left, "anna") == {FOOT: "wrong"}
        assert study.undo_vote(left, "anna") == FOOT
        assert study.answers(right, "anna") == {FOOT: "correct"}
        assert study.undo_vote(right, "anna") == FOOT
        assert study.undo_vote(left, "anna") is None
    assert clocks(path) == [1, 2, 3, 4]


def test_two_windows_at_once_number_events_one_by_one(path):
    def vote_often(answer):
        with study.open_study(path, backup=False) as handle:
            for _ in range(25):
                study.record_vote(handle, FOOT, "anna", answer)

    both = [threading.Thread(target=vote_often, args=(answer,)) for answer in ("correct", "wrong")]
    for one in both:
        one.start()
    for one in both:
        one.join()
    assert clocks(path) == list(range(1, 51))
    with study.open_study(path) as handle:
        assert len(study.current_votes(handle)) == 1
        assert study.majority(handle)[FOOT].verdict in ("correct", "wrong")


def test_an_item_that_others_settled_is_asked_no_more(tmp_path):
    """Of two windows with the same list, the second must not spend a vote on what the first has settled."""
    with study_of(tmp_path / "a.db") as handle:
        with handle.writing() as connection:
            connection.exec_driver_sql("UPDATE study SET votes = 2")
        mine = {one.item_id: one for one in study.open_items(handle, "carl")}
        assert set(mine) == {FOOT, STEM, SHADE}
        for code in ("anna", "bert"):
            study.record_vote(handle, FOOT, code, "correct")
        study.record_vote(handle, STEM, "anna", "correct")
        assert [study.still_open(handle, "carl", mine[item]) for item in (FOOT, STEM, SHADE)] == [False, True, True]
        assert not study.still_open(handle, "anna", mine[STEM])
        assert {one.item_id for one in study.open_items(handle, "carl")} == {STEM, SHADE}
        study.record_vote(handle, STEM, "carl", "wrong")
        ahead = [mine[FOOT], mine[STEM], mine[SHADE]]
        assert asking.needless_in_front(handle, "carl", ahead) == ((mine[STEM],), (mine[FOOT],))
        assert asking.needless_in_front(handle, "carl", ahead[::-1]) == ((), ())


def test_a_clock_set_back_does_not_change_what_counts(path, monkeypatch):
    with study.open_study(path) as handle:
        for day, answer in ((20, "correct"), (3, "wrong"), (11, "unsure")):
            monkeypatch.setattr(voting, "now", lambda day=day: f"2026-05-{day:02}T10:00:00.000000+00:00")
            study.record_vote(handle, FOOT, "anna", answer)
        assert study.answers(handle, "anna") == {FOOT: "unsure"}
        assert [vote.created_at[8:10] for vote in study.current_votes(handle)] == ["11"]
        study.undo_vote(handle, "anna")
        assert study.answers(handle, "anna") == {FOOT: "wrong"}
        monkeypatch.setattr(voting, "now", lambda: "1970-01-01T00:00:00.000000+00:00")
        study.undo_vote(handle, "anna")
        study.record_vote(handle, STEM, "anna", "correct")
        assert study.answers(handle, "anna") == {FOOT: "correct", STEM: "correct"}
        assert [vote.item_id for vote in study.current_votes(handle)] == [FOOT, STEM]
    assert clocks(path) == [1, 2, 3, 4, 5, 6]


def test_copies_go_on_when_the_clock_was_set_back(path, monkeypatch):
    """The newest copy stays the newest, and the oldest goes first."""
    folder = path.with_name("backups")
    folder.mkdir()
    ahead = time.time() + 90 * 86400
    for month in range(1, backup.KEPT + 1):
        copy = folder / f"lamps.db.2099{month:02}01T000000.000000"
        copy.write_bytes(path.read_bytes())
        os.utime(copy, (ahead, ahead))
    made = []
    monkeypatch.setattr(backup, "EVERY_SECONDS", 0.0)
    for answer in ("correct", "wrong"):
        with study.open_study(path) as handle:
            study.record_vote(handle, FOOT, "anna", answer)
        made.append(backup.backups(path)[-1].name)
    assert made[0] < made[1]
    assert made[0].startswith("lamps.db.20990501T000000.000002")  # after the copy of opening that of the vote
    with contextlib.closing(sqlite3.connect(folder / made[1])) as raw:
        assert raw.execute("SELECT answer FROM event").fetchall() == [("correct",), ("wrong",)]
    assert len(backup.backups(path)) == backup.KEPT
    assert not (folder / "lamps.db.20990101T000000.000000").exists()
