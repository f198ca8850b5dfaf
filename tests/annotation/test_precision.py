"""The precision table, counted by hand on a small world."""

import csv
import io

import pytest
from design_world import run_of
from findings_world import cast, ran
from judging_world import CANDLE, LAMP, ONE_TO_ONE, VASE, identity, result, study_of
from sqlalchemy import insert

from annotation import study
from annotation.design.sampling import sample as draw_sample
from annotation.findings.comparing import leave_one_out
from annotation.findings.precision import (
    ALL_SETS,
    ballots,
    counted,
    precision_table,
    proposed_later,
    sample,
    tabulate,
    without,
)
from annotation.findings.tabletext import agreement_line, notes, render
from annotation.results.matchesfile import run_of_json
from annotation.storage import schema
from annotation.storage.stamps import now
from engine.errors import BadParameter
from engine.evaluation.averages import thesis_average
from engine.evaluation.intervals import clustered_interval
from engine.matchfile import result_to_json

FOOT, STEM, SHADE = (identity(LAMP, one, VASE, other) for one, other in ONE_TO_ONE)


def vote(handle, volunteer, **items):
    for name, letter in items.items():
        answer = {"c": "correct", "w": "wrong", "u": "unsure"}[letter]
        study.record_vote(handle, {"foot": FOOT, "stem": STEM, "shade": SHADE}[name], volunteer, answer)


@pytest.fixture
def judged(place):
    """Two pairs: lamp-vase has a right, a tied and a wrong match, lamp-candle a right one and one unjudged."""
    candle = result(((0,), (0,)), ((1,), (1,)), target=CANDLE)
    with study_of(place, result(*ONE_TO_ONE), candle, set_name="lamps") as handle:
        vote(handle, "anna", foot="c", stem="c", shade="w")
        vote(handle, "bert", foot="c", stem="w", shade="u")
        study.record_vote(handle, identity(LAMP, (0,), CANDLE, (0,)), "anna", "correct")
        yield handle


def test_a_row_by_hand(judged):
    (row,) = precision_table(judged)
    assert row[:11] == ("top-down", "top-down", "lamps", 1, 2, 5, 4, 2, 1, 1, 1)
    assert row.micro == pytest.approx(2 / 3)
    assert row.macro == pytest.approx((1 / 2 + 1) / 2)
    assert row.interval == clustered_interval([1, 1], [2, 1])
    assert (row.bound_low, row.bound_high) == pytest.approx((2 / 5, 4 / 5))
    assert (row.volunteers, row.votes, row.unsure) == (2, 7, pytest.approx(1 / 7))


def test_nothing_judged_is_unknown_not_wrong(tmp_path):
    with study_of(tmp_path / "a.db") as handle:
        (row,) = precision_table(handle)
        text = render(precision_table(handle), ballots(handle))
    assert (row.micro, row.macro, row.interval, row.unsure) == (None,) * 4
    assert (row.bound_low, row.bound_high, row.judged, row.matches) == (0.0, 1.0, 0, 3)
    assert "0 of 3" in text
    assert "no match has been judged by two volunteers" in text


def test_the_interval_of_a_single_pair_says_how_little_it_says(tmp_path, judged):
    with study_of(tmp_path / "one.db") as handle:
        vote(handle, "anna", foot="c", stem="w")
        text = render(precision_table(handle), ballots(handle))
    assert "Wilson, one pair only" in text
    assert "single pair" in text
    assert "single pair" not in render(precision_table(judged), ballots(judged))


def test_one_vote_serves_both_methods(judged):
    study.add_result(judged, result(((0,), (0,)), ((0, 1), (0, 1)), preset="thesis-rigid"), set_name="lamps")
    rows = {row.preset: row for row in precision_table(judged)}
    assert (rows["thesis-rigid"].correct, rows["thesis-rigid"].matches, rows["thesis-rigid"].pairs) == (1, 2, 1)
    assert rows["top-down"].matches == 5


