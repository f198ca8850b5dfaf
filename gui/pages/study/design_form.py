"""A declared group of values as calm rows: caption, editor, what it means, and below it what is wrong with it."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from PySide6.QtCore import QEvent, QObject, Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPlainTextEdit,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from engine.parameters import ParameterInfo, Parameters, declared

LONG_TEXTS = ("guideline",)
EDITOR_WIDTH = 112


def decimals(step: float) -> int:
    """Digits after the point that a step needs."""
    return max(0, math.ceil(-math.log10(step) - 1e-9))


class Row(QWidget):
    """One value: its caption, the editor, a sentence of help, and a sentence where it is not accepted."""

    edited = Signal(str)

    def __init__(self, info: ParameterInfo, caption: str, compact: bool, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.info, self.text = info, info.kind == "text"
        self.caption = QLabel(caption, self)
        self.caption.setObjectName("field")
        self.help, self.error = QLabel(info.doc, self, wordWrap=True), QLabel("", self, wordWrap=True)
        self.help.setObjectName("soft")
        self.error.setObjectName("field-error")
        self.error.setTextFormat(Qt.TextFormat.PlainText)
        self.error.hide()
        self.editor = self._editor()
        self.editor.setAccessibleName(info.name.replace("_", " "))
        self.editor.installEventFilter(self)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        if info.kind == "switch":
            self.caption.hide()
            self.editor.setText(caption)
            column.addWidget(self.editor)
        elif self.text:
            column.addWidget(self.caption)
            column.addWidget(self.editor)
        else:
            line = QHBoxLayout()
            line.setSpacing(12)
            line.addWidget(self.caption, 1 if compact else 0)
            line.addWidget(self.editor)
            if not compact:
                line.addStretch(1)
            column.addLayout(line)
        if compact:
            self.help.hide()
            for widget in (self.caption, self.editor):
                widget.setToolTip(info.doc)
        column.addWidget(self.help)
        column.addWidget(self.error)

    def _editor(self) -> QWidget:
        info, said = self.info, lambda *_: self.edited.emit(self.info.name)
        if info.kind == "switch":
            editor = QCheckBox(self)
            editor.toggled.connect(said)
        elif info.kind == "choice":
            editor = QComboBox(self)
            editor.addItems([str(choice) for choice in info.choices])
            editor.currentTextChanged.connect(said)
            editor.setFixedWidth(EDITOR_WIDTH)
        elif self.text and info.name in LONG_TEXTS:
            editor = QPlainTextEdit(self, tabChangesFocus=True)
            editor.setFixedHeight(120)
            editor.textChanged.connect(said)
        elif self.text:
            editor = QLineEdit(self)
            editor.textChanged.connect(said)
        else:
            editor = self._number()
            editor.valueChanged.connect(said)
        return editor

    @property
    def percent(self) -> bool:
        """Whether the value is a share, shown in per cent."""
        return self.info.kind == "real" and self.info.high is not None and self.info.high <= 1 and not self.info.symbol

    def _number(self) -> QSpinBox | QDoubleSpinBox:
        info = self.info
        low, high = info.low or 0, info.high if info.high is not None else 1e9
        if info.kind == "integer":
            editor = QSpinBox(self)
            editor.setRange(int(low), int(min(high, 2**31 - 1)))
            editor.setSingleStep(int(info.step or 1))
        else:
            by, step = (100, info.step or 0.01) if self.percent else (1, info.step or 0.1)
            editor = QDoubleSpinBox(self, decimals=decimals(by * step))
            editor.setRange(by * low, by * high)
            editor.setSingleStep(by * step)
        unit = "%" if self.percent else "s" if info.unit == "s" else ""
        editor.setSuffix(f" {unit}" if unit else "")
        editor.setFixedWidth(EDITOR_WIDTH)
        editor.setAlignment(Qt.AlignmentFlag.AlignRight)
        return editor

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """A wheel that scrolls past must not change a value."""
        if event.type() == QEvent.Type.Wheel and not watched.hasFocus():
            event.ignore()
            return True
        return False

    @property
    def value(self) -> Any:
        """What the editor holds."""
        if self.info.kind == "switch":
            return self.editor.isChecked()
        if self.info.kind == "choice":
            return self.editor.currentText()
        if isinstance(self.editor, QPlainTextEdit):
            return self.editor.toPlainText()
        if isinstance(self.editor, QLineEdit):
            return self.editor.text()
        return round(self.editor.value() / 100, 6) if self.percent else self.editor.value()

    def show_value(self, value: Any) -> None:
        """Display a value."""
        if self.info.kind == "switch":
            self.editor.setChecked(bool(value))
        elif self.info.kind == "choice":
            self.editor.setCurrentText(str(value))
        elif isinstance(self.editor, QPlainTextEdit):
            self.editor.setPlainText(str(value))
        elif isinstance(self.editor, QLineEdit):
            self.editor.setText(str(value))
        else:
            self.editor.setValue(100 * value if self.percent else round(value) if self.info.kind == "integer" else value)

    def show_error(self, sentence: str) -> None:
        """Say what is wrong, or nothing."""
        self.error.setText(sentence)
        self.error.setVisible(bool(sentence))


class DesignForm(QWidget):
    """The rows of some fields of a model, in the order of their declaration."""

    edited = Signal(str)

    def __init__(self, model: type[Parameters], names: Sequence[str], parent: QWidget | None = None,
                 captions: Mapping[str, str] | None = None, *, compact: bool = False) -> None:  # fmt: skip
        super().__init__(parent)
        self.rows: dict[str, Row] = {}
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4 if compact else 16)
        for info in declared(model):
            if info.name in names:
                caption = (captions or {}).get(info.name) or info.name.replace("_", " ").capitalize()
                row = Row(info, caption, compact, self)
                row.show_value(info.default)
                row.edited.connect(self.edited)
                column.addWidget(row)
                self.rows[info.name] = row

    def values(self) -> dict[str, Any]:
        """The values by name."""
        return {name: row.value for name, row in self.rows.items()}

    def show_error(self, sentence: str) -> bool:
        """Say a sentence at the field that it names, none elsewhere; whether it was said."""
        named = [name for name in self.rows if sentence and f"'{name}'" in sentence]
        for name, row in self.rows.items():
            row.show_error(sentence if name in named[:1] else "")
        return bool(named)
