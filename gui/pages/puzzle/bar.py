"""The bar below the puzzle canvas: Solve, which joins are drawn, the truth, the view."""

from PySide6.QtCore import QRectF, Qt, Signal
from PySide6.QtGui import QColor, QLinearGradient, QPainter, QPaintEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QSlider, QWidget

from ...palette import LIGHT, Theme
from ...views.puzzle_painting import painting
from ...views.puzzle_scene import BINS, bin_colours
from ..shapes.arrange import share_text
from .state import PuzzleState


class Legend(QWidget):
    """The colours from doubtful to certain."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.theme = LIGHT
        self.setFixedSize(64, 10)
        self.setToolTip("Colours of the joins, from doubtful to certain")

    def paintEvent(self, event: QPaintEvent) -> None:
        gradient = QLinearGradient(0, 0, self.width(), 0)
        for k, colour in enumerate(bin_colours(self.theme).tolist()):
            gradient.setColorAt(k / (BINS - 1), QColor(*colour))
        with painting(self) as painter:
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(gradient)
            painter.drawRoundedRect(QRectF(self.rect()), 4, 4)


class PuzzleBar(QWidget):
    """Says what a hand did; displays what it is told."""

    solve = Signal()
    below = Signal(float)
    truth = Signal(bool)
    fit = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.solve_button = QPushButton("Solve", self, toolTip="Put the pieces together, around what is locked (F5)")
        self.solve_button.setObjectName("primary")
        self.solve_button.clicked.connect(lambda _=False: self.solve.emit())
        self.words, self.value = QLabel("Show joins below", self), QLabel("", self)
        self.slider = QSlider(Qt.Orientation.Horizontal, self)
        self.slider.setRange(0, 100)
        self.slider.setFixedWidth(150)
        self.slider.setToolTip("Hides the certain joins: only those less certain than this are drawn")
        self.slider.setAccessibleName("Show joins below a confidence")
        self.slider.valueChanged.connect(lambda at: self.below.emit(at / 100))
        self.value.setFixedWidth(36)
        self.legend = Legend(self)
        self.doubtful, self.certain = QLabel("doubtful", self), QLabel("certain", self)
        for label in (self.words, self.doubtful, self.certain):
            label.setObjectName("soft")
        self.truth_button = QPushButton("Truth", self, checkable=True, toolTip="Mark what is not where it was cut from (T)")
        self.truth_button.toggled.connect(self.truth)
        self.fit_button = QPushButton("Fit", self, toolTip="Show everything (R)")
        self.fit_button.clicked.connect(lambda _=False: self.fit.emit())
        for widget in (self.solve_button, self.slider, self.truth_button, self.fit_button):
            widget.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        row = QHBoxLayout(self)
        row.setContentsMargins(8, 6, 8, 6)
        row.setSpacing(8)
        row.addWidget(self.solve_button)
        row.addSpacing(12)
        for widget in (self.words, self.slider, self.value, self.doubtful, self.legend, self.certain):
            row.addWidget(widget)
        row.addStretch(1)
        row.addWidget(self.truth_button)
        row.addWidget(self.fit_button)

    def set_theme(self, theme: Theme) -> None:
        """Take other colours."""
        self.legend.theme = theme
        self.solve_button.setStyleSheet(
            f"QPushButton {{ background: {theme.accent}; color: {theme.on_accent}; border-color: {theme.accent};"
            f" padding: 5px 20px; font-weight: 600; }}"
            f"QPushButton:disabled {{ background: {theme.panel}; color: {theme.soft_ink}; border-color: {theme.line}; }}"
            f"QPushButton:focus {{ border: 2px solid {theme.ink}; padding: 4px 19px; }}"
        )
        self.legend.update()

    def show_state(self, state: PuzzleState, busy: bool) -> None:
        """Display a state."""
        joins = state.solution is not None and len(state.solution.joins) > 0
        self.solve_button.setEnabled(state.puzzle is not None and not busy)
        self.solve_button.setText("Solving …" if busy else "Solve again" if state.asked else "Solve")
        before = self.slider.blockSignals(True)
        self.slider.setValue(round(100 * state.below))
        self.slider.blockSignals(before)
        self.value.setText("all" if state.below >= 1 else share_text(state.below))
        for widget in (self.words, self.slider, self.value, self.legend, self.doubtful, self.certain):
            widget.setEnabled(joins)
        before = self.truth_button.blockSignals(True)
        self.truth_button.setChecked(state.overlay)
        self.truth_button.blockSignals(before)
        self.truth_button.setVisible(state.truth is not None)
        self.truth_button.setEnabled(state.marks is not None)
        self.fit_button.setEnabled(state.puzzle is not None)
