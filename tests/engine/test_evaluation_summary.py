"""Figures of methods on sets, counted by hand, and their tables."""

import csv
import io
import math

import pytest

from engine.evaluation.averages import thesis_average
from engine.evaluation.ceiling import Ceiling
from engine.evaluation.correspondence import Evaluation, SizeClass
from engine.evaluation.intervals import clustered_interval, ratio_interval
from engine.evaluation.sheets import PAIR_HEAD, SET_HEAD, TEST_HEAD, comparison_values, pair_values, set_values, tables
from engine.evaluation.summary import ALL_SETS, Judged, comparison_rows, set_row, set_rows
from engine.evaluation.tables import Table, percent, to_csv, to_latex, to_markdown
from engine.evaluation.thesis_tables import SetPrecision, thesis_table


def judged(pair, judged=4, lenient=3, right=1.0, covered=2.0, total=4.0, area=5.0, set_name="lamps", method="a", failure=""):
    """A pair with as many matches, so many of them right, and these areas."""
    chance = 0.5 if judged else float("nan")
    sizes = (SizeClass("1", judged, lenient, lenient),) if judged else ()
    figures = Evaluation(judged, lenient, lenient, chance, chance, right, covered, total, sizes)
    most = Ceiling(True, True, 0.8 * total, total, 0.9 * area, area, area)
    return Judged(set_name, pair, method, None if failure else figures, None if failure else most, 2.0, failure)


def empty(pair):
    return judged(pair, judged=0, lenient=0, right=0.0, covered=0.0)


def test_macro_is_the_mean_of_pairs_and_micro_pools_the_matches():
    row = set_row("a", "lamps", [judged("1", 4, 3), judged("2", 1, 0)])
    assert row.lenient == pytest.approx((3 / 5, (3 / 4 + 0) / 2))
    assert row.lenient_interval == clustered_interval([3, 0], [4, 1])
    assert (row.matches, row.pairs, row.failed, row.empty) == (5, 2, 0, 0)
    assert row.chance_lenient == pytest.approx((0.5, 0.5))


def test_a_pair_without_a_match_has_no_precision_but_a_recall_of_zero():
    row = set_row("a", "lamps", [judged("1"), empty("2")])
    assert row.lenient.macro == row.lenient.micro == pytest.approx(3 / 4)
    assert row.transfer_precision.macro == pytest.approx(1 / 2)
    assert row.transfer_recall.macro == pytest.approx((1 / 4 + 0) / 2)
    assert row.empty == 1
    assert row.chance_lenient.macro == pytest.approx(0.5)


def test_a_pair_that_failed_is_in_no_figure_but_counted():
    row = set_row("a", "lamps", [judged("1"), judged("2", failure="no")])
    assert (row.pairs, row.failed) == (2, 1)
    assert row.transfer_recall.macro == pytest.approx(1 / 4)


def test_large_meshes_weigh_no_more_than_small_ones():
    small = judged("1", right=1.0, covered=2.0, total=2.0, area=2.0)
    large = judged("2", right=2e6, covered=2e6, total=2e6, area=2e6)
    row = set_row("a", "lamps", [small, large])
    assert row.transfer_precision.micro == pytest.approx(3 / 4)
    assert row.transfer_precision_interval == ratio_interval([0.5, 1], [1, 1])


def test_rows_of_several_sets_end_with_one_over_all():
    rows = set_rows([judged("1"), judged("1", 4, 1, set_name="vases")])
    assert [(r.set_name, r.pairs) for r in rows] == [("lamps", 1), ("vases", 1), (ALL_SETS, 2)]
    assert [r.method for r in set_rows([judged("1"), judged("1", method="b"), judged("1", set_name="vases")])] == ["a", "b"] * 3
    assert rows[2].lenient.micro == pytest.approx(4 / 8)
    assert len(set_rows([judged("1"), judged("2")])) == 1


def test_methods_are_compared_on_the_pairs_that_both_have():
    first = [judged(str(k), 4, 2) for k in range(8)]
    second = [judged(str(k), 4, 3 + k % 2, method="b") for k in range(6)] + [judged("6", method="b", failure="no")]
    rows = comparison_rows([*first, *second, judged("7", 0, 0, method="b")])
    lenient = next(r for r in rows if r.measure == "lenient precision")
    assert (lenient.method, lenient.against, lenient.test.pairs) == ("b", "a", 6)
    assert lenient.test.difference == pytest.approx((0.25 + 0.5) / 2)
    assert lenient.holm_permutation == lenient.test.permutation == pytest.approx(2 / 2**6)
    assert next(r for r in rows if r.measure == "transfer recall").test.pairs == 7


