"""Re-runs keep votes: new matches are listed as unjudged, asked in the same study or in one that is merged back."""

import pytest
from design_world import known, run_of, runs_of
from sqlalchemy import select

from annotation import study
from annotation.design.designing import Design, create_design, judged_counts
from annotation.design.topup import name_gold, name_practice, top_up, top_up_study
from annotation.exchange.forgetting import forget
from annotation.exchange.merging import merge_handles
from annotation.storage import schema
from annotation.study import add_run
from annotation.voting.answering import open_items
from engine.errors import BadInput, BadParameter

DESIGN = Design(name="Lamps", gold=0, practice=0, overlap=0.5)
NEW = run_of("lamps", "a", ["a-4", "a-5", "a-6", "a-7"], "thesis")


def asked(handle):
    with handle.reading() as connection:
        return {row.item_id: row for row in connection.execute(select(schema.asked))}


@pytest.fixture
def handle(place):
    """Six matches, two of them judged, and a new method that proposes two of the six and two more."""
    with create_design(place, runs_of({"a": 6}), DESIGN) as made:
        for item in ("a-0", "a-5"):
            for code in ("anna", "bert"):
                study.record_vote(made, item, code, "correct")
        add_run(made, NEW)
        yield made


def test_votes_stay_and_new_matches_are_unjudged_until_they_are_asked(handle):
    counts = {count.method: (count.matches, count.asked, count.judged) for count in judged_counts(handle)}
    assert counts == {"learned": (6, 6, 2), "thesis": (4, 2, 1)}
    before = study.current_votes(handle)
    assert top_up(handle) == 2
    assert set(asked(handle)) == {f"a-{n}" for n in range(8)}
    assert study.current_votes(handle) == before
    assert {"a-6", "a-7"} <= {one.item_id for one in open_items(handle, "anna")}
    assert sum(row.overlapped for item, row in asked(handle).items() if item in ("a-6", "a-7")) == 1
    assert top_up(handle) == 0


def test_a_top_up_study_holds_what_has_no_vote_and_goes_back(handle, tmp_path):
    made, left = top_up_study(handle, tmp_path / "more.db")
    with made:
        assert left == 6
        assert {item.id for item in study.items(made, "carl")} == {f"a-{n}" for n in (1, 2, 3, 4, 6, 7)}
        about, parent = study.about(made), study.about(handle)
        assert about.settings["tops_up"] == parent.id
        assert (about.votes, about.question, about.seed) == (parent.votes, parent.question, parent.seed)
        study.record_vote(made, "a-6", "carl", "wrong")
        before = study.current_votes(handle)
        assert set(asked(handle)) == {f"a-{n}" for n in range(6)}  # the first study is as it was
        for _ in range(2):
            merge_handles(made, handle)
    assert {vote.uuid for vote in before} < {vote.uuid for vote in study.current_votes(handle)}
    assert study.majority(handle)["a-6"].verdict == "wrong"
    assert {count.method: count.asked for count in judged_counts(handle)} == {"learned": 6, "thesis": 4}
    assert {row.probability for row in asked(handle).values()} == {1.0}


def test_practice_goes_with_a_top_up_and_judged_gold_does_not(handle, tmp_path):
    name_gold(handle, known(["a-0", "a-1"]))
    name_practice(handle, known(["a-2"]))
    made, left = top_up_study(handle, tmp_path / "more.db", name="Rest")
    with made:
        assert study.about(made).name == "Rest"
        found = {item: row.role for item, row in asked(made).items()}
        assert found == {"a-1": "gold", "a-2": "practice"} | dict.fromkeys(("a-3", "a-4", "a-6", "a-7"), "judged")
        assert left == 5
        assert study.practice(made) == {"a-2": ("correct", "because of a-2")}


def test_nothing_left_is_a_sentence(place, tmp_path):
    with create_design(place, runs_of({"a": 1}), DESIGN) as handle:
        study.record_vote(handle, "a-0", "anna", "correct")
        with pytest.raises(BadParameter, match="nothing left for a top-up"):
            top_up_study(handle, tmp_path / "more.db")
    assert not (tmp_path / "more.db").exists()


