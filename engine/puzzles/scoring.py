"""How right a solution is, where the truth is known. Nothing here is ever seen by a solver."""

from dataclasses import dataclass

import numpy as np

from .pieces import LEFT, RIGHT, TOP, Piece, Puzzle, Truth
from .solution import UNPLACED, PuzzleSolution
from .turning import turned_vectors

TOLERANCE = 1.5  # pixels by which a polygon may be off its true place beside another


@dataclass(frozen=True, slots=True)
class Scores:
    """Shares in [0, 1], as the literature counts them; tie-aware ones take identical pieces for equal.

    `direct`: pieces at their true place (of the picture where its frame is known, else up to one shift of each
    picture; up to one turn of the whole, with its frame, where pieces are turned). `neighbour`: truly touching pairs that touch in the
    same way. `largest_component`: pieces in the largest group held together by such pairs. `perfect`: all pieces at
    their true places.
    """

    direct: float
    neighbour: float
    largest_component: float
    perfect: bool
    direct_tie_aware: float
    neighbour_tie_aware: float
    perfect_tie_aware: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Layout:
    """A placement: pictures (n,), centres (n, 2) of the pieces in pixels and quarter turns (n,)."""

    picture: np.ndarray
    centre: np.ndarray
    turns: np.ndarray


def _layout(puzzle: Puzzle, picture: np.ndarray, position: np.ndarray, turns: np.ndarray) -> _Layout:
    sizes = np.array([piece.mask.shape[::-1] for piece in puzzle.pieces])  # (w, h) as read
    sizes = np.where((turns % 2 == 1)[:, None], sizes[:, ::-1], sizes)
    return _Layout(picture, position + sizes / 2, turns % 4)


def score(puzzle: Puzzle, truth: Truth, solution: PuzzleSolution) -> Scores:
    """All scores of a solution."""
    true = _layout(puzzle, truth.picture, truth.position, truth.turns)
    found = _layout(puzzle, solution.picture, solution.position, solution.turns)
    shift = _alignment(puzzle, truth, solution, true, found)
    right = _right_places(true, found, shift)
    touching = contacts(puzzle, truth.picture, truth.position, truth.turns)
    kept = _same_beside(true, found, touching)
    n = puzzle.count
    largest = _largest(n, touching[kept])
    direct_aware, neighbour_aware = _tie_aware(puzzle, true, found, shift, touching, solution)
    total = max(len(touching), 1)
    return Scores(
        float(right.mean()), float(kept.sum() / total), largest / n, bool(right.all()),
        max(direct_aware, float(right.mean())), max(neighbour_aware, float(kept.sum() / total)), direct_aware == 1.0)  # fmt: skip


def right_places(puzzle: Puzzle, truth: Truth, solution: PuzzleSolution) -> np.ndarray:
    """Which pieces stand at their true places, (n,) bool."""
    true = _layout(puzzle, truth.picture, truth.position, truth.turns)
    found = _layout(puzzle, solution.picture, solution.position, solution.turns)
    return _right_places(true, found, _alignment(puzzle, truth, solution, true, found))


def right_joins(puzzle: Puzzle, truth: Truth, solution: PuzzleSolution) -> np.ndarray:
    """Which joins of the solution are true, (j,) bool: the two pieces lie beside each other in the same way."""
    true = _layout(puzzle, truth.picture, truth.position, truth.turns)
    found = _layout(puzzle, solution.picture, solution.position, solution.turns)
    return _same_beside(true, found, solution.joins.sides[:, [0, 2]])


def _alignment(
    puzzle: Puzzle, truth: Truth, solution: PuzzleSolution, true: _Layout, found: _Layout
) -> dict[int, tuple[int, int, np.ndarray]]:
    """For each picture found: the true picture, the turn and the shift that bring most of its pieces to their places.

    No shift is looked for where the frame is known, only what a turn of the frame brings with it; no turn where pieces
    are not turned.
    """
    framed = puzzle.frame is not None and (puzzle.pictures == 1 or not puzzle.turned)
    result = {}
    for k in np.unique(found.picture[found.picture != UNPLACED]):
        on = np.flatnonzero(found.picture == k)
        turns = range(4) if puzzle.turned else range(1)
        if framed:
            picture = int(true.picture[on[0]])
            size = solution.sizes[k] if k < len(solution.sizes) else truth.sizes[picture]
            result[int(k)] = _in_frame(true, found, on, picture, turns, truth.sizes[picture], size)
        else:
            result[int(k)] = _anywhere(true, found, on, turns)
    return result


