"""Several ways to put polygons together, of which the one with the best sum of contacts is kept.

Merging in the order of certainty makes a mistake now and then, and all that follows is shifted by it. It shows: a sure
join cannot be kept, or a doubtful one had to be made. So each such join is tried the other way, the pieces are put
together anew, and the outcome is kept if all touching borders, without looking at any truth, speak more for it.
"""

from typing import NamedTuple

import numpy as np

from ..progress import Progress
from .clusters import Layout, Trials, contact_total, held, merge
from .contacts import Ground

SURE, NEVER = 60.0, -60.0  # log odds that settle the order
DOUBT = 7.0  # log odds below which a join that was made is doubted
BETTER = 0.5  # log odds by which a hypothesis must win
LENIENT = 3.0  # log odds that every contact gains when the last pieces are filled in
LAST = -60.0  # log odds that the last pieces need


class Rules(NamedTuple):
    """What no layout may break: `forbidden` (f, 5) int64 rows (a, b, turn, dx, dy); `fixed` a piece whose cluster may
    not move, or -1; `width` and `height` of the frame (0: unknown), `either_way` if it may lie on its side; `base` the
    log odds of any contact before it is looked at."""

    forbidden: np.ndarray
    fixed: int
    width: int
    height: int
    either_way: bool
    base: float


class Hypothesis(NamedTuple):
    """A layout, the trials it was merged by, in order, their log odds (c,) as it saw them, and the sum of the log odds
    of all its contacts."""

    layout: Layout
    chosen: np.ndarray
    odds: np.ndarray
    total: float


def put_together(ground: Ground, start: Layout, trials: Trials, rules: Rules, least: float) -> Hypothesis:
    """Merge clusters from `start` on while the evidence is at least `least`."""
    layout = start.copy()
    nobody = np.zeros(len(layout.cluster), dtype=bool)
    chosen = merge(
        ground, layout, trials, rules.forbidden, rules.fixed, nobody, rules.width, rules.height, rules.either_way,
        least, rules.base,
    )  # fmt: skip
    return Hypothesis(
        layout, np.array(chosen, dtype=np.int64), trials.odds, contact_total(ground, layout, rules.base)[0]
    )


def reconsidered(
    ground: Ground, start: Layout, trials: Trials, rules: Rules, *, least: float, tries: int, progress: Progress
) -> Hypothesis:  # fmt: skip
    """Try up to `tries` joins the other way, the most striking first, and keep what the contacts speak for."""
    best = put_together(ground, start, trials, rules, least)
    tried = np.zeros((2, len(trials.odds)), dtype=bool)
    for number in range(tries if len(trials.odds) else 0):
        made, kept = np.zeros(tried.shape, dtype=bool)
        made[best.chosen] = True
        held(ground, best.layout, trials, kept)
        striking = np.stack([np.where(made, DOUBT - trials.odds, -np.inf), np.where(kept, -np.inf, trials.odds)])
        striking[tried] = -np.inf
        way, k = np.unravel_index(striking.argmax(), striking.shape)
        if striking[way, k] <= 0:
            break
        tried[way, k] = True
        other = best.odds.copy()
        other[k] = SURE if way else NEVER
        attempt = put_together(ground, start, trials._replace(odds=other), rules, least)
        if attempt.total > best.total + BETTER:
            best = attempt
        progress((number + 1) / tries, "weighing other ways")
    return best


def largest(layout: Layout, count: int, fixed: int) -> np.ndarray:
    """The names of the `count` largest clusters, the one of the fixed piece first."""
    sizes = np.bincount(layout.cluster, minlength=len(layout.cluster))
    if fixed >= 0:
        sizes[layout.cluster[fixed]] = len(sizes) + 1
    order = np.argsort(-sizes, kind="stable")
    return order[sizes[order] > 0][:count]


def filled(ground: Ground, start: Layout, layout: Layout, trials: Trials, rules: Rules, pictures: int) -> Layout:
    """Put what is left beside the largest clusters, wherever there is room, the best supported first.

    First the other clusters as they are, then their pieces one by one (as they hang together in `start`).
    """
    result = layout.copy()
    names = largest(layout, pictures, rules.fixed)
    main = np.zeros(len(layout.cluster), dtype=bool)
    main[names] = True
    for least, broken in ((0.0, False), (LAST, True)):
        outside = ~main[result.cluster]
        if not outside.any():
            break
        if broken:
            for now, before in zip(result, start, strict=True):
                now[outside] = before[outside]
        piece = np.searchsorted(ground.first, trials.side, side="right") - 1
        near = outside[piece].any(axis=1)
        merge(
            ground, result, Trials(*(column[near] for column in trials)), rules.forbidden, rules.fixed, main,
            rules.width, rules.height, rules.either_way, least, rules.base - LENIENT,
        )  # fmt: skip
    return result


def room_around(ground: Ground, layout: Layout, inside: np.ndarray, size: tuple[int, int]) -> list[tuple[int, int]]:
    """The shifts (x, y) that put some pieces into the corners of a picture of (w, h) pixels, likeliest first.

    A border of the picture is a straight line of sides without a gap: where a cluster is smaller than the picture, it
    lies at those of its own borders that are the straightest.
    """
    rows = np.flatnonzero(inside[np.searchsorted(ground.first, np.arange(len(ground.step)), side="right") - 1])
    piece = np.searchsorted(ground.first, rows, side="right") - 1
    start = ground.start[rows, layout.turns[piece]] + layout.place[piece]
    end = ground.end[rows, layout.turns[piece]] + layout.place[piece]
    choices = []
    for axis in (0, 1):
        low, high = start[:, axis].min(), start[:, axis].max()
        along = np.abs(end - start)[:, 1 - axis]
        covered = [
            along[(np.abs(start[:, axis] - line) <= 1) & (np.abs(end[:, axis] - line) <= 1)].sum()
            for line in (low, high)
        ]
        shifts = [-round(float(low)), size[axis] - round(float(high))]
        choices.append(list(dict.fromkeys(shifts if covered[0] >= covered[1] else shifts[::-1])))
    return [(x, y) for x in choices[0] for y in choices[1]]
