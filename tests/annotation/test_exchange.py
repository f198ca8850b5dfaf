"""Merging is a union: in any order, any number of times, nothing lost; CSV that a spreadsheet can open."""

import itertools
import shutil
import sqlite3
import tempfile
from contextlib import closing
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from judging_world import LAMP, ONE_TO_ONE, VASE, forged, identity, result, study_of

from annotation import study
from annotation.exchange.merging import Merged, merge
from engine.errors import BadInput

FOOT, STEM, SHADE = (identity(LAMP, one, VASE, other) for one, other in ONE_TO_ONE)
ITEMS = (FOOT, STEM, SHADE)

Step = tuple[str, int, str]
STEPS = st.lists(st.tuples(st.sampled_from(["anna", "bert"]), st.integers(0, 3), st.sampled_from(study.ANSWERS)))


def content(path: Path) -> dict[str, list]:
    """Every row of every table and of the view that counts, in a fixed order."""
    tables = ("study", "item", "run", "run_match", "volunteer", "event", "current_vote")
    with closing(sqlite3.connect(path)) as raw:
        return {table: sorted(raw.execute(f"SELECT * FROM {table}").fetchall(), key=repr) for table in tables}


def copies(folder: Path, count: int) -> list[Path]:
    """One study, handed out to several people."""
    study_of(folder / "0.db").close()
    return [folder / "0.db", *(Path(shutil.copy(folder / "0.db", folder / f"{n}.db")) for n in range(1, count))]


def lived(path: Path, steps: list[Step]) -> None:
    """Vote and undo; item 3 stands for an undo, and sometimes a result is added."""
    with study.open_study(path, backup=False) as handle:
        for code, number, answer in steps:
            if number == 3:
                study.undo_vote(handle, code)
            else:
                study.record_vote(handle, ITEMS[number], code, answer)
        if len(steps) % 2:
            study.add_result(handle, result(((0,), (0,)), ((0, 1), (0, 1)), seconds=len(steps)))


@settings(max_examples=4, deadline=None)
@given(st.lists(STEPS, min_size=3, max_size=3))
def test_any_histories_merged_in_any_order_are_the_same_study(histories):
    with tempfile.TemporaryDirectory() as folder:
        files = copies(Path(folder), 3)
        for path, steps in zip(files, histories, strict=True):
            lived(path, steps)
        merged = []
        for number, order in enumerate(itertools.permutations(files)):
            into = Path(shutil.copy(order[0], Path(folder) / f"merged-{number}.db"))
            for path in order[1:]:
                merge(into, path)
            merged.append(content(into))
            assert merge(into, order[0]) == merge(into, order[1]) == Merged(0, 0, 0, 0)
            assert content(into) == merged[-1]
        assert all(other == merged[0] for other in merged)
        events = [set(content(path)["event"]) for path in files]
        assert set(merged[0]["event"]) == set.union(*events)


def test_two_volunteers_return_their_files(tmp_path):
    one, other = copies(tmp_path, 2)
    lived(one, [("anna", 0, "correct"), ("anna", 1, "wrong")])
    lived(other, [("bert", 0, "wrong"), ("bert", 2, "correct"), ("bert", 3, "")])
    assert merge(one, other) == Merged(items=1, runs=1, volunteers=1, events=3)
    with study.open_study(one, backup=False) as handle:
        assert study.answers(handle, "anna") == {FOOT: "correct", STEM: "wrong"}
        assert study.answers(handle, "bert") == {FOOT: "wrong"}
        assert study.majority(handle)[FOOT].verdict == "tie"


def test_the_file_taken_from_is_not_changed(tmp_path):
    one, other = copies(tmp_path, 2)
    lived(other, [("bert", 0, "wrong")])
    before = other.read_bytes()
    merge(one, other)
    assert other.read_bytes() == before


def test_merging_works_while_a_window_holds_both_open(tmp_path):
    one, other = copies(tmp_path, 2)
    with study.open_study(one) as window, study.open_study(other) as second:
        study.record_vote(window, FOOT, "anna", "correct")
        study.record_vote(second, FOOT, "bert", "correct")
        merge(one, other)
        study.record_vote(window, STEM, "anna", "wrong")
        assert study.majority(window)[FOOT].correct == 2


def test_another_study_is_refused_unless_meant(tmp_path):
    study_of(tmp_path / "a.db").close()
    with study_of(tmp_path / "b.db") as handle:
        study.record_vote(handle, FOOT, "bert", "wrong")
    with pytest.raises(BadInput, match="belongs to another study"):
        merge(tmp_path / "a.db", tmp_path / "b.db")
    assert merge(tmp_path / "a.db", tmp_path / "b.db", other_study=True).events == 1


def test_a_forged_history_is_refused_whole(tmp_path):
    one, other = copies(tmp_path, 2)
    lived(one, [("anna", 0, "correct")])
    shutil.copy(one, other)
    lived(other, [("bert", 0, "correct")])
    forged(other, "UPDATE event SET answer = 'wrong' WHERE volunteer = 'anna'")
    before = content(one)
    with pytest.raises(BadInput, match="tampered"):
        merge(one, other)
    assert content(one) == before
