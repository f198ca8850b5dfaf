"""Writes what a paint function draws as PNG, SVG or PDF."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from PySide6.QtCore import QBuffer, QIODevice, QMarginsF, QRectF, QSize, QSizeF
from PySide6.QtGui import QColor, QImage, QPageSize, QPainter, QPdfWriter
from PySide6.QtSvg import QSvgGenerator

from engine.errors import BadInput
from engine.store import write_atomically

Paint = Callable[[QPainter], object]
KINDS = (".png", ".svg", ".pdf")


def save_figure(path: Path | str, size: tuple[int, int], paint: Paint, paper: str | None, title: str = "") -> None:
    """Write a figure of `size` logical pixels; the ending of `path` says the kind, `paper` None means transparent.

    Raises `BadInput` for another ending or a place that cannot be written to.
    """
    kind = Path(path).suffix.lower()
    if kind not in KINDS:
        raise BadInput(f"{Path(path).name} is no figure that can be written; end the name in .png, .svg or .pdf.")
    if kind == ".png":
        data = png_bytes(size, paint, paper)
    else:
        data = _vector_bytes(kind, size, paint, paper, title)
    write_atomically(path, data)


def png_bytes(size: tuple[int, int], paint: Paint, paper: str | None, scale: float = 2.0) -> bytes:
    """The figure as a PNG with `scale` pixels for each logical one."""
    image = QImage(QSize(*size) * scale, QImage.Format.Format_ARGB32_Premultiplied)
    image.setDevicePixelRatio(scale)
    image.fill(QColor(0, 0, 0, 0) if paper is None else QColor(paper))
    _run(QPainter(image), paint)
    return _encoded(image)


def image_bytes(pixels: np.ndarray) -> bytes:
    """An image (height, width, 3) uint8 as a PNG."""
    data = np.ascontiguousarray(pixels, np.uint8)
    height, width = data.shape[:2]
    return _encoded(QImage(data.data, width, height, 3 * width, QImage.Format.Format_RGB888))


def _encoded(image: QImage) -> bytes:
    buffer = _buffer()
    image.save(buffer, "PNG")
    return bytes(buffer.data().data())


def _vector_bytes(kind: str, size: tuple[int, int], paint: Paint, paper: str | None, title: str) -> bytes:
    buffer, area = _buffer(), QRectF(0, 0, *size)
    if kind == ".svg":
        device = QSvgGenerator()
        device.setOutputDevice(buffer)
        device.setSize(area.size().toSize())
        device.setViewBox(area)
        device.setTitle(title)
    else:
        device = QPdfWriter(buffer)
        device.setTitle(title)
        device.setResolution(96)
        device.setPageSize(QPageSize(QSizeF(size[0] * 0.75, size[1] * 0.75), QPageSize.Unit.Point, "figure",
                                     QPageSize.SizeMatchPolicy.ExactMatch))  # fmt: skip
        device.setPageMargins(QMarginsF())
    painter = QPainter(device)
    if paper is not None:
        painter.fillRect(area, QColor(paper))
    _run(painter, paint)
    return bytes(buffer.data().data())


def _buffer() -> QBuffer:
    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    return buffer


def _run(painter: QPainter, paint: Paint) -> None:
    try:
        paint(painter)
    finally:
        painter.end()
