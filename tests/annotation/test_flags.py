"""Flags: gold failures by hand, the most evenly disputed first, what is unresolved."""

from design_world import known, run_of

from annotation import study
from annotation.design.designing import Design, create_design
from annotation.design.flags import disputed, evenness, gold_failures, gold_records, unresolved
from annotation.records import Vote
from annotation.voting.majority import Majority


def vote(item, code, answer, clock=1):
    return Vote(f"{item}{code}", item, code, 1, answer, "", None, clock, None, None, {}, "")


def test_gold_records_by_hand():
    told = {"a": "correct", "b": "wrong", "c": "correct"}
    votes = [vote(item, "anna", answer) for item, answer in zip("abcx", ("correct", "wrong", "unsure", "wrong"), strict=True)]
    votes += [vote(item, "bert", answer) for item, answer in zip("abc", ("wrong", "correct", "correct"), strict=True)]
    votes.append(vote("a", "carl", "wrong"))
    bert, carl, anna = gold_records(votes, told)
    assert anna == ("anna", 3, 2, 0, 1, ())
    assert bert == ("bert", 3, 1, 2, 0, (("a", "correct"), ("b", "wrong")))
    assert (anna.share_right, bert.share_right) == (1.0, 1 / 3)
    assert [one.flagged for one in (anna, bert, carl)] == [False, True, False]  # of carl there is too little
    assert gold_records(votes, {}) == ()
    assert gold_records([vote("a", "dora", "unsure")], told)[0].share_right is None


def test_the_most_evenly_disputed_come_first():
    assert evenness(Majority(2, 2, 5, "tie")) == 0
    assert evenness(Majority(0, 0, 3, "unjudged")) == 0.5
    assert evenness(Majority(3, 1, 0, "correct")) == 0.25


def test_disputed_and_unresolved_of_a_study(place):
    items = [f"a-{n}" for n in range(6)]
    design = Design(name="Lamps", votes=2, gold=0.1, gold_least=1, practice=1)
    with create_design(place, [run_of("s", "a", items)], design, gold=known(["a-4"]), practice=known(["a-5"])) as handle:
        for item, answers in {"a-0": "cw", "a-1": "ccw", "a-2": "uu", "a-3": "cc", "a-4": "cw", "a-5": "cw"}.items():
            for code, letter in zip(("anna", "bert", "carl"), answers, strict=False):
                answer = {"c": "correct", "w": "wrong", "u": "unsure"}[letter]
                study.record_vote(handle, item, code, answer, round=0 if item == "a-5" else 1)
        assert [(one.item, one.for_adjudicator) for one in disputed(handle)] == [("a-0", True), ("a-4", True), ("a-1", False)]
        assert [(one.item, one.for_adjudicator) for one in unresolved(handle)] == [("a-0", True), ("a-2", True), ("a-4", True)]
        assert {one.volunteer: (one.right, one.wrong) for one in gold_failures(handle)} == {"anna": (1, 0), "bert": (0, 1)}
