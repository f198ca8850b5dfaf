"""Pictures for reports, drawn without a screen: a shape, a pair with links, and the overviews of a result."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping, Sequence

from PySide6.QtCore import QCoreApplication, QRectF
from PySide6.QtGui import QPainter
from PySide6.QtWidgets import QApplication

from engine.errors import ConcordError
from engine.shapes.result import MatchResult
from engine.shapes.segmentation import SegmentedShape

from .. import glprobe
from ..palette import LIGHT, Theme, segment_colours
from .figures import png_bytes
from .links import main_links
from .scene import Link, links_of, prepare

_app: QCoreApplication | None = None


def draw_pair(
    source: SegmentedShape,
    target: SegmentedShape,
    links: Sequence[Link],
    size: tuple[int, int] = (1200, 600),
    theme: Theme = LIGHT,
) -> bytes:
    """The two shapes and the links between them as a PNG of `size` logical pixels, two pixels each.

    Links that are not judged have the colour of their first source segment. Raises `ConcordError` where VTK or Qt
    cannot draw.
    """
    be_ready()
    from .pair import PairDrawing

    drawing = PairDrawing(theme, coloured=True)
    try:
        drawing.set_scenes(prepare(source), prepare(target), size[0] / 2 / size[1])
        drawing.links = tuple(links)
        return png_bytes(size, lambda painter: drawing.paint(painter, *size, 2.0), theme.paper)
    finally:
        drawing.close()


def draw_shape(shape: SegmentedShape, size: tuple[int, int] = (600, 600), theme: Theme = LIGHT) -> bytes:
    """One shape with its segments as a PNG of `size` logical pixels, two pixels each; raises as `draw_pair`."""
    be_ready()
    from .cameras import candidate_directions, fitting_distance, look_from
    from .pane import Pane

    pane, scene, towards = Pane(theme), prepare(shape), candidate_directions()[0]
    try:
        pane.set_scene(scene)
        pane.set_colours(segment_colours(scene.count))
        pane.camera = look_from(towards, fitting_distance(scene, towards, size[0] / size[1]))
        image = pane.image(2 * size[0], 2 * size[1], scale=2.0)
        return png_bytes(size, _drawer(image, size), theme.paper)
    finally:
        pane.close()


def report_pictures(
    source: SegmentedShape, target: SegmentedShape, result: MatchResult, states: Mapping[str, str] | None = None,
    theme: Theme = LIGHT,
) -> list[tuple[str, bytes]]:  # fmt: skip
    """Titles and PNGs for a report: all one-to-one matches as lines, and matches of merged nodes as polygons.

    Many matches of merged nodes nest in each other; then only small ones that share no segment are drawn. `states` says
    by id which matches are correct and which wrong; these are drawn in the colours of judgements.
    """
    links = links_of(result, states)
    merged = [link for link in links if link.merged]
    main = {link.id for link in main_links(result)}
    shown = [link for link in merged if link.id in main]
    single = [link for link in links if not link.merged]
    pictures = [(_counted(len(single), "one-to-one match", "one-to-one matches"), single)]
    if merged:
        title = _counted(len(merged), "match of merged segments", "matches of merged segments")
        if len(shown) < len(merged):
            title += f", {len(shown)} of them shown: small ones that share no segment"
        pictures.append((title, shown))
    return [(title, draw_pair(source, target, group, theme=theme)) for title, group in pictures]


def _counted(count: int, one: str, many: str) -> str:
    return f"{count} {one if count == 1 else many}"


def _drawer(image: object, size: tuple[int, int]) -> Callable[[QPainter], None]:
    return lambda painter: painter.drawImage(QRectF(0, 0, *size), image)


def be_ready() -> None:
    """Make sure that VTK can draw and that there is a Qt application for text; neither needs a screen."""
    global _app
    sentence = glprobe.problem()
    if sentence is not None:
        raise ConcordError(sentence)
    if QCoreApplication.instance() is None:
        if sys.platform.startswith("linux"):
            os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
        _app = QApplication([])  # of widgets: a window may follow in the same process
