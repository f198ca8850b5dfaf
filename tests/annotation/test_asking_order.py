"""Who is asked what, and when: votes saved, ties, adjudicators, gold, practice, packets, seeds, skips."""

import random
from collections import Counter

import pytest
from design_world import known, run_of, runs_of
from sqlalchemy import insert, select

from annotation import study
from annotation.design.designing import Design, create_design, put_asked
from annotation.design.flags import disputed, gold_failures, unresolved
from annotation.design.sampling import Drawn
from annotation.design.topup import name_gold, name_practice
from annotation.findings.precision import precision_table
from annotation.storage import schema
from annotation.storage.stamps import now
from annotation.voting.answering import (
    known_volunteer,
    make_adjudicator,
    open_items,
    seconds_each,
    settle_seeds,
    sides_swapped,
)
from annotation.voting.asking import opening
from annotation.voting.majority import majorities
from engine.errors import BadInput, BadParameter

ITEMS = [f"a-{n}" for n in range(8)]
PLAIN = Design(gold=0, practice=0, overlap=0)


def designed(place, design=PLAIN, items=ITEMS, **more):
    return create_design(place, [run_of("lamps", "a", items)], design.changed(name="Lamps"), **more)


def asked(handle, code):
    return {one.item_id for one in open_items(handle, code)}


def votes(handle, item, **answers):
    for code, answer in answers.items():
        study.record_vote(handle, item, code, answer)


def in_bulk(handle, code, answers):
    """The votes of a volunteer as plain rows."""
    study.volunteer(handle, code)
    rows = [
        {"uuid": f"{code}-{item}", "kind": "vote", "item_id": item, "volunteer": code, "round": 1, "answer": answer,
         "comment": "", "clock": number, "presentation": "{}", "app_version": "", "created_at": now()}
        for number, (item, answer) in enumerate(answers.items(), start=1)
    ]  # fmt: skip
    with handle.writing() as connection:
        connection.execute(insert(schema.event), rows)


def test_a_third_vote_only_where_two_differ_gives_the_majorities_of_three(tmp_path):
    """20,000 matches, a fifth overlapped: the same majorities as of three votes each, with far fewer votes."""
    chance, codes = random.Random(5), ("anna", "bert", "carl")
    items = [str(n) for n in range(20_000)]
    truth = {item: chance.random() < 0.7 for item in items}
    full = {
        item: {code: "unsure" if chance.random() < 0.02 else "correct" if truth[item] == (chance.random() < 0.94) else "wrong"
               for code in codes} for item in items
    }  # fmt: skip
    with designed(tmp_path / "a.db", PLAIN.changed(overlap=0.2), items) as handle:
        cast = []
        for code in codes:
            study.volunteer(handle, code)
            answers = {item: full[item][code] for item in asked(handle, code)}
            in_bulk(handle, code, answers)
            cast.append(len(answers))
        with handle.reading() as connection:
            overlapped = set(connection.scalars(select(schema.asked.c.item_id).where(schema.asked.c.overlapped == 1)))
        found = study.current_votes(handle)
        adaptive = majorities(items, ((vote.item_id, vote.answer) for vote in found))
    complete = majorities(items, ((item, answer) for item in items for answer in full[item].values()))
    assert {item: m.verdict for item, m in adaptive.items()} == {item: m.verdict for item, m in complete.items()}
    assert cast[:2] == [20_000, 20_000]
    assert 1 - sum(cast) / 60_000 > 0.2
    each = Counter(vote.item_id for vote in found)
    assert len(overlapped) == 4000
    assert {each[item] for item in overlapped} == {3}
    assert {each[item] for item in items} == {2, 3}


def test_without_saving_everybody_asked_is_asked_until_there_are_k_votes(place):
    with designed(place, PLAIN.changed(adaptive=False)) as handle:
        votes(handle, ITEMS[0], anna="correct", bert="correct")
        assert ITEMS[0] in asked(handle, "carl")
        votes(handle, ITEMS[0], carl="correct")
        assert ITEMS[0] not in asked(handle, "dora")


