"""From blocks to whole pictures: main blocks, what is attached to them, cells filled, loose pieces swapped."""

from typing import NamedTuple

import numpy as np

from ..errors import BadInput
from ..progress import Progress, share
from .blocks import Blocks, Rules, grow_blocks, turn_cell
from .candidates import Candidates
from .evidence import Evidence, kinds_of
from .filling import EMPTY, best_place, cell_score, fill_cells, merge_by_contacts, rearrange, total_worth
from .shifting import shift
from .solution import UNPLACED
from .turning import turned_vectors

SURE, HOPEFUL = 2.0, -1.0  # log odds: what merges two blocks, and what makes a placement worth a look
LOOSE, MOST_LOOSE = 1.5, 600  # mean log odds a contact below which a piece may be swapped, and how many may
ROUNDS, PATIENCE = 40, 6  # of moving loose pieces
STRICTER = (1.0, 2.5, 4.0, 6.0, 8.0)  # log odds of joins by which mixed pictures are tried to be kept apart
BARELY = -3.0  # mean log odds a contact below which no piece is added where the frame is not known


Pinned = tuple[int, int, int, int]  # a piece, its column, row and turns


class _Canvas(NamedTuple):
    """A grid (rows, columns) of pieces with room around a main block; its first cell is (x, y) of the block's own cells.

    `width` and `height` limit what is placed (0: no limit); `anchored` says that the grid is the frame itself.
    """

    grid: np.ndarray
    x: int
    y: int
    width: int
    height: int
    anchored: bool


class Layout(NamedTuple):
    """`picture` (n,) int64 (`UNPLACED` for none), `x`, `y` cells and `turns` (n,) int64, and the judge's sum."""

    picture: np.ndarray
    x: np.ndarray
    y: np.ndarray
    turns: np.ndarray
    worth: float


def complete(
    blocks: Blocks, start: Blocks, candidates: Candidates, e: Evidence, rules: Rules, *,
    groups: np.ndarray, pin: Pinned | None, pictures: int, turned: bool, missing: bool, progress: Progress,
) -> Layout:  # fmt: skip
    """Complete the `pictures` largest of the `blocks`, which have grown from `start`.

    Blocks are merged where their contacts say so; then where anything speaks for it. What is left goes into empty cells
    one piece at a time: wherever it does least harm if the frame is known, only where it fits if it is not. In the end
    loosely held pieces are moved, and whole rows and columns at the border, while the sum of all log odds grows.
    `groups` (n,) int64 names pieces that people have locked together, -1 for all others; a group is placed as it is, and
    others make room for it. Raises `BadInput` where there is no place for one.
    """
    merging = share(progress, 0.0, 0.3)
    blocks = merge_by_contacts(blocks, candidates, e, rules, least=SURE, hopeful=HOPEFUL, progress=merging)
    if pictures > 1:
        blocks = _several(blocks, start, candidates, e, rules, pictures, merging)
    known = rules.frame is not None
    mains = main_blocks(blocks, pictures, rules.anchored if pin is None else np.array([pin[0]]))
    if pictures == 1:
        rules = with_guessed_frame(blocks, int(mains[0]), rules, missing)
    rules = Rules(rules.frame, rules.either_way, rules.forbidden, rules.anchored, apart=mains)
    if rules.frame is not None or pictures > 1:
        least, hopeful = (-60.0, -4.0) if rules.frame is not None else (SURE, HOPEFUL)
        blocks = merge_by_contacts(blocks, candidates, e, rules, least=least, hopeful=hopeful, progress=merging)
        mains = blocks.block[mains]  # a larger block may have given them its name
    if not known and rules.frame is not None and pin is not None and (pin[3] - blocks.turns[pin[0]]) % 2:
        rules = Rules(
            rules.frame[::-1], rules.either_way, rules.forbidden, rules.anchored, apart=mains
        )  # it turns along
    blocks = _as_pinned(blocks, pin)
    canvases = [_canvas(blocks, name, rules) for name in mains]
    pinned = -1 if pin is None else int(np.flatnonzero(mains == blocks.block[pin[0]])[0])
    return _together(canvases, pinned, blocks, e, rules, turned, groups, share(progress, 0.3, 1.0))


def _several(
    blocks: Blocks, start: Blocks, candidates: Candidates, e: Evidence, rules: Rules, pictures: int, progress: Progress
) -> Blocks:
    """Blocks of which the `pictures` largest may each be a picture: where too few are large, joins must be likelier."""
    n = len(blocks.block)
    tried = []
    for least in STRICTER:
        sizes = np.sort(np.unique(blocks.block, return_counts=True)[1])[::-1]
        smallest = sizes[pictures - 1] if len(sizes) >= pictures else 0
        tried.append((int(smallest), blocks))
        if smallest >= 0.25 * n / pictures:
            return blocks
        order = np.argsort(-e.logit, kind="stable")
        grown = grow_blocks(candidates.pairs, order[e.logit[order] >= least], start, rules)[0]
        blocks = merge_by_contacts(grown, candidates, e, rules, least=2 * least, hopeful=least, progress=progress)
    return max(tried, key=lambda found: found[0])[1]


