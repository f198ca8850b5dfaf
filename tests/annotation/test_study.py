"""Studies, items and votes: what is asked, what is kept, what an undo gives back."""

import sqlite3
from datetime import datetime

import pytest
from judging_world import CANDLE, LAMP, ONE_TO_ONE, VASE, identity, result, study_of

from annotation import study
from annotation.study import Majority
from annotation.voting import answering as voting
from engine.errors import BadInput, BadParameter

FOOT, STEM, SHADE = (identity(LAMP, one, VASE, other) for one, other in ONE_TO_ONE)


@pytest.fixture
def handle(place):
    with study_of(place) as opened:
        yield opened


@pytest.fixture
def on_file(tmp_path):
    with study_of(tmp_path / "lamps.db") as opened:
        yield opened


def reversed_result():
    return result(*((b, a) for a, b in ONE_TO_ONE), source=VASE, target=LAMP, preset="thesis-rigid")


def test_a_study_remembers_what_it_was_made_with(place):
    with study.create_study(place, name=" Vases ", question="Same part?", seed="7") as made:
        first = study.about(made)
    with study.open_study(place) as opened:
        assert study.about(opened) == first
    assert (first.name, first.question, first.seed, dict(first.settings)) == ("Vases", "Same part?", "7", {})


def test_an_item_can_be_shown_again(handle):
    shown = {item.id: item for item in study.items(handle, "anna")}
    assert set(shown) == {FOOT, STEM, SHADE}
    assert study.item(handle, SHADE) == shown[SHADE]
    with pytest.raises(BadInput, match="no item x"):
        study.item(handle, "x")
    assert shown[SHADE].payload == {
        "source": {"file": "lamp.off", "sha256": "a" * 64, "segments": ["shade"]},
        "target": {"file": "vase.off", "sha256": "b" * 64, "segments": [9]},
    }


def test_one_match_is_one_item_whoever_found_it_from_whichever_side(handle):
    before = study.items(handle, "anna")
    study.record_vote(handle, FOOT, "anna", "correct")
    study.add_result(handle, reversed_result())
    assert study.items(handle, "anna") == before
    assert study.majority(handle)[FOOT] == Majority(1, 0, 0, "correct")


def test_sides_are_the_same_when_first_found_from_the_other_side(tmp_path):
    with study_of(tmp_path / "1.db") as one, study_of(tmp_path / "2.db", reversed_result()) as other:
        assert study.items(one, "anna") == study.items(other, "anna")


def test_adding_a_result_again_adds_nothing(handle):
    first = study.add_result(handle, result(*ONE_TO_ONE))
    assert study.add_result(handle, result(*ONE_TO_ONE, seconds=9.0)) == first
    assert study.add_result(handle, result(*ONE_TO_ONE), set_name="other") != first
    with handle.reading() as connection:
        assert connection.exec_driver_sql("SELECT count(*) FROM run").scalar() == 2
        assert connection.exec_driver_sql("SELECT count(*) FROM run_match").scalar() == 6


def test_a_shape_against_itself_asks_each_match_once(tmp_path):
    both = result(((0,), (1,)), ((1,), (0,)), source=CANDLE, target=CANDLE)
    with study_of(tmp_path / "self.db", both) as handle:
        assert len(study.items(handle, "anna")) == 1


def test_votes_survive_a_run_with_other_parameters(handle):
    study.record_vote(handle, FOOT, "anna", "correct")
    study.add_result(handle, result(((0,), (0,)), ((1, 2), (1, 2)), K=3))
    assert len(study.items(handle, "anna")) == 4
    assert study.answers(handle, "anna") == {FOOT: "correct"}


def test_items_without_a_run_can_be_judged(handle):
    join = study.Item("join-1", "puzzle", {"image": "a.png", "pieces": [3, 4]})
    assert study.add_items(handle, [join]) == 1
    assert study.add_items(handle, [join]) == 0
    study.record_vote(handle, "join-1", "anna", "wrong")
    assert study.majority(handle)["join-1"].verdict == "wrong"
    assert join in study.items(handle, "anna")
    with pytest.raises(BadInput, match="kind 'song'"):
        study.add_items(handle, [study.Item("x", "song", {})])


def test_a_vote_is_there_for_another_reader_at_once(handle, place):
    vote = study.record_vote(
        handle, FOOT, "anna", "unsure", comment="dark", shown_ms=900, active_ms=800, presentation={"left": "target"}
    )
    with study.open_study(place) as other:
        assert study.current_votes(other) == (vote,)
    assert (vote.answer, vote.comment, vote.shown_ms, vote.active_ms, vote.clock) == ("unsure", "dark", 900, 800, 1)
    assert vote.presentation == {"left": "target"}
    assert datetime.fromisoformat(vote.created_at).utcoffset().total_seconds() == 0