def test_a_tie_goes_to_one_more_volunteer_and_then_to_adjudicators_alone(place):
    with designed(place, PLAIN.changed(votes=2)) as handle:
        make_adjudicator(handle, "zoe")
        votes(handle, ITEMS[0], anna="correct")
        votes(handle, ITEMS[1], anna="wrong", bert="wrong")
        assert asked(handle, "zoe") == set()
        votes(handle, ITEMS[0], bert="wrong")
        assert ITEMS[0] in asked(handle, "carl")
        assert [one.item for one in disputed(handle) if one.for_adjudicator] == [ITEMS[0]]
        votes(handle, ITEMS[0], carl="unsure")
        assert ITEMS[0] not in asked(handle, "dora")
        assert asked(handle, "zoe") == {ITEMS[0]}
        assert [(one.item, one.for_adjudicator) for one in unresolved(handle)] == [(ITEMS[0], True)]
        votes(handle, ITEMS[0], zoe="wrong")
        assert all(ITEMS[0] not in asked(handle, code) for code in ("anna", "dora", "zoe"))
        assert unresolved(handle) == ()
        assert study.majority(handle)[ITEMS[0]].verdict == "wrong"


def test_two_adjudicators_who_differ_leave_it_to_a_third(place):
    with designed(place, PLAIN.changed(votes=2)) as handle:
        for code in ("yve", "zoe", "xan"):
            make_adjudicator(handle, code)
        votes(handle, ITEMS[0], anna="unsure", bert="unsure", yve="correct", zoe="wrong")
        assert asked(handle, "xan") == {ITEMS[0]}
        assert asked(handle, "zoe") == asked(handle, "yve") == set()


def test_an_adjudicator_is_blind_and_may_become_a_volunteer_again(place):
    with designed(place, PLAIN.changed(votes=2, practice=2), practice=known(ITEMS)) as handle:
        code = make_adjudicator(handle, " zoe ").code
        assert asked(handle, code) == set()  # no practice, nothing unresolved
        assert study.volunteer(handle, "zoe").adjudicates
        assert not make_adjudicator(handle, "zoe", adjudicates=False).adjudicates
        assert asked(handle, "zoe") == set(ITEMS)


def test_an_abstention_is_a_vote_that_decides_nothing(place):
    with designed(place) as handle:
        votes(handle, ITEMS[0], anna="correct", bert="unsure")
        assert ITEMS[0] in asked(handle, "carl")
        votes(handle, ITEMS[0], carl="unsure")
        assert ITEMS[0] not in asked(handle, "dora")
        assert study.majority(handle)[ITEMS[0]].verdict == "correct"
        votes(handle, ITEMS[1], anna="unsure", bert="unsure", carl="unsure")
        assert ITEMS[1] in asked(handle, "dora")


def test_gold_is_asked_of_everybody_and_failures_are_flagged_but_stay(place):
    with designed(place, Design(gold=0.3, gold_least=3, practice=0), gold=known(ITEMS[:3])) as handle:
        told = known(ITEMS[:3])
        for code in ("anna", "bert", "carl", "dora"):
            assert set(ITEMS[:3]) <= asked(handle, code)
            wrong_way = {"correct": "wrong", "wrong": "correct"}
            for item in ITEMS[:3]:
                right = told[item].answer
                votes(handle, item, **{code: wrong_way[right] if code == "carl" else right})
        worst, *others = gold_failures(handle)
        assert (worst.volunteer, worst.judged, worst.wrong, worst.flagged) == ("carl", 3, 3, True)
        assert {item for item, _ in worst.failed} == set(ITEMS[:3])
        assert [(one.volunteer, one.right, one.flagged) for one in others] == [(c, 3, False) for c in ("anna", "bert", "dora")]
        assert len(study.current_votes(handle)) == 12


def test_practice_comes_first_and_counts_in_no_table(place):
    with designed(place, Design(gold=0, practice=2), practice=known(ITEMS[:2])) as handle:
        first, second, *rest = open_items(handle, "anna")
        assert {(one.item_id, one.round) for one in (first, second)} == {(item, 0) for item in ITEMS[:2]}
        assert {one.round for one in rest} == {1}
        assert study.practice(handle)[ITEMS[0]] == ("correct", "because of a-0")
        study.record_vote(handle, first.item_id, "anna", "wrong", round=0)
        assert first.item_id not in asked(handle, "anna")
        assert study.progress(handle, "anna")[:2] == (0, 6)
        study.record_vote(handle, rest[0].item_id, "anna", "correct")
        (row,) = precision_table(handle)
        assert (row.votes, row.correct, row.matches) == (1, 1, 6)


