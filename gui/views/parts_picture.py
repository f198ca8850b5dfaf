"""A match as one picture for a report: both shapes, the matched parts in one strong colour, seen from a good side."""

from __future__ import annotations

from annotation.results.shownitems import ShownParts

from ..palette import LIGHT, Theme, rgb
from .figures import png_bytes
from .pictures import be_ready
from .scene import prepare


def draw_parts(shown: ShownParts, size: tuple[int, int] = (900, 420), theme: Theme = LIGHT) -> bytes:
    """The two shapes with their marked segments as a PNG of `size` logical pixels, two pixels each.

    Raises `ConcordError` where VTK or Qt cannot draw.
    """
    be_ready()
    from .pair import PairDrawing

    drawing, aspect = PairDrawing(theme), size[0] / 2 / size[1]
    try:
        drawing.through = True
        drawing.set_scenes(prepare(shown.source), prepare(shown.target), aspect)
        drawing.set_highlight(shown.source_segments, shown.target_segments, rgb(theme.accent))
        cameras = drawing.views_of(shown.source_segments, shown.target_segments, aspect, together=True)
        for pane, camera in zip(drawing.panes, cameras, strict=True):
            pane.camera = camera
        return png_bytes(size, lambda painter: drawing.paint(painter, *size, 2.0), theme.paper)
    finally:
        drawing.close()
