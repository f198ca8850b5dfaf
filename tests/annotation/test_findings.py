"""All that votes say, put together; its tables, its page and its chart."""

import csv
import io
import random
import re

import pytest
from design_world import run_of
from findings_world import cast, ran, read
from judging_world import CANDLE, ONE_TO_ONE, result, study_of
from sqlalchemy import insert

from annotation import study
from annotation.findings.chart import precision_chart
from annotation.findings.gathering import findings, worked_out
from annotation.findings.overview import overview
from annotation.findings.precision import Ballot
from annotation.findings.report import Drawn, as_csv, as_html, written
from annotation.findings.splitting import split
from annotation.findings.tables import tables, values
from annotation.storage import schema
from annotation.voting.volunteers import make_adjudicator
from engine.errors import BadParameter
from engine.evaluation.tables import Table, split_wide

RESULTS = [ran("m", "p", "a b c"), ran("n", "p", "a d"), ran("m", "q", "e f", "vases"), ran("k (guided)", "p", "a")]
VOTES = cast(a="ccw", b="cw.", c="www", d="ccc", e="wcu", f="ccc")


def shown(section="all", **changes):
    return {table.title: table for table in tables(worked_out(read(RESULTS, VOTES), **changes), section)}


def test_everything_of_a_small_study():
    found = worked_out(read(RESULTS, VOTES, comments={"a": ("odd",)}, adaptive=True), chosen=["n"])
    assert [(row.method, row.set_name) for row in found.rows] == [("m", "lamps"), ("m", "vases"), ("m", "(all)")]
    assert [row.method for row in found.chosen] == ["k (guided)", "n"]
    assert [d.item for d in found.disputed] == ["b", "e", "a"]
    assert found.disputed[2][1:] == ("shape", ("lamps",), "p", (2, 1, 0, "correct"), ("odd",))
    assert len(found.left_out) == len(found.modelled) == 5
    assert [row.of for row in found.agreement] == ["all matches", "lamps", "vases"]
    assert [s[:4] for s in found.sets] == [("m", "lamps", 0.5, 1), ("m", "vases", 1.0, 1)]


def test_votes_on_what_no_method_proposes_do_not_count():
    extra = [Ballot("z", code, "wrong") for code in ("anna", "bert", "zora")]
    assert worked_out(read(RESULTS, VOTES))[2:9] == worked_out(read(RESULTS, [*VOTES, *extra]))[2:9]


def test_the_order_of_votes_does_not_matter():
    mixed = VOTES[:]
    random.Random(1).shuffle(mixed)
    one, other = (tables(worked_out(read(RESULTS, votes))) for votes in (VOTES, mixed))
    assert one == other


def test_what_is_read_of_a_study(tmp_path):
    with study_of(tmp_path / "a.db", result(*ONE_TO_ONE), result(((0,), (0,)), target=CANDLE), set_name="lamps") as handle:
        first, *_ = study.items(handle, "anna")
        study.record_vote(handle, first.id, "anna", "correct", comment="clear")
        study.record_vote(handle, first.id, "bert", "wrong")
        found = findings(handle, preset="thesis")
    (one,) = found.disputed
    assert (found.study, found.preset, one.item, one.comments, one.kind) == ("Lamps", "thesis", first.id, ("clear",), "shape")
    assert one.pair in ("lamp.off – vase.off", "lamp.off – candle.off")
    assert found.model is None
    assert not found.adaptive


@pytest.mark.parametrize(
    ("votes", "adaptive", "referee", "told"),
    [(3, True, False, True), (3, False, False, False), (2, False, False, True), (0, True, False, False), (3, False, True, True)],
)
def test_disputed_matches_get_more_votes_by_design_at_ties_and_by_adjudicators(tmp_path, votes, adaptive, referee, told):
    with study.create_study(tmp_path / "a.db", name="A", votes=votes, adaptive=adaptive) as handle:
        study.volunteer(handle, "anna")
        if referee:
            make_adjudicator(handle, "zoe")
        assert findings(handle).adaptive is told