def test_many_votes_at_once_are_as_so_many_one_by_one(handle):
    study.record_vote(handle, FOOT, "truth", "wrong")
    made = study.record_votes(handle, "truth", {FOOT: "correct", STEM: "wrong"})
    assert study.current_votes(handle) == made
    assert [vote.clock for vote in made] == [2, 3]
    assert study.undo_vote(handle, "truth") == STEM
    assert study.undo_vote(handle, "truth") == FOOT
    assert study.answers(handle, "truth") == {FOOT: "wrong"}


def test_of_many_votes_all_are_kept_or_none(handle):
    with pytest.raises(BadInput, match="no item x"):
        study.record_votes(handle, "truth", {FOOT: "correct", "x": "wrong"})
    with pytest.raises(BadParameter, match="'yes' is no answer"):
        study.record_votes(handle, "truth", {FOOT: "correct", STEM: "yes"})
    assert study.current_votes(handle) == ()
    assert study.volunteers(handle) == ()


def test_a_screen_left_open_for_months_takes_the_vote(handle):
    assert study.record_vote(handle, FOOT, "anna", "wrong", shown_ms=10**10).shown_ms == 10**10


def test_a_second_answer_replaces_the_first_and_keeps_it(handle):
    first = study.record_vote(handle, FOOT, "anna", "wrong")
    second = study.record_vote(handle, FOOT, "anna", "correct")
    assert second.supersedes == first.uuid
    assert study.current_votes(handle) == (second,)
    with handle.reading() as connection:
        assert connection.exec_driver_sql("SELECT count(*) FROM event").scalar() == 2


def test_undo_goes_back_step_by_step_to_the_very_beginning(handle):
    study.record_vote(handle, FOOT, "anna", "wrong")
    study.record_vote(handle, STEM, "anna", "correct")
    study.record_vote(handle, FOOT, "anna", "correct")
    study.record_vote(handle, STEM, "bert", "wrong")
    seen = []
    while (item := study.undo_vote(handle, "anna")) is not None:
        seen.append((item, study.answers(handle, "anna")))
    assert seen == [(FOOT, {FOOT: "wrong", STEM: "correct"}), (STEM, {FOOT: "wrong"}), (FOOT, {})]
    assert study.answers(handle, "bert") == {STEM: "wrong"}
    study.record_vote(handle, FOOT, "anna", "unsure")
    assert study.answers(handle, "anna") == {FOOT: "unsure"}


def test_a_clock_set_back_loses_nothing(handle, monkeypatch):
    times = iter(f"20{year}-01-01T00:00:00.000000+00:00" for year in range(30, 10, -1))
    monkeypatch.setattr(voting, "now", lambda: next(times))
    for answer in ("wrong", "unsure", "correct"):
        study.record_vote(handle, FOOT, "anna", answer)
    assert study.answers(handle, "anna") == {FOOT: "correct"}
    study.undo_vote(handle, "anna")
    assert study.answers(handle, "anna") == {FOOT: "unsure"}


def test_a_tie_stays_a_tie(handle):
    study.record_vote(handle, FOOT, "anna", "correct")
    study.record_vote(handle, FOOT, "bert", "wrong")
    study.record_vote(handle, FOOT, "carl", "unsure")
    study.record_vote(handle, STEM, "carl", "unsure")
    found = study.majority(handle)
    assert found == {
        FOOT: Majority(1, 1, 1, "tie"), STEM: Majority(0, 0, 1, "unjudged"), SHADE: Majority(0, 0, 0, "unjudged"),
    }  # fmt: skip


def test_a_second_round_does_not_touch_the_first(handle):
    study.record_vote(handle, FOOT, "anna", "correct")
    study.record_vote(handle, FOOT, "anna", "wrong", round=2)
    assert study.answers(handle, "anna") == {FOOT: "correct"}
    assert study.majority(handle, round=2)[FOOT].verdict == "wrong"


def test_next_item_walks_through_the_volunteers_own_order(handle):
    order = [item.id for item in study.items(handle, "anna")]
    walked = []
    while (item := study.next_item(handle, "anna")) is not None:
        walked.append(item.id)
        study.record_vote(handle, item.id, "anna", "correct")
    assert walked == order == list(study.ordered_ids(handle, "anna"))


def test_a_skipped_item_comes_back_at_the_end(handle):
    first, second, third = (item.id for item in study.items(handle, "anna"))
    assert study.next_item(handle, "anna", skipped={first}).id == second
    for item in (second, third):
        study.record_vote(handle, item, "anna", "wrong")
    assert study.next_item(handle, "anna", skipped={first}).id == first


