"""A join from close by: the two borders pixel by pixel, and the other partners that the side could have."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QFont, QImage, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from engine.puzzles.identity import join_frame, size_of
from engine.puzzles.pieces import Puzzle
from engine.puzzles.solution import Joins
from engine.puzzles.turning import turned_polygon

from ..palette import LIGHT, Theme
from .puzzle_painting import painting
from .puzzle_scene import meetings
from .puzzle_sheet import rasters

LEAST_SCALE = 2.0  # screen pixels for one of a piece
ACROSS, ALONG = 5.0, 1.5  # pixels of a piece that are seen at least: on either side of the seam, and beyond its ends


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """Two joined pieces as they stand, alone: premultiplied BGRA `pixels` (h, w, 4) uint8 and their `seam` (2, 2) in it."""

    pixels: np.ndarray
    seam: np.ndarray


def pair_of(puzzle: Puzzle, joins: Joins, row: int, turns: int) -> Pair:
    """The two pieces of one join; `turns` are the clockwise quarter turns in which piece a stands."""
    (w, h), turned, corners = join_frame(puzzle, joins, row, turns)
    pixels, sides = np.zeros((h, w, 4), np.uint8), []
    for (piece, side), quarters, (u, v) in zip(joins.sides[row].reshape(2, 2).tolist(), turned, corners, strict=True):
        raster = np.rot90(rasters(puzzle)[piece], -quarters)
        part = pixels[v : v + raster.shape[0], u : u + raster.shape[1]]
        np.copyto(part, raster, where=raster[..., 3:] > 0)
        ring = turned_polygon(puzzle.pieces[piece].polygon, size_of(puzzle.pieces[piece], 0), quarters) + np.array([u, v])
        sides.append(ring[[side % len(ring), (side + 1) % len(ring)]])
    return Pair(pixels, meetings(sides[0][None], sides[1][None])[0])


def stretched(pair: Pair) -> Pair:
    """The pair with its tones near the seam spread over the whole range, so that dark or pale borders can be told apart.

    All channels are scaled alike; one in a hundred pixels at either end may be cut off.
    """
    low, high = np.floor(pair.seam.min(axis=0) - 8).astype(int), np.ceil(pair.seam.max(axis=0) + 8).astype(int)
    near = pair.pixels[max(low[1], 0) : high[1], max(low[0], 0) : high[0]]
    seen = near[near[..., 3] == 255][:, :3]
    if not len(seen):
        return pair
    dark, bright = np.percentile(seen, (1, 99))
    wider = (pair.pixels[..., :3].astype(np.float64) - dark) * (255 / max(bright - dark, 1))
    pixels = pair.pixels.copy()
    pixels[..., :3] = np.clip(wider, 0, 255) * (pair.pixels[..., 3:] / 255)
    return Pair(pixels, pair.seam)


class Window(NamedTuple):
    """What a close-up shows: screen = scale · pixels + (x, y)."""

    scale: float
    x: float
    y: float


def window_on(pair: Pair, width: float, height: float, slide: float = 0.0) -> Window:
    """The view of a seam that fills a box: whole where its pixels are then large enough, else a part of it.

    `slide` in [-1, 1] moves along a seam that does not fit.
    """
    low, high = pair.seam.min(axis=0), pair.seam.max(axis=0)
    span = high - low
    room = span + 2 * np.where(span < span.max(), ACROSS, ALONG)
    scale = max(LEAST_SCALE, min(width / room[0], height / room[1]))
    scale = float(np.floor(scale)) if scale >= 3 else float(scale)
    middle = (low + high) / 2
    spare = np.maximum(room * scale - (width, height), 0) / scale / 2
    direction = np.sign(pair.seam[1] - pair.seam[0])
    middle = middle + slide * spare * direction
    return Window(scale, width / 2 - scale * float(middle[0]), height / 2 - scale * float(middle[1]))


def paint_pair(painter: QPainter, box: QRectF, pair: Pair, theme: Theme, slide: float = 0.0, ticks: bool = True) -> None:
    """The two borders in a box, and ticks beside the seam, which itself stays free of lines."""
    view = window_on(pair, box.width(), box.height(), slide)
    painter.save()
    painter.setClipRect(box)
    painter.fillRect(box, QColor(theme.panel))
    painter.translate(box.topLeft())
    h, w = pair.pixels.shape[:2]
    image = QImage(pair.pixels.data, w, h, 4 * w, QImage.Format.Format_ARGB32_Premultiplied)
    painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, on=False)
    painter.drawImage(QRectF(view.x, view.y, w * view.scale, h * view.scale), image)
    if ticks:
        _paint_ticks(painter, pair, view, box, theme)
    painter.restore()


def _paint_ticks(painter: QPainter, pair: Pair, view: Window, box: QRectF, theme: Theme) -> None:
    """A short stroke at either end of the seam, on the rim of the box where it goes on beyond."""
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    ends = pair.seam * view.scale + (view.x, view.y)
    unit = (ends[1] - ends[0]) / max(float(np.hypot(*(ends[1] - ends[0]))), 1e-9)
    for end, away in ((ends[0], -unit), (ends[1], unit)):
        tip = np.clip(end, (1, 1), (box.width() - 1, box.height() - 1))
        start = tip if (tip == end).all() else tip - 12 * away
        stop = start + 12 * away
        for colour, wide in ((theme.halo, 5.0), (theme.accent, 2.5)):
            painter.setPen(QPen(QColor(colour), wide, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
            painter.drawLine(QPointF(*start.tolist()), QPointF(*stop.tolist()))


class JoinCloseup(QWidget):
    """Shows one join; dragging slides along a seam that is too long to be seen at once."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.theme, self.pair, self.slide = LIGHT, None, 0.0
        self._plain: Pair | None = None
        self.stretches = False
        self._last: QPointF | None = None
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.setFixedHeight(224)
        self.setAccessibleName("Close-up of the join")

    def set_theme(self, theme: Theme) -> None:
        """Take other colours."""
        self.theme = theme
        self.update()

    def show_pair(self, pair: Pair | None) -> None:
        """Show a join, or nothing."""
        self._plain, self.slide = pair, 0.0
        self.stretch(self.stretches)

    def stretch(self, on: bool) -> None:
        """Spread the tones of the borders, or show them as they are."""
        self.stretches = on
        self.pair = stretched(self._plain) if on and self._plain is not None else self._plain
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        with painting(self) as painter:
            box = QRectF(self.rect())
            if self.pair is None:
                painter.fillRect(box, QColor(self.theme.panel))
                painter.setPen(QColor(self.theme.soft_ink))
                flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
                painter.drawText(box.adjusted(24, 8, -24, -8), flags, "Click a join to see both borders pixel by pixel.")
            else:
                paint_pair(painter, box, self.pair, self.theme, self.slide)
            painter.setPen(QPen(QColor(self.theme.line), 1))
            painter.drawRect(box.adjusted(0.5, 0.5, -0.5, -0.5))

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self._last = event.position()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self._last is None or self.pair is None:
            return
        step, self._last = event.position() - self._last, event.position()
        low, high = self.pair.seam.min(axis=0), self.pair.seam.max(axis=0)
        scale = window_on(self.pair, self.width(), self.height()).scale
        spare = np.maximum((high - low) * scale - (self.width(), self.height()), 0) / 2
        along = self.pair.seam[1] - self.pair.seam[0]
        axis = int(np.abs(along).argmax())
        if spare[axis] > 0:
            moved = (step.x(), step.y())[axis] / float(spare[axis])
            self.slide = float(np.clip(self.slide - moved * np.sign(along[axis]), -1, 1))
            self.update()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        self._last = None


