"""A group of declared parameters as a form: one row each, made from the declaration alone."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from PySide6.QtCore import QEvent, QObject, Qt, QTimer, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QGridLayout,
    QLabel,
    QSizePolicy,
    QSlider,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from engine.parameters import ParameterInfo, Parameters, declared

LONGEST_SLIDER = 100_000
_SPELLED = {"δ": "delta", "σ": "sigma", "₀": "_0", "₁": "_1", "₂": "_2", "₃": "_3"}


@dataclass(frozen=True, slots=True)
class Scale:
    """The positions 0..`steps` of a slider and the values low..high that they stand for."""

    low: float
    high: float
    step: float
    whole: bool

    @property
    def steps(self) -> int:
        """Number of steps from low to high."""
        return max(1, round((self.high - self.low) / self.step))

    @property
    def decimals(self) -> int:
        """Digits after the point that the step needs."""
        return 0 if self.whole else max(0, math.ceil(-math.log10(self.step) - 1e-9))

    def value(self, position: int) -> float | int:
        """The value at a position, inside the range."""
        exact = min(self.high, max(self.low, self.low + position * self.step))
        return round(exact) if self.whole else round(exact, self.decimals)

    def position(self, value: float) -> int:
        """The position nearest to a value."""
        return min(self.steps, max(0, round((value - self.low) / self.step)))


def scale(info: ParameterInfo) -> Scale | None:
    """The scale of a number with a range; None for a switch, a choice or an open range."""
    if info.kind not in ("real", "integer") or info.low is None or info.high is None:
        return None
    step = info.step or (1 if info.kind == "integer" else (info.high - info.low) / 100)
    return Scale(info.low, info.high, step, info.kind == "integer")


def caption(info: ParameterInfo) -> str:
    """Symbol and name as a row shows them; the name alone where there is no symbol, once where both are the same."""
    words = info.name.replace("_", " ")
    spelled = "".join(_SPELLED.get(letter, letter) for letter in info.symbol)
    if not info.symbol:
        return words
    return info.symbol if spelled == info.name else f"{info.symbol}  {words}"


def help_text(info: ParameterInfo, reference: Any) -> str:
    """What hovering says: the sentence, the equation, the range, the preset's value and what a change costs."""
    where = info.source
    unit = f" {info.unit}" if info.unit else ""
    bounds = f"{info.low:g} to {info.high:g}{unit}" if info.low is not None and info.high is not None else ""
    cost = "Followed while you move it." if info.live else "Computed anew when you let go."
    facts = " · ".join(text for text in (where, bounds, f"preset: {reference}") if text)
    return f"<p style='white-space:pre-wrap'><b>{caption(info)}</b><br>{info.doc}<br><i>{facts}</i><br>{cost}</p>"


def applies(info: ParameterInfo, method: str) -> bool:
    """Whether a method uses the parameter."""
    return not info.methods or method in info.methods


