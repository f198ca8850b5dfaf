"""The slider that hides weakly supported matches, the same on the page of a collection and on that of a pair."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSlider, QWidget

from .arrange import share_text

_STEPS = 20


class LeastSupport(QWidget):
    """A slider from 0 to 1 with its value and a note, such as how many matches are left."""

    moved = Signal(float)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.slider = QSlider(Qt.Orientation.Horizontal, self)
        self.slider.setRange(0, _STEPS)
        self.slider.setPageStep(2)
        self.slider.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.slider.setAccessibleName("least support")
        self.slider.valueChanged.connect(lambda position: self.moved.emit(position / _STEPS))
        self.value, self.note = QLabel("", self), QLabel("", self)
        self.value.setFixedWidth(30)
        self.note.setObjectName("soft")
        tip = "Hides matches that the other shapes of the collection support less than this"
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(8)
        for widget, stretch in ((QLabel("Least support", self), 0), (self.slider, 1), (self.value, 0), (self.note, 0)):
            widget.setToolTip(tip)
            row.addWidget(widget, stretch)
        self.show_value(0.0)

    def show_value(self, least: float, note: str = "") -> None:
        """Display a value without telling anybody."""
        before = self.slider.blockSignals(True)
        self.slider.setValue(round(least * _STEPS))
        self.slider.blockSignals(before)
        self.value.setText(share_text(least))
        self.note.setText(note)
        self.note.setVisible(bool(note))
