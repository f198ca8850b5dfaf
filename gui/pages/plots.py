"""Live plots of shares with their intervals. The plotting library is imported with the first plot that is shown."""

from collections.abc import Sequence
from html import escape
from typing import Any, NamedTuple

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QResizeEvent
from PySide6.QtWidgets import QVBoxLayout, QWidget

from ..palette import SERIES, Theme, theme

SYMBOLS = (("o", "●"), ("s", "■"), ("t1", "▲"), ("d", "◆"), ("t", "▼"), ("star", "★"), ("p", "⬟"), ("h", "⬢"))
LETTER, MARGIN = 8, 60  # pixels: of a letter of the axis at most, and left of the first group
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
    there = {mark[:2] for mark in marks}
    beside = {group: {name: k for k, name in enumerate(name for name in series if (group, name) in there)} for group in groups}
    column, row = ({name: k for k, name in enumerate(some)} for some in (groups, series))

    def at(mark: Mark) -> float:
        here = beside[mark.group]
        return column[mark.group] + step * (here[mark.series] - (len(here) - 1) / 2)

    return [(at(mark), row[mark.series], mark) for mark in marks]


def names(marks: Sequence[Mark]) -> tuple[list[str], list[str]]:
    """Groups and series in the order in which they come."""
    return list(dict.fromkeys(m.group for m in marks)), list(dict.fromkeys(m.series for m in marks))


def legend(marks: Sequence[Mark]) -> str:
    """Symbol and name of each series, as rich text."""
    _, series = names(marks)
    return " &nbsp;&nbsp; ".join(
        f"<span style='color: {colour_of(row)}'>{symbol_of(row)[1]}</span>&nbsp;{escape(name)}"
        for row, name in enumerate(series))  # fmt: skip


def colour_of(row: int) -> str:
    """The colour of a series."""
    return SERIES[row % len(SERIES)]


def symbol_of(row: int) -> tuple[str, str]:
    """The symbol of a series, to draw and to write; with more series than colours, another one comes with each colour."""
    return SYMBOLS[(row + row // len(SERIES)) % len(SYMBOLS)]


def shortened(names: Sequence[str], room: float) -> list[str]:
    """Names that stand beside each other in `room` pixels without touching; the middle of a long one is left out."""
    most = max(3, int(room / max(1, len(names)) / LETTER) - 1)
    return [name if len(name) <= most else name[: most - most // 2 - 1] + "…" + name[len(name) - most // 2 :] for name in names]


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
        marks = placed(self.marks)
        for row in range(len(series)):
            self._series(item, row, [(x, m) for x, k, m in marks if k == row], colours)

    def _axes(self, item: Any, groups: list[str], colours: Theme) -> None:
        self.plot.setBackground(colours.paper)
        for side in ("left", "bottom"):
            axis = item.getAxis(side)
            axis.setPen(colours.line)
            axis.setTextPen(colours.soft_ink)
        self._name_groups(groups)
        item.getAxis("left").setTicks([[(k / 5, f"{20 * k}") for k in range(6)]])
        item.setLabel("left", self.axis, color=colours.soft_ink)
        item.showGrid(y=True, alpha=0.25)
        item.setXRange(-0.6, len(groups) - 0.4, padding=0)
        item.setYRange(-0.05, 1.05, padding=0)

    def _name_groups(self, groups: Sequence[str]) -> None:
        shown = shortened([group or "–" for group in groups], self.plot.width() - MARGIN)
        self.plot.getPlotItem().getAxis("bottom").setTicks([list(enumerate(shown))])

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if self.plot is not None:
            self._name_groups(names(self.marks)[0])

    def _series(self, item: Any, row: int, points: list[tuple[float, Mark]], colours: Theme) -> None:
        import pyqtgraph

        colour = QColor(colour_of(row))
        band = QColor(colour)
        band.setAlpha(60)
        bands = [(x, m.bound_low, m.bound_high) for x, m in points if m.bound_low is not None and m.bound_high is not None]
        lines = [(x, m.low, m.high) for x, m in points if m.low is not None and m.high is not None]
        for bars, width, shade in ((bands, 9, band), (lines, 2, colour)):
            if bars:  # one item for all of a series: each item costs as much as a whole curve
                pen = pyqtgraph.mkPen(shade, width=width * self.devicePixelRatioF())  # pyqtgraph counts pixels of the screen
                pen.setCapStyle(Qt.PenCapStyle.FlatCap)
                item.plot([x for x, _, _ in bars for _ in range(2)], [y for _, *ends in bars for y in ends], connect="pairs", pen=pen)
        item.plot([x for x, _ in points], [m.share for _, m in points], pen=None, symbol=symbol_of(row)[0],
                  symbolSize=9, symbolBrush=colour, symbolPen=colours.paper)  # fmt: skip

    def shutdown(self) -> None:
        """Give the scene back before the window goes."""
        if self.plot is not None:
            self.plot.close()
            self.plot.deleteLater()
            self.plot = None