def test_several_sets_are_adjusted_after_holm():
    sets = ("lamps", "vases")
    rows = [judged(str(k), 4, 2, set_name=s) for s in sets for k in range(6)]
    rows += [judged(str(k), 4, 3 + k % 2, set_name=s, method="b") for s in sets for k in range(6)]
    lenient = [r for r in comparison_rows(rows) if r.measure == "lenient precision"]
    assert [r.set_name for r in lenient] == ["lamps", "vases", ALL_SETS]
    assert lenient[0].holm_permutation == pytest.approx(2 * lenient[0].test.permutation)
    assert lenient[2].holm_permutation == lenient[2].test.permutation


def test_every_line_of_the_files_fits_its_head():
    rows = [judged("1"), empty("2"), judged("3", failure="=no"), judged("1", method="b")]
    assert {len(pair_values(r)) for r in rows} == {len(PAIR_HEAD)}
    assert {len(set_values(r)) for r in set_rows(rows)} == {len(SET_HEAD)}
    assert {len(comparison_values(r)) for r in comparison_rows(rows)} == {len(TEST_HEAD)}
    read = list(csv.DictReader(io.StringIO(to_csv(PAIR_HEAD, map(pair_values, rows)))))
    assert float(read[0]["lenient"]) == 0.75
    assert (read[1]["lenient"], read[1]["transfer_recall"]) == ("", "0")
    assert read[2]["failure"] == "'=no"


def test_tables_for_people_say_what_is_unknown():
    rows = [empty("1"), judged("2", failure="no")]
    means, pooled, sizes = tables(set_rows(rows), comparison_rows(rows))
    assert means.rows[0][2:5] == ("1 (1)", "– (–)", "– (–)")
    assert "could not be matched" in means.remark
    assert pooled.rows[0][2:] == ("0", "–", "–", "–", "–", "–", "0.0")
    assert sizes.rows[0][2:] == ("–", "–", "–")


def test_markdown_and_latex_escape_what_would_break_them():
    table = Table("A & B", ("set", "50 %"), [("a|b_c", "1.0")])
    assert "| a\\|b_c | 1.0 |" in to_markdown([table], "lead", ["note"])
    assert "|---|--:|" in to_markdown([table], "lead")
    latex = to_latex([table], "two\nlines")
    assert r"a|b\_c & 1.0 \\" in latex
    assert r"50 \%" in latex
    assert r"\caption{A \& B.}" in latex
    assert latex.startswith("% two\n% lines\n")
    assert latex.count("\\begin{") == latex.count("\\end{") == 2
    assert r"\endhead" in to_latex([table], "", long=True)
    assert (percent(0.5), percent(None), percent(float("nan"))) == ("50.0", "–", "–")


THESIS = {
    "3.1": ({"lamps": (85.2, 76.7, 30), "vases": (86.0, 63.0, 20), "candles": (86.2, 71.3, 11), "planes": (83.5, 60.8, 11)},
            ("85.3 % (1.2)", "69.6 % (7.4)")),
    "3.2": ({"wolf": (97.2, 59.0, 3), "human": (83.3, 62.7, 7), "horse": (85.3, 81.6, 6), "centaur": (90.9, 67.5, 4)},
            ("87.5 % (6.2)", "68.8 % (9.9)")),
}  # fmt: skip


@pytest.mark.parametrize("number", THESIS)
def test_the_averages_of_the_thesis_come_out(number):
    sets, averages = THESIS[number]
    found = [SetPrecision(method, name, row[k] / 100, row[2], 8) for k, method in enumerate(("MLG", "SHED")) for name, row in sets.items()]
    table = thesis_table(number, found)
    assert table.head == ("set", "MLG", "SHED", "pairs", "layers")
    assert table.rows[-1] == ("average", *averages, "", "")
    for name, *cells in table.rows[:-1]:
        ours, theirs, pairs = sets[name]
        assert cells == [f"{ours:.1f} %", f"{theirs:.1f} %", str(pairs), "8"]


def test_what_is_not_known_is_in_no_average():
    found = [SetPrecision("a", "one", 0.8, 2, 8), SetPrecision("a", "two", float("nan"), 3, 0), SetPrecision("b", "one", 0.5, 1, 8)]
    table = thesis_table("3.1", found)
    assert table.rows == [("one", "80.0 %", "50.0 %", "2, 1", "8"), ("two", "–", "–", "3", "–"), ("average", "80.0 %", "50.0 %", "", "")]
    assert math.isnan(thesis_average([80], [2])[1])
