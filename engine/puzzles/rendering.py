"""Pictures of puzzles: the assembled picture, marks on it, and a sheet of the pieces as they were read."""

from collections.abc import Sequence

import numpy as np

from .pieces import Piece, Puzzle
from .solution import PuzzleSolution
from .turning import turned_polygon, turned_raster

# Red to blue through a pale middle, told apart by all kinds of colour sight; doubtful joins are the warm ones.
SCALE = np.array([[0xC8, 0x3E, 0x00], [0xE6, 0x8A, 0x2E], [0xF0, 0xD8, 0x8A], [0x7F, 0xBF, 0xE8], [0x00, 0x72, 0xB2]], float)
WRONG = np.array([0xD5, 0x5E, 0x00], dtype=np.float64)
SURE = 0.9  # confidence from which a join is drawn as certain
PAPER = np.array([0xFA, 0xFA, 0xF7], dtype=np.uint8)


def assembled(puzzle: Puzzle, solution: PuzzleSolution, picture: int = 0) -> np.ndarray:
    """The picture that the placed pieces make, (h, w, 4) uint8 RGBA; transparent where no piece lies."""
    w, h = (int(side) for side in solution.sizes[picture])
    canvas = np.zeros((max(h, 1), max(w, 1), 4), dtype=np.uint8)
    full = puzzle.square is not None
    for i in np.flatnonzero(solution.picture == picture):
        _lay(canvas, puzzle.pieces[i], solution.position[i], int(solution.turns[i]), full)
    return canvas


def _lay(canvas: np.ndarray, piece: Piece, position: np.ndarray, turns: int, full: bool) -> None:
    """Put the seen pixels of a turned piece on the canvas; what lies outside is cut off."""
    image = turned_raster(piece.image, turns) if turns else piece.image
    h, w = image.shape[:2]
    x, y = int(position[0]), int(position[1])
    x0, y0, x1, y1 = max(x, 0), max(y, 0), min(x + w, canvas.shape[1]), min(y + h, canvas.shape[0])
    if x0 >= x1 or y0 >= y1:
        return
    place, part = canvas[y0:y1, x0:x1], (slice(y0 - y, y1 - y), slice(x0 - x, x1 - x))
    if full:
        place[..., :3], place[..., 3] = image[part], 255
    else:
        seen = turned_raster(piece.mask, turns)[part]
        place[seen, :3], place[seen, 3] = image[part][seen], 255


def confidence_colours(confidence: np.ndarray) -> np.ndarray:
    """Colours (j, 3) uint8 of confidences (j,) in [0, 1]: warm where a join is doubtful, blue where it is certain."""
    at = np.clip(confidence, 0, 1) * (len(SCALE) - 1)
    low = np.minimum(at.astype(np.int64), len(SCALE) - 2)
    part = (at - low)[:, None]
    return np.round(SCALE[low] * (1 - part) + SCALE[low + 1] * part).astype(np.uint8)


def marked(
    canvas: np.ndarray, puzzle: Puzzle, solution: PuzzleSolution, *, picture: int = 0,
    right: np.ndarray | None = None, joins: bool = True,
) -> np.ndarray:  # fmt: skip
    """A copy of the assembled picture on paper with marks, (h, w, 3) uint8.

    `right` (n,) bool, where the truth is known, hatches the pieces that lie wrong; `joins` draws the shared sides in
    the colours of their confidence, the doubtful ones thicker and last.
    """
    seen = canvas[..., 3:] > 0
    shown = np.where(seen, canvas[..., :3], PAPER).astype(np.uint8)
    if right is not None:
        for i in np.flatnonzero((solution.picture == picture) & ~right):
            _hatch(shown, puzzle.pieces[i], solution.position[i], int(solution.turns[i]))
    if joins:
        _draw_joins(shown, puzzle, solution, picture)
    return shown


def _draw_joins(shown: np.ndarray, puzzle: Puzzle, solution: PuzzleSolution, picture: int) -> None:
    """The shared sides in their colours: certain ones thin and faint, then doubtful ones, the most doubtful on top."""
    import cv2

    confidence = solution.joins.confidence
    chosen = np.flatnonzero(solution.picture[solution.joins.sides[:, 0]] == picture)
    chosen = chosen[np.argsort(-confidence[chosen], kind="stable")]
    sure = confidence[chosen] >= SURE
    ends = np.round(side_ends(puzzle, solution, chosen) * 16 - 8).astype(np.int32)
    colours = confidence_colours(confidence[chosen])
    width = max(1, round(typical_side(puzzle) / 28))
    faint = shown.copy()
    for page, rows, thick in ((faint, np.flatnonzero(sure), width), (shown, np.flatnonzero(~sure), 2 * width)):
        for k in rows:
            cv2.line(page, ends[k, 0].tolist(), ends[k, 1].tolist(), colours[k].tolist(), thick, cv2.LINE_AA, 4)
        if page is faint:
            cv2.addWeighted(faint, 0.5, shown, 0.5, 0.0, dst=shown)


def side_ends(puzzle: Puzzle, solution: PuzzleSolution, joins: Sequence[int] | np.ndarray) -> np.ndarray:
    """The two ends of what the sides of some joins share in the assembled picture, (j, 2, 2) float64 pixels."""
    ends = np.zeros((len(joins), 2, 2))
    for k, (a, side_a, b, side_b) in enumerate(solution.joins.sides[np.asarray(joins, dtype=np.int64)]):
        one, other = (_side(puzzle, solution, int(i), int(side)) for i, side in ((a, side_a), (b, side_b)))
        along = one[1] - one[0]
        length = float(np.hypot(*along)) or 1.0
        at = np.sort((other - one[0]) @ along / length)
        start, stop = max(at[0], 0.0), min(at[1], length)
        ends[k] = one[0] + np.array([[start], [max(stop, start)]]) * along / length
    return ends


