"""The joins of an assembled puzzle of polygons: every contact of two sides, and how sure it is."""

import numpy as np
from numba import njit

from .alignments import Alignments
from .clusters import BAD, GOOD, Layout, Trials, extent, held, near, rotated
from .contacts import FEATURES, Ground, side_odds, touching
from .identity import size_of
from .pieces import Puzzle
from .solution import Joins

MOST_SUPPORT, MOST_OWN = 15.0, 8.0
SURE = 0.5  # probability of the two other joins of a loop
SHOWN = 60  # likely partners of one side


def touching_sides(
    ground: Ground, layout: Layout, candidates: Alignments, odds: np.ndarray, base: float
) -> tuple[np.ndarray, ...]:
    """All contacts of a layout: sides (j, 2), pieces (j, 2), turn (j,), offset (j, 2), and what speaks for them (j, 5).

    That is 1, the log odds of the contact by itself, those of the candidate that it is and whether it is one, and
    what the other contacts of the two pieces say, the lesser of both.
    """
    sides, pieces, relation, own = _contacts(ground, layout, base)
    kept = np.zeros(len(odds), dtype=bool)
    held(ground, layout, Trials(candidates.side, candidates.turn, candidates.offset, odds), kept)
    known = {(int(e), int(f)): float(z) for (e, f), z in zip(candidates.side[kept], odds[kept], strict=True)}
    logit = np.array([known.get((int(e), int(f)), np.nan) for e, f in sides]).reshape(len(sides))
    total = np.zeros(len(layout.cluster))
    for column in (0, 1):
        np.add.at(total, pieces[:, column], own)
    others = (total[pieces] - own[:, None]).min(axis=1, initial=np.inf)
    listed = ~np.isnan(logit)
    seen = np.stack([
        np.ones(len(own)), own, np.clip(np.where(listed, logit, 0), -MOST_OWN, MOST_OWN), listed,
        np.clip(others, -MOST_SUPPORT, MOST_SUPPORT),
    ], axis=1)  # fmt: skip
    return sides, pieces, relation[:, 0], relation[:, 1:], seen


@njit(cache=True, nogil=True)
def _contacts(g, layout, base):  # type: ignore[no-untyped-def]
    n, z = len(layout.cluster), np.empty(FEATURES)
    sides, pieces, relation, own = [(0, 0)], [(0, 0)], [(0, 0, 0)], [0.0]
    for a in range(n):
        for b in range(a + 1, n):
            if layout.cluster[a] != layout.cluster[b]:
                continue
            ta, tb = layout.turns[a], layout.turns[b]
            dx, dy = layout.place[b, 0] - layout.place[a, 0], layout.place[b, 1] - layout.place[a, 1]
            if not near(g, a, ta, b, tb, dx, dy):
                continue
            wa, ha = extent(g, a, ta)
            wb, hb = extent(g, b, tb)
            x0, y0 = rotated(0, 0, wa, ha, -ta)
            x, y = rotated(dx, dy, wb, hb, -ta)
            for e in range(g.first[a], g.first[a + 1]):
                for f in range(g.first[b], g.first[b + 1]):
                    m, i, j = touching(g, e, ta, f, tb, dx, dy)
                    if m > 0:
                        sides.append((e, f))
                        pieces.append((a, b))
                        relation.append(((tb - ta) % 4, x - x0, y - y0))
                        own.append(min(max(side_odds(g, e, i, f, j, m, z) - base, BAD), GOOD))
    return np.array(sides)[1:], np.array(pieces)[1:], np.array(relation)[1:], np.array(own)[1:]


def joins_of_layout(
    ground: Ground, layout: Layout, candidates: Alignments, odds: np.ndarray, base: float, weights: np.ndarray, locked: Joins
) -> Joins:  # fmt: skip
    """The joins of touching sides with their probabilities; `weights` (5,) are those of `touching_sides`' last."""
    sides, pieces, turn, offset, seen = touching_sides(ground, layout, candidates, odds, base)
    probability = 1 / (1 + np.exp(-seen @ weights))
    wished = {tuple(row) for row in locked.sides.tolist()} | {(b, t, a, s) for a, s, b, t in locked.sides.tolist()}
    rows = np.column_stack([pieces[:, 0], sides[:, 0] - ground.first[pieces[:, 0]],
                            pieces[:, 1], sides[:, 1] - ground.first[pieces[:, 1]]])  # fmt: skip
    person = np.array([tuple(row) in wished for row in rows.tolist()], dtype=bool)
    loop = _in_loops(pieces, probability)
    words = tuple("person" if p else "loops" if k else "" for p, k in zip(person, loop, strict=True))
    return Joins(rows, offset, turn, np.where(person, 1.0, probability), words)


def _in_loops(pieces: np.ndarray, probability: np.ndarray) -> np.ndarray:
    """Which joins are closed by a third piece that both pieces are surely joined to, (j,) bool."""
    beside: dict[int, set[int]] = {}
    for (a, b), p in zip(pieces.tolist(), probability, strict=True):
        if p > SURE:
            beside.setdefault(a, set()).add(b)
            beside.setdefault(b, set()).add(a)
    return np.array([bool(beside.get(a, set()) & beside.get(b, set())) for a, b in pieces.tolist()], dtype=bool)


def likely_partners(
    puzzle: Puzzle, ground: Ground, candidates: Alignments, odds: np.ndarray, piece: int, side: int
) -> Joins:
    """The candidates of one side, likeliest first, the piece itself standing as it was read."""
    e = int(ground.first[piece]) + side
    rows = np.flatnonzero((candidates.side == e).any(axis=1))
    rows = rows[np.argsort(-odds[rows], kind="stable")][:SHOWN]
    sides, turns, offsets = [], [], []
    for k in rows:
        mine = int(candidates.side[k, 0] != e)
        f = int(candidates.side[k, 1 - mine])
        other = int(np.searchsorted(ground.first, f, side="right")) - 1
        turn, (x, y) = int(candidates.turn[k]), candidates.offset[k].tolist()
        if mine:  # seen from the second piece: all is turned back until it stands as it was read
            w, h = size_of(puzzle.pieces[piece], turn)
            x0, y0 = rotated(x, y, w, h, -turn)
            x1, y1 = rotated(0, 0, *size_of(puzzle.pieces[other], 0), -turn)
            turn, x, y = -turn % 4, x1 - x0, y1 - y0
        sides.append((piece, side, other, f - int(ground.first[other])))
        turns.append(turn)
        offsets.append((x, y))
    return Joins(np.reshape(sides, (-1, 4)), np.reshape(offsets, (-1, 2)), np.reshape(turns, -1),
                 1 / (1 + np.exp(-odds[rows])))  # fmt: skip
