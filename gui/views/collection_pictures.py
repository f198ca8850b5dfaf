"""Pictures of a collection for reports, drawn without a screen."""

from __future__ import annotations

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QFont, QPainter

from engine.shapes.collection_result import CollectionResult

from ..palette import LIGHT, Theme
from .aligning import aligned
from .collection_layout import CAPTION, corner, grid_for
from .figures import png_bytes
from .pictures import be_ready
from .scene import prepare

MOST = 60
_WIDTH = 1200


def collection_pictures(found: CollectionResult, theme: Theme = LIGHT) -> list[tuple[str, bytes]]:
    """Title and PNG of all shapes (the first 60 of many) in the colours of their parts; raises `ConcordError`."""
    be_ready()
    from .tiles import TileMaker, coloured, groups, part_colours

    shown = found.shapes[:MOST]
    scenes = aligned([prepare(shape) for shape in shown], found.parts[:MOST])
    grid = grid_for(len(shown), _WIDTH, 700)
    maker = TileMaker(theme)
    try:
        images = [
            coloured(maker.tile(scene, grid.side * 2), part_colours(parts, theme), groups(parts), theme)
            for scene, parts in zip(scenes, found.parts, strict=False)
        ]
    finally:
        maker.close()

    def paint(painter: QPainter) -> None:
        font = QFont(painter.font())
        font.setPixelSize(14)
        painter.setFont(font)
        painter.setPen(QColor(theme.ink))
        for row, image in enumerate(images):
            left, top = corner(grid, row)
            painter.drawImage(QRectF(left, top, grid.side, grid.side), image)
            name = painter.fontMetrics().elidedText(found.names[row], Qt.TextElideMode.ElideMiddle, grid.side)
            painter.drawText(QRectF(left, top - CAPTION, grid.side, CAPTION), Qt.AlignmentFlag.AlignCenter, name)

    title = f"All shapes in the colours of their {found.part_count} parts; a segment without a part is grey."
    if len(shown) < len(found.shapes):
        title = f"The first {MOST} shapes, in the colours of the {found.part_count} parts of all."
    return [(title, png_bytes((_WIDTH, grid.height), paint, theme.paper))]