def _in_frame(
    true: _Layout, found: _Layout, on: np.ndarray, picture: int, turns: range, frame: np.ndarray, size: np.ndarray
) -> tuple[int, int, np.ndarray]:
    """The turn that maps a picture of `size` (w, h) onto its true `frame` (w, h) and most pieces to their places.

    A picture of another size than its frame, lying or standing, is taken to have begun at the same corner.
    """
    w, h = frame
    shifts = np.array([(0, 0), (w, 0), (w, h), (0, h)], dtype=np.float64)
    possible = [t for t in turns if np.array_equal(size[::-1] if t % 2 else size, frame)] or list(turns)

    def right(turn: int) -> int:
        near = np.abs(turned_vectors(found.centre[on], np.full(len(on), turn)) + shifts[turn] - true.centre[on]) <= TOLERANCE
        return int((near.all(axis=1) & ((found.turns[on] + turn) % 4 == true.turns[on]) & (true.picture[on] == picture)).sum())

    best = max(possible, key=right)
    return picture, best, shifts[best]


def _anywhere(true: _Layout, found: _Layout, on: np.ndarray, turns: range) -> tuple[int, int, np.ndarray]:
    """The true picture, the turn and the shift on which most pieces `on` a picture agree."""
    best = (-1, 0, 0, np.zeros(2))
    for turn in turns:
        moved = turned_vectors(found.centre[on], np.full(len(on), turn))
        fits = (found.turns[on] + turn) % 4 == true.turns[on]
        shift = np.round(true.centre[on] - moved, 1)
        rows, counts = np.unique(np.column_stack([true.picture[on], shift])[fits], axis=0, return_counts=True)
        if len(counts) and counts.max() > best[0]:
            row = rows[counts.argmax()]
            best = (int(counts.max()), int(row[0]), turn, row[1:])
    return best[1:]


def _moved(found: _Layout, alignment: dict[int, tuple[int, int, np.ndarray]]) -> _Layout:
    """The layout found, each picture turned and shifted to where it fits the truth best."""
    picture, centre, turns = found.picture.copy(), found.centre.copy(), found.turns.copy()
    for k, (true_picture, turn, shift) in alignment.items():
        on = found.picture == k
        picture[on] = true_picture
        centre[on] = turned_vectors(found.centre[on], np.full(on.sum(), turn)) + shift
        turns[on] = (found.turns[on] + turn) % 4
    return _Layout(picture, centre, turns)


def _right_places(true: _Layout, found: _Layout, alignment: dict[int, tuple[int, int, np.ndarray]]) -> np.ndarray:
    moved = _moved(found, alignment)
    near = (np.abs(moved.centre - true.centre) <= TOLERANCE).all(axis=1)
    return near & (moved.picture == true.picture) & (moved.turns == true.turns)


def _same_beside(true: _Layout, found: _Layout, pairs: np.ndarray) -> np.ndarray:
    """Which pairs (k, 2) of pieces lie to each other in the layout found as they do in truth, (k,) bool."""
    a, b = pairs[:, 0], pairs[:, 1]
    together = (found.picture[a] == found.picture[b]) & (found.picture[a] != UNPLACED)
    together &= true.picture[a] == true.picture[b]
    together &= (found.turns[b] - found.turns[a]) % 4 == (true.turns[b] - true.turns[a]) % 4
    beside = [turned_vectors(layout.centre[b] - layout.centre[a], -layout.turns[a]) for layout in (true, found)]
    return together & (np.abs(beside[0] - beside[1]) <= TOLERANCE).all(axis=1)