def test_a_sample_is_told_how_many_more_and_has_one_probability(place):
    with create_design(place, runs_of({"a": 40, "b": 10}), DESIGN.changed(most=10)) as handle:
        with pytest.raises(BadParameter, match="asks a sample of 10 matches; say how many more"):
            top_up(handle)
        with pytest.raises(BadParameter, match="0 for all"):
            top_up(handle, most=-1)
        assert {row.probability for row in asked(handle).values()} == {0.2}
        assert top_up(handle, most=15) == 15
        of = [(row.stratum, row.probability) for row in asked(handle).values()]
        for stratum, size in (("lamps/", 50),):
            assert sum(1 / chance for name, chance in of if name.startswith(stratum)) == pytest.approx(size)
        assert len(set(of)) == 2
        assert top_up(handle, most=0) == 25
        assert {row.probability for row in asked(handle).values()} == {1.0}


def test_a_study_that_asks_everything_goes_on_asking_everything(place, tmp_path):
    with study.create_study(place, name="All") as handle:
        for run in runs_of({"a": 3}):
            add_run(handle, run)
        assert top_up(handle) == 0
        study.record_vote(handle, "a-0", "anna", "correct")
        made, left = top_up_study(handle, tmp_path / "more.db")
        with made:
            assert left == 2
            assert asked(made) == {}
            assert {one.item_id for one in open_items(made, "anna")} == {"a-1", "a-2"}
        assert name_gold(handle, known(["a-1"])) == 1
        assert {item: row.role for item, row in asked(handle).items()} == {"a-0": "judged", "a-1": "gold", "a-2": "judged"}
        assert name_gold(handle, known(["a-1", "elsewhere"])) == 0


def test_no_more_gold_is_named_than_wanted(handle):
    assert name_gold(handle, known([f"a-{n}" for n in range(8)]), 3) == 3
    assert sum(row.role == "gold" for row in asked(handle).values()) == 3


@pytest.mark.parametrize("design", [3, None, [], {"most": "many", "overlap": "all"}, {"most": -4, "overlap": 7}])
def test_a_damaged_design_is_told(place, design):
    with study.create_study(place, name="Odd", votes=3, settings={"design": design}) as handle:
        add_run(handle, runs_of({"a": 3})[0])
        assert name_gold(handle, known(["a-0"])) == 1
        add_run(handle, NEW)
        with pytest.raises(BadInput, match="settings of Odd are damaged"):
            top_up(handle, most=0)
        assert len(asked(handle)) == 3


def test_a_top_up_of_a_top_up_goes_into_both(handle, tmp_path):
    middle, _ = top_up_study(handle, tmp_path / "middle.db")
    with middle:
        last, left = top_up_study(middle, tmp_path / "last.db")
        with last:
            assert left == 6
            study.record_vote(last, "a-6", "carl", "wrong")
            for target in (handle, middle, handle):
                merge_handles(last, target)
                assert study.answers(target, "carl") == {"a-6": "wrong"}
        merge_handles(middle, handle)
        with pytest.raises(BadInput, match="another study"):
            merge_handles(handle, last)
    assert {row.probability for row in asked(handle).values()} == {1.0}


def test_who_is_deleted_in_a_top_up_of_a_top_up_is_deleted_where_it_goes(handle, tmp_path):
    middle, _ = top_up_study(handle, tmp_path / "middle.db")
    with middle:
        last, _ = top_up_study(middle, tmp_path / "last.db")
        with last:
            for target in (middle, last):
                study.record_vote(target, "a-6", "anna-quill", "wrong")
            study.record_vote(handle, "a-1", "anna-quill", "wrong")
            gone = forget(last, "anna-quill")
            merge_handles(last, middle)
        assert {one.code for one in study.volunteers(middle)} == {gone.pseudonym}
        merge_handles(middle, handle)
    assert "anna-quill" not in {one.code for one in study.volunteers(handle)}
    assert set(study.answers(handle, gone.pseudonym)) == {"a-1", "a-6"}
