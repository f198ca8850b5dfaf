"""Drawing of links and captions with QPainter: the same for the screen, PNG, SVG and PDF."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QFont, QPainter, QPainterPath, QPen, QPolygonF

from ..palette import Theme, segment_colours
from .links import LinkShape, marked, signed
from .scene import Link

_DASHES = {"wrong": [5.0, 3.0], "tie": [1.0, 2.2]}
_SYMBOL, _PIN, _HOLE = 8.0, 11.5, 4.0
_FADED = 0.16
_SYMBOL_STRENGTH = 0.8


def paint_links(
    painter: QPainter,
    shapes: Sequence[LinkShape],
    theme: Theme,
    selected: str | None = None,
    hovered: str | None = None,
    coloured: bool = False,
) -> None:
    """Draw all links: polygons below lines, the hovered and the selected one on top, and no line across a symbol."""
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    rank = {hovered: 2, selected: 3}
    ordered = sorted(shapes, key=lambda s: rank.get(s.link.id, 0 if s.link.merged else 1))
    for shape in ordered:
        chosen = shape.link.id == selected
        painter.setOpacity(_strength(shape, selected, hovered))
        own = coloured and not marked(shape.link)
        colour = _own(shape) if own else QColor(theme.state(shape.link.state))
        width = line_width(shape, chosen or shape.link.id == hovered, own)
        paint_link(painter, shape, theme, colour, width, chosen)
    for shape in ordered:
        strength = _strength(shape, selected, hovered)
        if signed(shape.link) and strength > _FADED:
            painter.setOpacity(max(strength, _SYMBOL_STRENGTH))
            _paint_symbol(painter, shape.link, shape.symbol, theme)
    painter.setOpacity(1.0)


def _strength(shape: LinkShape, selected: str | None, hovered: str | None) -> float:
    if shape.link.id in (selected, hovered):
        return 1.0
    if selected is not None:
        usual = _FADED / 2 if shape.folded else _FADED
    else:
        usual = 1.0 if not shape.folded else 0.6 if marked(shape.link) else 0.35
    return usual * (0.4 if shape.hidden else 1.0) * (0.25 + 0.75 * min(1.0, 1.6 * shape.link.support))


def paint_link(painter: QPainter, shape: LinkShape, theme: Theme, colour: QColor, width: float, selected: bool) -> None:
    """Draw one link without its symbol: a halo, the line or polygon in its colour and dash, its anchors.

    A link that fades behind the selected one is only a line or polygon.
    """
    faded = painter.opacity() <= _FADED
    if len(shape.outline) > 2 and not faded:
        fill = _own(shape)
        fill.setAlphaF(0.42 if selected else 0.20)
        painter.fillPath(_polygon(shape), fill)
    if selected:
        glow = QColor(colour)
        glow.setAlphaF(0.25)
        _stroke(painter, shape, _pen(glow, width + 12))
        _stroke(painter, shape, _pen(QColor(theme.halo), width + 4))
    elif not faded and not shape.folded:
        _stroke(painter, shape, _flat(_pen(QColor(theme.paper), width + 2)))
    pen = _flat(_pen(colour, width))
    if shape.link.state in _DASHES:
        pen.setDashPattern(_DASHES[shape.link.state])
    _stroke(painter, shape, pen)
    if not (faded or shape.folded):
        _paint_dots(painter, shape, theme, colour, selected)


def _stroke(painter: QPainter, shape: LinkShape, pen: QPen) -> None:
    """Draw the outline; a plain opaque line with flat ends costs Qt an eighth of the same path."""
    painter.setPen(pen)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    if len(shape.outline) == 2:
        (x, y), (u, v) = shape.outline.tolist()
        painter.drawLine(QPointF(x, y), QPointF(u, v))
    else:
        painter.drawPath(_polygon(shape))


def _own(shape: LinkShape) -> QColor:
    """The colour of the first source segment, so that links can be told apart whatever was judged."""
    first = shape.link.source[0]
    return QColor(*map(int, segment_colours(first + 1)[first]))


def line_width(shape: LinkShape, strong: bool, coloured: bool = False) -> float:
    """Width in pixels: judged links stand out from grey ones, a better score is a little thicker, a pin more."""
    if strong:
        return 4.0
    plain = 0.6 if shape.folded else 2.2 if coloured or marked(shape.link) else 1.3
    return plain + 0.7 * float(np.clip(shape.link.score, 0.0, 1.0)) + (1.4 if shape.link.pinned else 0.0)


def _polygon(shape: LinkShape) -> QPainterPath:
    path = QPainterPath()
    path.addPolygon(QPolygonF([QPointF(x, y) for x, y in shape.outline.tolist()]))
    path.closeSubpath()
    return path


def _pen(colour: QColor, width: float) -> QPen:
    return QPen(QBrush(colour), width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap, Qt.PenJoinStyle.RoundJoin)


def _flat(pen: QPen) -> QPen:
    pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    return pen


def _paint_dots(painter: QPainter, shape: LinkShape, theme: Theme, colour: QColor, selected: bool) -> None:
    """A dot at each anchor: full where it is seen, a ring where something hides it."""
    radius = 5.0 if selected else 3.5
    for (x, y), seen in zip(shape.dots.tolist(), shape.seen.tolist(), strict=True):
        painter.setPen(_pen(QColor(theme.halo) if seen else colour, 1.5))
        painter.setBrush(colour if seen else QColor(theme.paper))
        painter.drawEllipse(QPointF(x, y), radius, radius)


def _paint_symbol(painter: QPainter, link: Link, at: np.ndarray, theme: Theme) -> None:
    """A tick, a cross or two bars in a disc, drawn as strokes so that no font is needed; a pin's head about it."""
    x, y = map(float, at)
    if link.pinned:
        painter.setPen(_pen(QColor(theme.halo), 1.5))
        painter.setBrush(QColor(theme.ink))
        painter.drawEllipse(QPointF(x, y), _PIN, _PIN)
    if not marked(link):
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(theme.paper))
        painter.drawEllipse(QPointF(x, y), _HOLE, _HOLE)
        return
    painter.setPen(_pen(QColor(theme.halo), 1.5))
    painter.setBrush(QColor(theme.state(link.state)))
    painter.drawEllipse(QPointF(x, y), _SYMBOL, _SYMBOL)
    painter.setPen(_pen(QColor("#FFFFFF"), 2.0))
    strokes = {
        "correct": [[(-3.6, 0.3), (-1.0, 3.0), (3.8, -2.8)]],
        "wrong": [[(-2.9, -2.9), (2.9, 2.9)], [(-2.9, 2.9), (2.9, -2.9)]],
        "tie": [[(-3.4, -1.8), (3.4, -1.8)], [(-3.4, 1.8), (3.4, 1.8)]],
    }[link.state]
    for stroke in strokes:
        painter.drawPolyline(QPolygonF([QPointF(x + u, y + v) for u, v in stroke]))


