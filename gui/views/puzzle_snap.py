"""What a hand carries, and where it comes to rest."""

from typing import NamedTuple

import numpy as np

from .puzzle_layout import Layout, outlines, turned_corners


def snapped(layout: Layout, carried: frozenset[int], piece: int, x: float, y: float, reach: float) -> tuple[int, int, bool]:
    """The top-left pixel where a piece held at (x, y) on the canvas comes to rest, and whether something held it there.

    Of all corners of placed pieces and of the pictures, the nearest to one of its own corners pulls it, if it is
    within `reach`. The pieces that are `carried` along do not attract it. Equal squares take the cells of the picture
    that they are held over.
    """
    px, size = layout.puzzle.square, layout.size[piece]
    for area in layout.pictures if px else ():
        if area.holds(x + size[0] / 2, y + size[1] / 2):
            return int(area.x) + px * round((x - area.x) / px), int(area.y) + px * round((y - area.y) / px), True
    shape = outlines(layout.puzzle)
    turned = turned_corners(shape, layout.turns)
    own = turned[shape.first[piece] : shape.first[piece + 1]] + np.array([x, y])
    free = layout.placed[shape.owner] & ~np.isin(shape.owner, list(carried))
    frames = [(a.x + u, a.y + v) for a in layout.pictures for u in (0, a.w) for v in (0, a.h)]
    goals = np.concatenate([(turned + layout.position[shape.owner])[free], np.reshape(frames, (-1, 2))])
    goals = goals[((goals >= own.min(axis=0) - reach) & (goals <= own.max(axis=0) + reach)).all(axis=1)]
    if len(goals):
        step = goals[None] - own[:, None]
        away = np.hypot(step[..., 0], step[..., 1])
        best = np.unravel_index(int(away.argmin()), away.shape)
        if away[best] <= reach:
            x, y = x + step[best][0], y + step[best][1]
            return round(x), round(y), True
    return round(x), round(y), False


class Carried(NamedTuple):
    """Pieces in a hand: the one that it `held`, all that move along, where it was grabbed, and where it would rest.

    `grab` is the point of the held piece's raster below the pointer, `rest` its top-left pixel on the canvas and whether
    something holds it there.
    """

    held: int
    pieces: frozenset[int]
    grab: tuple[float, float]
    rest: tuple[int, int, bool]

    def moved(self, layout: Layout, x: float, y: float, reach: float) -> "Carried":
        """The same with the pointer at (x, y) on the canvas; over the tray nothing snaps."""
        left, top = x - self.grab[0], y - self.grab[1]
        if layout.tray is not None and layout.tray.holds(x, y):
            return self._replace(rest=(round(left), round(top), False))
        reach = min(reach, 0.4 * float(layout.size[self.held].min()))
        return self._replace(rest=snapped(layout, self.pieces, self.held, left, top, reach))

    def step(self, layout: Layout) -> np.ndarray:
        """How far (2,) the pieces are from where the layout has them."""
        return np.array(self.rest[:2]) - layout.position[self.held]


def taken_up(layout: Layout, piece: int, pieces: frozenset[int], x: float, y: float) -> Carried:
    """A piece, and what moves along, taken up at the point (x, y) of the canvas."""
    left, top = layout.position[piece].tolist()
    return Carried(piece, pieces, (x - left, y - top), (left, top, False))
