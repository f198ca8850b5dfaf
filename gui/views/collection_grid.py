"""All shapes of a collection as tiles in the colours of their parts."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from PySide6.QtCore import QPointF, QRect, QRectF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QColor, QFont, QImage, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QApplication, QSizePolicy, QWidget

from .. import glprobe
from ..palette import LIGHT, Theme
from .collection_layout import CAPTION, Grid, corner, grid_for, tile_at
from .scene import Scene
from .tiles import Tile, TileMaker, coloured, groups, part_colours, segment_at

_CLICK = 4.0
_DEGREES = 0.6  # a shape turns by for each pixel of a drag


class CollectionGrid(QWidget):
    """Shows shapes as tiles: a click on a part lights it up in all of them, a drag turns all, a click on a name or
    beside a shape chooses the shape.

    Tiles are drawn one at a time when the window is idle. `problem` is a sentence where nothing can be drawn.
    """

    part_clicked = Signal(int)
    shape_clicked = Signal(int)

    def __init__(self, parent: QWidget | None = None, probe: Callable[[], str | None] = glprobe.problem) -> None:
        super().__init__(parent)
        self._theme, self._probe = LIGHT, probe
        self.problem = ""
        self.scenes: tuple[Scene, ...] = ()
        self.names: tuple[str, ...] = ()
        self.parts: tuple[np.ndarray, ...] = ()
        self.lit, self.chosen = -1, ()
        self._turn = 0.0
        self._owned: list[TileMaker] = []
        self._tiles: list[Tile | None] = []
        self._images: list[QImage | None] = []
        self._waiting: list[int] = []
        self._room = QSize(1, 1)
        self._pressed: QPointF | None = None
        self._dragging, self._from = False, 0.0
        self._idle = QTimer(self, interval=0)
        self._idle.timeout.connect(self._draw_one)
        self.setMouseTracking(True)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.destroyed.connect(_closer(self._owned))
        if app := QApplication.instance():
            app.aboutToQuit.connect(_closer(self._owned))

    # --- what is shown

    def set_collection(self, scenes: Sequence[Scene], names: Sequence[str], parts: Sequence[np.ndarray]) -> None:
        """Show these shapes under their names, (s,) int64 the part of each segment."""
        if self.names != tuple(names):
            self._tiles = []  # of the same shapes, turned, the old ones stand until they are drawn anew
        self.scenes, self.names, self.parts = tuple(scenes), tuple(names), tuple(parts)
        self._images = [None] * len(self._tiles)
        self.lit, self.chosen, self._turn = -1, (), 0.0
        self._fit()

    def set_parts(self, parts: Sequence[np.ndarray]) -> None:
        """Colour the same shapes by other parts."""
        self.parts = tuple(parts)
        self._recolour()

    def set_lit(self, part: int) -> None:
        """Light one part up in all shapes and fade the others; -1 shows all."""
        if part != self.lit:
            self.lit = part
            self._recolour()

    def set_chosen(self, shapes: Sequence[int]) -> None:
        """Frame the shapes that were chosen for a pair."""
        self.chosen = tuple(shapes)
        self.update()

    def set_theme(self, theme: Theme) -> None:
        """Change between light and dark."""
        self._theme = theme
        self._recolour()

    def reset_view(self) -> None:
        """Show all shapes from the usual side."""
        self.turn_to(0.0)

    def turn_to(self, degrees: float) -> None:
        """Turn all shapes around their upright axes."""
        if degrees != self._turn:
            self._turn = degrees
            self._stale()

    @property
    def ready(self) -> bool:
        """Whether every tile is drawn as it should be."""
        return not self._idle.isActive()

    @property
    def grid(self) -> Grid:
        """Where the tiles stand."""
        return grid_for(len(self.scenes), self._room.width(), self._room.height())

    def fit_into(self, room: QSize) -> None:
        """Use this much room; what needs more is scrolled to."""
        if room != self._room:
            self._room = room
            self._fit()

    def _fit(self) -> None:
        self.setMinimumHeight(self.grid.height if self.scenes else 0)
        self._stale()

    def _stale(self) -> None:
        """All tiles are to be drawn again; the old ones stay until then where they fit."""
        if len(self._tiles) != len(self.scenes):
            self._tiles = [None] * len(self.scenes)
            self._images = [None] * len(self.scenes)
        first = [row for row in self._waiting if row < len(self.scenes)]  # so that all come in turn during a drag
        self._waiting = first + [row for row in range(len(self.scenes)) if row not in first]
        if self.scenes:
            self._idle.start()
        self.update()

    def _recolour(self) -> None:
        self._images = [None] * len(self._tiles)
        self.update()

    def _draw_one(self) -> None:
        """Draw the next tile that is waiting; those in sight first."""
        if not self._waiting or not self._start():
            self._idle.stop()
            return
        if not self.isVisible():
            return
        seen = self.visibleRegion().boundingRect()
        row = next((k for k in self._waiting if self._frame(k).intersects(seen)), self._waiting[0])
        self._waiting.remove(row)
        size = max(32, round(self.grid.side * self.devicePixelRatioF()))
        self._tiles[row] = self._owned[0].tile(self.scenes[row], size, self._turn)
        self._images[row] = None
        self.update(self._frame(row))
        if not self._waiting:
            self._idle.stop()

    def _start(self) -> bool:
        """Make the VTK window on first use; False where that cannot work."""
        if not self._owned and not self.problem:
            self.problem = self._probe() or ""
            if not self.problem:
                self._owned.append(TileMaker(self._theme))
            self.update()
        return bool(self._owned)

    def _image(self, row: int) -> QImage | None:
        tile = self._tiles[row] if row < len(self._tiles) else None
        if tile is not None and self._images[row] is None and len(self.parts[row]) == self.scenes[row].count:
            colours = part_colours(self.parts[row], self._theme, self.lit)
            self._images[row] = coloured(tile, colours, groups(self.parts[row]), self._theme)
        return self._images[row]

    # --- painting

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the tiles in sight with their names."""
        painter = QPainter(self)
        painter.fillRect(event.rect(), QColor(self._theme.paper))
        if self.problem:
            painter.setPen(QColor(self._theme.soft_ink))
            painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, self.problem)
            return
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for row in range(len(self.scenes)):
            if self._frame(row).intersects(event.rect()):
                self._paint_tile(painter, row)

    def _paint_tile(self, painter: QPainter, row: int) -> None:
        left, top = corner(self.grid, row)
        side = self.grid.side
        image = self._image(row)
        if image is not None:
            painter.drawImage(QRectF(left, top, side, side), image)
        chosen = row in self.chosen
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(QColor(self._theme.accent if chosen else self._theme.line), 2.0 if chosen else 1.0))
        painter.drawRoundedRect(QRectF(left + 0.5, top - CAPTION + 0.5, side - 1, side + CAPTION - 1), 6, 6)
        self._paint_caption(painter, QRect(left + 10, top - CAPTION, side - 20, CAPTION), row, chosen)

    def _paint_caption(self, painter: QPainter, box: QRect, row: int, chosen: bool) -> None:
        font = QFont(self.font())
        font.setWeight(QFont.Weight.DemiBold)
        painter.setFont(font)
        scene = self.scenes[row]
        note = f"{scene.count} segments" if box.width() > 220 else str(scene.count)
        room = painter.fontMetrics().horizontalAdvance(note) + 12
        name = painter.fontMetrics().elidedText(self.names[row], Qt.TextElideMode.ElideMiddle, box.width() - room)
        painter.setPen(QColor(self._theme.accent if chosen else self._theme.ink))
        painter.drawText(box, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, name)
        painter.setFont(self.font())
        painter.setPen(QColor(self._theme.soft_ink))
        painter.drawText(box, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignRight, note)

    def _frame(self, row: int) -> QRect:
        left, top = corner(self.grid, row)
        return QRect(left - 2, top - CAPTION - 2, self.grid.side + 4, self.grid.side + CAPTION + 4)

    # --- mouse

    def under(self, at: QPointF) -> tuple[int, int] | None:
        """Shape and part under a point; the part is -1 beside the surface and where a segment has none."""
        found = tile_at(self.grid, len(self.scenes), at.x(), at.y())
        if found is None:
            return None
        row, x, y = found
        tile = self._tiles[row] if row < len(self._tiles) else None
        segment = segment_at(tile, x, y) if tile is not None and y >= 0 else -1
        return row, int(self.parts[row][segment]) if segment >= 0 else -1

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Remember where a click or a drag begins."""
        self._pressed, self._from, self._dragging = event.position(), self._turn, False

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Turn all shapes by a drag; else show what a click would do."""
        if self._pressed is None:
            here = self.under(event.position())
            self.setCursor(Qt.CursorShape.PointingHandCursor if here is not None else Qt.CursorShape.ArrowCursor)
            if here is not None:
                name = self.names[here[0]]
                self.setToolTip(f"{name}, part {here[1] + 1}" if here[1] >= 0 else f"{name}: click to choose it for a pair")
            return
        moved = event.position() - self._pressed
        self._dragging |= moved.manhattanLength() > _CLICK
        if self._dragging:
            self.turn_to(self._from - _DEGREES * moved.x())

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Report what was clicked."""
        if self._pressed is not None and not self._dragging:
            here = self.under(event.position())
            if here is None:
                self.part_clicked.emit(-1)
            elif here[1] >= 0:
                self.part_clicked.emit(-1 if here[1] == self.lit else here[1])
            else:
                self.shape_clicked.emit(here[0])
        self._pressed, self._dragging = None, False

    # --- the end

    def shutdown(self) -> None:
        """Give the VTK window back; called by itself when the widget or the application goes."""
        self._idle.stop()
        self.scenes, self._tiles, self._images, self._waiting = (), [], [], []
        _closer(self._owned)()


def _closer(owned: list[TileMaker]) -> Callable[..., None]:
    """A function that closes what is in the list, once; it does not keep the widget alive."""

    def close(*_: object) -> None:
        while owned:
            owned.pop().close()

    return close