def main_blocks(blocks: Blocks, pictures: int, anchored: np.ndarray) -> np.ndarray:
    """The names of the largest blocks, largest first; a block that people pinned counts as the first."""
    names, counts = np.unique(blocks.block, return_counts=True)
    first = np.isin(names, blocks.block[anchored])
    return names[np.lexsort((names, -counts, ~first))][:pictures]


def with_guessed_frame(blocks: Blocks, main: int, rules: Rules, missing: bool) -> Rules:
    """Where no frame is known and no piece is missing: the size that n pieces make and that fits the main block and the
    largest one best, if that holds half of the pieces."""
    if rules.frame is not None or missing or len(rules.anchored):
        return rules
    n = len(blocks.block)
    largest = main_blocks(blocks, 1, rules.anchored)[0]
    spans = [[int(np.ptp(c[blocks.block == name])) + 1 for c in (blocks.x, blocks.y)] for name in (main, largest)]
    w, h = np.max(spans, axis=0).tolist()
    sizes = [(a, n // a) for a in range(1, n + 1) if n % a == 0 and a >= w and n // a >= h]
    if not sizes or (blocks.block == largest).sum() < 0.5 * n:
        return rules
    frame = min(sizes, key=lambda size: size[0] - w + size[1] - h)
    return Rules(frame, False, rules.forbidden, rules.anchored)


def _as_pinned(blocks: Blocks, pin: Pinned | None) -> Blocks:
    """The block of a pinned piece turned and moved so that the piece is where it should be."""
    if pin is None:
        return blocks
    piece, x, y, turn = pin
    on = np.flatnonzero(blocks.block == blocks.block[piece])
    k = int(turn - blocks.turns[piece]) % 4
    moved = turned_vectors(np.column_stack([blocks.x, blocks.y])[on], np.full(len(on), k))
    moved += (x, y) - moved[on == piece]
    new_x, new_y, turns = blocks.x.copy(), blocks.y.copy(), blocks.turns.copy()
    new_x[on], new_y[on], turns[on] = moved[:, 0], moved[:, 1], (turns[on] + k) % 4
    return Blocks(blocks.block, new_x, new_y, turns)


def _canvas(blocks: Blocks, name: int, rules: Rules) -> _Canvas:
    """The canvas of one main block."""
    on = np.flatnonzero(blocks.block == name)
    x, y = blocks.x[on], blocks.y[on]
    anchored = rules.frame is not None and len(rules.anchored) > 0 and name == blocks.block[rules.anchored[0]]
    w, h = int(np.ptp(x)) + 1, int(np.ptp(y)) + 1
    if rules.frame is None:
        width = height = 0
        room_x = room_y = min(30, len(blocks.block))
    else:
        width, height = rules.frame
        if (
            rules.either_way
            and not anchored
            and (w > width or h > height or ((w > h) != (width > height) and h <= width and w <= height))
        ):
            width, height = height, width
        room_x, room_y = width - w, height - h
    x0, y0 = (0, 0) if anchored else (int(x.min()) - room_x, int(y.min()) - room_y)
    shape = (height, width) if anchored else (h + 2 * room_y, w + 2 * room_x)
    grid = np.full(shape, EMPTY, dtype=np.int64)
    grid[y - y0, x - x0] = on
    return _Canvas(grid, x0, y0, *((0, 0) if anchored else (width, height)), anchored)


def _together(
    canvases: list[_Canvas], pinned: int, blocks: Blocks, e: Evidence, rules: Rules, turned: bool, groups: np.ndarray,
    progress: Progress,
) -> Layout:  # fmt: skip
    """Fill all canvases with what is left, best first, and read the layout off them."""
    n = len(blocks.block)
    turns = np.array(blocks.turns)
    held = np.isin(blocks.block, [blocks.block[c.grid[c.grid != EMPTY][0]] for c in canvases])
    left = np.flatnonzero(~held & (groups < 0))
    waiting = [np.flatnonzero(groups == g) for g in np.unique(groups[~held & (groups >= 0)])]
    left = _with_groups(sorted(waiting, key=len, reverse=True), canvases, blocks, left, turns, turned, groups, e)
    layout = Layout(np.full(n, UNPLACED), np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64), turns, 0.0)
    least = -1e9 if rules.frame is not None and len(canvases) == 1 else BARELY
    for k, canvas in enumerate(canvases):
        here = share(progress, k / len(canvases), (k + 1) / len(canvases))
        placed = _filled(canvas, turns, left, turned, least, e, share(here, 0.0, 0.6))
        loose = _loose_cells(
            canvas.grid, np.concatenate([left[placed], _doubtful(canvas.grid, turns, e)]), rules, groups
        )
        rearrange(canvas.grid, turns, loose, turned, ROUNDS, PATIENCE, 0, e, share(here, 0.6, 0.9))
        if rules.frame is not None and not canvas.anchored and len(canvases) == 1:
            shift(canvas.grid, turns, loose, groups, turned, e, share(here, 0.9, 1.0))
        left = left[~placed]
        _read_off(canvas, k, canvas.anchored or pinned == k, layout)
        layout = layout._replace(worth=layout.worth + total_worth(canvas.grid, turns, e))
    return layout


def _read_off(canvas: _Canvas, k: int, in_place: bool, layout: Layout) -> None:
    """Note the cells of the pieces on a canvas, from its first used one or, where it is in its place, from the origin."""
    rows, columns = np.nonzero(canvas.grid != EMPTY)
    pieces = canvas.grid[rows, columns]
    layout.picture[pieces] = k
    layout.x[pieces] = columns + canvas.x if in_place else columns - columns.min()
    layout.y[pieces] = rows + canvas.y if in_place else rows - rows.min()


def _doubtful(grid: np.ndarray, turns: np.ndarray, e: Evidence) -> np.ndarray:
    """Placed pieces whose contacts say little for them."""
    rows, columns = np.nonzero(grid != EMPTY)
    found = []
    for r, c in zip(rows.tolist(), columns.tolist(), strict=True):
        total, contacts = cell_score(grid, turns, r, c, grid[r, c], turns[grid[r, c]], e)
        if contacts and total / contacts < LOOSE:
            found.append((total / contacts, int(grid[r, c])))
    return np.array([piece for _, piece in sorted(found)[:MOST_LOOSE]], dtype=np.int64)


def _filled(
    canvas: _Canvas, turns: np.ndarray, left: np.ndarray, turned: bool, least: float, e: Evidence, progress: Progress
) -> np.ndarray:
    """Fill the cells of a canvas part by part, so that it can be stopped; which of `left` were placed, (m,) bool."""
    placed = np.zeros(len(left), dtype=bool)
    kind = kinds_of(e)[left]
    part = max(100, len(left) // 8)
    while True:
        progress(float(placed.mean()) if len(left) else 1.0, "filling cells")
        rest = np.flatnonzero(~placed)
        rest = rest[np.argsort(kind[rest], kind="stable")]
        done = fill_cells(
            canvas.grid, turns, left[rest], kind[rest], canvas.width, canvas.height, turned, least, part, e
        )
        placed[rest[done]] = True
        if done.sum() < part:
            return placed


def _with_groups(
    waiting: list[np.ndarray], canvases: list[_Canvas], blocks: Blocks, left: np.ndarray, turns: np.ndarray, turned: bool,
    groups: np.ndarray, e: Evidence,
) -> np.ndarray:  # fmt: skip
    """Place locked groups where they fit best, among free cells or in the place of pieces that are not locked.

    Returns the pieces that are left to place. Raises `BadInput` where a group has no place on any canvas.
    """
    for group in waiting:
        for evict in (False, True):
            made = next((room for canvas in canvases if (room := _make_room(
                group, canvas, blocks, turns, turned, groups, evict, e)) is not None), None)  # fmt: skip
            if made is not None:
                left = np.concatenate([left, made])
                break
        else:
            raise BadInput(
                f"The locked joins of piece {group[0]} and {len(group) - 1} other(s) leave no place for them in the picture; "
                "unlock one of them.")  # fmt: skip
    return left


def _make_room(
    group: np.ndarray, canvas: _Canvas, blocks: Blocks, turns: np.ndarray, turned: bool, groups: np.ndarray, evict: bool,
    e: Evidence,
) -> np.ndarray | None:  # fmt: skip
    """Put a locked group onto a canvas; the pieces that had to leave, or None where there is no place for it."""
    movable = (groups < 0) & evict
    best, row, column, k = best_place(
        canvas.grid, turns, group, blocks.x[group], blocks.y[group], blocks.turns[group], movable, canvas.width,
        canvas.height, turned, e)  # fmt: skip
    if best == -np.inf:
        return None
    gone = []
    for piece in group:
        x, y = turn_cell(blocks.x[piece], blocks.y[piece], k)
        if canvas.grid[row + y, column + x] != EMPTY:
            gone.append(canvas.grid[row + y, column + x])
        canvas.grid[row + y, column + x] = piece
        turns[piece] = (blocks.turns[piece] + k) % 4
    return np.array(gone, dtype=np.int64)


def _loose_cells(grid: np.ndarray, pieces: np.ndarray, rules: Rules, groups: np.ndarray) -> np.ndarray:
    pieces = pieces[(groups[pieces] < 0) & ~np.isin(pieces, rules.anchored)][:MOST_LOOSE]
    return np.argwhere(np.isin(grid, pieces) & (grid != EMPTY))


def lying_as(layout: Layout, frame: tuple[int, int] | None) -> Layout:
    """A single picture after a quarter turn if that is what makes it lie in its frame (columns, rows)."""
    on = layout.picture != UNPLACED
    w, h = (int(np.ptp(c[on])) + 1 if on.any() else 0 for c in (layout.x, layout.y))
    if frame is None or (w <= frame[0] and h <= frame[1]):
        return layout
    return layout._replace(
        x=np.where(on, h - 1 - layout.y, 0), y=np.where(on, layout.x, 0), turns=np.where(on, (layout.turns + 1) % 4, 0))  # fmt: skip