def test_a_rerun_replaces_its_pair_and_keeps_the_votes(judged):
    study.add_result(judged, result(((0,), (0,)), ((1, 2), (1, 2)), K=3), set_name="lamps")
    (row,) = precision_table(judged)
    assert (row.pairs, row.matches, row.correct, row.wrong, row.unjudged) == (2, 4, 2, 0, 2)
    assert row.parameter_sets == 2
    assert "top-down*" in render([row], ballots(judged))
    backwards = result(*((b, a) for a, b in ONE_TO_ONE), source=VASE, target=LAMP)
    study.add_result(judged, backwards, set_name="lamps")
    assert precision_table(judged)[0].matches == 5


def test_sets_are_rows_and_their_total_counts_a_pair_once(judged):
    study.add_result(judged, result(*ONE_TO_ONE), set_name="again")
    rows = precision_table(judged)
    assert [row.set_name for row in rows] == ["again", "lamps", ALL_SETS]
    total = rows[-1]
    assert (total.pairs, total.matches, total.correct, total.wrong) == (2, 5, 2, 1)
    assert "As in Tables 3.1/3.2, top-down" in render(rows, ballots(judged))


def test_a_pair_without_matches_is_a_pair(judged):
    study.add_result(judged, result(source=CANDLE, target=VASE), set_name="lamps")
    assert precision_table(judged)[0].pairs == 3


def test_one_mesh_with_two_segmentations_makes_two_pairs(tmp_path):
    with study_of(tmp_path / "a.db", result(*ONE_TO_ONE)) as handle:
        for labels in ("coarse", "fine"):
            content = result_to_json(result(*ONE_TO_ONE))
            content["source"]["segmentation"] = labels
            study.add_run(handle, run_of_json(content, "cut"))
        assert [(row.set_name, row.pairs) for row in precision_table(handle)] == [("", 1), ("cut", 2), (ALL_SETS, 3)]


def test_text_and_markdown_have_all_columns(judged):
    text, markdown = (render(precision_table(judged), ballots(judged), style) for style in ("text", "markdown"))
    header, rule, row = text.splitlines()[:3]
    assert header.split()[:2] == ["method", "set"]
    assert set(rule) == {"-"}
    for cell in ("4 of 5", " 66.7 ", " 75.0 ", "40.0 – 80.0", " 7 by 2 ", " 14.3"):
        assert cell in row
    lines = [line for line in markdown.splitlines() if line.startswith("|")]
    assert len(lines) == 3
    assert len({line.count("|") for line in lines}) == 1


def test_csv_has_shares_and_the_kind_of_interval(judged):
    (row,) = csv.DictReader(io.StringIO(render(precision_table(judged), ballots(judged), "csv")))
    assert float(row["micro_precision"]) == pytest.approx(2 / 3)
    assert row["interval_method"] == "cluster-robust GLM, t"
    assert (row["matches"], row["judged"], row["tie"]) == ("5", "4", "1")


def test_agreement_leaves_abstentions_out(judged):
    """Two items with two decisive votes: foot agrees, stem does not; alpha = 1 - .5 / (6/12) by hand."""
    line = agreement_line(ballots(judged))
    assert "2 matches" in line
    assert "50.0 % raw" in line
    assert "alpha 0.000" in line
    vote(judged, "bert", stem="c")
    assert "not defined" in agreement_line(ballots(judged))


def test_thesis_average_by_hand():
    """Weighted mean (10·80 + 30·90) / 40, plain sample deviation of 80, 90."""
    mean, spread = thesis_average([80, 90], [10, 30])
    assert mean == pytest.approx(87.5)
    assert spread == pytest.approx(50**0.5)
    assert thesis_average([80, 90], [1, 1])[0] == pytest.approx(85)
    for bad in (([], []), ([80], [1, 2]), ([80], [0])):
        with pytest.raises(BadParameter):
            thesis_average(*bad)


