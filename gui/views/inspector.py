"""A window of its own for one shape: pick, hide and isolate segments, cut it open, take a picture.

It is the one place that uses pyvistaqt, whose widget must be closed before its window goes, must not redraw by timer,
and must not multisample; it is imported when the first inspector opens.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PySide6.QtCore import QEvent, QObject, QPointF, Qt
from PySide6.QtGui import QCloseEvent, QGuiApplication, QKeySequence, QShortcut
from PySide6.QtWidgets import QFileDialog, QHBoxLayout, QLabel, QMainWindow, QPushButton, QSlider, QVBoxLayout, QWidget

from engine.errors import ConcordError
from engine.shapes.segmentation import SegmentedShape
from engine.store import write_atomically

from .. import glprobe
from ..palette import LIGHT, Theme, rgb, segment_colours
from .cameras import VIEW_ANGLE, candidate_directions, fitting_distance, look_from
from .scene import Scene, prepare, union_colours

NO_SCREEN = (
    "The inspector needs a screen; start Concord on a desktop, or draw headless pictures with the report instead."
)
_CLICK = 4.0
_CLIP_STEPS = 200


class Inspector(QMainWindow):
    """One shape in its own window. Raises `ConcordError` where there is no screen or no OpenGL."""

    def __init__(self, shape: SegmentedShape, theme: Theme = LIGHT, parent: QWidget | None = None) -> None:
        if QGuiApplication.platformName() in ("offscreen", "minimal"):
            raise ConcordError(NO_SCREEN)
        if sentence := glprobe.problem():
            raise ConcordError(sentence)
        super().__init__(parent)
        import pyvistaqt

        self.scene, self._theme = prepare(shape), theme
        self.hidden: set[int] = set()
        self.picked: int | None = None
        self._shown_faces = np.arange(len(self.scene.faces))
        self._pressed: QPointF | None = None
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(f"{self.scene.name} · Inspector")
        self.plotter = pyvistaqt.QtInteractor(self, auto_update=False, multi_samples=0)
        self.plotter.set_background(theme.paper)
        self.plotter.interactor.installEventFilter(self)
        self._lay_out()
        self._redraw()
        self._look()

    def _lay_out(self) -> None:
        self._note = QLabel()
        self._hide = _button("Hide", "Hide the picked segment (H)", self.hide_picked)
        self._isolate = _button("Isolate", "Show only the picked segment (I)", self.isolate_picked)
        self._clip = _button("Cut open", "Cut the shape where you look at it (C)", self.cut_open)
        self._clip.setCheckable(True)
        self._depth = QSlider(Qt.Orientation.Horizontal, minimum=0, maximum=_CLIP_STEPS, value=_CLIP_STEPS // 2)
        self._depth.setFixedWidth(160)
        self._depth.setVisible(False)
        self._depth.setToolTip("How deep the cut is")
        self._depth.valueChanged.connect(self._move_cut)
        row, column, body = QHBoxLayout(), QVBoxLayout(), QWidget()
        row.setContentsMargins(12, 8, 12, 8)
        row.addWidget(self._note, 1)
        everything = _button("Show all", "Show all segments again (A)", self.show_all)
        picture = _button("Picture…", "Save a picture (S)", self.ask_picture)
        for widget in (self._hide, self._isolate, everything, self._depth, self._clip, picture):
            row.addWidget(widget)
        row.setSpacing(8)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.plotter.interactor, 1)
        column.addLayout(row)
        body.setLayout(column)
        self.setCentralWidget(body)
        self.resize(900, 680)
        for key, slot in (("H", self.hide_picked), ("I", self.isolate_picked), ("A", self.show_all),
                          ("C", self._clip.click), ("S", self.ask_picture)):  # fmt: skip
            QShortcut(QKeySequence(key), self).activated.connect(slot)

    def _look(self) -> None:
        towards = candidate_directions()[0]
        camera = look_from(towards, fitting_distance(self.scene, towards, self.width() / self.height()))
        self.plotter.camera.view_angle = VIEW_ANGLE
        self.plotter.camera_position = [camera.position, camera.focal, camera.up]
        self.plotter.reset_camera_clipping_range()
        self.plotter.render()

    # --- segments

    def pick(self, segment: int | None) -> None:
        """Choose a segment, or none, and say what it is."""
        self.picked = segment
        self._redraw()

    def hide_picked(self) -> None:
        """Take the picked segment out of sight."""
        if self.picked is not None and len(self.hidden) < self.scene.count - 1:
            self.hidden.add(self.picked)
            self.pick(None)

    def isolate_picked(self) -> None:
        """Show nothing but the picked segment."""
        if self.picked is not None:
            self.hidden = set(range(self.scene.count)) - {self.picked}
            self._redraw()

    def show_all(self) -> None:
        """Show all segments again."""
        self.hidden = set()
        self._redraw()

    def _redraw(self) -> None:
        import pyvista

        self._shown_faces = np.flatnonzero(~np.isin(self.scene.labels, list(self.hidden)))
        base = segment_colours(self.scene.count)
        if self.picked is not None:
            base = union_colours(base, [self.picked], base[self.picked], rgb(self._theme.faded))
        surface = pyvista.PolyData.from_regular_faces(self.scene.points, self.scene.faces[self._shown_faces])
        surface.cell_data["colour"] = base[self.scene.labels[self._shown_faces]]
        self._actor = self.plotter.add_mesh(
            surface, scalars="colour", rgb=True, name="shape", reset_camera=False, render=False, ambient=0.38,
            diffuse=0.74, smooth_shading=True, split_sharp_edges=True, feature_angle=38)  # fmt: skip
        if self._clip.isChecked():
            self._actor.mapper.AddClippingPlane(self._plane())
        self._say()
        self.plotter.render()

    def _say(self) -> None:
        chosen = self.picked is not None
        self._hide.setEnabled(chosen)
        self._isolate.setEnabled(chosen)
        hidden = f" · {len(self.hidden)} hidden" if self.hidden else ""
        what = describe(self.scene, self.picked) if self.picked is not None else "Click a segment"
        self._note.setText(what + hidden)

    # --- cutting

    def cut_open(self) -> None:
        """Switch the cut on, facing the camera as it is now, or off."""
        self._depth.setVisible(self._clip.isChecked())
        camera = self.plotter.camera
        self._normal = np.subtract(camera.focal_point, camera.position)
        self._normal /= np.linalg.norm(self._normal)
        self._redraw()

    def _plane(self) -> object:
        from vtkmodules.vtkCommonDataModel import vtkPlane

        depth = self.scene.samples @ self._normal
        plane = vtkPlane()
        share = self._depth.value() / _CLIP_STEPS
        plane.SetOrigin(*(self._normal * (depth.min() * (1 - share) + depth.max() * share)))
        plane.SetNormal(*self._normal)
        return plane

    def _move_cut(self) -> None:
        self._actor.mapper.RemoveAllClippingPlanes()
        self._actor.mapper.AddClippingPlane(self._plane())
        self.plotter.render()

    # --- picture and mouse

    def ask_picture(self) -> None:
        """Ask where to, and save a picture."""
        path, _ = QFileDialog.getSaveFileName(self, "Save a picture", f"{self.scene.name}.png", "Picture (*.png)")
        if path:
            try:
                self.save_picture(path)
            except ConcordError as error:
                self._note.setText(str(error))

    def save_picture(self, path: Path | str) -> None:
        """Write what is seen as a PNG; raises `BadInput` where that cannot be."""
        from .figures import image_bytes

        self.plotter.render()
        write_atomically(path, image_bytes(self.plotter.screenshot(return_img=True)))

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """A click without a drag picks the segment below it."""
        if event.type() == QEvent.Type.MouseButtonPress and event.button() == Qt.MouseButton.LeftButton:
            self._pressed = event.position()
        elif event.type() == QEvent.Type.MouseButtonRelease and self._pressed is not None:
            if (event.position() - self._pressed).manhattanLength() <= _CLICK:
                self.pick(self.segment_at(event.position()))
            self._pressed = None
        return super().eventFilter(watched, event)

    def segment_at(self, at: QPointF) -> int | None:
        """The segment at a place in the picture (logical pixels), or None."""
        from vtkmodules.vtkRenderingCore import vtkCellPicker

        picker, ratio = vtkCellPicker(), self.devicePixelRatioF()
        picker.SetTolerance(0.0)
        height = self.plotter.interactor.height()
        picker.Pick(at.x() * ratio, (height - at.y() - 1) * ratio, 0, self.plotter.renderer)
        cell = picker.GetCellId()
        return int(self.scene.labels[self._shown_faces[cell]]) if cell >= 0 else None

    def closeEvent(self, event: QCloseEvent) -> None:
        """Give VTK's widget back before the window goes."""
        self.plotter.interactor.removeEventFilter(self)
        self.plotter.close()
        super().closeEvent(event)


def describe(scene: Scene, segment: int) -> str:
    """What is said of a picked segment: its label in the file, its share of the area, its faces."""
    inside = scene.labels == segment
    share = scene.area[inside].sum() / scene.area.sum()
    return f"Segment {scene.names[segment]} · {share:.1%} of the area · {inside.sum():,} faces"


def _button(text: str, tip: str, slot: object) -> QPushButton:
    button = QPushButton(text)
    button.setToolTip(tip)
    button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    button.clicked.connect(lambda *_: slot())
    return button
