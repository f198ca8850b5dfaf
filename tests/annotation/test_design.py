"""Making studies under a design: what is asked of whom, whole or not at all, and how many matches are judged."""

from collections import Counter

import pytest
from design_world import known, run_of, runs_of
from sqlalchemy import select

from annotation import study
from annotation.design.designing import Design, create_design, draw_design, judged_counts
from annotation.records import Item, Proposal, Run
from annotation.results.proposals import run_id
from annotation.storage import schema
from engine.errors import BadInput, BadParameter, Cancelled
from engine.parameters import declared

RUNS = runs_of({"a": 60, "b": 30, "c": 10})
ITEMS = sorted({p.item.id for run in RUNS for p in run.proposals})


def roles(plan):
    return Counter(row.role for row in plan.asked)


def test_every_value_has_a_range_and_a_sentence():
    for info in declared(Design):
        assert info.doc.endswith(".")
        assert info.kind in ("switch", "text") or info.low is not None
    with pytest.raises(BadParameter, match="'votes' cannot be 100: it takes a whole number from 0 to 99"):
        Design().changed(votes=100)
    with pytest.raises(BadParameter, match="'question' cannot be 3: it takes a text"):
        Design().changed(question=3)


def test_every_distinct_match_is_asked_once_whoever_proposed_it():
    other = run_of("lamps", "a", [f"a-{n}" for n in range(50, 70)], "thesis")
    plan = draw_design([*RUNS, other, RUNS[0]], Design())
    assert sorted(row.item_id for row in plan.asked) == sorted({*ITEMS, *(f"a-{n}" for n in range(60, 70))})
    assert {row.probability for row in plan.asked} == {1.0}
    assert len({row.stratum for row in plan.asked}) == 3


def test_gold_practice_and_overlapped_are_drawn_by_the_seed():
    plan = draw_design(RUNS, Design(), gold=known(ITEMS))
    assert roles(plan) == {"judged": 85, "gold": 10, "practice": 5}
    assert sum(row.overlapped for row in plan.asked) == 17  # a fifth of those judged
    assert {row.role for row in plan.asked if row.overlapped} == {"judged"}
    for row in plan.asked:
        told = known(ITEMS)[row.item_id]
        assert (row.answer, row.reason) == ((None, "") if row.role == "judged" else told)
    assert set(draw_design(RUNS[::-1], Design(), gold=known(ITEMS)).asked) == set(plan.asked)
    assert set(draw_design(RUNS, Design(seed=1), gold=known(ITEMS)).asked) != set(plan.asked)
    gold = [row for row in plan.asked if row.role == "gold"]
    assert abs(sum(row.answer == "correct" for row in gold) - 5) <= 1


def test_what_gets_all_votes_anyway_is_not_overlapped():
    for design in (Design(adaptive=False), Design(votes=2), Design(votes=0)):
        assert not any(row.overlapped for row in draw_design(RUNS, design).asked)


def test_a_sample_tells_its_probabilities_and_grows():
    small, large = (draw_design(RUNS, Design(most=most)) for most in (20, 40))
    assert {row.item_id for row in small.asked} < {row.item_id for row in large.asked}
    assert sum(1 / row.probability for row in small.asked) == pytest.approx(100)
    assert "A sample of 20 of 100 matches is asked." in small.notes
    (note,) = (note for note in draw_design(RUNS, Design(most=2)).notes if "no room" in note)
    assert "all 3 pairs; 2 of them" in note


def test_gold_is_drawn_from_the_sample_first_and_practice_from_outside():
    plan = draw_design(RUNS, Design(most=40), gold=known(ITEMS))
    assert all(row.probability is not None for row in plan.asked if row.role != "practice")
    assert roles(plan) == {"judged": 30, "gold": 10, "practice": 5}
    sampled = set(draw_design(RUNS, Design(most=40)).asked)
    outside = [item for item in ITEMS if item not in {row.item_id for row in sampled}]
    few = draw_design(RUNS, Design(most=40, practice=0), gold=known(outside[:12]))
    assert {row.probability for row in few.asked if row.role == "gold"} == {None}  # not by the sample


