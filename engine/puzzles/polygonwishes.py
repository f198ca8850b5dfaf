"""What people decided about polygons, as the layout that all merging starts from and the joins it must not make."""

import numpy as np

from .clusters import Layout, apart
from .pieces import Puzzle
from .solution import Wishes
from .wishcheck import chains, check_wishes


def start_layout(puzzle: Puzzle, wishes: Wishes) -> tuple[Layout, int, np.ndarray]:
    """Locked joins as clusters, a pinned piece whose cluster may not move (-1: none), and forbidden rows (f, 5).

    A forbidden row is (a, b, turn, dx, dy) as in `Joins`. Raises `BadInput` where wishes contradict each other.
    """
    check_wishes(puzzle, wishes)
    layout, fixed = apart(puzzle.count), -1
    for places, pinned in chains(puzzle, wishes):
        members = np.array(sorted(places))
        layout.cluster[members] = members[0]
        for i in members:
            layout.place[i], layout.turns[i] = places[int(i)][:2], places[int(i)][2]
        if pinned:
            fixed = int(members[0])
    joins = wishes.forbidden
    return layout, fixed, np.column_stack([joins.sides[:, [0, 2]], joins.turn % 4, joins.offset]).astype(np.int64)
