"""Exports: every vote with its state, the same rows in each format, and a dictionary that tells of every column."""

import csv
import io

from judging_world import LAMP, ONE_TO_ONE, VASE, identity, study_of

from annotation import study
from annotation.exporting import votes_csv
from annotation.exporttables import names

FOOT, STEM, SHADE = (identity(LAMP, one, VASE, other) for one, other in ONE_TO_ONE)


def test_votes_are_exported_with_their_state(tmp_path):
    with study_of(tmp_path / "a.db") as handle:
        study.record_vote(handle, FOOT, "anna", "wrong", comment='=HYPERLINK("x")')
        study.record_vote(handle, FOOT, "anna", "correct", comment="-1", active_ms=700)
        study.record_vote(handle, STEM, "anna", "unsure", comment='+cmd, "quoted"\nand broken')
        study.undo_vote(handle, "anna")
        study.record_vote(handle, SHADE, "-bert", "wrong", comment="@x")
        text = votes_csv(handle)
    rows = list(csv.DictReader(io.StringIO(text)))
    assert tuple(rows[0]) == names("votes")
    assert [(r["volunteer"], r["answer"], r["state"]) for r in rows] == [
        ("'-bert", "wrong", "current"), ("anna", "wrong", "replaced"), ("anna", "correct", "current"),
        ("anna", "unsure", "retracted"),
    ]  # fmt: skip
    assert [r["comment"] for r in rows] == ["'@x", '\'=HYPERLINK("x")', "-1", '\'+cmd, "quoted"\nand broken']
    assert [r["active_ms"] for r in rows] == ["", "", "700", ""]
    assert rows[1]["item"] == FOOT
    assert "lamp.off" in rows[1]["payload"]