def test_too_little_gold_is_told_in_a_sentence():
    assert any("no gold matches" in note for note in draw_design(RUNS, Design()).notes)
    few = draw_design(RUNS, Design(), gold=known(ITEMS[:4]))
    assert roles(few) == {"judged": 96, "gold": 4}  # gold goes before practice
    assert any(note.startswith("Only 4 of 10 gold matches were found") for note in few.notes)
    assert any("no practice" in note for note in few.notes)
    assert draw_design(RUNS, Design(gold=0, practice=0)).notes == ()
    assert draw_design(RUNS, Design(), gold=known(ITEMS)).notes == ()


def test_practice_of_its_own_does_not_take_from_gold():
    plan = draw_design(RUNS, Design(), gold=known(ITEMS[:10]), practice=known(ITEMS[10:13]))
    assert roles(plan) == {"judged": 87, "gold": 10, "practice": 3}
    assert {row.item_id for row in plan.asked if row.role == "practice"} == set(ITEMS[10:13])


def test_a_study_is_made_as_designed_and_says_nothing_of_gold(place):
    told = []
    design = Design(name="Lamps", question="Same?", guideline="Look twice.", votes=5, unsure=False, seed=7, most=50)
    with create_design(place, RUNS, design, gold=known(ITEMS), tell=told.append) as handle:
        about = study.about(handle)
        with handle.reading() as connection:
            rows = connection.execute(select(schema.asked)).all()
            (text,) = connection.scalars(select(schema.study.c.settings))
    assert (about.name, about.question, about.guideline, about.seed) == ("Lamps", "Same?", "Look twice.", "7")
    assert (about.votes, about.adaptive, about.unsure) == (5, True, False)
    assert Counter(row.role for row in rows) == {"judged": 40, "gold": 10, "practice": 5}
    assert about.settings["design"] == {"overlap": 0.2, "most": 50, "seed": 7}
    assert "gold" not in text
    assert "practice" not in text
    assert told == ["A sample of 50 of 100 matches is asked."]


def test_a_study_is_made_whole_or_not_at_all(place, tmp_path):
    song = Run("puzzle", "m", "m", {}, "s", {"sha256": "z", "pieces": 2}, {}, {}, (Proposal(Item("z-0", "song", {}), 1.0, 1),))
    with pytest.raises(BadInput, match="kind 'song'"):
        create_design(place, [*RUNS, song], Design())

    def stop(share, words):
        if share > 0.5:
            raise Cancelled

    with pytest.raises(Cancelled):
        create_design(place, RUNS, Design(), progress=stop)
    assert list(tmp_path.iterdir()) == []
    create_design(place, RUNS, Design()).close()
    with pytest.raises(BadInput, match="already"):
        create_design(place, RUNS, Design())


def test_a_study_without_a_name_has_that_of_its_file(tmp_path):
    with create_design(tmp_path / "vases.concord", RUNS, Design()) as handle:
        assert study.about(handle).name == "vases"


def test_n_of_m_judged(place):
    runs = [run_of("lamps", "a", [f"a-{n}" for n in range(4)]), run_of("lamps", "a", ["a-3", "a-4"], "thesis")]
    with create_design(place, runs, Design(gold=0, practice=1), practice=known(["a-0"])) as handle:
        study.record_vote(handle, "a-3", "anna", "correct")
        study.record_vote(handle, "a-1", "anna", "unsure")  # decides nothing
        study.record_vote(handle, "a-0", "anna", "correct", round=0)  # practice
        learned, thesis = judged_counts(handle)
        assert (learned.method, learned.matches, learned.asked, learned.judged) == ("learned", 4, 3, 1)
        assert (thesis.method, thesis.matches, thesis.asked, thesis.judged) == ("thesis", 2, 2, 1)
        assert thesis.run_id == run_id(runs[1])