def test_orders_and_sides_are_reproducible_and_differ_between_volunteers(tmp_path):
    many = [study.Item(f"{n}", "puzzle", {}) for n in range(40)]
    orders, sides = [], []
    for name in ("one.db", "two.db"):
        with study.create_study(tmp_path / name, name=name, seed="same") as handle:
            study.add_items(handle, many if name == "one.db" else reversed(many))
            for code in ("anna", "bert"):
                orders.append([item.id for item in study.items(handle, code)])
                voter = study.volunteer(handle, code)
                sides.append([study.sides_swapped(voter, item.id) for item in many])
    assert orders[:2] == orders[2:]
    assert sides[:2] == sides[2:]
    assert orders[0] != orders[1]
    assert sides[0] != sides[1]
    assert 5 < sum(sides[0]) < 35


def test_progress_counts_and_guesses_the_rest(handle):
    assert study.progress(handle, "anna") == (0, 3, None)
    study.record_vote(handle, FOOT, "anna", "correct", active_ms=4000)
    study.record_vote(handle, STEM, "anna", "correct", shown_ms=3_600_000)
    assert study.progress(handle, "anna") == (2, 3, 32.0)
    assert voting.seconds_each([500] * 5 + [2000] * 20) == 2.0


def test_who_votes_and_what_is_asked_is_blind(handle):
    study.record_vote(handle, FOOT, "bert", "wrong", comment="never")
    shown = repr((study.items(handle, "anna"), study.next_item(handle, "anna"), study.progress(handle, "anna")))
    for secret in ("top-down", "score", "votes", "bert", "wrong", "never"):
        assert secret not in shown


@pytest.mark.parametrize("code", ["", " ", "a b", "x" * 41, "a;b", "a/b"])
def test_bad_codes_are_refused(handle, code):
    with pytest.raises(BadParameter, match="volunteer code"):
        study.volunteer(handle, code)
    with pytest.raises(BadParameter, match="volunteer code"):
        study.record_vote(handle, FOOT, code, "correct")


def test_good_codes_are_taken(handle):
    for code in ("A-1_b", "Jürgen", "x" * 40, "7"):
        assert study.volunteer(handle, code) == study.volunteer(handle, f" {code} ")
    assert len(study.volunteers(handle)) == 4


def test_unknown_answers_and_items_are_refused_and_leave_nothing(handle, tmp_path):
    with pytest.raises(BadParameter, match="'yes' is no answer"):
        study.record_vote(handle, FOOT, "anna", "yes")
    with pytest.raises(BadInput, match="no item nowhere"):
        study.record_vote(handle, "nowhere", "anna", "correct")
    assert study.volunteers(handle) == ()
    with pytest.raises(BadParameter, match="name"):
        study.create_study(tmp_path / "b.db", name=" ")


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE event SET answer = 'wrong'",
        "DELETE FROM event",
        "REPLACE INTO event SELECT uuid, kind, item_id, volunteer, round, 'wrong', comment, supersedes, clock,"
        " shown_ms, active_ms, presentation, app_version, created_at FROM event",
    ],
)
def test_the_log_of_votes_cannot_be_changed(on_file, statement):
    """Not even by another program, which sets none of Concord's switches."""
    study.record_vote(on_file, FOOT, "anna", "correct")
    other = sqlite3.connect(on_file.path)
    with pytest.raises(sqlite3.IntegrityError, match="only ever added"):
        other.execute(statement)
    other.close()
    assert study.answers(on_file, "anna") == {FOOT: "correct"}


@pytest.mark.parametrize(
    "values",
    [
        "'u', 'vote', '{item}', 'anna', 1, 'perhaps', '', NULL, 1",
        "'u', 'vote', '{item}', 'anna', 1, NULL, '', NULL, 1",
        "'u', 'retraction', '{item}', 'anna', 1, NULL, '', NULL, 1",
        "'u', 'vote', '{item}', 'anna', 'one', 'wrong', '', NULL, 1",
        "'u', 'vote', 'nowhere', 'anna', 1, 'wrong', '', NULL, 1",
    ],
)
def test_the_tables_refuse_nonsense(on_file, values):
    study.volunteer(on_file, "anna")
    other = sqlite3.connect(on_file.path)
    other.execute("PRAGMA foreign_keys=ON")
    with pytest.raises(sqlite3.IntegrityError):
        other.execute(
            "INSERT INTO event (uuid, kind, item_id, volunteer, round, answer, comment, supersedes, clock,"
            f" presentation, app_version, created_at) VALUES ({values.format(item=FOOT)}, '{{}}', '', '')"
        )
    other.close()
