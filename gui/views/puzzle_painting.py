"""What lies over the pieces: joins by confidence, judgements, padlocks, outlines, the tray and its name."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QFont, QImage, QPainter, QPen, QPolygonF
from PySide6.QtWidgets import QWidget

from ..palette import Theme
from .puzzle_layout import Box, Layout, outlines
from .puzzle_scene import BINS, View, bin_colours, in_view, widths
from .puzzle_sheet import rasters
from .puzzle_snap import Carried

_SYMBOL = 8.0


@contextmanager
def painting(widget: QWidget) -> Iterator[QPainter]:
    """A painter that ends whatever happens; one that does not takes the program with it."""
    painter = QPainter(widget)
    try:
        yield painter
    finally:
        painter.end()


def no_rows() -> np.ndarray:
    """No rows."""
    return np.zeros(0, np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class Overlay:
    """What is drawn over the pieces of one layout.

    `seams` (j, 2, 2) are the joins on the canvas, `bins` (j,) their colours, `shown` (j,) bool which are drawn; `judged`
    says 'correct', 'wrong' or 'tie' by row, `locked` (j,) bool which a person holds. `selected` is a row, `piece` a
    piece, -1 for none, whose `sides` (k, 2, 2) are drawn in the colours `side_bins` (k,) of their best partners; `pinned`
    pieces stay put. `wrong_pieces` and `wrong_joins` are rows marked as errors where the
    truth is known and wanted. `ghost` (k, 2) outlines where a piece would stand that is tried out.
    """

    seams: np.ndarray = field(default_factory=lambda: np.zeros((0, 2, 2)))
    bins: np.ndarray = field(default_factory=no_rows)
    shown: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))
    judged: dict[int, str] = field(default_factory=dict)
    locked: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))
    selected: int = -1
    piece: int = -1
    pinned: tuple[int, ...] = ()
    wrong_pieces: np.ndarray = field(default_factory=no_rows)
    wrong_joins: np.ndarray = field(default_factory=no_rows)
    sides: np.ndarray = field(default_factory=lambda: np.zeros((0, 2, 2)))
    side_bins: np.ndarray = field(default_factory=no_rows)
    ghost: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    caption: str = ""


class Extent(NamedTuple):
    """The size of the window in logical pixels and the device pixels for one of them."""

    width: int
    height: int
    ratio: float


def draw_joins(picture: np.ndarray, overlay: Overlay, view: View, ratio: float, theme: Theme) -> None:
    """Draw the shown joins into a picture (h, w, 4) uint8 BGRA: doubtful ones thick, on top, with a dark edge."""
    import cv2

    h, w = picture.shape[:2]
    plain = overlay.shown.copy()
    plain[list(overlay.judged)] = False  # those have the colour of their verdict
    bins = np.concatenate([overlay.bins[plain], overlay.side_bins])
    segments = view.to_screen(np.concatenate([overlay.seams[plain], overlay.sides])) * ratio
    seen = in_view(segments, w, h)
    bins, segments = bins[seen], segments[seen]
    if not len(bins):
        return
    side = float(np.median(np.hypot(*(segments[:, 1] - segments[:, 0]).T))) / ratio
    thick = np.maximum(1, np.round(widths(side) * ratio)).astype(int)
    points = np.round(segments * 16).astype(np.int32)
    colours = bin_colours(theme)
    for k in range(BINS - 1, -1, -1):
        lines = list(points[bins == k])
        if not lines:
            continue
        red, green, blue = (int(c) for c in colours[k])
        style = cv2.LINE_AA if len(lines) <= 3000 else cv2.LINE_8
        if k < BINS // 2 and side > 10:
            cv2.polylines(picture, lines, False, (22, 18, 16, 255), int(thick[k] + 2 * round(ratio)), style, 4)
        cv2.polylines(picture, lines, False, (blue, green, red, 255), int(thick[k]), style, 4)


def paint_ground(painter: QPainter, layout: Layout, view: View, theme: Theme) -> None:
    """The areas below the pieces: hatched where a picture has gaps, a tray with its name."""
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    for area in layout.pictures:
        box = _screen(area, view)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(theme.panel))
        painter.drawRect(box)
        painter.setPen(_pen(QColor(theme.line), 1))
        painter.setBrush(QBrush(QColor(theme.line), Qt.BrushStyle.BDiagPattern))
        painter.drawRect(box)
    if layout.tray is not None:
        box = _screen(layout.tray, view)
        painter.setPen(_pen(QColor(theme.line), 1))
        painter.setBrush(QColor(theme.panel))
        painter.drawRoundedRect(box, 8, 8)
        left = int((~layout.placed).sum())
        _label(painter, box, f"Tray · {left} piece{'s' * (left != 1)}", theme)
    if layout.tray is not None or len(layout.pictures) > 1:
        middles = layout.position[layout.placed] + layout.size[layout.placed] / 2
        for k, area in enumerate(layout.pictures, 1):
            inside = ((middles >= area[:2]) & (middles <= (area.x + area.w, area.y + area.h))).all(axis=1).sum()
            name = "Picture" if len(layout.pictures) == 1 else f"Picture {k}"
            _label(painter, _screen(area, view), f"{name} · {inside or 'nothing'} placed{'' if inside else ' yet'}", theme)


def paint_marks(painter: QPainter, layout: Layout, overlay: Overlay, view: View, theme: Theme, extent: Extent) -> None:
    """Errors, judgements, locks, and what is selected, over the pieces."""
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    if len(overlay.wrong_pieces):
        _paint_wrong(painter, layout, overlay, view, theme, extent)
    if overlay.piece >= 0 and not len(overlay.sides):
        outline(painter, view.to_screen(layout.polygon(overlay.piece)), theme)
    if len(overlay.ghost):
        _paint_ghost(painter, view.to_screen(overlay.ghost), theme)
    segments = view.to_screen(overlay.seams)
    if 0 <= overlay.selected < len(segments):
        _paint_selected(painter, segments[overlay.selected], theme)
    marked = sorted({*overlay.judged, *np.flatnonzero(overlay.locked).tolist()})
    if marked:
        seen = in_view(segments[marked], extent.width, extent.height)
        for row in np.array(marked)[seen].tolist():
            _paint_mark(painter, segments[row], overlay.judged.get(row, ""), bool(overlay.locked[row]), theme)
    for piece in overlay.pinned:
        x, y = view.to_screen(layout.position[piece] + layout.size[piece] / 2)
        if -20 < x < extent.width + 20 and -20 < y < extent.height + 20:
            paint_padlock(painter, float(x), float(y), theme)


def _paint_wrong(painter: QPainter, layout: Layout, overlay: Overlay, view: View, theme: Theme, extent: Extent) -> None:
    """A veil and a dashed frame over each misplaced piece, dashes along each wrong join."""
    colour = QColor(theme.wrong)
    veil = QColor(colour)
    veil.setAlpha(72)
    corners, first = view.to_screen(layout.corners()), outlines(layout.puzzle).first
    painter.setPen(_dashed(colour, 1.5))
    painter.setBrush(veil)
    for piece in overlay.wrong_pieces.tolist():
        ring = corners[first[piece] : first[piece + 1]]
        if (ring.max(axis=0) > 0).all() and (ring.min(axis=0) < (extent.width, extent.height)).all():
            painter.drawPolygon(_polygon(ring))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setPen(_dashed(colour, 3))
    lines = view.to_screen(overlay.seams[overlay.wrong_joins])
    for segment in lines[in_view(lines, extent.width, extent.height)]:
        _line(painter, segment)


def paint_carried(painter: QPainter, layout: Layout, carried: Carried, view: View, theme: Theme) -> None:
    """Carried pieces where they would come to rest, with a frame that says whether they snapped."""
    step = carried.step(layout)
    for piece in sorted(carried.pieces):
        raster = np.ascontiguousarray(np.rot90(rasters(layout.puzzle)[piece], -int(layout.turns[piece])))
        h, w = raster.shape[:2]
        image = QImage(raster.data, w, h, 4 * w, QImage.Format.Format_ARGB32_Premultiplied)
        painter.save()
        painter.translate(*view.to_screen(layout.position[piece] + step).tolist())
        painter.scale(view.scale, view.scale)
        painter.drawImage(QPointF(0, 0), image)
        painter.restore()
        outline(painter, view.to_screen(layout.polygon(piece) + step), theme, carried.rest[2])


def paint_outlines(painter: QPainter, layout: Layout, pieces: tuple[int, ...], view: View, theme: Theme) -> None:
    """Frames around pieces."""
    corners, first = view.to_screen(layout.corners()), outlines(layout.puzzle).first
    for piece in pieces:
        outline(painter, corners[first[piece] : first[piece + 1]], theme)


def _paint_ghost(painter: QPainter, ring: np.ndarray, theme: Theme) -> None:
    """A dashed frame."""
    painter.setPen(_pen(QColor(theme.halo), 5))
    painter.drawPolygon(_polygon(ring))
    painter.setPen(_dashed(QColor(theme.accent), 3))
    painter.drawPolygon(_polygon(ring))


def outline(painter: QPainter, ring: np.ndarray, theme: Theme, strong: bool = True) -> None:
    """A frame around a piece (k, 2): one that is chosen or has found its place, or a faint one."""
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for colour, width in ((theme.halo, 5), (theme.accent if strong else theme.undecided, 2.5)):
        painter.setPen(_pen(QColor(colour), width))
        painter.drawPolygon(_polygon(ring))


def _paint_selected(painter: QPainter, segment: np.ndarray, theme: Theme) -> None:
    """Thick, with a light halo, and knobs at its ends."""
    for colour, width in ((QColor("#101214"), 11), (QColor(theme.halo), 8), (QColor(theme.accent), 4)):
        painter.setPen(_pen(colour, width))
        _line(painter, segment)
    painter.setPen(_pen(QColor("#101214"), 1.5))
    painter.setBrush(QColor(theme.halo))
    for x, y in segment.tolist():
        painter.drawEllipse(QPointF(x, y), 4.5, 4.5)
    painter.setBrush(Qt.BrushStyle.NoBrush)


def _paint_mark(painter: QPainter, segment: np.ndarray, judged: str, locked: bool, theme: Theme) -> None:
    """A judged join in the colour of its verdict with its symbol; a locked one with a padlock."""
    x, y = segment.mean(axis=0).tolist()
    long = float(np.hypot(*(segment[1] - segment[0])))
    if judged:
        colour = QColor(theme.state(judged))
        painter.setPen(_pen(QColor(theme.halo), 6))
        _line(painter, segment)
        painter.setPen(_dashed(colour, 4) if judged == "wrong" else _pen(colour, 4))
        _line(painter, segment)
    if long < 14:
        return
    if judged:
        _paint_symbol(painter, x, y, judged, theme)
    if locked:
        paint_padlock(painter, x + (2.2 * _SYMBOL if judged else 0), y, theme)


def _paint_symbol(painter: QPainter, x: float, y: float, judged: str, theme: Theme) -> None:
    painter.setPen(_pen(QColor(theme.halo), 1.5))
    painter.setBrush(QColor(theme.state(judged)))
    painter.drawEllipse(QPointF(x, y), _SYMBOL, _SYMBOL)
    painter.setPen(_pen(QColor("#FFFFFF"), 2))
    strokes = {
        "correct": [[(-3.6, 0.3), (-1.0, 3.0), (3.8, -2.8)]],
        "wrong": [[(-2.9, -2.9), (2.9, 2.9)], [(-2.9, 2.9), (2.9, -2.9)]],
        "tie": [[(-3.4, -1.8), (3.4, -1.8)], [(-3.4, 1.8), (3.4, 1.8)]],
    }[judged]
    for stroke in strokes:
        painter.drawPolyline(QPolygonF([QPointF(x + u, y + v) for u, v in stroke]))
    painter.setBrush(Qt.BrushStyle.NoBrush)


def paint_padlock(painter: QPainter, x: float, y: float, theme: Theme) -> None:
    """A padlock in a disc, drawn as strokes so that no font is needed."""
    painter.setPen(_pen(QColor("#101214"), 1))
    painter.setBrush(QColor(theme.halo))
    painter.drawEllipse(QPointF(x, y), _SYMBOL + 1, _SYMBOL + 1)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setPen(_pen(QColor("#22252A"), 1.6))
    painter.drawArc(QRectF(x - 2.6, y - 5.6, 5.2, 6.4), 0, 180 * 16)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(QColor("#22252A"))
    painter.drawRoundedRect(QRectF(x - 4, y - 1.6, 8, 6.2), 1.2, 1.2)
    painter.setBrush(Qt.BrushStyle.NoBrush)


def paint_caption(painter: QPainter, text: str, height: int, theme: Theme) -> None:
    """A line of text on a plate in the lower left corner of a window of that height."""
    painter.setFont(_font(painter, 13))
    metrics = painter.fontMetrics()
    box = QRectF(8, height - metrics.height() - 14, metrics.horizontalAdvance(text) + 20, metrics.height() + 8)
    painter.setPen(_pen(QColor(theme.line), 1))
    painter.setBrush(QColor(theme.raised))
    painter.drawRoundedRect(box, 6, 6)
    painter.setPen(QColor(theme.ink))
    painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)
    painter.setBrush(Qt.BrushStyle.NoBrush)


def _label(painter: QPainter, box: QRectF, text: str, theme: Theme) -> None:
    painter.setFont(_font(painter, 12))
    painter.setPen(QColor(theme.soft_ink))
    painter.drawText(QPointF(box.left() + 2, box.top() - 6), text)


def _font(painter: QPainter, pixels: int) -> QFont:
    font = QFont(painter.font())
    font.setPixelSize(pixels)
    return font


def _screen(box: Box, view: View) -> QRectF:
    x, y = view.to_screen(np.array([box.x, box.y])).tolist()
    return QRectF(x, y, box.w * view.scale, box.h * view.scale)


def _polygon(points: np.ndarray) -> QPolygonF:
    return QPolygonF([QPointF(x, y) for x, y in points.tolist()])


def _line(painter: QPainter, segment: np.ndarray) -> None:
    (x0, y0), (x1, y1) = segment.tolist()
    painter.drawLine(QPointF(x0, y0), QPointF(x1, y1))


def _pen(colour: QColor, width: float) -> QPen:
    return QPen(QBrush(colour), width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap, Qt.PenJoinStyle.RoundJoin)


def _dashed(colour: QColor, width: float) -> QPen:
    pen = QPen(QBrush(colour), width, Qt.PenStyle.CustomDashLine, Qt.PenCapStyle.FlatCap)
    pen.setDashPattern([max(1.0, 7 / width), max(1.0, 4 / width)])
    return pen