def _side(puzzle: Puzzle, solution: PuzzleSolution, i: int, side: int) -> np.ndarray:
    """The two corners (2, 2) of a side of a placed piece."""
    piece = puzzle.pieces[i]
    h, w = piece.mask.shape
    corners = piece.polygon[[side, (side + 1) % len(piece.polygon)]]
    return turned_polygon(corners, (w, h), int(solution.turns[i])) + solution.position[i]


def typical_side(puzzle: Puzzle) -> float:
    """The side in pixels of a square as large as the middle piece."""
    return float(np.sqrt(np.median([piece.mask.size for piece in puzzle.pieces])))


def _hatch(shown: np.ndarray, piece: Piece, position: np.ndarray, turns: int) -> None:
    """Diagonal stripes over a piece and a tint under them."""
    mask = turned_raster(piece.mask, turns)
    h, w = mask.shape
    x, y = int(position[0]), int(position[1])
    x0, y0, x1, y1 = max(x, 0), max(y, 0), min(x + w, shown.shape[1]), min(y + h, shown.shape[0])
    if x0 >= x1 or y0 >= y1:
        return
    place, seen = shown[y0:y1, x0:x1], mask[y0 - y : y1 - y, x0 - x : x1 - x, None]
    step = max(6, round(min(h, w) / 3))
    stripe = (np.add.outer(np.arange(y0, y1), np.arange(x0, x1)) % step < max(2, step // 4))[..., None]
    strength = seen * np.where(stripe, 0.8, 0.15)
    place[:] = np.round(place * (1 - strength) + WRONG * strength).astype(np.uint8)


def sheet(puzzle: Puzzle, *, width: int = 1200, most: int = 30_000) -> np.ndarray:
    """All pieces as they were read, in their order, in rows on paper, (h, width, 3) uint8; at most `most` of them."""
    import cv2

    pieces = puzzle.pieces[:most]
    sides = np.array([piece.mask.shape[::-1] for piece in pieces], dtype=np.float64)
    scale = min(np.sqrt(0.62 * width**2 / (sides[:, 0] * sides[:, 1]).sum()), 240 / sides.max(), 2.5)
    sizes = np.maximum(np.round(sides * scale), 1).astype(np.int64)
    gap = 1 if np.median(sizes) < 16 else 3 if puzzle.square is not None else 8
    places, height = shelves(sizes, width, gap)
    page = np.broadcast_to(PAPER, (height, width, 3)).copy()
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_NEAREST
    for piece, (x, y), (w, h) in zip(pieces, places.tolist(), sizes.tolist(), strict=True):
        small = np.asarray(cv2.resize(piece.image, (w, h), interpolation=how))
        place = page[y : y + h, x : x + w]
        if piece.mask.all():
            place[:] = small
        else:
            share = np.asarray(cv2.resize(piece.mask.astype(np.float32), (w, h), interpolation=how))[..., None]
            place[:] = np.minimum(small + place * (1 - share), 255).astype(np.uint8)
    return page


def shelves(sizes: np.ndarray, width: int, gap: int) -> tuple[np.ndarray, int]:
    """Places (n, 2) of boxes (n, 2) side by side in rows no wider than `width`, in their order, and the height of all."""
    places = np.zeros((len(sizes), 2), dtype=np.int64)
    x, y, tallest, first = gap, gap, 0, 0
    for k, (w, h) in enumerate(sizes.tolist()):
        if k > first and x + w + gap > width:
            y, x, tallest, first = y + tallest + gap, gap, 0, k
        places[k] = x, y
        x, tallest = x + w + gap, max(tallest, h)
    return places, y + tallest + gap


def close_up(puzzle: Puzzle, solution: PuzzleSolution, join: int, *, longest: int = 150) -> np.ndarray:
    """The two pieces of one join as they lie in the assembled picture and nothing else, (h, w, 3) uint8, enlarged."""
    import cv2

    pair = solution.joins.sides[join, ::2]
    turned = [turned_raster(puzzle.pieces[i].mask, int(solution.turns[i])).shape for i in pair]
    low = solution.position[pair].min(axis=0)
    w, h = np.max([solution.position[i] + (m[1], m[0]) for i, m in zip(pair, turned, strict=True)], axis=0) - low
    canvas = np.zeros((h, w, 4), dtype=np.uint8)
    for i in pair:
        _lay(canvas, puzzle.pieces[i], solution.position[i] - low, int(solution.turns[i]), False)
    shown = np.where(canvas[..., 3:] > 0, canvas[..., :3], PAPER).astype(np.uint8)
    scale = longest / max(h, w)
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_NEAREST
    return np.asarray(cv2.resize(shown, (max(1, round(w * scale)), max(1, round(h * scale))), interpolation=how))


def thumbnail(pixels: np.ndarray, *, longest: int) -> np.ndarray:
    """Pixels scaled down so that the longer side is at most `longest`; smaller ones stay as they are."""
    import cv2

    h, w = pixels.shape[:2]
    scale = longest / max(h, w)
    if scale >= 1:
        return pixels
    return np.asarray(cv2.resize(pixels, (max(1, round(w * scale)), max(1, round(h * scale))), interpolation=cv2.INTER_AREA))