class _Row(QObject):
    """The widgets of one parameter: dot and caption, editor, reset."""

    edited = Signal(str, object, bool)
    """name, value, whether the hand has left it"""

    def __init__(self, info: ParameterInfo, parent: QWidget) -> None:
        super().__init__(parent)
        self.info, self.scale, self.value, self.reference = info, scale(info), info.default, info.default
        self.caption = QLabel(caption(info), parent)
        self.dot = QLabel("", parent)
        self.dot.setObjectName("changed-dot")
        self.dot.setFixedWidth(10)
        self.reset = QToolButton(parent, text="↺", autoRaise=True)
        self.reset.setFixedSize(22, 22)
        self.reset.clicked.connect(lambda: self.edited.emit(info.name, self.reference, True))
        self.slider: QSlider | None = None
        self.editor: QWidget = self._editor(parent)
        for widget in (self.editor, self.reset, *([self.slider] if self.slider else [])):
            widget.setAccessibleName(info.name.replace("_", " "))
            widget.installEventFilter(self)
        self.timer = QTimer(self, singleShot=True, interval=15)
        self.timer.timeout.connect(self._live)

    def _editor(self, parent: QWidget) -> QWidget:
        info = self.info
        if info.kind == "switch":
            box = QCheckBox(parent)
            box.toggled.connect(lambda on: info.name and self.edited.emit(info.name, on, True))
            return box
        if info.kind == "choice":
            combo = QComboBox(parent)
            combo.addItems([str(choice) for choice in info.choices])
            combo.currentTextChanged.connect(lambda text: self.edited.emit(info.name, text, True))
            combo.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            return combo
        return self._number(parent)

    def _number(self, parent: QWidget) -> QDoubleSpinBox:
        info, scale_ = self.info, self.scale
        box = QDoubleSpinBox(parent, decimals=scale_.decimals if scale_ else 3, keyboardTracking=False)
        box.setRange(*((info.low, info.high) if scale_ else (-1e12, 1e12)))
        box.setSingleStep(scale_.step if scale_ else 1)
        box.setButtonSymbols(QDoubleSpinBox.ButtonSymbols.NoButtons)
        box.setAlignment(Qt.AlignmentFlag.AlignRight)
        box.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        box.valueChanged.connect(self._typed)
        box.lineEdit().returnPressed.connect(box.clearFocus)  # letters judge again once a number is entered
        if scale_ and scale_.steps <= LONGEST_SLIDER:
            box.setFixedWidth(58)
            self.slider = QSlider(Qt.Orientation.Horizontal, parent)
            self.slider.setRange(0, scale_.steps)
            self.slider.setPageStep(max(1, scale_.steps // 10))
            self.slider.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            self.slider.setMinimumWidth(72)
            self.slider.valueChanged.connect(self._moved)
            self.slider.sliderReleased.connect(self._released)
        return box

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """A wheel that scrolls the page over a row must not change its value."""
        if event.type() == QEvent.Type.Wheel and not watched.hasFocus():
            event.ignore()
            return True
        return False

    def _typed(self, number: float) -> None:
        value = round(number) if self.info.kind == "integer" else number
        self.edited.emit(self.info.name, value, True)

    def _moved(self, position: int) -> None:
        self._show_number(self.scale.value(position))
        if not self.slider.isSliderDown():
            self.edited.emit(self.info.name, self.scale.value(position), True)
        elif self.info.live:
            self.timer.start() if not self.timer.isActive() else None

    def _live(self) -> None:
        self.edited.emit(self.info.name, self.scale.value(self.slider.value()), not self.slider.isSliderDown())

    def _released(self) -> None:
        self.timer.stop()
        self.edited.emit(self.info.name, self.scale.value(self.slider.value()), True)

    def _show_number(self, value: float) -> None:
        before = self.editor.blockSignals(True)
        self.editor.setValue(value)
        self.editor.blockSignals(before)

    def show(self, value: Any, reference: Any) -> None:
        """Display a value without telling anybody; `reference` is the preset's."""
        self.value, self.reference = value, reference
        differs = value != reference
        self.dot.setText("●" if differs else "")
        self.reset.setEnabled(differs)
        self.reset.setToolTip(f"Back to {reference}" if differs else "")
        for widget in (self.caption, self.editor, *([self.slider] if self.slider else [])):
            widget.setToolTip(help_text(self.info, reference))
        if isinstance(self.editor, QDoubleSpinBox) and self.slider and self.slider.isSliderDown():
            return
        before = self.editor.blockSignals(True)
        if isinstance(self.editor, QCheckBox):
            self.editor.setChecked(value)
        elif isinstance(self.editor, QComboBox):
            self.editor.setCurrentText(str(value))
        else:
            self.editor.setValue(value)
        self.editor.blockSignals(before)
        if self.slider:
            before = self.slider.blockSignals(True)
            self.slider.setValue(self.scale.position(value))
            self.slider.blockSignals(before)

    def set_visible(self, on: bool) -> None:
        """Show or hide the whole row."""
        for widget in (self.dot, self.caption, self.editor, self.reset, *([self.slider] if self.slider else [])):
            widget.setVisible(on)


def live_groups_first(infos: Sequence[ParameterInfo]) -> list[ParameterInfo]:
    """The parameters by group, groups that follow while a slider moves before those that cost a whole run."""
    groups: dict[str, list[ParameterInfo]] = {}
    for info in infos:
        groups.setdefault(info.group, []).append(info)
    return [info for group in sorted(groups.values(), key=lambda group: not any(i.live for i in group)) for info in group]


class ParameterForm(QWidget):
    """All rows of a model under the headings of their steps; only those that the current method uses are visible.

    The form owns no value: it says what a hand did (`edited`) and displays what it is told (`show_values`).
    """

    edited = Signal(str, object, bool)
    """name, value, whether the hand has left it"""

    def __init__(self, model: type[Parameters], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.rows: dict[str, _Row] = {}
        self._heads: dict[str, tuple[QLabel, list[_Row]]] = {}
        grid = QGridLayout()
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(4)
        grid.setVerticalSpacing(2)
        grid.setColumnStretch(2, 1)
        for info in live_groups_first(declared(model)):
            self._add(grid, info)
        outer = QVBoxLayout(self)
        outer.setContentsMargins(8, 4, 8, 8)
        outer.addLayout(grid)
        outer.addStretch(1)
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)

    def _add(self, grid: QGridLayout, info: ParameterInfo) -> None:
        if info.group not in self._heads:
            head = QLabel(info.group, self)
            head.setObjectName("group-heading")
            head.setContentsMargins(0, 8 if self._heads else 0, 0, 2)
            grid.addWidget(head, grid.rowCount(), 0, 1, 5)
            self._heads[info.group] = (head, [])
        row = self.rows[info.name] = _Row(info, self)
        line = grid.rowCount()
        grid.addWidget(row.dot, line, 0)
        grid.addWidget(row.caption, line, 1)
        if row.slider:
            grid.addWidget(row.slider, line, 2)
            grid.addWidget(row.editor, line, 3)
        else:
            grid.addWidget(row.editor, line, 2, 1, 2)
        grid.addWidget(row.reset, line, 4)
        self._heads[info.group][1].append(row)
        row.edited.connect(self.edited)

    def show_values(self, parameters: Parameters, reference: Parameters) -> None:
        """Display parameters beside those of the preset they are compared with; tells nobody."""
        values, presets = parameters.model_dump(), reference.model_dump()
        method = str(values.get("method", ""))
        for name, row in self.rows.items():
            row.show(values[name], presets[name])
            row.set_visible(applies(row.info, method))
        for head, rows in self._heads.values():
            head.setVisible(any(applies(row.info, method) for row in rows))

    def visible_names(self) -> Iterable[str]:
        """Names of the rows that the current method uses."""
        return [name for name, row in self.rows.items() if not row.caption.isHidden()]
