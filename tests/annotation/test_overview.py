"""The researcher's overview, counted by hand."""

import csv
import io

import pytest
from judging_world import CANDLE, ONE_TO_ONE, result, study_of
from sqlalchemy import insert

from annotation import study
from annotation.exchange.csvtext import csv_text
from annotation.findings.overview import overview
from annotation.findings.overview_tables import VALUES_HEAD, overview_table, overview_values
from annotation.storage import schema

WIDE = [tuple(k for k in range(3) if bits >> k & 1) for bits in range(1, 7)]


@pytest.fixture
def handle(place):
    with study_of(place, result(*zip(WIDE, WIDE, strict=True), target=CANDLE), result(*ONE_TO_ONE)) as opened:
        yield opened


def ids(handle):
    """All matches, in an order of their own."""
    return sorted(item.id for item in study.items(handle, "reader"))


def row_of(handle, code):
    return next(row for row in overview(handle) if row.code == code)


def test_who_did_how_much_how_fast(handle):
    """Nine matches: anna votes on five, one changed, one taken back; pauses are cut at 60 s."""
    items = ids(handle)
    assert len(items) == 9
    for item, (answer, ms, comment) in zip(items, [("correct", 2000, "odd"), ("wrong", 4000, ""), ("unsure", 900_000, "hm"),
                                                   ("correct", 6000, ""), ("wrong", 1000, "")], strict=False):  # fmt: skip
        study.record_vote(handle, item, "anna", answer, shown_ms=ms, comment=comment)
    study.undo_vote(handle, "anna")
    study.record_vote(handle, items[0], "anna", "wrong", shown_ms=99_000, active_ms=3000)
    row = row_of(handle, "anna")
    assert (row.judged, row.open, row.comments) == (4, 5, 1)
    assert row.unsure == pytest.approx(1 / 4)
    assert row.seconds == pytest.approx((4 + 6) / 2)
    assert row.first <= row.last
    assert row.agreement is None
    assert row.flags == ()


def test_practice_is_no_work_and_gold_is_told_apart(handle):
    items = ids(handle)
    roles = dict(zip(items, ["gold", "gold", "gold", "gold", "practice"], strict=False))
    with handle.writing() as connection:
        for item in items:
            role = roles.get(item, "judged")
            answer = None if role == "judged" else "correct"
            values = {"item_id": item, "role": role, "answer": answer, "reason": "", "stratum": "", "overlapped": 0, "added_at": ""}
            connection.execute(insert(schema.asked).values(values))
    for item, answer in zip(items, ["wrong", "wrong", "correct", "unsure"], strict=False):
        study.record_vote(handle, item, "anna", answer)
    study.record_vote(handle, items[4], "anna", "wrong", round=0)
    row = row_of(handle, "anna")
    assert (row.judged, row.open, row.gold_right, row.gold_wrong) == (4, 4, 1, 2)
    assert row.flags == ("fails gold items: 2 of 4 wrong",)
    assert len(study.current_votes(handle, volunteer="anna")) == 4


def test_haste_and_one_answer_for_all_are_told(tmp_path):
    matches = [(one, other) for one in WIDE for other in WIDE][:12]
    with study_of(tmp_path / "a.db", result(*matches)) as handle:
        for k, item in enumerate(ids(handle)):
            study.record_vote(handle, item, "slow", "correct" if k % 3 else "wrong", shown_ms=8000)
            study.record_vote(handle, item, "even", "correct" if k % 3 else "wrong", shown_ms=9000)
            study.record_vote(handle, item, "fast", "correct", shown_ms=1000)
        assert row_of(handle, "slow").flags == row_of(handle, "even").flags == ()
        assert row_of(handle, "fast").flags == (
            "much faster than others: 1.0 s a vote beside 8.5 s", "always the same answer: correct, 12 times")  # fmt: skip
        assert row_of(handle, "fast").agreement == pytest.approx(8 / 12)
        assert row_of(handle, "slow").agreement == pytest.approx(1.0)
        table = overview_table(overview(handle))
    assert [row[0] for row in table.rows] == ["even", "fast !", "reader", "slow"]
    assert "fast always the same answer" in table.remark
    assert "no vote is ever left out" in table.remark


def test_somebody_without_votes_is_there(handle):
    study.volunteer(handle, "zoe")
    row = row_of(handle, "zoe")
    assert (row.judged, row.open, row.seconds, row.first, row.unsure) == (0, 9, None, "", None)
    assert dict(zip(VALUES_HEAD, overview_values(row), strict=True))["flags"] == ""
    assert overview_table([row]).rows[0][5:8] == ("–", "–", "–")
    assert "Nobody" in overview_table([]).remark


def test_the_values_make_a_csv(handle):
    study.volunteer(handle, "zoe")
    (row,) = csv.DictReader(io.StringIO(csv_text(VALUES_HEAD, map(overview_values, overview(handle)))))
    assert (row["volunteer"], row["open"], row["median_seconds"]) == ("zoe", "9", "")
