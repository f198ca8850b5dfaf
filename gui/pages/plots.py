"""Live plots of shares with their intervals. The plotting library is imported with the first plot that is shown."""

from collections.abc import Sequence
from html import escape
from typing import Any, NamedTuple

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QVBoxLayout, QWidget

from ..palette import SERIES, Theme, theme

SYMBOLS = (("o", "●"), ("s", "■"), ("t1", "▲"), ("d", "◆"), ("t", "▼"), ("star", "★"), ("p", "⬟"), ("h", "⬢"))
SPREAD = 0.5  # how much of the room of a group its series take


class Mark(NamedTuple):
    """One share in [0, 1] of a series in a group, with its interval and its bounds where they are known."""

    group: str
    series: str
    share: float
    low: float | None = None
    high: float | None = None
    bound_low: float | None = None
    bound_high: float | None = None


def placed(marks: Sequence[Mark]) -> list[tuple[float, int, Mark]]:
    """Where each mark stands: its abscissa (groups at 0, 1, …; their series side by side), and the row of its series."""
    groups, series = names(marks)
    step = SPREAD / max(1, len(series))
    beside = {group: [name for name in series if any(m[:2] == (group, name) for m in marks)] for group in groups}

    def at(mark: Mark) -> float:
        here = beside[mark.group]
        return groups.index(mark.group) + step * (here.index(mark.series) - (len(here) - 1) / 2)

    return [(at(mark), series.index(mark.series), mark) for mark in marks]


def names(marks: Sequence[Mark]) -> tuple[list[str], list[str]]:
    """Groups and series in the order in which they come."""
    return list(dict.fromkeys(m.group for m in marks)), list(dict.fromkeys(m.series for m in marks))


def legend(marks: Sequence[Mark]) -> str:
    """Symbol and name of each series, as rich text."""
    _, series = names(marks)
    return "&nbsp;&nbsp;&nbsp; ".join(
        f"<span style='color: {SERIES[row % len(SERIES)]}'>{SYMBOLS[row % len(SYMBOLS)][1]}</span> {escape(name)}"
        for row, name in enumerate(series))  # fmt: skip


class IntervalPlot(QWidget):
    """Groups beside each other, in each a dot with its interval for every series; what is only bounded is a pale band."""

    def __init__(self, axis: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.axis, self.dark, self.marks = axis, False, ()
        self.plot = None
        self.column = QVBoxLayout(self)
        self.column.setContentsMargins(0, 0, 0, 0)

    def show_marks(self, marks: Sequence[Mark], dark: bool) -> None:
        """Draw these marks instead of those before."""
        if (tuple(marks), dark) == (self.marks, self.dark) and self.plot is not None:
            return
        self.marks, self.dark = tuple(marks), dark
        if marks or self.plot is not None:
            self._draw()

    def _draw(self) -> None:
        import pyqtgraph

        if self.plot is None:
            self.plot = pyqtgraph.PlotWidget(self)
            self.plot.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            self.plot.setMenuEnabled(False)
            self.plot.setMouseEnabled(False, False)
            self.plot.hideButtons()
            self.column.addWidget(self.plot)
        colours = theme(self.dark)
        item = self.plot.getPlotItem()
        item.clear()
        groups, series = names(self.marks)
        self._axes(item, groups, colours)
        for row in range(len(series)):
            self._series(item, row, colours)

    def _axes(self, item: Any, groups: list[str], colours: Theme) -> None:
        self.plot.setBackground(colours.paper)
        for side in ("left", "bottom"):
            axis = item.getAxis(side)
            axis.setPen(colours.line)
            axis.setTextPen(colours.soft_ink)
        item.getAxis("bottom").setTicks([[(k, group or "–") for k, group in enumerate(groups)]])
        item.getAxis("left").setTicks([[(k / 5, f"{20 * k}") for k in range(6)]])
        item.setLabel("left", self.axis, color=colours.soft_ink)
        item.showGrid(y=True, alpha=0.25)
        item.setXRange(-0.6, len(groups) - 0.4, padding=0)
        item.setYRange(-0.05, 1.05, padding=0)

    def _series(self, item: Any, row: int, colours: Theme) -> None:
        import pyqtgraph

        colour = QColor(SERIES[row % len(SERIES)])
        band = QColor(colour)
        band.setAlpha(60)
        points = [(x, m) for x, k, m in placed(self.marks) if k == row]
        for x, m in points:
            for low, high, width, shade in ((m.bound_low, m.bound_high, 9, band), (m.low, m.high, 2, colour)):
                if low is not None and high is not None:
                    item.plot([x, x], [low, high], pen=pyqtgraph.mkPen(shade, width=width, capStyle=Qt.PenCapStyle.FlatCap))
        item.plot([x for x, _ in points], [m.share for _, m in points], pen=None, symbol=SYMBOLS[row % len(SYMBOLS)][0],
                  symbolSize=9, symbolBrush=colour, symbolPen=colours.paper)  # fmt: skip

    def shutdown(self) -> None:
        """Give the scene back before the window goes."""
        if self.plot is not None:
            self.plot.close()
            self.plot.deleteLater()
            self.plot = None
