"""Ways to divide a picture into polygons, every pixel in exactly one of them."""

from typing import NamedTuple

import numpy as np

from ..errors import BadInput
from .pieces import rectangle
from .turning import from_the_top

SMALLEST = 4  # pixels; a side shorter than that has too little to compare
MERGED, HALVED = 0.25, 0.4  # the share of squares that are merged away, and that are cut in two


class Dissection(NamedTuple):
    """Which polygon each pixel belongs to, (h, w) int64, and the polygons in pixels of the picture, clockwise."""

    labels: np.ndarray
    polygons: list[np.ndarray]


def pieces_per_cell(kind: str) -> float:
    """How many pieces come of one square of the grid, on average."""
    return {"squares": 1.0, "merged": 1 - MERGED, "triangles": 1 + HALVED}[kind]


def squares(columns: int, rows: int, px: int) -> Dissection:
    """The grid of equal squares of `px` pixels, row by row."""
    labels = np.arange(rows * columns).reshape(rows, columns).repeat(px, axis=0).repeat(px, axis=1)
    y, x = np.divmod(np.arange(rows * columns), columns)
    corners = rectangle(px, px)[None] + px * np.stack([x, y], axis=1)[:, None]
    return Dissection(labels, list(corners))


def merged(columns: int, rows: int, px: int, rng: np.random.Generator) -> Dissection:
    """The grid with a quarter of the squares merged into a neighbour, at most three to a piece."""
    owner = np.arange(rows * columns)
    cells = owner.reshape(rows, columns)
    right = np.stack([cells[:, :-1].ravel(), cells[:, 1:].ravel()], axis=1)
    down = np.stack([cells[:-1].ravel(), cells[1:].ravel()], axis=1)
    wanted = round(MERGED * rows * columns)
    for a, b in rng.permutation(np.concatenate([right, down])):
        if not wanted:
            break
        together = (owner == owner[a]) | (owner == owner[b])
        if owner[a] != owner[b] and together.sum() <= 3:
            owner[together] = owner[a]
            wanted -= 1
    _, owner = np.unique(owner, return_inverse=True)
    grid = owner.reshape(rows, columns)
    outlines = [px * outline(grid == k) for k in range(owner.max() + 1)]
    return Dissection(grid.repeat(px, axis=0).repeat(px, axis=1), outlines)


def outline(cells: np.ndarray) -> np.ndarray:
    """The corners (v, 2) float64 around a simply connected set of cells (h, w) bool, clockwise as seen."""
    padded = np.pad(cells, 1)
    steps: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for y, x in np.argwhere(cells):
        around = ((-1, 0, 0, 0, 1, 0), (0, 1, 1, 0, 1, 1), (1, 0, 1, 1, 0, 1), (0, -1, 0, 1, 0, 0))
        for dy, dx, x0, y0, x1, y1 in around:  # the cell across the side, and the side clockwise
            if not padded[y + 1 + dy, x + 1 + dx]:
                steps.setdefault((int(x + x0), int(y + y0)), []).append((int(x + x1), int(y + y1)))
    here = min(steps, key=lambda corner: corner[::-1])
    walk = [here]
    while steps[here]:
        here = steps[here].pop()
        walk.append(here)
    ring = np.array(walk[:-1], dtype=np.float64)
    bends = (ring != np.roll(ring, 1, axis=0)) != (np.roll(ring, -1, axis=0) != ring)
    return ring[bends.any(axis=1)]


def triangles(columns: int, rows: int, px: int, rng: np.random.Generator) -> Dissection:
    """The grid with two fifths of the squares cut along a diagonal; the pixels on it belong to the upper half."""
    count = rows * columns
    halved = np.zeros(count, dtype=bool)
    halved[rng.permutation(count)[: round(HALVED * count)]] = True
    falling = rng.random(count) < 0.5  # from the top left to the bottom right
    y, x = np.mgrid[:px, :px]
    lower = {True: y > x, False: x + y + 1 > px}
    corners = rectangle(px, px)
    halves = {True: ([0, 1, 2], [0, 2, 3]), False: ([0, 1, 3], [1, 2, 3])}
    labels = np.zeros((rows * px, columns * px), dtype=np.int64)
    polygons: list[np.ndarray] = []
    for cell in range(count):
        top, left = px * (cell // columns), px * (cell % columns)
        place, kind = labels[top : top + px, left : left + px], bool(falling[cell])
        place[:] = len(polygons)
        if halved[cell]:
            place += lower[kind]
        parts = halves[kind] if halved[cell] else (slice(None),)
        polygons += [from_the_top(corners[part]) + np.array([left, top]) for part in parts]
    return Dissection(labels, polygons)


def rectangles(width: int, height: int, pieces: int, rng: np.random.Generator) -> Dissection:
    """Guillotine cuts: the largest rectangle is cut in two, anywhere in its middle half, until there are enough."""
    boxes = [(0, 0, width, height)]
    while len(boxes) < pieces:
        x, y, w, h = boxes.pop(max(range(len(boxes)), key=lambda k: boxes[k][2] * boxes[k][3]))
        upright = rng.random() < w**2 / (w**2 + h**2)
        if min(w, h) < 2 * SMALLEST:
            upright = w > h
        side = w if upright else h
        at = int(np.clip(round(side * rng.uniform(0.25, 0.75)), SMALLEST, side - SMALLEST))
        if side < 2 * SMALLEST:
            raise BadInput(
                f"A picture of {width} × {height} pixels cannot be cut into {pieces} rectangles whose sides are at "
                f"least {SMALLEST} pixels; ask for fewer pieces."
            )
        boxes += [(x, y, at, h), (x + at, y, w - at, h)] if upright else [(x, y, w, at), (x, y + at, w, h - at)]
    labels = np.zeros((height, width), dtype=np.int64)
    for k, (x, y, w, h) in enumerate(boxes):
        labels[y : y + h, x : x + w] = k
    return Dissection(labels, [rectangle(w, h) + np.array([x, y]) for x, y, w, h in boxes])