def contacts(puzzle: Puzzle, picture: np.ndarray, position: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Pairs (k, 2) of pieces whose borders touch, a before b in reading order for squares; unplaced ones touch none.

    Polygons touch where at least two pixels of theirs do: one is the corner of a slope.
    """
    found = [np.zeros((0, 2), dtype=np.int64)]
    for k in np.unique(picture[picture != UNPLACED]):
        on = np.flatnonzero(picture == k)
        labels = _painted(puzzle, on, position[on], turns[on])
        pairs = np.concatenate([_beside(labels[:, :-1], labels[:, 1:]), _beside(labels[:-1], labels[1:])])
        if puzzle.square is None:
            pairs = np.sort(pairs, axis=1)
        distinct, counts = np.unique(pairs, axis=0, return_counts=True)
        found.append(distinct if puzzle.square is not None else distinct[counts >= 2])
    return np.concatenate(found)


def _painted(puzzle: Puzzle, on: np.ndarray, position: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Which piece covers each pixel (-1: none); for squares in whole cells of a grid, one pixel a cell."""
    px = puzzle.square
    low = position.min(axis=0)
    if px is not None and not ((position - low) % px).any():
        cells = (position - low) // px
        labels = np.full(cells.max(axis=0)[::-1] + 1, -1, dtype=np.int64)
        labels[cells[:, 1], cells[:, 0]] = on
        return labels
    masks = [np.rot90(puzzle.pieces[i].mask, -int(t)) for i, t in zip(on, turns, strict=True)]
    high = np.max([p + m.shape[::-1] for p, m in zip(position, masks, strict=True)], axis=0)
    labels = np.full((high - low)[::-1], -1, dtype=np.int64)
    for i, p, mask in zip(on, position - low, masks, strict=True):
        labels[p[1] : p[1] + mask.shape[0], p[0] : p[0] + mask.shape[1]][mask] = i
    return labels


def _beside(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    touch = (first != second) & (first >= 0) & (second >= 0)
    return np.stack([first[touch], second[touch]], axis=1)


def _largest(n: int, pairs: np.ndarray) -> int:
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    return int(np.bincount(connected_components(graph, directed=False)[1]).max())


def _looks(puzzle: Puzzle, turns: np.ndarray) -> np.ndarray:
    """A number (n,) for what each piece looks like after its turns; equal numbers look equal."""

    def key(piece: Piece, turn: int) -> tuple[object, ...]:
        image = np.rot90(piece.image, -turn)
        return image.shape, image.tobytes(), np.packbits(np.rot90(piece.mask, -turn)).tobytes()

    seen: dict[tuple[object, ...], int] = {}
    return np.array([seen.setdefault(key(p, int(t)), len(seen)) for p, t in zip(puzzle.pieces, turns, strict=True)])


def _tie_aware(
    puzzle: Puzzle, true: _Layout, found: _Layout, alignment: dict[int, tuple[int, int, np.ndarray]],
    touching: np.ndarray, solution: PuzzleSolution,
) -> tuple[float, float]:  # fmt: skip
    """Direct and neighbour scores by what pieces look like, not which they are."""
    n = puzzle.count
    moved = _moved(found, alignment)
    looks = _looks(Puzzle(puzzle.pieces * 2), np.concatenate([true.turns, moved.turns]))
    there = _places(true, looks[:n], np.ones(n, dtype=bool))
    here = _places(moved, looks[n:], found.picture != UNPLACED)
    direct = _common(there, here) / n
    pairs = contacts(puzzle, solution.picture, solution.position, solution.turns)
    return direct, _common(_relations(true, looks[:n], touching), _relations(moved, looks[n:], pairs)) / max(
        len(touching), 1
    )


def _places(layout: _Layout, looks: np.ndarray, on: np.ndarray) -> np.ndarray:
    return np.column_stack([layout.picture, np.round(2 * layout.centre), looks])[on]


def _relations(layout: _Layout, looks: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Rows (k, 4) that say what lies beside what and how, either order alike."""
    a, b = pairs[:, 0], pairs[:, 1]
    step = np.round(2 * (layout.centre[b] - layout.centre[a]))
    swap = (step[:, 0] < 0) | ((step[:, 0] == 0) & (step[:, 1] < 0))
    first, second = np.where(swap, b, a), np.where(swap, a, b)
    return np.column_stack([looks[first], looks[second], np.where(swap[:, None], -step, step)])


def _common(first: np.ndarray, second: np.ndarray) -> int:
    """How many rows two multisets of rows have in common."""
    if not len(first) or not len(second):
        return 0
    rows, owner = np.unique(np.concatenate([first, second]), axis=0, return_inverse=True)
    owner = owner.ravel()
    counts = [np.bincount(part, minlength=len(rows)) for part in (owner[: len(first)], owner[len(first) :])]
    return int(np.minimum(*counts).sum())


def true_partners(truth: Truth, px: int) -> np.ndarray:
    """The true partner (4 n,) int64 of each side 4 i + side of square pieces of `px` pixels; -1 at the frame."""
    n = len(truth.position)
    cells = np.column_stack([truth.picture, truth.position // px])
    where = {tuple(cell): i for i, cell in enumerate(cells.tolist())}
    partners = np.full(4 * n, -1, dtype=np.int64)
    for i, (picture, x, y) in enumerate(cells.tolist()):
        for direction, other in ((RIGHT, (picture, x + 1, y)), (RIGHT + 1, (picture, x, y + 1))):
            j = where.get(other, -1)
            if j >= 0:
                facing = LEFT if direction == RIGHT else TOP
                a = 4 * i + (direction - int(truth.turns[i])) % 4
                b = 4 * j + (facing - int(truth.turns[j])) % 4
                partners[a], partners[b] = b, a
    return partners
