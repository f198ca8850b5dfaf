"""Where a piece that a hand carries comes to rest."""

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