class Partner(NamedTuple):
    """One partner that a side could have: the join, how sure it is, and whether it is the one shown above."""

    pair: Pair
    confidence: str
    colour: str
    current: bool
    tip: str


class PartnerStrip(QWidget):
    """The likeliest partners of one side, side by side; a click looks at one."""

    picked = Signal(int)
    SIZE, GAP, TEXT, MOST = 76, 6, 22, 4

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.theme, self.partners, self.stretches = LIGHT, (), False
        self.setFixedHeight(self.SIZE + self.TEXT)
        self.setMouseTracking(True)
        self.setAccessibleName("Other partners of this side")

    def set_theme(self, theme: Theme) -> None:
        """Take other colours."""
        self.theme = theme
        self.update()

    def show_partners(self, partners: tuple[Partner, ...]) -> None:
        """Show these, best first."""
        self.partners = partners[: self.MOST]
        self.update()

    def stretch(self, on: bool) -> None:
        """Spread the tones of the borders, or show them as they are."""
        self.stretches = on
        self.update()

    def _box(self, k: int) -> QRectF:
        return QRectF(k * (self.SIZE + self.GAP), 0, self.SIZE, self.SIZE)

    def paintEvent(self, event: QPaintEvent) -> None:
        with painting(self) as painter:
            font = QFont(self.font())
            font.setPixelSize(12)
            painter.setFont(font)
            for k, partner in enumerate(self.partners):
                box = self._box(k)
                pair = stretched(partner.pair) if self.stretches else partner.pair
                paint_pair(painter, box, pair, self.theme, ticks=False)
                strong = partner.current
                painter.setPen(QPen(QColor(self.theme.accent if strong else self.theme.line), 3 if strong else 1))
                painter.setBrush(Qt.BrushStyle.NoBrush)
                painter.drawRect(box.adjusted(1, 1, -1, -1))
                painter.setPen(QPen(QColor(partner.colour), 4))
                middle = box.bottom() + self.TEXT / 2
                painter.drawLine(QPointF(box.left() + 4, middle), QPointF(box.left() + 18, middle))
                painter.setPen(QColor(self.theme.ink if strong else self.theme.soft_ink))
                words = QRectF(box.left() + 26, box.bottom(), box.width() - 26, self.TEXT)
                painter.drawText(words, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, partner.confidence)

    def _at(self, event: QMouseEvent) -> int:
        return next((k for k in range(len(self.partners)) if self._box(k).contains(event.position())), -1)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        k = self._at(event)
        self.setToolTip(self.partners[k].tip if k >= 0 else "")
        self.setCursor(Qt.CursorShape.PointingHandCursor if k >= 0 else Qt.CursorShape.ArrowCursor)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        k = self._at(event)
        if k >= 0:
            self.picked.emit(k)