def test_files_and_servers_give_the_same_figures(place):
    with study.create_study(place, name="Lamps", votes=3, seed="s") as handle:
        for run in (run_of("lamps", "p", ["a", "b", "c"]), run_of("lamps", "p", ["a", "d"], "other")):
            study.add_run(handle, run)
        for vote in cast(a="ccw", b="cw.", c="www", d="ccc"):
            study.record_vote(handle, vote.item, vote.volunteer, vote.answer, shown_ms=3000)
        asked = {"role": "judged", "answer": None, "reason": "", "stratum": "", "added_at": ""}
        with handle.writing() as connection:
            for item, p, twice in (("a", 0.5, 1), ("c", 1.0, 0), ("d", 1.0, 1)):
                connection.execute(insert(schema.asked).values(**asked, item_id=item, probability=p, overlapped=twice))
        found, people = findings(handle), overview(handle)
    one, other = found.rows
    assert (one.method, one.micro, one.drawn, one.seen) == ("learned", pytest.approx(2 / 3), 2, 3)
    assert (other.micro, other.recall, other.recall_pairs) == (1.0, 1.0, 1)
    assert [(row.of, row.items) for row in found.agreement] == [("overlapped matches", 2), ("all matches", 4)]
    assert found.adaptive
    assert [(row.code, row.judged, row.open, row.seconds) for row in people] == [
        ("anna", 4, 0, 3.0), ("bert", 4, 0, 3.0), ("carl", 3, 0, 3.0)]  # fmt: skip


def test_tables_say_what_the_figures_are():
    found = shown()
    assert list(found) == [
        "Precision by majority of the votes", "Precision of methods whose parameters or results were chosen with help",
        "Pooled recall", "Agreement", "Volunteers", "Methods compared, pair by pair",
        "How far the figures hang on single volunteers", "The most disputed matches",
    ]  # fmt: skip
    assert ("k (guided)", "lamps", "1 of 1", "50.0") in found["Pooled recall"].rows
    assert "flatter" in found["Precision of methods whose parameters or results were chosen with help"].remark
    assert len(found["Volunteers"].head) == 7
    assert all(len(row) == len(table.head) for table in found.values() for row in table.rows)
    assert "another one is asked" not in found["Agreement"].remark
    adaptive = tables(worked_out(read(RESULTS, VOTES, adaptive=True)), "agreement")
    assert "another one is asked" in adaptive[0].remark


def test_chosen_methods_bear_a_mark_wherever_they_stand_beside_fixed_ones():
    found = {table.title: table for table in tables(worked_out(read(RESULTS, VOTES), chosen=["n"]))}
    for title in ("Pooled recall", "Methods compared, pair by pair", "How far the figures hang on single volunteers"):
        cells = {cell for row in found[title].rows for cell in row[:2]}
        assert {"m", "n†", "k (guided)"} <= cells, title
        assert "†" in found[title].remark
    assert not any("†" in table.remark for table in tables(worked_out(read(RESULTS, VOTES))))
    tuned = worked_out(read(RESULTS, VOTES), chosen=["n"])
    chart = precision_chart((*tuned.rows, *tuned.chosen))
    assert chart.count("†") == 1
    assert "n† · lamps" in chart


def test_comments_have_a_column_where_there_are_any():
    silent, loud = (tables(worked_out(read(RESULTS, VOTES, comments=said)), "disputed")[0] for said in ({}, {"b": ("odd", "why?")}))
    assert silent.head == ("match", "pair", "set", "correct", "wrong", "unsure")
    assert loud.head[3] == "comments"
    assert [row[3] for row in loud.rows] == ["odd | why?", "", ""]
    assert (silent.words, loud.words) == (3, 4)
    assert [row[:3] + row[4:] for row in loud.rows] == silent.rows