@pytest.mark.parametrize(
    ("percentages", "pairs", "mean", "deviation"),
    [
        ([85.2, 86.0, 86.2, 83.5], [30, 20, 11, 11], 85.315, 1.228),
        ([76.7, 63.0, 71.3, 60.8], [30, 20, 11, 11], 69.640, 7.380),
        ([97.2, 83.3, 85.3, 90.9], [3, 7, 6, 4], 87.505, 6.243),
        ([59.0, 62.7, 81.6, 67.5], [3, 7, 6, 4], 68.775, 9.898),
    ],
)
def test_the_eight_numbers_of_tables_3_1_and_3_2(percentages, pairs, mean, deviation):
    assert thesis_average(percentages, pairs) == pytest.approx((mean, deviation), abs=6e-4)


def test_a_sample_is_weighted_by_what_each_drawn_match_stands_for():
    """One pair, a (p 1/4) right, b (p 1) wrong, c drawn and unseen (p 1/2), d not drawn: 4 / 5, bounds 4/7 and 6/7."""
    (row,) = tabulate([ran("m", "pair", "a b c d")], cast(a="c", b="w", d="w"), {"a": 4.0, "b": 1.0, "c": 2.0})
    assert (row.micro, row.macro) == pytest.approx((4 / 5, 4 / 5))
    assert (row.bound_low, row.bound_high) == pytest.approx((4 / 7, 6 / 7))
    assert (row.matches, row.drawn, row.judged, row.seen, row.sampled) == (4, 3, 3, 3, True)
    assert row.interval.method == "Wilson, one pair only, weighted"
    assert "1 / p" in " ".join(notes([row]))


def test_a_sample_of_equal_chances_gives_the_figures_of_its_counts():
    results, votes = [ran("m", "p", "a b c"), ran("m", "q", "d e")], cast(a="c", b="w", c="c", d="c", e="c")
    (plain,), (drawn,) = tabulate(results, votes), tabulate(results, votes, dict.fromkeys("abcde", 4.0))
    assert drawn.micro == pytest.approx(plain.micro)
    assert drawn.interval[:2] == pytest.approx(plain.interval[:2])
    assert drawn.interval.method == plain.interval.method


def test_nobody_has_seen_is_not_unresolved():
    """Of four: one right, one tied, one with an abstention alone, one unseen; two of the three seen are unresolved."""
    (row,) = tabulate([ran("m", "pair", "a b c d")], cast(a="cc", b="cw", c="u"))
    assert (row.seen, row.unresolved, row.judged, row.unjudged) == (3, pytest.approx(2 / 3), 2, 2)
    assert (row.bound_low, row.bound_high) == pytest.approx((1 / 4, 1.0))


def test_the_study_says_what_its_drawn_matches_stand_for(tmp_path):
    with study_of(tmp_path / "a.db") as handle:
        assert sample(handle) is None
        rows = [{"item_id": item, "role": "judged", "reason": "", "stratum": "", "probability": p, "overlapped": 0, "added_at": ""}
                for item, p in ((FOOT, 1.0), (STEM, 0.5))]  # fmt: skip
        rows.append(rows[0] | {"item_id": SHADE, "role": "practice", "answer": "wrong", "probability": None})
        with handle.writing() as connection:
            for row in rows:
                connection.execute(insert(schema.asked).values(row))
        assert sample(handle) == {FOOT: 1.0, STEM: 2.0}
        study.record_vote(handle, SHADE, "anna", "correct", round=0)
        vote(handle, "anna", foot="w", stem="c")
        (found,) = precision_table(handle)
        assert (found.micro, found.votes, found.drawn) == (pytest.approx(2 / 3), 2, 2)


def test_pooled_recall_is_of_pairs_where_everything_was_seen():
    """On p both methods were seen whole: a, b, d are right, m has a and b. On q one proposal was not seen."""
    results = [ran("m", "p", "a b c"), ran("n", "p", "a d"), ran("m", "q", "e"), ran("n", "q", "f g"), ran("m", "r", "h")]
    rows = tabulate(results, cast(a="c", b="c", c="w", d="c", e="c", f="c", h="c"))
    assert [(row.recall, row.recall_pairs) for row in rows] == [(pytest.approx(2 / 3), 1), (pytest.approx(2 / 3), 1)]
    assert tabulate([ran("m", "p", "a")], cast(a="c"))[0].recall is None


