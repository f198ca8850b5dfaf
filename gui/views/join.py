"""Two pieces of a puzzle, put together and pulled apart: what a volunteer judges a join by."""

from __future__ import annotations

import base64
import binascii
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from engine.errors import BadInput

from ..palette import LIGHT, Theme

LARGEST = 4096  # pixels of a stored side; more is no join that Concord wrote
_APART, _GAP, _MARGIN, _CAPTION = 0.34, 0.25, 24.0, 24.0
_TICK, _MOST = 12.0, 40.0


class Placed(NamedTuple):
    """One piece of a join: its pixels (h, w, 4) uint8 RGBA, and where its top-left one stands."""

    rgba: np.ndarray
    x: int
    y: int

    @property
    def box(self) -> tuple[int, int, int, int]:
        """Left, top, right, bottom."""
        h, w = self.rgba.shape[:2]
        return self.x, self.y, self.x + w, self.y + h


class JoinPicture(NamedTuple):
    """The two pieces of a join as they stand together in a picture of `size` (w, h)."""

    size: tuple[int, int]
    pieces: tuple[Placed, Placed]


def join_picture(payload: Mapping[str, Any]) -> JoinPicture:
    """What the payload of an item of kind "puzzle" shows; raises `BadInput` where it is not one."""
    try:
        w, h = (int(side) for side in payload["size"])
        first, second = (Placed(_rgba(p["png"]), int(p["x"]), int(p["y"])) for p in payload["pieces"])
    except (KeyError, TypeError, ValueError, OverflowError, binascii.Error):
        raise BadInput("The pictures of a join in this study are damaged; add its solution again.") from None
    inside = all(min(p.box[:2]) >= 0 and p.box[2] <= w + 1 and p.box[3] <= h + 1 for p in (first, second))
    if not (inside and 0 < max(w, h) <= LARGEST):
        raise BadInput("The pieces of a join in this study do not lie in their picture; add its solution again.")
    return JoinPicture((w, h), (first, second))


def _rgba(png: str) -> np.ndarray:
    """The pixels (h, w, 4) uint8 of a PNG in base 64; raises `ValueError`."""
    image = QImage.fromData(base64.b64decode(png, validate=True), "PNG")
    if image.isNull() or max(image.width(), image.height()) > LARGEST:
        raise ValueError
    image = image.convertToFormat(QImage.Format.Format_RGBA8888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), image.bytesPerLine())
    return rows[:, : 4 * image.width()].reshape(image.height(), image.width(), 4).copy()


def seam(picture: JoinPicture) -> np.ndarray | None:
    """The two ends (2, 2) of where the pieces touch, in pixels of the picture; None where they do not."""
    w, h = picture.size
    masks = np.zeros((2, h + 2, w + 2), bool)
    for mask, piece in zip(masks, picture.pieces, strict=True):
        left, top, right, bottom = piece.box
        mask[top:bottom, left:right] = piece.rgba[..., 3] > 0
    a, b = masks
    beside = (a[:, :-1] & b[:, 1:]) | (b[:, :-1] & a[:, 1:])
    above = (a[:-1] & b[1:]) | (b[:-1] & a[1:])
    y, x = np.nonzero(beside)
    v, u = np.nonzero(above)
    corners = np.concatenate([np.column_stack(c) for c in ((x + 1, y), (x + 1, y + 1), (u, v + 1), (u + 1, v + 1))])
    if not len(corners):
        return None
    centred = corners - corners.mean(axis=0)
    along = centred @ np.linalg.svd(centred, full_matrices=False)[2][0]
    return corners[[along.argmin(), along.argmax()]].astype(np.float64)


def pulled_apart(picture: JoinPicture) -> JoinPicture:
    """The same pieces with a gap between them, across the seam or, without one, from middle to middle."""
    first, second = picture.pieces
    middles = [np.add((p.x, p.y), np.argwhere(p.rgba[..., 3]).mean(axis=0)[::-1]) for p in (first, second)]
    step, ends = middles[1] - middles[0], seam(picture)
    if ends is not None:
        across = (ends[1] - ends[0])[::-1] * (1, -1)
        step = across if across @ step >= 0 else -across
    gap = max(1, round(_GAP * min(first.rgba.shape[:2] + second.rgba.shape[:2])))
    dx, dy = np.round(step / max(float(np.hypot(*step)), 1e-9) * gap).astype(int).tolist() if step.any() else (gap, 0)
    left, top = min(0, dx), min(0, dy)
    moved = (
        Placed(first.rgba, first.x - left, first.y - top),
        Placed(second.rgba, second.x + dx - left, second.y + dy - top),
    )
    return JoinPicture((picture.size[0] + abs(dx), picture.size[1] + abs(dy)), moved)


