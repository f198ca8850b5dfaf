"""One shape whose segments are picked, painted and cut: a plain widget over one off-screen VTK window."""

from __future__ import annotations

from collections.abc import Callable, Collection

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt, QTimer, Signal
from PySide6.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QPen, QWheelEvent
from PySide6.QtWidgets import QApplication, QWidget

from .. import glprobe
from ..palette import LIGHT, Theme, rgb, segment_colours
from .cameras import VIEW_ANGLE, candidate_directions, fitting_distance, look_from
from .mesh_pair import _closer
from .painting import paint_caption, paint_message
from .pane import Pane
from .scene import Scene

SELECT, BRUSH, CUT = "select", "brush", "cut"
_CLICK, _STILL_AFTER, _STEP, _FADE = 4.0, 160, 5.0, 0.62


def editing_colours(count: int, selected: Collection[int], faded: np.ndarray) -> np.ndarray:
    """Colours (count, 3) uint8 of labels 0..count-1; where some are selected, the others fade most of the way."""
    base = segment_colours(count)
    if not selected:
        return base
    others = np.setdiff1d(np.arange(count), list(selected))
    out = base.astype(float)
    out[others] = (1 - _FADE) * out[others] + _FADE * faded
    return out.round().astype(np.uint8)


def stroke_points(start: QPointF, end: QPointF) -> list[QPointF]:
    """Points on the way of a stroke, its end the last, so close that the brush leaves no gaps."""
    way = end - start
    steps = max(1, int(np.hypot(way.x(), way.y()) / _STEP))
    return [start + way * (k / steps) for k in range(1, steps + 1)]


def sides_of_line(xy: np.ndarray, start: QPointF, end: QPointF) -> np.ndarray:
    """Signed distance (q,) of points (q, 2) in a picture from the line through two of its points."""
    way = np.array([end.x() - start.x(), end.y() - start.y()])
    off = xy - [start.x(), start.y()]
    return (way[0] * off[:, 1] - way[1] * off[:, 0]) / max(float(np.hypot(*way)), 1e-12)


