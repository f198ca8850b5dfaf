"""Two shapes with one marked part each, as a volunteer sees them; the next two are drawn while these are looked at."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from PySide6.QtCore import QSize, QTimer
from PySide6.QtGui import QMouseEvent, QResizeEvent
from PySide6.QtWidgets import QStyle, QWidget

from ..palette import Theme, rgb
from .cameras import turned
from .mesh_pair import MeshPairView
from .scene import Scene
from .voting_views import best_views, part_cameras

if TYPE_CHECKING:
    from .pair import PairDrawing
    from .pane import Surface

_PAUSE, _STEP_OF_TURN = 40, 30.0  # ms between two pieces of drawing ahead; degrees of a turn without motion


class ReadyPair(NamedTuple):
    """Two shapes, left and right, made ready for VTK, with their marked segments and the directions (3,) chosen for these."""

    surfaces: tuple[Surface, Surface]
    segments: tuple[tuple[int, ...], tuple[int, ...]]
    views: tuple[np.ndarray, np.ndarray]


def ready_pair(scenes: Sequence[Scene], segments: tuple[tuple[int, ...], tuple[int, ...]]) -> ReadyPair:
    """All that can be done for a pair before it is drawn; safe to call in a thread."""
    from .pane import surface_of

    first, second = (surface_of(scene) for scene in scenes)
    return ReadyPair((first, second), segments, best_views(scenes, segments))


class VotingPairView(MeshPairView):
    """Shows ready pairs. `draw_ahead` draws one into a second, hidden pair of windows, and `present` brings it up."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAcceptDrops(False)
        self.set_captions(False)  # a name can tell where a shape came from
        self.ready: ReadyPair | None = None
        self._spare: PairDrawing | None = None
        self._ahead: ReadyPair | None = None
        self._left: list[int] = []  # what is still to be drawn ahead: -1 the set-up, then the two panes
        self._aimed = self._spare_aimed = 0.0  # the width / height that the views of both pairs were chosen for
        self._drawer = QTimer(self, interval=_PAUSE)
        self._drawer.timeout.connect(self._draw_one)

    # --- the next pair

    def draw_ahead(self, ready: ReadyPair) -> None:
        """Begin to draw a pair that comes next, a piece at a time between events."""
        if ready is not self._ahead:
            self._ahead, self._left = ready, [-1, 0, 1]
            self._drawer.start()

    @property
    def drawn_ahead(self) -> bool:
        """Whether the next pair is drawn, so that it can come up at once."""
        return self._ahead is not None and not self._left

    def present(self, ready: ReadyPair) -> None:
        """Show a pair from its chosen views: at once where it was drawn ahead, else quickly and then smoothly."""
        self._drawer.stop()
        if self._drawing is None and not self._start():
            return
        self._flight.stop()
        self._turner.stop()
        self._still.stop()
        if ready is self._ahead and -1 not in self._left and self._spare is not None:
            self._drawing, self._spare = self._spare, self._drawing
            self._aimed, self._spare_aimed = self._spare_aimed, self._aimed
        else:
            self._set_up(self._drawing, ready)
            self._aimed = self._aspect()
        self._ahead, self._left, self.ready = None, [], ready
        self._shown, self._shapes, self._pressed, self._dragged = True, [], None, None
        fresh = not any(pane.stale for pane in self._drawing.panes)
        self._moving = False
        self.update() if fresh else self._move()

    def _set_up(self, drawing: PairDrawing, ready: ReadyPair) -> None:
        drawing.set_theme(self._theme)
        drawing.set_scenes(*ready.surfaces, self._aspect())
        drawing.set_highlight(*ready.segments, rgb(self._theme.accent))
        self._aim(drawing, ready)

    def _aim(self, drawing: PairDrawing, ready: ReadyPair) -> None:
        cameras = part_cameras([surface.scene for surface in ready.surfaces], ready.views, self._aspect())
        for pane, camera in zip(drawing.panes, cameras, strict=True):
            pane.camera = camera

    def _draw_one(self) -> None:
        """One piece of drawing ahead, so that a key that is pressed meanwhile waits for no more than that."""
        if self._moving or self._turner.isActive():
            return
        if self._ahead is None or not self._left or (self._spare is None and not self._start_spare()):
            self._drawer.stop()
            return
        piece = self._left.pop(0)
        if piece < 0:
            self._set_up(self._spare, self._ahead)
            self._spare_aimed = self._aspect()
            return
        ratio = self.devicePixelRatioF()
        size = round(self.width() / 2 * ratio), round(self.height() * ratio)
        self._spare.panes[piece].image(*size, scale=ratio)

    def _start_spare(self) -> bool:
        if self._drawing is None:
            return False
        from .pair import PairDrawing

        self._spare = self._marking(PairDrawing(self._theme))
        self._owned.append(self._spare)
        return True

    def _start(self) -> bool:
        if not super()._start():
            return False
        self._marking(self._drawing)
        return True

    @staticmethod
    def _marking(drawing: PairDrawing) -> PairDrawing:
        drawing.captions, drawing.through = False, True
        return drawing

    def _again(self) -> None:
        """What was drawn ahead no longer fits: draw it once more."""
        if self._ahead is not None:
            self._left = [-1, 0, 1]
            self._drawer.start()

    # --- looking

    def set_theme(self, theme: Theme) -> None:
        """Change between light and dark, the marked parts too."""
        super().set_theme(theme)
        if self.ready is not None and self._shown:
            self.set_highlight(*self.ready.segments, rgb(theme.accent))
        self._again()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """The chosen views fit the new size, also if it was not known when they were chosen."""
        super().resizeEvent(event)
        if self._shown and self.ready is not None and not event.oldSize().isValid() and self._aimed != self._aspect():
            self._aim(self._drawing, self.ready)
            self._aimed = self._aspect()
        self._again()

    def sizeHint(self) -> QSize:
        """As large as there is room."""
        return QSize(900, 480)

    def reset_view(self) -> None:
        """Back to the views that were chosen for the marked parts."""
        if self._shown and self.ready is not None:
            self._turner.stop()
            scenes = [surface.scene for surface in self.ready.surfaces]
            self._fly_to(part_cameras(scenes, self.ready.views, self._aspect()))

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """The same as the key for it."""
        self.reset_view()

    @property
    def calm(self) -> bool:
        """Whether nothing should move by itself."""
        return self.reduced_motion or not self.style().styleHint(QStyle.StyleHint.SH_Widget_Animation_Duration)

    @property
    def turning(self) -> bool:
        """Whether the shapes turn by themselves."""
        return self._turner.isActive()

    def turn(self) -> None:
        """Start turning both shapes slowly, or stop; where less motion is wanted, turn them by one step."""
        if not self._shown:
            return
        if not self.calm:
            self.turntable(not self.turning)
            return
        self._flight.stop()
        for pane in self._drawing.panes:
            pane.camera = turned(pane.camera, _STEP_OF_TURN)
        self._move()

    def looking_from(self) -> list[list[float]]:
        """From where both shapes are seen now, two unit vectors rounded to thousandths; empty without shapes."""
        if not self._shown:
            return []
        arms = [pane.camera.position - pane.camera.focal for pane in self._drawing.panes]
        return [np.round(arm / max(float(np.linalg.norm(arm)), 1e-12), 3).tolist() for arm in arms]

    def shutdown(self) -> None:
        """Give the VTK windows back, those of the next pair too."""
        self._drawer.stop()
        self._spare = self._ahead = self.ready = None
        super().shutdown()