def test_figures_of_pairs_held_out_are_not_said_to_flatter():
    """Parameters that were chosen on the other pairs are judged fairly on these."""
    results = [ran(method, pair, f"{pair}a {pair}b") for method in "mn" for pair in "pqr"]
    parts = split(read(results, cast(**{f"{pair}{end}": "ccw" for pair in "pqr" for end in "ab"})), 1)
    held, others = ({t.title: t.remark for t in tables(worked_out(part, chosen=["n"]))} for part in parts[:2])
    for title, fair, flatters in (
        ("Precision of methods whose parameters or results were chosen with help", "are fair", "such figures flatter"),
        ("How far the figures hang on single volunteers", "fair if these pairs", "the figure flatters"),
    ):
        assert fair in held[title]
        assert flatters not in held[title]
        assert flatters in others[title]
        assert fair not in others[title]


def test_alpha_that_is_not_defined_is_said_so():
    (table,) = tables(worked_out(read([ran("m", "p", "a b")], cast(a="cc", b="cc"))), "agreement")
    assert table.rows == [("all matches", "2", "4", "100.0", "not defined")]


def test_nothing_judged_has_a_table_that_says_so():
    (table, *others) = tables(worked_out(read([], [])))
    assert "no results yet" in table.remark
    assert [t.title for t in others] == ["Agreement"]


@pytest.mark.parametrize("number", [0, 1, 2, 3])
def test_the_preset_prints_the_eight_numbers_of_tables_3_1_and_3_2(number):
    """Every pair of a set has the set's percentage of 1000 votes; the averages come out as printed in the thesis."""
    percentages, pairs, mean, deviation = [
        ([85.2, 86.0, 86.2, 83.5], [30, 20, 11, 11], "85.315", "1.228"),
        ([76.7, 63.0, 71.3, 60.8], [30, 20, 11, 11], "69.640", "7.380"),
        ([97.2, 83.3, 85.3, 90.9], [3, 7, 6, 4], "87.505", "6.243"),
        ([59.0, 62.7, 81.6, 67.5], [3, 7, 6, 4], "68.775", "9.898"),
    ][number]
    results, votes = [], []
    for s, (percentage, count) in enumerate(zip(percentages, pairs, strict=True)):
        items = [f"{s}.{k}" for k in range(1000)]
        results += [ran("method", f"{s}/{p}", " ".join(items[p::count]), f"set {s}") for p in range(count)]
        votes += [Ballot(item, "anna", "correct" if k < round(10 * percentage) else "wrong") for k, item in enumerate(items)]
    (table,) = tables(worked_out(read(results, votes), preset="thesis"), "precision")
    assert table.head == ("set", "method", "pairs", "layers")
    assert [row[1] for row in table.rows[:4]] == [f"{percentage:.1f} %" for percentage in percentages]
    assert [row[2] for row in table.rows[:4]] == [str(count) for count in pairs]
    assert table.rows[4][1] == f"{mean} % ({deviation})"
    *_, row = csv.DictReader(io.StringIO(as_csv(values(worked_out(read(results, votes), preset="thesis")))))
    assert (row["set"], f"{100 * float(row['precision']):.3f}", f"{100 * float(row['deviation']):.3f}") == ("(average)", mean, deviation)


def test_csv_of_each_section_has_its_columns_and_safe_cells():
    found = worked_out(read([ran("=m", "p", "a b")], cast(a="ccw", b="cww")))
    for section in ("precision", "recall", "agreement", "volunteers", "compared", "sensitivity", "disputed"):
        head, rows = values(found, section)
        assert all(len(row) == len(head) for row in rows), section
        assert len(set(head)) == len(head)
    (row,) = csv.DictReader(io.StringIO(as_csv(values(found))))
    assert row["method"] == "'=m"
    assert float(row["micro_precision"]) == 0.5
    assert values(found, "all") == values(found, "precision")
    head, rows = values(worked_out(read(RESULTS, VOTES), preset="thesis"))
    assert (head[0], rows[0]) == ("method", ("m", "lamps", 0.5, 1, None, None))