class SegmentCanvas(QWidget):
    """Drag turns the shape, a click picks a segment; with the brush a drag paints, with the knife it draws a line.

    The right button turns the shape with every tool, as does a drag that begins beside it.
    """

    picked = Signal(int, bool)
    """face (-1 beside the shape), whether it is added"""
    painted = Signal(list)
    """faces under the stroke since the last time"""
    stroke_ended = Signal()
    cut_drawn = Signal(object, int)
    """signed distance (m,) of the faces from the cut in pixels, and the face under the middle of the line or -1"""

    def __init__(self, parent: QWidget | None = None, probe: Callable[[], str | None] = glprobe.problem) -> None:
        super().__init__(parent)
        self._theme, self._probe, self._message = LIGHT, probe, ""
        self._pane: Pane | None = None
        self._owned: list[Pane] = []
        self._shown = self._moving = False
        self.tool, self.radius, self.note = SELECT, 0.03, ""
        self._selected: tuple[int, ...] = ()
        self._pressed: tuple[QPointF, Qt.MouseButton, bool] | None = None
        self._act = ""
        self._last = QPointF()
        self._hover: QPointF | None = None
        self._still = QTimer(self, singleShot=True, interval=_STILL_AFTER)
        self._still.timeout.connect(self._rest)
        self.setMouseTracking(True)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.setMinimumSize(320, 200)
        self.destroyed.connect(_closer(self._owned))
        if app := QApplication.instance():
            app.aboutToQuit.connect(_closer(self._owned))

    # --- what is shown

    def set_scene(self, scene: Scene) -> None:
        """Show a shape from the usual side."""
        if self._pane is None:
            self._message = self._probe() or ""
            if self._message:
                self.update()
                return
            self._pane = Pane(self._theme)
            self._owned.append(self._pane)
        self._pane.set_scene(scene)
        self._shown = True
        self.reset_view()
        self._recolour()

    def set_labels(self, labels: np.ndarray, selected: tuple[int, ...]) -> None:
        """Show these labels (m,), the selected ones strong."""
        self._selected = selected
        if self._shown:
            self._pane.set_labels(labels)
            self._recolour()

    def set_theme(self, theme: Theme) -> None:
        """Change between light and dark."""
        self._theme = theme
        if self._pane is not None:
            self._pane.set_theme(theme)
            self._recolour()
        self.update()

    def set_tool(self, tool: str, radius: float) -> None:
        """Choose what a drag does; the radius of the brush is in diagonals of the shape."""
        self.tool, self.radius = tool, radius
        self.setCursor(Qt.CursorShape.CrossCursor if tool != SELECT else Qt.CursorShape.ArrowCursor)
        self.update()

    def _recolour(self) -> None:
        if self._shown and self._pane.scene is not None:
            count = int(self._pane.scene.labels.max()) + 1
            self._pane.set_colours(editing_colours(count, self._selected, rgb(self._theme.faded)))
            self._move()

    def reset_view(self) -> None:
        """Show the whole shape from the usual side."""
        if self._shown:
            towards, scene = candidate_directions()[0], self._pane.scene
            self._pane.camera = look_from(towards, fitting_distance(scene, towards, self.width() / max(1, self.height())))
            self._move()

    def _move(self) -> None:
        self._moving = True
        self._still.start()
        self.update()

    def _rest(self) -> None:
        self._moving = self._act == "turn"
        self.update()

    # --- painting

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the shape if it changed, and the tool above it."""
        painter = QPainter(self)
        if not self._shown:
            painter.fillRect(self.rect(), QColor(self._theme.paper))
            paint_message(painter, QRectF(self.rect()), self._message or "No shape is being edited.", self._theme, False)
            painter.end()
            return
        ratio = self.devicePixelRatioF()
        size = round(self.width() * ratio), round(self.height() * ratio)
        painter.drawImage(QRectF(self.rect()), self._pane.image(*size, scale=ratio, moving=self._moving))
        paint_caption(painter, QRectF(0, 0, self.width(), 36), self._pane.scene.name, self.note, self._theme, False)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(QColor(self._theme.ink), 1.5))
        if self.tool == BRUSH and self._hover is not None and self._act != "turn":
            reach = self.brush_pixels()
            painter.setPen(QPen(QColor(self._theme.halo), 3))
            painter.drawEllipse(self._hover, reach, reach)
            painter.setPen(QPen(QColor(self._theme.ink if not self._theme.dark else self._theme.paper), 1.2))
            painter.drawEllipse(self._hover, reach, reach)
        if self._act == "cut" and self._pressed is not None:
            painter.setPen(QPen(QColor(self._theme.halo), 4))
            painter.drawLine(self._pressed[0], self._last)
            painter.setPen(QPen(QColor(self._theme.wrong), 2, Qt.PenStyle.DashLine))
            painter.drawLine(self._pressed[0], self._last)
        painter.end()

    def brush_pixels(self) -> float:
        """Radius of the brush in the picture, at the distance of the shape's middle."""
        scene, camera = self._pane.scene, self._pane.camera
        diagonal = float(np.linalg.norm(np.ptp(scene.points[np.unique(scene.faces)], axis=0)))
        away = float(np.linalg.norm(camera.position - camera.focal))
        return self.radius * diagonal * self.height() / (2 * np.tan(np.radians(VIEW_ANGLE / 2)) * max(away, 1e-9))

    # --- mouse

    def face_at(self, at: QPointF) -> int:
        """The face under a position, -1 beside the shape."""
        ratio = self.devicePixelRatioF()
        face = self._pane.pick_face(at.x() * ratio, at.y() * ratio) if self._shown else None
        return -1 if face is None else face

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Begin a click, a stroke, a line or a turn."""
        if not self._shown:
            return
        shift = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        self._pressed, self._last, self._act = (event.position(), event.button(), shift), event.position(), ""
        on_shape = event.button() == Qt.MouseButton.LeftButton and self.face_at(event.position()) >= 0
        if self.tool == BRUSH and on_shape:
            self._act = "brush"
            self.painted.emit([self.face_at(event.position())])
        elif self.tool == CUT and event.button() == Qt.MouseButton.LeftButton:
            self._act = "cut"

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Go on with what the press began."""
        at = event.position()
        self._hover = at
        if self._act == "brush":
            faces = [face for face in map(self.face_at, stroke_points(self._last, at)) if face >= 0]
            if faces:
                self.painted.emit(faces)
        elif self._act != "cut" and self._pressed is not None:
            self._turn(at)
        self._last = at
        self.update()

    def _turn(self, at: QPointF) -> None:
        start, button, _ = self._pressed
        name = "Middle" if button == Qt.MouseButton.MiddleButton else "Left"
        ratio = self.devicePixelRatioF()
        if self._act != "turn" and (at - start).manhattanLength() > _CLICK:
            self._act = "turn"
            self._pane.mouse(f"{name}ButtonPressEvent", start.x() * ratio, start.y() * ratio)
        if self._act == "turn":
            self._pane.mouse("MouseMoveEvent", at.x() * ratio, at.y() * ratio)
            self._move()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """End it."""
        if self._pressed is None:
            return
        start, button, shift = self._pressed
        act, self._act, self._pressed = self._act, "", None
        at, ratio = event.position(), self.devicePixelRatioF()
        if act == "brush":
            self.stroke_ended.emit()
        elif act == "turn":
            name = "Middle" if button == Qt.MouseButton.MiddleButton else "Left"
            self._pane.mouse(f"{name}ButtonReleaseEvent", at.x() * ratio, at.y() * ratio)
            self._move()
        elif act == "cut" and (at - start).manhattanLength() > 2 * _CLICK:
            xy = self._pane.project(self._pane.scene.centroid)[0] / ratio
            self.cut_drawn.emit(sides_of_line(xy, start, at), self.face_at((start + at) / 2))
        elif button == Qt.MouseButton.LeftButton:
            self.picked.emit(self.face_at(at), shift)
        self.update()

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom by the wheel or by two fingers."""
        if self._shown:
            pixels = event.pixelDelta().y()
            self._pane.zoom(1.12 ** (pixels / 60 if pixels else event.angleDelta().y() / 120))
            self._move()
        event.accept()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """A double click beside the shape shows it from the usual side again."""
        if self._shown and self.face_at(event.position()) < 0:
            self.reset_view()

    def leaveEvent(self, event: object) -> None:
        """The brush is nowhere."""
        self._hover = None
        self.update()

    def shutdown(self) -> None:
        """Give the VTK window back."""
        self._shown = False
        self._still.stop()
        self._pane = None
        _closer(self._owned)()