def test_votes_taken_away_are_votes_that_were_never_given():
    votes = cast(a="cwc", b="uw", c="..c")
    for code in ("anna", "bert", "carl"):
        own = [v for v in votes if v.volunteer == code]
        assert without(counted(votes), own) == counted([v for v in votes if v.volunteer != code])


def test_guided_and_named_methods_have_chosen_parameters():
    results = [ran("m", "p", "a"), ran("n", "p", "a"), ran("k (guided)", "p", "a")]
    assert [row.chosen for row in tabulate(results, cast(a="c"), chosen=["n"])] == [True, False, True]


def test_a_match_that_two_pairs_share_counts_once():
    results, votes = [ran("m", "p", "a b"), ran("m", "q", "a c")], cast(a="c", b="w", c="c")
    (row,) = tabulate(results, votes)
    assert (row.correct, row.wrong, row.matches) == (2, 1, 3)
    assert (row.micro, row.bound_low, row.bound_high) == pytest.approx((2 / 3,) * 3)
    assert row.macro == pytest.approx((1 / 2 + 1) / 2)
    assert leave_one_out(results, [*votes, *cast(a=".c")])[0].micro == pytest.approx(2 / 3)


def test_matches_proposed_after_the_draw_had_no_chance(tmp_path):
    """Of a, b, c two were drawn, each standing for 1.5; d and e came later. The new method's one drawn match is right and
    stands for 1.5; of 3.5 that is the lower bound."""
    design = {"role": "judged", "answer": None, "reason": "", "stratum": "", "overlapped": 0, "probability": 2 / 3}
    with study.create_study(tmp_path / "a.db", name="Late") as handle:
        study.add_run(handle, run_of("lamps", "p", ["a", "b", "c"]))
        with handle.writing() as connection:
            for item in "ab":
                connection.execute(insert(schema.asked).values(**design, item_id=item, added_at=now()))
        assert proposed_later(handle) == frozenset()
        study.add_run(handle, run_of("lamps", "p", ["a", "d", "e"], "new"))
        study.record_votes(handle, "anna", {"a": "correct", "b": "wrong"})
        assert proposed_later(handle) == {"d", "e"}
        old, new = precision_table(handle)
    assert (old.later, old.micro, old.bound_low, old.bound_high) == (0, *map(pytest.approx, (0.5, 0.5, 0.5)))
    assert (new.later, new.micro, new.bound_low, new.bound_high) == (2, *map(pytest.approx, (1.0, 1.5 / 3.5, 1.0)))
    assert "top-up" in " ".join(notes([old, new]))
    assert "top-up" not in " ".join(notes([old]))


def test_samples_by_the_design_tell_the_precision_of_the_whole_and_counts_alone_do_not():
    """One pair of 200 matches, 9 of 10 right, and twenty pairs of two wrong ones: 180 of 240. Of 30 drawn every pair gives one."""
    results = [ran("m", "large", " ".join(f"l{k}" for k in range(200))), *(ran("m", f"s{k}", f"s{k}a s{k}b") for k in range(20))]
    right = {f"l{k}": "w" if k % 10 == 0 else "c" for k in range(200)}
    votes = counted(cast(**right, **{f"s{k}{end}": "w" for k in range(20) for end in "ab"}))
    strata = {item: result.pair for result in results for item in result.items}
    weighted, plain = [], []
    for seed in range(150):
        drawn = draw_sample(strata, 30, str(seed))
        some = {item: votes[item] for item in drawn}
        weighted.append(tabulate(results, some, {item: 1 / p for item, p in drawn.items()})[0].micro)
        plain.append(tabulate(results, some)[0].micro)
    assert sum(weighted) / 150 == pytest.approx(180 / 240, abs=0.015)
    assert sum(plain) / 150 < 0.5
