"""The plot as a figure: what it shows, the kinds of files, and what it refuses."""

import pytest
from research_world import judged_study

from annotation.findings.precision import precision_table
from annotation.study import create_study, open_study
from engine.errors import BadInput
from gui.pages.plots import Mark, colour_of
from gui.pages.results.figure import MARKERS, drawn, figure_bytes
from gui.pages.results.precision import marks
from gui.pages.study import work

MARKS = [Mark("vases", "a", 0.5, 0.3, 0.9, 0.4, 0.6), Mark("vases", "b", 0.75), Mark("lamps", "a", 0.25, 0.1, 0.4)]
STARTS = {"svg": b"<?xml", "pdf": b"%PDF", "png": b"\x89PNG"}


def test_every_mark_its_interval_and_its_bounds_are_drawn_in_per_cent():
    figure = drawn(MARKS)
    (axes,) = figure.axes
    assert [float(line.get_ydata()[0]) for line in axes.lines] == [50, 75, 25]
    assert [line.get_color() for line in axes.lines] == [colour_of(0), colour_of(1), colour_of(0)]
    ends = sorted(tuple(part.get_segments()[0][:, 1]) for part in axes.collections)
    assert ends == [(10, 40), (30, 90), (40, 60)]
    assert [label.get_text() for label in axes.get_xticklabels()] == ["vases", "lamps"]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["a", "b"]
    assert axes.get_ylim()[0] == 0


@pytest.mark.parametrize("ending", STARTS)
def test_a_figure_is_written_in_each_kind_and_twice_the_same(tmp_path, make_bar, ending):
    judged_study(tmp_path / "bars.db", make_bar, {"anna": dict.fromkeys(range(5), "correct")}, votes=2, gold=0.0, practice=0)
    with open_study(tmp_path / "bars.db") as handle:
        told = work.figure(handle, lambda *_: None, tmp_path / f"plot.{ending.upper()}")
        assert marks(precision_table(handle))
    written = (tmp_path / f"plot.{ending.upper()}").read_bytes()
    assert written.startswith(STARTS[ending])
    assert told.endswith(f"plot.{ending.upper()}")
    if ending == "svg":
        assert figure_bytes(MARKS, "svg") == figure_bytes(MARKS, "svg")
        assert b"precision" in written or b"<path" in written


def test_another_kind_of_file_and_an_empty_study_are_refused_in_a_sentence(tmp_path):
    with pytest.raises(BadInput, match=r"\.svg, \.pdf or \.png"):
        figure_bytes(MARKS, "jpg")
    with create_study(tmp_path / "e.db", name="e") as handle, pytest.raises(BadInput, match="nothing to draw"):
        work.figure(handle, lambda *_: None, tmp_path / "plot.svg")
    assert not (tmp_path / "plot.svg").exists()


def test_every_symbol_of_the_window_has_one_on_paper():
    from gui.pages.plots import SYMBOLS

    assert set(MARKERS) == {name for name, _ in SYMBOLS}
