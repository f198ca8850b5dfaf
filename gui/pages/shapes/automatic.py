"""Shapes that came without labels: a bar that says so, with a slider for the number of segments and the way to edit them."""

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Qt, QTimer, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QSlider, QVBoxLayout, QWidget

from engine.progress import Progress
from engine.shapes.segmentation import SegmentedShape
from engine.shapes.segmentationparameters import DEFAULT
from engine.store import default_cache

from ...jobs import Jobs
from ...session import Session, State
from ..elided import ElidedLabel

if TYPE_CHECKING:
    from .matching import Matching

FEWEST, USUAL_MOST, PAUSE, SLIDER_WIDTH = 2, 60, 350, 160


def automatic_words(shape: SegmentedShape) -> str:
    """What the bar says of a shape."""
    return f"{shape.mesh.name} has no labels and was cut automatically."


class AutomaticRow(QWidget):
    """One shape: what was done, the slider, the number, and a button to edit by hand."""

    numbered = Signal(int)
    edited = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.words, self.number = ElidedLabel("", self, objectName="soft"), QLabel("", self)
        self.number.setMinimumWidth(88)
        self.slider = QSlider(Qt.Orientation.Horizontal, self, minimum=FEWEST, maximum=USUAL_MOST)
        self.slider.setToolTip("Number of segments; the pair is matched again")
        self.slider.setFixedWidth(SLIDER_WIDTH)
        self.slider.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.edit = QPushButton("Edit…", self, toolTip="Merge, split and repaint the segments by hand")
        self.edit.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        row = QHBoxLayout(self)
        row.setContentsMargins(8, 4, 8, 4)
        row.setSpacing(8)
        row.addWidget(self.words, 1)
        row.addWidget(self.slider)
        row.addWidget(self.number)
        row.addWidget(self.edit)
        self._pause = QTimer(self, singleShot=True, interval=PAUSE)
        self._pause.timeout.connect(self._settled)
        self.slider.valueChanged.connect(self._moved)
        self.slider.sliderReleased.connect(self._settled)
        self.edit.clicked.connect(lambda _=False: self.edited.emit())
        self.hide()

    def show_shape(self, shape: SegmentedShape | None) -> None:
        """Show a shape that was segmented automatically; anything else hides the row."""
        self.setVisible(shape is not None and shape.automatic)
        if shape is None or not shape.automatic:
            return
        self._pause.stop()
        count, before = shape.segmentation.count, self.slider.blockSignals(True)
        self.slider.setMaximum(max(USUAL_MOST, count))
        self.slider.setValue(count)
        self.slider.blockSignals(before)
        self.words.setText(automatic_words(shape))
        self._show_number(count)

    def _show_number(self, count: int) -> None:
        self.number.setText(f"{count} segments")

    def _moved(self, count: int) -> None:
        self._show_number(count)
        if not self.slider.isSliderDown():
            self._pause.start()

    def _settled(self) -> None:
        self._pause.stop()
        self.numbered.emit(self.slider.value())


class AutomaticBar(QWidget):
    """A row for each shape of the pair that came without labels."""

    numbered = Signal(int, int)
    """side, number of segments"""
    edited = Signal(int)
    """side"""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.rows = (AutomaticRow(self), AutomaticRow(self))
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        for side, row in enumerate(self.rows):
            row.numbered.connect(lambda count, side=side: self.numbered.emit(side, count))
            row.edited.connect(lambda side=side: self.edited.emit(side))
            column.addWidget(row)

    def show_pair(self, source: SegmentedShape | None, target: SegmentedShape | None) -> None:
        """Show what is automatic of a pair."""
        for row, shape in zip(self.rows, (source, target), strict=True):
            row.show_shape(shape)


class Automatic(QObject):
    """Segments a shape of the pair anew when its number of segments changes, and has the pair matched again."""

    refused = Signal()
    """the shape stays as it is, so that the slider has to go back"""

    def __init__(self, session: Session, jobs: Jobs, matching: "Matching", parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.session, self.jobs, self.matching, self.cache = session, jobs, matching, default_cache()

    def number(self, side: int, count: int) -> None:
        """Cut one shape into another number of segments."""
        state = self.session.state
        shape = state.target if side else state.source
        if shape is None or not shape.automatic or shape.segmentation.count == count:
            return

        def work(progress: Progress) -> SegmentedShape:
            from engine.shapes.segmenting import auto_segment, origin_words

            chosen = DEFAULT.changed(segments=count)
            found = auto_segment(shape.mesh, chosen, progress=progress, cache=self.cache)
            return SegmentedShape(shape.mesh, found, shape.file, (origin_words(shape.mesh, found, chosen),), automatic=True)

        def done(made: SegmentedShape) -> None:
            now: State = self.session.state
            if (now.target if side else now.source) is shape and now.source is not None and now.target is not None:
                pair = (now.source, made) if side else (made, now.target)
                self.matching.show_pair(*pair, set_name=now.set_name)

        def failed(sentence: str, details: str) -> None:
            self.refused.emit()
            self.jobs.failed.emit(sentence, details)
            self.matching.again()

        self.jobs.cancel("match")
        self.jobs.start("segments", work, done, words="Segmenting", failed=failed)