def test_a_packet_fixes_what_is_asked_and_counts_as_waiting(place):
    with designed(place) as handle:
        for code in ("anna", "bert", "carl"):
            study.volunteer(handle, code)
        with handle.writing() as connection:
            held = [{"item_id": item, "volunteer": code, "made_at": now()} for code in ("anna", "bert") for item in ITEMS[:2]]
            connection.execute(insert(schema.assignment), held)
        assert asked(handle, "anna") == set(ITEMS[:2])
        assert asked(handle, "carl") == set(ITEMS[2:])  # two packets may settle the others
        votes(handle, ITEMS[0], anna="correct", bert="wrong")
        assert asked(handle, "carl") == {ITEMS[0], *ITEMS[2:]}


@pytest.mark.parametrize("share", [0.1, 0.5])
def test_the_first_item_is_never_gold(tmp_path, share):
    items = [f"a-{n}" for n in range(40)]
    with designed(tmp_path / "a.db", Design(gold=share, gold_least=0, practice=0), items, gold=known(items)) as handle:
        with handle.reading() as connection:
            gold = set(connection.scalars(select(schema.asked.c.item_id).where(schema.asked.c.role == "gold")))
        assert len(gold) == 40 * share
        queues = [[one.item_id for one in open_items(handle, f"v{n}")] for n in range(60)]
        assert not gold & {queue[0] for queue in queues}
        assert gold & {queue[5] for queue in queues} or share < 0.5
        assert len({tuple(queue) for queue in queues}) == 60


def test_gold_that_is_named_later_comes_first_for_nobody_who_begins(tmp_path):
    with designed(tmp_path / "a.db", items=[f"a-{n}" for n in range(30)]) as handle:
        before = {code: open_items(handle, code)[0].item_id for code in "abcdefgh"}
        votes(handle, before["a"], a="correct")
        seeds = {one.code: one.seed for one in study.volunteers(handle)}
        gold = set(before.values())
        assert name_gold(handle, known(sorted(gold))) == len(gold)
        assert not gold & {open_items(handle, code)[0].item_id for code in "bcdefgh"}
        assert study.volunteer(handle, "a").seed == seeds["a"]  # has begun: the order stays


def test_who_comes_late_does_not_begin_with_gold_either(tmp_path):
    items = [f"a-{n}" for n in range(30)]
    with designed(tmp_path / "a.db", Design(votes=1, gold=0.3, gold_least=0, practice=0), items, gold=known(items)) as handle:
        with handle.reading() as connection:
            gold = set(connection.scalars(select(schema.asked.c.item_id).where(schema.asked.c.role == "gold")))
        for item in sorted(set(items) - gold)[2:]:
            votes(handle, item, anna="correct")
        assert len(asked(handle, "late") - gold) == 2
        assert not gold & {open_items(handle, f"late{n}")[0].item_id for n in range(20)}


def test_who_is_invited_early_and_begins_late_does_not_begin_with_gold_either(tmp_path):
    items, late = [f"a-{n}" for n in range(30)], [f"late{n}" for n in range(20)]
    with designed(tmp_path / "a.db", Design(votes=1, gold=0.3, gold_least=0, practice=0), items, gold=known(items)) as handle:
        for code in late:
            study.volunteer(handle, code)
        with handle.reading() as connection:
            gold = set(connection.scalars(select(schema.asked.c.item_id).where(schema.asked.c.role == "gold")))
        for item in sorted(set(items) - gold)[2:]:
            votes(handle, item, anna="correct")
        assert gold & {open_items(handle, code)[0].item_id for code in late}
        firsts = [opening(handle, code, new=False).open[0].item_id for code in late]
        assert not gold & set(firsts)
        assert [open_items(handle, code)[0].item_id for code in late] == firsts
        votes(handle, firsts[0], late0="correct")
        seeds = {one.code: one.seed for one in study.volunteers(handle)}
        for item in sorted(set(items) - gold)[:1]:
            votes(handle, item, anna="correct")
        opening(handle, "late0", new=False)
        assert study.volunteer(handle, "late0").seed == seeds["late0"]  # has begun: the order stays