def layout(
    together: tuple[int, int], apart: tuple[int, int], size: tuple[float, float], ratio: float
) -> tuple[QRectF, QRectF]:
    """Where the pieces are drawn together and apart in a view of `size` logical pixels.

    Each pixel becomes a whole number of the screen's, `ratio` of which make a logical one, where there is room for it.
    """
    width, height = size[0] - 3 * _MARGIN, size[1] - 2 * _MARGIN - 2 * _CAPTION
    large = _scale(together, (1 - _APART) * width, height, ratio)
    small = min(_scale(apart, _APART * width, height, ratio), max(1 / ratio, np.floor(large * ratio * 0.6) / ratio))
    w, h = together[0] * large, together[1] * large
    u, v = apart[0] * small, apart[1] * small
    left, middle = (size[0] - w - u - 2 * _MARGIN) / 2, _MARGIN + height / 2
    corners = np.array([[left, middle - h / 2], [left + w + 2 * _MARGIN, middle - v / 2]])
    (x, y), (x2, y2) = (np.round(corners * ratio) / ratio).tolist()
    return QRectF(x, y, w, h), QRectF(x2, y2, u, v)


def _scale(size: tuple[int, int], width: float, height: float, ratio: float) -> float:
    fit = min(width / size[0], height / size[1], _MOST)
    return max(np.floor(fit * ratio) / ratio, 0.05) if fit * ratio >= 1 else max(fit, 0.05)


def paint_join(painter: QPainter, box: QRectF, picture: JoinPicture, theme: Theme) -> None:
    """The pieces with nothing smoothed, enlarged to fill `box`, with a hair line around them."""
    scale = box.width() / picture.size[0]
    painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, False)
    images = [(_image(p.rgba), QRectF(box.left() + p.x * scale, box.top() + p.y * scale, p.rgba.shape[1] * scale,
                                      p.rgba.shape[0] * scale)) for p in picture.pieces]  # fmt: skip
    for image, place in images:
        line = _silhouette(image, QColor(theme.undecided))
        for dx, dy in ((-1, 0), (1, 0), (0, -1), (0, 1)):
            painter.drawImage(place.translated(dx, dy), line)
    for image, place in images:
        painter.drawImage(place, image)


def paint_seam(painter: QPainter, box: QRectF, picture: JoinPicture, theme: Theme) -> None:
    """A short thin line beyond either end of the seam, so that the seam itself stays bare."""
    ends = seam(picture)
    if ends is None:
        return
    scale = box.width() / picture.size[0]
    along = (ends[1] - ends[0]) / max(float(np.hypot(*(ends[1] - ends[0]))), 1e-9)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(QPen(QColor(theme.accent), 2.0, Qt.PenStyle.SolidLine, Qt.PenCapStyle.FlatCap))
    for end, out in ((ends[0], -along), (ends[1], along)):
        start = QPointF(box.left() + end[0] * scale, box.top() + end[1] * scale) + QPointF(*(3 * out))
        painter.drawLine(start, start + QPointF(*(_TICK * out)))


def _image(rgba: np.ndarray) -> QImage:
    h, w = rgba.shape[:2]
    return QImage(rgba.tobytes(), w, h, 4 * w, QImage.Format.Format_RGBA8888).copy()


def _silhouette(image: QImage, colour: QColor) -> QImage:
    flat = image.convertToFormat(QImage.Format.Format_ARGB32_Premultiplied)
    painter = QPainter(flat)
    painter.setCompositionMode(QPainter.CompositionMode.CompositionMode_SourceIn)
    painter.fillRect(flat.rect(), colour)
    painter.end()
    return flat


class JoinView(QWidget):
    """Shows one join: together and large at the left, pulled apart and small at the right."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._theme = LIGHT
        self.picture: JoinPicture | None = None
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setMinimumSize(320, 200)

    def set_picture(self, picture: JoinPicture) -> None:
        """Show another join."""
        self.picture = picture
        self.update()

    def set_theme(self, theme: Theme) -> None:
        """Change between light and dark."""
        self._theme = theme
        self.update()

    def sizeHint(self) -> QSize:
        """As large as there is room."""
        return QSize(900, 480)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw both pictures with their captions."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor(self._theme.paper))
        if self.picture is not None:
            self._paint(painter, self.picture)
        painter.end()

    def _paint(self, painter: QPainter, picture: JoinPicture) -> None:
        apart = pulled_apart(picture)
        boxes = layout(picture.size, apart.size, (self.width(), self.height()), self.devicePixelRatioF())
        for box, shown, words in zip(boxes, (picture, apart), ("together", "pulled apart"), strict=True):
            paint_join(painter, box, shown, self._theme)
            painter.setPen(QColor(self._theme.soft_ink))
            below = QRectF(box.center().x() - 100, box.bottom() + _TICK + 8, 200, _CAPTION)
            painter.drawText(below, Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignTop, words)
        paint_seam(painter, boxes[0], picture, self._theme)