def paint_caption(painter: QPainter, box: QRectF, name: str, note: str, theme: Theme, align_right: bool) -> None:
    """The name of a shape with a soft note behind it, at the top of its half."""
    font = QFont(painter.font())
    font.setPixelSize(14)
    font.setWeight(QFont.Weight.Normal)
    strong = QFont(font)
    strong.setWeight(QFont.Weight.DemiBold)
    painter.setFont(strong)
    box = box.adjusted(16, 12, -16, 0)
    metrics = painter.fontMetrics()
    name = metrics.elidedText(name, Qt.TextElideMode.ElideMiddle, int(box.width() * 0.6))
    width = metrics.horizontalAdvance(name)
    height = metrics.height()
    painter.setFont(font)
    note_width = painter.fontMetrics().horizontalAdvance(note)
    left = box.right() - width - 10 - note_width if align_right else box.left()
    painter.setPen(QColor(theme.soft_ink))
    painter.drawText(QRectF(left + width + 10, box.top(), note_width + 4, height), Qt.AlignmentFlag.AlignLeft, note)
    painter.setFont(strong)
    painter.setPen(QColor(theme.ink))
    painter.drawText(QRectF(left, box.top(), width + 4, height), Qt.AlignmentFlag.AlignLeft, name)


def paint_message(painter: QPainter, box: QRectF, text: str, theme: Theme, active: bool = False) -> None:
    """An empty state: a dashed frame to drop files into, and what to do."""
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    frame = box.adjusted(24, 24, -24, -24)
    pen = _pen(QColor(theme.accent if active else theme.line), 2.0)
    pen.setDashPattern([4.0, 4.0])
    painter.setPen(pen)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.drawRoundedRect(frame, 12, 12)
    font = QFont(painter.font())
    font.setPixelSize(16)
    painter.setFont(font)
    painter.setPen(QColor(theme.soft_ink))
    flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
    painter.drawText(frame.adjusted(32, 32, -32, -32), flags, text)
