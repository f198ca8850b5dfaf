"""The page that edits the segments of one shape: the shape at the left, tools, numbers and the list at the right."""

from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QColor, QIcon, QPixmap
from PySide6.QtWidgets import (
    QAbstractItemView,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QSlider,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from engine.shapes.editing import MOST_PARTS, names_of
from engine.shapes.segmentationparameters import DEFAULT, SegmentationParameters

from ...palette import segment_colours, theme
from ...parameter_form import ParameterForm
from ...session import Session
from ...views.segment_canvas import BRUSH, CUT, SELECT, SegmentCanvas
from ..elided import ElidedLabel
from .state import EditState

if TYPE_CHECKING:
    from .desk import SegmentDesk

PANEL_WIDTH, BRUSH_STEPS = 340, 100
HINTS = {
    SELECT: "Click a segment; Shift-click adds another. Drag turns the shape.",
    BRUSH: "Paint with the left button; the right button turns the shape.",
    CUT: "Draw a line across a segment; the right button turns the shape.",
}


def brush_position(radius: float) -> int:
    """Where the slider of the brush stands: the square root of the radius is even along it."""
    return round(BRUSH_STEPS * (radius / 0.3) ** 0.5)


def brush_radius(position: int) -> float:
    """The radius at a position of the slider, in diagonals."""
    return 0.3 * (position / BRUSH_STEPS) ** 2


def swatch(colour: np.ndarray) -> QIcon:
    """A square in one colour (3,) uint8."""
    pixmap = QPixmap(14, 14)
    pixmap.fill(QColor(*colour.tolist()))
    return QIcon(pixmap)


class SegmentsPage(QWidget):
    """Draws the state of the editor; what a hand does goes to the desk."""

    failed = Signal(str, str)

    def __init__(self, session: Session, desk: "SegmentDesk", parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session, self.desk = session, desk
        self.view = SegmentCanvas(self)
        self.form = ParameterForm(SegmentationParameters, self)
        self.hint = QLabel("", self, objectName="soft")
        self.title, self.facts = ElidedLabel("", self, objectName="page-heading"), QLabel("", self, objectName="soft")
        self.list = QListWidget(self)
        self.panel = self._panel()
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(0)
        column = QVBoxLayout()
        column.setSpacing(0)
        column.addWidget(self.view, 1)
        self.hint.setContentsMargins(16, 6, 16, 6)
        column.addWidget(self.hint)
        row.addLayout(column, 1)
        row.addWidget(self.panel)
        self._connect()
        self.apply(EditState(), session.state, frozenset(EditState.__slots__))

    def _button(self, text: str, tip: str, slot: object, checkable: bool = False) -> QPushButton:
        button = QPushButton(text, self, toolTip=tip, checkable=checkable)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        button.clicked.connect(lambda _=False: slot())
        return button

    def _panel(self) -> QWidget:
        panel = QWidget(self)
        panel.setFixedWidth(PANEL_WIDTH)
        column = QVBoxLayout(panel)
        column.setContentsMargins(12, 12, 12, 12)
        column.setSpacing(8)
        column.addWidget(self.title)
        column.addWidget(self.facts)
        column.addWidget(self.form)
        column.addWidget(self._heading("By hand"))
        column.addLayout(self._tools())
        column.addWidget(self._heading("Segments"))
        self.list.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.list.setIconSize(QSize(14, 14))
        self.list.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        column.addWidget(self.list, 1)
        column.addLayout(self._ending())
        return panel

    def _heading(self, text: str) -> QLabel:
        return QLabel(text, self, objectName="group-heading")

    def _tools(self) -> QGridLayout:
        desk, grid = self.desk, QGridLayout()
        grid.setSpacing(8)
        self.merge = self._button("Merge", "Make the selected segments one (M)", desk.merge)
        self.split = self._button("Split into", "Split the selected segment into patches (S)", desk.split)
        self.parts = QSpinBox(self, minimum=2, maximum=MOST_PARTS, value=2, toolTip="Into how many patches")
        self.brush = self._button("Brush", "Paint faces to a segment (B)", lambda: desk.choose_tool(BRUSH), True)
        self.cut = self._button("Knife", "Cut a segment along a line (X)", lambda: desk.choose_tool(CUT), True)
        self.new = self._button("New segment", "Paint a segment of its own (N)", desk.new_segment)
        self.size = QSlider(Qt.Orientation.Horizontal, self, minimum=10, maximum=BRUSH_STEPS, toolTip="Size of the brush ([ and ])")
        self.size.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        rows = ((self.merge, self.cut), (self.brush, self.new))
        for line, pair in enumerate(rows):
            for place, widget in enumerate(pair):
                grid.addWidget(widget, line, place)
        into = QHBoxLayout()
        into.addWidget(self.split, 1)
        into.addWidget(self.parts)
        grid.addLayout(into, 2, 0)
        brush = QHBoxLayout()
        brush.addWidget(QLabel("Size", self))
        brush.addWidget(self.size, 1)
        grid.addLayout(brush, 2, 1)
        grid.setColumnStretch(0, 1)
        grid.setColumnStretch(1, 1)
        return grid

    def _ending(self) -> QHBoxLayout:
        row = QHBoxLayout()
        row.setSpacing(8)
        self.save = self._button("Save", "Write a .seg file beside the mesh (Ctrl+S)", self.desk.save)
        self.save_as = self._button("Save as…", "Write a .seg file elsewhere (Ctrl+Shift+S)", self.desk.save_as)
        self.done = self._button("Done", "Match the pair again with these segments (Ctrl+Return)", self.desk.done)
        self.done.setDefault(True)
        for button in (self.save, self.save_as, self.done):
            row.addWidget(button, 1)
        return row

    def _connect(self) -> None:
        desk = self.desk
        self.session.changed.connect(self.apply)
        self.view.picked.connect(desk.pick)
        self.view.painted.connect(desk.paint)
        self.view.stroke_ended.connect(self.session.settle)
        self.view.cut_drawn.connect(desk.cut)
        self.form.edited.connect(desk.edit_parameter)
        self.size.valueChanged.connect(lambda at: desk.set_brush(brush_radius(at)))
        self.parts.valueChanged.connect(lambda parts: self.session.update(parts=parts))
        self.list.itemSelectionChanged.connect(self._listed)

    def _listed(self) -> None:
        chosen = tuple(item.data(Qt.ItemDataRole.UserRole) for item in self.list.selectedItems())
        if set(chosen) != set(self.session.state.selected):
            self.desk.choose(chosen)

    # --- what the state says

    def apply(self, old: EditState, state: EditState, names: frozenset[str]) -> None:
        """Draw the difference between two states."""
        if "dark" in names:
            self.view.set_theme(theme(state.dark))
        if "scene" in names and state.scene is not None:
            self.view.set_scene(state.scene)
        if names & {"labels", "selected", "scene"} and state.labels is not None:
            self.view.note = self._count(state)
            self.view.set_labels(state.labels, state.selected)
        if names & {"tool", "radius"}:
            self.view.set_tool(state.tool, state.radius)
        if names & {"labels", "names", "selected", "shape"}:
            self._show_list(state, bool(names & {"labels", "names", "shape"}))
        if "parameters" in names:
            self.show_parameters()
        self._show_tools(state)
        self.desk.page_changed()

    def _count(self, state: EditState) -> str:
        count = len(np.unique(state.labels))
        return "1 segment" if count == 1 else f"{count} segments"

    def _show_tools(self, state: EditState) -> None:
        chosen = len(state.selected)
        self.merge.setEnabled(chosen > 1)
        self.split.setEnabled(chosen == 1)
        for button, tool in ((self.brush, BRUSH), (self.cut, CUT)):
            button.setChecked(state.tool == tool)
        before = self.size.blockSignals(True)
        self.size.setValue(brush_position(state.radius))
        self.size.blockSignals(before)
        ready = state.shape is not None
        for widget in (self.brush, self.cut, self.new, self.save, self.save_as, self.form):
            widget.setEnabled(ready)
        self.hint.setText(self._hint(state))
        self.title.setText("Segments" if not ready else f"Segments of {state.shape.mesh.name}")
        if ready:
            told = "saved" if state.file else "as they were opened"
            saved = "cut automatically" if not state.by_hand else "edited, not saved" if state.unsaved else told
            self.facts.setText(f"{self._count(state)} · {saved}")

    def _hint(self, state: EditState) -> str:
        if state.tool == BRUSH and state.labels is not None:
            names = names_of(state.labels, state.names)
            what = "the segment that it first touches" if state.active < 0 else f"segment {names.get(state.active, 'that is new')}"
            return f"The brush paints {what}. {HINTS[BRUSH]}"
        return HINTS[state.tool]

    def _show_list(self, state: EditState, anew: bool) -> None:
        before = self.list.blockSignals(True)
        if anew:
            self._fill(state)
        for row in range(self.list.count()):
            item = self.list.item(row)
            item.setSelected(item.data(Qt.ItemDataRole.UserRole) in state.selected)
            if item.isSelected() and len(state.selected) == 1:
                self.list.scrollToItem(item)
        self.list.blockSignals(before)

    def _fill(self, state: EditState) -> None:
        self.list.clear()
        if state.labels is None:
            return
        area = np.bincount(state.labels, state.graph.area)
        colours = segment_colours(len(area))
        names = names_of(state.labels, state.names)
        widest = max(len(str(name)) for name in names.values())
        for label, name in names.items():
            aligned = str(name).rjust(widest, "\u2007")  # a space as wide as a digit
            item = QListWidgetItem(swatch(colours[label]), f"{aligned}   {100 * area[label] / area.sum():.1f} % of the surface")
            item.setData(Qt.ItemDataRole.UserRole, label)
            self.list.addItem(item)

    def show_parameters(self) -> None:
        """The values of the automatic segmentation."""
        self.form.show_values(self.session.state.parameters, DEFAULT)

    def shutdown(self) -> None:
        """Give back what the view holds of the graphics system."""
        self.view.shutdown()
