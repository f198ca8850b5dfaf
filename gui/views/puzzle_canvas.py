"""The puzzle canvas: one plain widget that warps the pieces' pixels onto the screen and draws the joins over them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt, QTimer, Signal
from PySide6.QtGui import (
    QColor,
    QDragEnterEvent,
    QDragLeaveEvent,
    QDropEvent,
    QImage,
    QMouseEvent,
    QPaintEvent,
    QResizeEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QSizePolicy, QWidget

from ..palette import LIGHT, Theme
from .painting import paint_message
from .puzzle_growth import Growth
from .puzzle_layout import Layout, growing
from .puzzle_painting import (
    Extent,
    Overlay,
    draw_joins,
    paint_caption,
    paint_carried,
    paint_ground,
    paint_marks,
    paint_outlines,
    painting,
)
from .puzzle_scene import View, fitted, hit_join, hit_piece, kept
from .puzzle_sheet import Sheet, compose
from .puzzle_snap import Carried, taken_up

REACH, DRAG_FROM, SNAP = 6.0, 4.0, 18.0  # screen pixels: click to join, before a hand carries, between corners
GROWTH_MS, FRAME_MS, FLASH_MS, MOST_FLASHED = 1100, 33, 1200, 200


class PuzzleCanvas(QWidget):
    """Shows a layout and an overlay; says what was clicked, carried and dropped.

    It owns how it is looked at (`view`) and nothing else: what it shows is told by `show_layout` and `show_overlay`.
    """

    join_clicked = Signal(int)
    piece_clicked = Signal(int)
    background_clicked = Signal()
    carried = Signal(int, int, int)
    """piece, and the top-left pixel (x, y) on the canvas where its raster was let go"""
    files_dropped = Signal(list)
    grown = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.theme, self.layout_shown, self.overlay = LIGHT, None, Overlay()
        self.view, self.follows = View(), True  # whether the view keeps showing all, until a hand moves it
        self.group_of: Callable[[int], frozenset[int]] = lambda piece: frozenset({piece})
        self.tip_of: Callable[[int], str] = lambda row: ""
        self._sheet: Sheet | None = None
        self._frame: QImage | None = None
        self._pixels: np.ndarray | None = None  # what the frame's memory belongs to
        self._pressed: tuple[QPointF, int] | None = None
        self._panning = False
        self._carried: Carried | None = None
        self._growth: Growth | None = None
        self._timer = QTimer(self, interval=FRAME_MS)
        self._timer.timeout.connect(self._grow)
        self._flashed: tuple[int, ...] = ()
        self._calm = QTimer(self, singleShot=True, interval=FLASH_MS)
        self._calm.timeout.connect(lambda: self.flash(np.zeros(0, np.int64)))
        self._invitation: tuple[str, QWidget | None] = ("", None)
        self._drop_wanted = False
        self.setMouseTracking(True)
        self.setAcceptDrops(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(200, 160)

    # --- what is shown

    def set_theme(self, theme: Theme) -> None:
        """Take other colours."""
        self.theme = theme
        self._refresh()

    def set_invitation(self, text: str, buttons: QWidget) -> None:
        """What the empty canvas says, and the buttons below that."""
        self._invitation = (text, buttons)
        self._place_invitation()
        self.update()

    def _place_invitation(self) -> None:
        _, buttons = self._invitation
        if buttons is not None:
            buttons.adjustSize()
            buttons.move((self.width() - buttons.width()) // 2, self.height() // 2 + 36)

    @property
    def aspect(self) -> float:
        """Width by height, for laying out."""
        return max(self.width(), 1) / max(self.height(), 1)

    def show_layout(self, layout: Layout | None) -> None:
        """Show pieces as a layout has them; the view stays where a hand has put it."""
        self._stop_growth()
        self._drop_carried()
        other = self.layout_shown is None or layout is None or layout.puzzle is not self.layout_shown.puzzle
        self.layout_shown, self._flashed = layout, ()
        if layout is None:
            self._sheet = None
        elif self._sheet is None or not self._sheet.follow(layout):
            self._sheet = compose(layout)
        self.overlay = Overlay()
        if other:
            self.follows = True
        if self.follows:
            self.reset_view()
        self._refresh()

    def show_overlay(self, overlay: Overlay) -> None:
        """Draw these joins and marks over the pieces."""
        self.overlay = overlay
        self._refresh()

    def reset_view(self) -> None:
        """Show everything, and keep doing so."""
        self.follows = True
        if self.layout_shown is not None:
            self.view = fitted(self.layout_shown.box, self.width(), self.height(), 32)
        self._refresh()

    def look_at(self, segment: np.ndarray) -> None:
        """Move, and if need be zoom, so that a join (2, 2) is well seen."""
        ends = self.view.to_screen(segment)
        middle = ends.mean(axis=0)
        long = float(np.hypot(*(segment[1] - segment[0])))
        scale = max(self.view.scale, 24.0 / max(long, 1))
        inside = (middle > 16).all() and (middle < (self.width() - 16, self.height() - 16)).all()
        if inside and scale == self.view.scale:
            return
        x, y = segment.mean(axis=0)
        centred = View(scale, self.width() / 2 - scale * x, self.height() / 2 - scale * y)
        self.view = kept(centred, self.layout_shown.box, self.width(), self.height())
        self.follows = False
        self._refresh()

    def flash(self, pieces: np.ndarray) -> None:
        """Frame pieces for a moment: those that another solution has moved, unless that is nearly everything."""
        total = 0 if self.layout_shown is None else len(self.layout_shown.placed)
        self._flashed = tuple(pieces.tolist()) if len(pieces) <= min(MOST_FLASHED, total / 2) else ()
        if self._flashed:
            self._calm.start()
        self.update()

    def grow(self, full: Layout, goal: Layout, order: np.ndarray) -> None:
        """Let a picture grow: pieces go in an `order` from where `full` has them to where `goal` has them."""
        self.show_layout(growing(full, goal, np.zeros(len(full.placed), bool)))
        self._growth = Growth(full, goal, order, GROWTH_MS // FRAME_MS)
        self._timer.start()

    def _grow(self) -> None:
        if self._growth is None or self._sheet is None:
            self._stop_growth()
            return
        self.layout_shown = self._growth.step(self._sheet)
        self._refresh()
        if self._growth.ended:
            self._stop_growth()
            self.grown.emit()

    def _stop_growth(self) -> None:
        self._timer.stop()
        self._growth = None

    @property
    def is_growing(self) -> bool:
        """Whether pieces are on their way."""
        return self._growth is not None

    # --- painting

    def _refresh(self) -> None:
        self._frame = None
        self.update()

    def render_frame(self) -> QImage | None:
        """The pieces and plain joins as seen now; kept until something changes."""
        if self._sheet is None:
            return None
        if self._frame is None:
            ratio = self.devicePixelRatioF()
            width, height = round(self.width() * ratio), round(self.height() * ratio)
            self._pixels = self._sheet.warped(self.view, width, height, ratio)
            if self._carried is None:
                draw_joins(self._pixels, self.overlay, self.view, ratio, self.theme)
            data = self._pixels
            self._frame = QImage(data.data, width, height, 4 * width, QImage.Format.Format_ARGB32_Premultiplied)
            self._frame.setDevicePixelRatio(ratio)
        return self._frame

    def paintEvent(self, event: QPaintEvent) -> None:
        with painting(self) as painter:
            painter.fillRect(self.rect(), QColor(self.theme.paper))
            layout = self.layout_shown
            if layout is None:
                paint_message(painter, QRectF(self.rect()), self._invitation[0], self.theme, self._drop_wanted)
            else:
                paint_ground(painter, layout, self.view, self.theme)
                frame = self.render_frame()
                if frame is not None:
                    painter.drawImage(QPointF(0, 0), frame)
                if self._carried is not None:
                    paint_carried(painter, layout, self._carried, self.view, self.theme)
                else:
                    extent = Extent(self.width(), self.height(), self.devicePixelRatioF())
                    paint_marks(painter, layout, self.overlay, self.view, self.theme, extent)
                    if self._flashed:
                        paint_outlines(painter, layout, self._flashed, self.view, self.theme)
                if self.overlay.caption:
                    paint_caption(painter, self.overlay.caption, self.height(), self.theme)

    # --- hands

    def _at(self, event: QMouseEvent) -> tuple[float, float]:
        return self.view.to_canvas(event.position().x(), event.position().y())

    def join_at(self, x: float, y: float) -> int:
        """The shown join at a point of the widget, or -1."""
        rows = np.flatnonzero(self.overlay.shown)
        found = hit_join(self.view.to_screen(self.overlay.seams[rows]), x, y, REACH) if len(rows) else -1
        return int(rows[found]) if found >= 0 else -1

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if self.layout_shown is None or self.is_growing:
            return
        left = event.button() == Qt.MouseButton.LeftButton
        piece = hit_piece(self.layout_shown, *self._at(event)) if left else -1
        self._pressed = (event.position(), piece)
        self._panning = not left
        self.setCursor(Qt.CursorShape.ClosedHandCursor if self._panning else Qt.CursorShape.ArrowCursor)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self._pressed is None:
            self._hover(event)
            return
        start, piece = self._pressed
        step = event.position() - start
        if self._carried is not None:
            self.carry_to(event.position())
        elif self._panning:
            self.view, self.follows = self.view.moved(step.x(), step.y()), False
            self._pressed = (event.position(), piece)
            self._refresh()
        elif step.manhattanLength() >= DRAG_FROM:
            if piece >= 0:
                self.take_up(piece, start)
                self.carry_to(event.position())
            else:
                self._panning = True
                self.setCursor(Qt.CursorShape.ClosedHandCursor)

    def _hover(self, event: QMouseEvent) -> None:
        row = self.join_at(event.position().x(), event.position().y())
        self.setCursor(Qt.CursorShape.PointingHandCursor if row >= 0 else Qt.CursorShape.ArrowCursor)
        self.setToolTip(self.tip_of(row) if row >= 0 else "")

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        if self._pressed is None:
            return
        (_, piece), panned, carried = self._pressed, self._panning, self._carried
        self._pressed, self._panning = None, False
        self.setCursor(Qt.CursorShape.ArrowCursor)
        if carried is not None:
            self._drop_carried()
            self.carried.emit(carried.held, *carried.rest[:2])
        elif not panned and event.button() == Qt.MouseButton.LeftButton:
            row = self.join_at(event.position().x(), event.position().y())
            if row >= 0:
                self.join_clicked.emit(row)
            elif piece >= 0:
                self.piece_clicked.emit(piece)
            else:
                self.background_clicked.emit()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        if self.layout_shown is not None and hit_piece(self.layout_shown, *self._at(event)) < 0:
            self.reset_view()

    def wheelEvent(self, event: QWheelEvent) -> None:
        if self.layout_shown is None:
            return
        steps = event.angleDelta().y() / 120
        at = event.position()
        self.view, self.follows = self.view.zoomed(1.2**steps, at.x(), at.y()), False
        self._refresh()
        event.accept()

    def take_up(self, piece: int, at: QPointF) -> None:
        """Take a piece, and what is locked to it, into the hand."""
        self._carried = taken_up(self.layout_shown, piece, self.group_of(piece), *self.view.to_canvas(at.x(), at.y()))
        self._sheet.lift(self._carried.pieces)
        self.setCursor(Qt.CursorShape.ClosedHandCursor)

    def carry_to(self, at: QPointF) -> None:
        """Move what is in the hand."""
        x, y = self.view.to_canvas(at.x(), at.y())
        self._carried = self._carried.moved(self.layout_shown, x, y, SNAP / self.view.scale)
        self._refresh()

    def _drop_carried(self) -> None:
        """Show carried pieces where the layout has them; whoever hears of it shows another."""
        if self._carried is not None:
            for piece in sorted(self._carried.pieces):
                self._sheet.paste(piece, self.layout_shown)
            self._sheet.refresh()
            self._carried = self._pressed = None
            self._refresh()

    # --- the window around it

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._place_invitation()
        if self.follows:
            self.reset_view()
        self._refresh()

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        if event.mimeData().hasUrls():
            self._drop_wanted = True
            self.update()
            event.acceptProposedAction()

    def dragLeaveEvent(self, event: QDragLeaveEvent) -> None:
        self._drop_wanted = False
        self.update()

    def dropEvent(self, event: QDropEvent) -> None:
        self._drop_wanted = False
        paths = [url.toLocalFile() for url in event.mimeData().urls() if url.isLocalFile()]
        event.acceptProposedAction()
        if paths:
            QTimer.singleShot(0, lambda: self.files_dropped.emit(paths))
