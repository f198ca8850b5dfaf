"""The pair view: two shapes side by side and the links between them, in one plain widget."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, QTimer, QVariantAnimation, Signal
from PySide6.QtGui import (
    QColor,
    QDragEnterEvent,
    QDropEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QResizeEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QApplication, QStyle, QToolTip, QWidget

from engine.shapes.segmentation import SegmentedShape

from .. import glprobe
from ..palette import LIGHT, Theme
from .cameras import Camera, between, narrowed, turned
from .figures import save_figure
from .links import LinkShape, hit_inside, hit_outline
from .painting import paint_message
from .scene import Link, prepare

if TYPE_CHECKING:
    from .pair import PairDrawing

EMPTY_TEXT = "Drop two meshes here, or open the example"
_STILL_AFTER, _TURN_TIME, _TURNTABLE_STEP, _TURNTABLE_SPEED = 160, 200, 40, 24.0
_CLICK = 4.0


def aspect_of(size: QSize) -> float:
    """Width / height of one half of a view."""
    return size.width() / 2 / max(1, size.height())


class MeshPairView(QWidget):
    """Shows a source and a target shape with links between their segments.

    Drag turns a shape, right or shift drag moves it, wheel or two fingers zoom, a double click resets it. A click
    selects a link, a segment or nothing; the owner answers with `set_selected` and `set_highlight`.
    """

    link_clicked = Signal(str)
    segment_clicked = Signal(int, int)
    background_clicked = Signal()
    files_dropped = Signal(list)

    def __init__(self, parent: QWidget | None = None, probe: Callable[[], str | None] = glprobe.problem) -> None:
        super().__init__(parent)
        self._theme, self._probe, self._message = LIGHT, probe, EMPTY_TEXT
        self._drawing: PairDrawing | None = None
        self._owned: list[PairDrawing] = []
        self._shown = self._linked = self._moving = self._dropping = False
        self._captions = True
        self._shapes: list[LinkShape] = []
        self._pressed: tuple[QPointF, str] | None = None
        self._dragged: tuple[int, str] | None = None
        self._still = QTimer(self, singleShot=True, interval=_STILL_AFTER)
        self._still.timeout.connect(self._rest)
        self._turner = QTimer(self, interval=_TURNTABLE_STEP)
        self._turner.timeout.connect(self._turn_a_little)
        self._flight = QVariantAnimation(self, startValue=0.0, endValue=1.0, duration=_TURN_TIME)
        self._flight.valueChanged.connect(self._fly)
        self._path: tuple[tuple[Camera, Camera], ...] = ()
        self.reduced_motion = False
        self.setMouseTracking(True)
        self.setAcceptDrops(True)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.setMinimumSize(320, 200)
        self.destroyed.connect(_closer(self._owned))
        if app := QApplication.instance():
            app.aboutToQuit.connect(_closer(self._owned))

    # --- what is shown

    def set_shapes(self, source: SegmentedShape, target: SegmentedShape) -> None:
        """Show two shapes from the usual side, without links; where VTK cannot draw, say what to install."""
        if self._drawing is None and not self._start():
            return
        self._flight.stop()
        self._drawing.set_scenes(prepare(source), prepare(target), self._aspect())
        if self._linked:
            self._drawing.panes[1].camera = self._drawing.panes[0].camera
        self._shown, self._shapes = True, []
        self.update()

    def clear(self, text: str = EMPTY_TEXT) -> None:
        """Show no shapes but a sentence that says what to do."""
        self._shown, self._shapes, self._message = False, [], text
        self._turner.stop()
        self._flight.stop()
        self.update()

    def set_links(self, links: Sequence[Link]) -> None:
        """Show these links; later ones are drawn above earlier ones."""
        self._change(lambda d: setattr(d, "links", tuple(links)))

    def set_selected(self, link_id: str | None) -> None:
        """Draw one link thick with a halo and let the others fade; None for none."""
        self._change(lambda d: setattr(d, "selected", link_id))

    def set_highlight(
        self, source_segments: Sequence[int], target_segments: Sequence[int], colour: np.ndarray | None = None
    ) -> None:
        """Give the two unions one colour and fade all other segments; both empty ends it.

        `colour` (3,) uint8 defaults to that of the first source segment.
        """
        self._change(lambda d: d.set_highlight(tuple(source_segments), tuple(target_segments), colour))

    def set_layer_colours(self, source: np.ndarray | None, target: np.ndarray | None) -> None:
        """Colour the segments (s, 3) and (t, 3) uint8, for instance by the nodes of a layer; None for their own."""
        self._change(lambda d: d.set_base_colours(source, target))

    def set_theme(self, theme: Theme) -> None:
        """Change between light and dark."""
        self._theme = theme
        if self._drawing is not None:
            self._drawing.set_theme(theme)
        self.update()

    @property
    def scenes_shown(self) -> bool:
        """Whether shapes are shown, rather than a message."""
        return self._shown

    def _change(self, change: Callable[[PairDrawing], None]) -> None:
        """Apply a change to what is shown; where shapes are drawn anew, quickly first and smoothly once still."""
        if self._drawing is not None and self._shown:
            change(self._drawing)
            if any(pane.stale for pane in self._drawing.panes):
                self._move()
            else:
                self.update()

    def _start(self) -> bool:
        """Make the VTK windows on first use; False (and a message) where that cannot work."""
        sentence = self._probe()
        if sentence is not None:
            self.clear(sentence)
            return False
        from .pair import PairDrawing

        self._drawing = PairDrawing(self._theme)
        self._drawing.captions = self._captions
        self._owned.append(self._drawing)
        return True

    def set_captions(self, shown: bool) -> None:
        """Whether the names of the shapes stand above them."""
        self._captions = shown
        self._change(lambda d: setattr(d, "captions", shown))

    # --- cameras

    def set_linked_cameras(self, linked: bool) -> None:
        """Turn both shapes together from now on, starting from how the source lies."""
        self._linked = linked
        self._change(lambda d: self._follow(0) if linked else None)

    def reset_view(self) -> None:
        """Show both whole shapes from the usual side."""
        if self._shown:
            self._fly_to(self._drawing.home(self._aspect()))

    def frame_match(self, source_segments: Sequence[int], target_segments: Sequence[int]) -> None:
        """Turn both shapes so that the given segments are seen best."""
        if self._shown:
            views = self._drawing.views_of(source_segments, target_segments, self._aspect(), together=self._linked)
            self._fly_to(views)

    def turntable(self, on: bool) -> None:
        """Turn both shapes slowly until switched off."""
        if on and self._shown:
            self._turner.start()
        else:
            self._turner.stop()

    def _turn_a_little(self) -> None:
        if not self.isVisible():
            return
        for pane in self._drawing.panes:
            pane.camera = turned(pane.camera, _TURNTABLE_SPEED * _TURNTABLE_STEP / 1000)
        self._move()

    def _fly_to(self, cameras: tuple[Camera, Camera]) -> None:
        self._flight.stop()
        self._path = (tuple(p.camera for p in self._drawing.panes), cameras)
        calm = self.reduced_motion or not self.style().styleHint(QStyle.StyleHint.SH_Widget_Animation_Duration)
        if calm or not self.isVisible():
            self._fly(1.0)
        else:
            self._flight.start()

    def _fly(self, share: float) -> None:
        if not self._path or not self._shown:
            return
        eased = share * share * (3 - 2 * share)
        for pane, start, end in zip(self._drawing.panes, *self._path, strict=True):
            pane.camera = between(start, end, eased) if share < 1 else end
        self._move()

    def _follow(self, side: int) -> None:
        if self._linked:
            self._drawing.panes[1 - side].camera = self._drawing.panes[side].camera

    def _move(self) -> None:
        self._moving = True
        self._still.start()
        self.update()

    def _rest(self) -> None:
        self._moving = self._dragged is not None
        self.update()

    def _aspect(self) -> float:
        return aspect_of(self.size())

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Keep the shapes whole where there is less room at their sides."""
        super().resizeEvent(event)
        before, after = (max(0.05, aspect_of(size)) for size in (event.oldSize(), event.size()))
        if not self._shown or not event.oldSize().isValid() or min(1.0, before) == min(1.0, after):
            return
        if self._flight.state() == QVariantAnimation.State.Running:
            self._flight.stop()
            self._fly(1.0)
        for pane in self._drawing.panes:
            pane.camera = narrowed(pane.camera, before, after)
        self._move()

    # --- painting

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the panes that changed, and the links."""
        painter = QPainter(self)
        if self._shown:
            ratio = self.devicePixelRatioF()
            self._shapes = self._drawing.paint(painter, self.width(), self.height(), ratio, self._moving)
        else:
            painter.fillRect(self.rect(), QColor(self._theme.paper))
            paint_message(painter, QRectF(self.rect()), self._message, self._theme, self._dropping)
        if self._dropping and self._shown:
            painter.setPen(QColor(self._theme.accent))
            painter.drawRect(self.rect().adjusted(1, 1, -2, -2))
        painter.end()

    def paint_figure(
        self, painter: QPainter, size: tuple[int, int], scale: float = 2.0, transparent: bool = False
    ) -> None:
        """Draw what is shown at another size in logical pixels, the shapes with `scale` pixels each."""
        if not self._shown:
            paint_message(painter, QRectF(0, 0, *size), self._message, self._theme)
            return
        for pane in self._drawing.panes:
            pane.set_theme(self._theme, transparent)
        try:
            self._drawing.paint(painter, *size, scale)
        finally:
            for pane in self._drawing.panes:
                pane.set_theme(self._theme)
            self.update()

    def save_figure(self, path: Path | str, size: tuple[int, int] = (1400, 700), transparent: bool = False) -> None:
        """Write the picture as .png, .svg or .pdf; raises `BadInput` where that cannot be."""
        paper = None if transparent else self._theme.paper
        save_figure(path, size, lambda p: self.paint_figure(p, size, 2.0, transparent), paper, "Correspondences")

    # --- mouse

    def _side(self, at: QPointF) -> int:
        return int(at.x() >= self.width() / 2)

    def _in_pane(self, at: QPointF, side: int) -> tuple[float, float]:
        ratio = self.devicePixelRatioF()
        return (at.x() - side * self.width() / 2) * ratio, at.y() * ratio

    def _link_at(self, at: QPointF) -> str | None:
        return hit_outline(self._shapes, np.array([at.x(), at.y()])) if self._shown else None

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Remember where a click or a drag begins."""
        if not self._shown:
            return
        moves = event.button() != Qt.MouseButton.LeftButton or event.modifiers() & Qt.KeyboardModifier.ShiftModifier
        self._pressed = (event.position(), "Middle" if moves else "Left")

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Turn or move the shape that was pressed, or show which link would be hit."""
        if not self._shown:
            return
        if self._pressed is None:
            self._hover(self._link_at(event.position()))
            return
        start, button = self._pressed
        if self._dragged is None and (event.position() - start).manhattanLength() > _CLICK:
            self._flight.stop()
            self._dragged = (self._side(start), button)
            self._drawing.panes[self._dragged[0]].mouse(
                f"{button}ButtonPressEvent", *self._in_pane(start, self._dragged[0]))  # fmt: skip
        if self._dragged is not None:
            self._drag(event.position(), "MouseMoveEvent")

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """End a drag, or report what was clicked."""
        if self._dragged is not None:
            self._drag(event.position(), f"{self._dragged[1]}ButtonReleaseEvent")
        elif self._pressed is not None and self._pressed[1] == "Left" and self._shown:
            self._click(event.position())
        self._pressed = self._dragged = None

    def _drag(self, at: QPointF, name: str) -> None:
        side = self._dragged[0]
        self._drawing.panes[side].mouse(name, *self._in_pane(at, side))
        self._follow(side)
        self._move()

    def _click(self, at: QPointF) -> None:
        side = self._side(at)
        link = self._link_at(at)
        segment = None if link else self._drawing.panes[side].pick(*self._in_pane(at, side))
        if link is None and segment is None:
            link = hit_inside(self._shapes, np.array([at.x(), at.y()]))
        if link is not None:
            self.link_clicked.emit(link)
        elif segment is not None:
            self.segment_clicked.emit(side, segment)
        else:
            self.background_clicked.emit()

    def _hover(self, link: str | None) -> None:
        if link != self._drawing.hovered:
            self._drawing.hovered = link
            self.setCursor(Qt.CursorShape.PointingHandCursor if link else Qt.CursorShape.ArrowCursor)
            self.update()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Reset the shape that was double-clicked (both if they are linked)."""
        if not self._shown:
            return
        home, side = list(self._drawing.home(self._aspect())), self._side(event.position())
        if not self._linked:
            home[1 - side] = self._drawing.panes[1 - side].camera
        self._fly_to((home[0], home[1]))

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom by the wheel or by two fingers on a trackpad."""
        steps = event.pixelDelta().y() / 60 if not event.pixelDelta().isNull() else event.angleDelta().y() / 120
        self._zoom(event.position(), 1.12**steps)
        event.accept()

    def _zoom(self, at: QPointF, factor: float) -> None:
        if self._shown and factor != 1.0:
            self._drawing.panes[self._side(at)].zoom(factor)
            self._follow(self._side(at))
            self._move()

    def event(self, event: QEvent) -> bool:
        """Pinch to zoom, and a tool tip over links."""
        if event.type() == QEvent.Type.NativeGesture:
            if event.gestureType() == Qt.NativeGestureType.ZoomNativeGesture:
                self._zoom(event.position(), 1.0 + event.value())
            return True
        if event.type() == QEvent.Type.ToolTip and self._shown:
            QToolTip.showText(event.globalPos(), self._tip(QPointF(event.pos())), self)
            return True
        return super().event(event)

    def _tip(self, at: QPointF) -> str:
        found = self._link_at(at)
        for shape in self._shapes:
            if shape.link.id == found:
                sides = (shape.link.source, shape.link.target)
                named = [_named(p.scene.names, s) for p, s in zip(self._drawing.panes, sides, strict=True)]
                return f"{named[0]} → {named[1]} · score {shape.link.score:.2f} · {shape.link.state}"
        return ""

    def leaveEvent(self, event: QEvent) -> None:
        """No link is hovered any more."""
        if self._shown:
            self._hover(None)

    # --- dropping files

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Take files, and show that they would be taken."""
        if event.mimeData().hasUrls():
            self._dropping = True
            event.acceptProposedAction()
            self.update()

    def dragLeaveEvent(self, event: QEvent) -> None:
        """The files went elsewhere."""
        self._dropping = False
        self.update()

    def dropEvent(self, event: QDropEvent) -> None:
        """Report the dropped files that lie on this computer."""
        self._dropping = False
        paths = [url.toLocalFile() for url in event.mimeData().urls() if url.isLocalFile()]
        event.acceptProposedAction()
        self.update()
        if paths:
            self.files_dropped.emit(paths)

    # --- the end

    def shutdown(self) -> None:
        """Give the VTK windows back; called by itself when the widget or the application goes."""
        self.clear()
        self._still.stop()
        self._drawing = None
        _closer(self._owned)()


def _named(names: Sequence[int | str], segments: Sequence[int]) -> str:
    inner = ", ".join(str(names[s]) for s in segments)
    return inner if len(segments) == 1 else "{" + inner + "}"


def _closer(owned: list[PairDrawing]) -> Callable[..., None]:
    """A function that closes what is in the list, once; it does not keep the widget alive."""

    def close(*_: object) -> None:
        while owned:
            owned.pop().close()

    return close