def test_a_packet_does_not_begin_with_gold(tmp_path):
    with designed(tmp_path / "a.db", Design(gold=0.25, gold_least=0, practice=0), gold=known(ITEMS[:2])) as handle:
        for code in "abcdefghij":
            study.volunteer(handle, code)
        with handle.writing() as connection:
            connection.execute(insert(schema.assignment), [
                {"item_id": item, "volunteer": code, "made_at": now()} for code in "abcdefghij" for item in (ITEMS[0], ITEMS[5])])
            settle_seeds(connection)
        assert {open_items(handle, code)[0].item_id for code in "abcdefghij"} == {ITEMS[5]}


def test_orders_and_sides_are_drawn_for_each_volunteer_and_stay(tmp_path):
    items = [f"a-{n}" for n in range(100)]
    with designed(tmp_path / "a.db", PLAIN, items) as one, designed(tmp_path / "b.db", PLAIN, items) as other:
        assert open_items(one, "anna") == open_items(other, "anna") != open_items(one, "bert")
        voter = study.volunteer(one, "anna")
        swapped = [sides_swapped(voter, item) for item in items]
        assert swapped == [sides_swapped(study.volunteer(other, "anna"), item) for item in items]
        assert 30 < sum(swapped) < 70
    with designed(tmp_path / "c.db", PLAIN.changed(seed=1), items) as third:
        assert open_items(third, "anna") != open_items(one, "anna")


def test_what_is_skipped_comes_back_at_the_end_in_the_order_of_skipping(place):
    with designed(place) as handle:
        order = [one.item_id for one in open_items(handle, "anna")]
        assert study.next_item(handle, "anna", skipped=order[:2]).id == order[2]
        assert study.next_item(handle, "anna", skipped=[*order[1:], order[0]]).id == order[1]
        for item in order[1:]:
            votes(handle, item, anna="correct")
        assert study.next_item(handle, "anna", skipped=[order[0]]).id == order[0]
        votes(handle, order[0], anna="correct")
        assert study.next_item(handle, "anna", skipped=[order[0]]) is None


def test_unsure_is_refused_where_it_is_switched_off(place):
    with designed(place, PLAIN.changed(unsure=False)) as handle:
        with pytest.raises(BadParameter, match="takes no answer 'unsure'"):
            votes(handle, ITEMS[0], anna="unsure")
        assert study.current_votes(handle) == ()


def test_a_code_that_does_not_exist_is_one_sentence(place):
    with designed(place) as handle:
        with pytest.raises(BadInput, match="no volunteer 'anna'; it has none yet"):
            known_volunteer(handle, "anna")
        study.volunteer(handle, "bert")
        assert known_volunteer(handle, " bert ").code == "bert"
        with pytest.raises(BadInput, match="no volunteer 'anna'; it has bert"):
            known_volunteer(handle, "anna")
        with pytest.raises(BadParameter, match="no volunteer code"):
            known_volunteer(handle, "a b")


def test_a_clock_that_was_set_back_spoils_no_progress(place):
    assert seconds_each([-5000, 4000, 2000, -1]) == 3.0
    assert seconds_each([-5]) is None
    with designed(place) as handle:
        for item, ms in zip(ITEMS, (-9000, 4000, 4000), strict=False):
            study.record_vote(handle, item, "anna", "correct", shown_ms=ms, active_ms=ms)
        assert study.progress(handle, "anna") == (3, 8, 20.0)


def test_what_was_drawn_is_replaced_item_by_item(place):
    with designed(place) as handle:
        with handle.writing() as connection:
            put_asked(connection, [Drawn(ITEMS[0], "gold", "wrong", "", "s", None, False)])
            rows = connection.execute(select(schema.asked.c.item_id, schema.asked.c.role)).all()
        assert Counter(row.role for row in rows) == {"judged": 7, "gold": 1}


def test_practice_is_named_among_matches_without_a_vote(place):
    with create_design(place, runs_of({"a": 6}), PLAIN.changed(name="Lamps")) as handle:
        votes(handle, "a-0", anna="correct")
        assert name_practice(handle, known(["a-0", "a-1", "a-2"])) == 2
        assert set(study.practice(handle)) == {"a-1", "a-2"}
        assert name_practice(handle, known(["a-1"])) == 0
