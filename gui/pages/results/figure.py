"""The plot of precision as a figure for a paper: the colours and symbols of the window on white, in SVG, PDF or PNG."""

from collections.abc import Sequence
from io import BytesIO
from typing import Any

from engine.errors import BadInput

from ...palette import LIGHT
from ..plots import Mark, colour_of, names, placed, symbol_of

ENDINGS = ("svg", "pdf", "png")
MARKERS = {"o": "o", "s": "s", "t1": "^", "d": "D", "t": "v", "star": "*", "p": "p", "h": "h"}  # by the live plot's names
LEAST_WIDTH, MOST_WIDTH, HEIGHT = 5.0, 24.0, 3.2  # inches; 5 are a column and a half of most papers
ROOM = 0.22  # inches for each mark
LEVEL = 7  # letters: names of sets that are longer are set at an angle where there are many


def figure_bytes(marks: Sequence[Mark], ending: str) -> bytes:
    """The file of a figure; raises `BadInput` for another kind of file, and where nothing is decided."""
    if ending not in ENDINGS:
        raise BadInput(f"A figure is written as .svg, .pdf or .png, not as .{ending}; choose one of these endings.")
    if not marks:
        raise BadInput("No match is decided in this study yet, so there is nothing to draw.")
    import matplotlib

    written = BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "concord", "pdf.fonttype": 42, "font.size": 9, "axes.edgecolor": LIGHT.soft_ink}):
        drawn(marks).savefig(written, format=ending, dpi=300, metadata={"Date": None} if ending == "svg" else None)
    return written.getvalue()


def drawn(marks: Sequence[Mark]) -> Any:
    """The figure: groups beside each other, in each a symbol with its 95 % interval for every series, and bounds as bands."""
    from matplotlib.figure import Figure

    groups, series = names(marks)
    width = min(MOST_WIDTH, max(LEAST_WIDTH, ROOM * len(marks) + 1))
    figure = Figure(figsize=(width, HEIGHT + 0.16 * (len(series) // 4)), layout="constrained")
    axes = figure.add_subplot()
    for x, row, mark in placed(marks):
        colour = colour_of(row)
        if mark.bound_low is not None and mark.bound_high is not None:
            axes.vlines(x, 100 * mark.bound_low, 100 * mark.bound_high, color=colour, alpha=0.25, linewidth=5)
        if mark.low is not None and mark.high is not None:
            axes.vlines(x, 100 * mark.low, 100 * mark.high, color=colour, linewidth=1.2)
        axes.plot(x, 100 * mark.share, MARKERS[symbol_of(row)[0]], color=colour, markersize=5, markeredgecolor="white",
                  markeredgewidth=0.6, label=series[row])  # fmt: skip
    _axes(axes, groups)
    shown = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))  # each series once
    figure.legend([shown[name] for name in series], series, loc="outside upper left", ncols=min(4, len(series)), frameon=False)
    return figure


def _axes(axes: Any, groups: Sequence[str]) -> None:
    steep = len(groups) > 5 and max(map(len, groups)) > LEVEL
    axes.set_xticks(range(len(groups)), [group or "–" for group in groups], rotation=30 if steep else 0,
                    ha="right" if steep else "center")  # fmt: skip
    axes.set_xlim(-0.6, len(groups) - 0.4)
    axes.set_ylim(0, 102)
    axes.set_ylabel("precision, % (95 % interval)")
    axes.grid(axis="y", color=LIGHT.line, linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