def test_text_markdown_and_latex_have_every_table():
    listed = tables(worked_out(read(RESULTS, VOTES)))
    text, markdown, latex = (written("Lamps & vases", listed, style) for style in ("text", "markdown", "latex"))
    for table in listed:
        assert table.title in text
        assert f"## {table.title}" in markdown
        assert table.title in latex
    assert latex.startswith("% Lamps & vases")
    assert latex.count(r"\begin{tabular}") == latex.count(r"\end{tabular}") >= len(listed)


def test_a_page_needs_no_other_file_and_shows_strangers_words_as_text():
    evil = "<script>alert(1)</script>"
    found = worked_out(read([ran(evil, "p", "a b"), ran("n", "p", "a")], cast(a="cw", b="cc"), comments={"a": (evil,)}))
    page = as_html(found, evil, tables(found), Drawn([(evil, b"\x89PNG")], ("No picture.",)))
    assert "<script" not in page
    assert not re.search(r'(?:src|href)="(?!data:)', page)
    assert page.count("<svg") == 1
    assert "No picture." in page
    assert page.startswith("<!doctype html>")


def test_the_chart_draws_each_known_row_where_its_figures_are():
    rows = worked_out(read([ran("m", "p", "a b c d"), ran("n", "p", "x")], cast(a="c", b="w", c="c"))).rows
    chart = precision_chart(rows)
    assert chart.count("<circle") == 1
    assert f'cx="{330 + 460 * 2 / 3:.1f}"' in chart
    assert f'x1="{330 + 460 * 2 / 4:.1f}" x2="{330 + 460 * 3 / 4:.1f}"' in chart
    assert precision_chart([]) == ""


def test_pairs_held_out_and_the_others_make_up_all():
    votes = read([ran(m, p, f"{p}x") for m in "mn" for p in "abcdef"], [])
    held, others, names = split(votes, 2, seed=5)
    pairs = [{r.pair for r in part.results} for part in (held, others)]
    assert (len(pairs[0]), len(pairs[1]), pairs[0] & pairs[1]) == (2, 4, set())
    assert set(names) == pairs[0]
    assert split(votes._replace(results=votes.results[::-1]), 2, seed=5).names == names
    assert {split(votes, 2, seed=s).names for s in range(9)} != {names}
    for bad in (0, 6, -1):
        with pytest.raises(BadParameter, match="of 6 pairs cannot be held out"):
            split(votes, bad)


def test_wide_tables_are_split_with_their_words_repeated():
    table = Table("Wide", ("method", "one", "two", "three"), [("m", "1" * 10, "2" * 10, "3" * 10)], 1, "remark")
    assert split_wide(table, 100) == [table]
    first, second = split_wide(table, 32)
    assert first == Table("Wide (1 of 2)", ("method", "one", "two"), [("m", "1" * 10, "2" * 10)], 1, "")
    assert (second.head, second.remark) == (("method", "three"), "remark")


def test_comments_are_one_short_line_and_commands_to_a_terminal_are_blanks():
    said = ("two\nlines\x1b[2J", "word " * 40)
    found = worked_out(read([ran("m", "p", "a")], cast(a="cw"), comments={"a": said}))
    text = written("Lamps\x1b[31m", tables(found, "disputed"), "text")
    assert "\x1b" not in text
    assert "two lines [2J | word word" in text
    assert max(map(len, text.splitlines())) < 140
    assert "word " * 39 in as_csv(values(found, "disputed"))


def test_a_narrow_terminal_gets_narrow_tables():
    listed = tables(worked_out(read(RESULTS, VOTES)), "precision")
    wide, narrow = (written("Lamps", listed, "text", width) for width in (0, 80))
    assert max(map(len, narrow.splitlines())) <= 80 < max(map(len, wide.splitlines()))
    assert "(1 of 3)" in narrow


def test_an_adaptive_study_says_whether_some_matches_got_all_votes():
    told = [tables(worked_out(read(RESULTS, VOTES, adaptive=True, overlapped=frozenset(twice))), "agreement")[0].remark
            for twice in ("ab", "")]  # fmt: skip
    assert "figure to quote" in told[0]
    assert "no match was marked" in told[1]
