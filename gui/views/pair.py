"""Two panes and the links between them as one drawing, for the widget, for figures and for headless pictures."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QRectF
from PySide6.QtGui import QColor, QPainter

from ..palette import Theme, rgb, segment_colours
from .cameras import Camera, candidate_directions, fitting_distance, look_from, view_scores
from .links import LinkShape, folded, lay_out
from .painting import paint_caption, paint_links
from .pane import Pane, Surface
from .scene import Link, Scene, union_colours

_CAPTION = 36
_REST_IN_THE_DARK = "#7C818A"  # a shape without links beside it should still be seen as a whole


class PairDrawing:
    """The source at the left, the target at the right, links above both. `close` it before its owner goes.

    `coloured` gives each link that is not judged the colour of its first source segment instead of grey.
    """

    def __init__(self, theme: Theme, coloured: bool = False) -> None:
        self._coloured = coloured
        self.theme = theme
        self.panes = (Pane(theme), Pane(theme))
        self._links: tuple[Link, ...] = ()
        self._folded: frozenset[str] = frozenset()
        self.selected: str | None = None
        self.hovered: str | None = None
        self.captions = True
        self.through = False  # whether what is highlighted shines through what hides it
        self._highlight: tuple[tuple[int, ...], tuple[int, ...]] = ((), ())
        self._strong: np.ndarray | None = None
        self._base: list[np.ndarray | None] = [None, None]

    # --- what is shown

    def set_scenes(self, source: Scene | Surface, target: Scene | Surface, aspect: float) -> None:
        """Show two shapes from the usual side in panes of this width / height; links and highlights are dropped."""
        self.links, self.selected, self.hovered = (), None, None
        self._highlight, self._base = ((), ()), [None, None]
        for pane, scene in zip(self.panes, (source, target), strict=True):
            pane.set_scene(scene)
        for pane, camera in zip(self.panes, self.home(aspect), strict=True):
            pane.camera = camera
        self._recolour()

    @property
    def links(self) -> tuple[Link, ...]:
        """What is drawn between the shapes; polygons that would lie over others are folded to thin lines."""
        return self._links

    @links.setter
    def links(self, links: Sequence[Link]) -> None:
        self._links, self._folded = tuple(links), folded(links)

    def set_theme(self, theme: Theme) -> None:
        """Change between light and dark."""
        self.theme = theme
        for pane in self.panes:
            pane.set_theme(theme)
        self._recolour()

    def set_base_colours(self, source: np.ndarray | None, target: np.ndarray | None) -> None:
        """Colours (s, 3) uint8 of the segments, for instance of a layer; None for each segment's own."""
        self._base = [source, target]
        self._recolour()

    def set_highlight(self, source: Sequence[int], target: Sequence[int], colour: np.ndarray | None = None) -> None:
        """Show two unions in one colour (the first source segment's if None) and fade the rest; nothing if empty."""
        self._highlight, self._strong = (tuple(source), tuple(target)), colour
        self._recolour()

    def _recolour(self) -> None:
        strong = self._strong
        if strong is None and any(self._highlight):
            side = 0 if self._highlight[0] else 1
            strong = self._colours(side)[self._highlight[side][0]]
        for side, pane in enumerate(self.panes):
            if pane.scene is None:
                continue
            colours = self._colours(side)
            if any(self._highlight):
                rest = _REST_IN_THE_DARK if self.through and self.theme.dark else self.theme.faded
                colours = union_colours(colours, self._highlight[side], strong, rgb(rest))
            pane.set_colours(colours)
            pane.show_through(self._highlight[side] if self.through else (), strong)

    def _colours(self, side: int) -> np.ndarray:
        scene, base = self.panes[side].scene, self._base[side]
        assert scene is not None
        return segment_colours(scene.count) if base is None else np.asarray(base, np.uint8)

    # --- cameras

    def home(self, aspect: float) -> tuple[Camera, Camera]:
        """The usual views of both shapes, at the same scale."""
        return self._cameras([candidate_directions()[0]] * 2, aspect)

    def views_of(
        self, source: Sequence[int], target: Sequence[int], aspect: float, together: bool = False
    ) -> tuple[Camera, Camera]:
        """The views in which the given segments are best seen; one common direction if `together`, which is chosen
        for the side that is seen worse first."""
        candidates = candidate_directions()
        wanted = zip(self.panes, (source, target), strict=True)
        scores = [view_scores(pane.scene, segments, candidates) for pane, segments in wanted]
        if together:
            scores = [scores[0] + scores[1] + 4 * np.minimum(*scores)] * 2
        return self._cameras([candidates[int(np.argmax(score))] for score in scores], aspect)

    def _cameras(self, directions: Sequence[np.ndarray], aspect: float) -> tuple[Camera, Camera]:
        pairs = zip(self.panes, directions, strict=True)
        distance = max(fitting_distance(pane.scene, towards, aspect) for pane, towards in pairs)
        return look_from(directions[0], distance), look_from(directions[1], distance)

    # --- the picture

    def shapes(self, width: float, height: float, scale: float) -> list[LinkShape]:
        """The links as they lie in the picture of this size, in logical pixels."""
        places = []
        for side, pane in enumerate(self.panes):
            xy, seen = pane.spots()
            places += [xy / scale + [side * _half(width), 0.0], seen]
        return lay_out(self.links, *places, self._folded - {self.selected})

    def paint(self, painter: QPainter, width: int, height: int, scale: float, moving: bool = False) -> list[LinkShape]:
        """Draw everything into a rectangle of logical pixels, the shapes with `scale` device pixels each.

        Returns where the links lie, for hit tests.
        """
        half = _half(width)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        for side, pane in enumerate(self.panes):
            image = pane.image(round(half * scale), round(height * scale), scale=scale, moving=moving)
            painter.drawImage(QRectF(side * half, 0, half, height), image)
        painter.setPen(QColor(self.theme.line))
        painter.drawLine(round(half), _CAPTION if self.captions else 0, round(half), height)
        shapes = self.shapes(width, height, scale) if self.links else []
        paint_links(painter, shapes, self.theme, self.selected, self.hovered, self._coloured)
        if self.captions:
            self._paint_captions(painter, half)
        return shapes

    def _paint_captions(self, painter: QPainter, half: float) -> None:
        for side, pane in enumerate(self.panes):
            count = pane.scene.count
            note = "1 segment" if count == 1 else f"{count} segments"
            box = QRectF(side * half, 0, half, _CAPTION)
            paint_caption(painter, box, pane.scene.name, note, self.theme, align_right=side == 1)

    def close(self) -> None:
        """Give both VTK windows back."""
        for pane in self.panes:
            pane.close()


def _half(width: float) -> float:
    return width / 2
