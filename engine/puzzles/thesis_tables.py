"""Tables 4.1 and 5.2 of the thesis on any pictures, with what was chosen by the truth apart from what was not."""

import time
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..errors import BadInput
from ..progress import Progress, share, silent
from .confirming import confirm_diffusion, confirm_matchlift
from .corners import universe_of
from .cutting import cut
from .halves import half_dissimilarity
from .measures import Strips, side_strips
from .parameters import PuzzleParameters
from .plaintree import Ratios, direct_and_neighbour, judged, plain_tree, ratios_of

T_1 = tuple(np.linspace(0.6, 1.0, 20).round(3).tolist())  # the grid of the thesis, section 4.5.1
T_2 = tuple(np.linspace(0.5, 0.95, 9).round(3).tolist())
GRIDS = (10, 12, 14)  # 100, 144 and 196 pieces
PIECES = 192  # of Table 5.2
MEASURE = "mgc-root"
Images = Sequence[tuple[str, np.ndarray]]  # names and pixels (h, w, 3) uint8
NONE = np.zeros(0, dtype=np.int64)


class Outcome(NamedTuple):
    """Shares in [0, 1] of one assembly, the thresholds it was made with, and what the judge says of it."""

    direct: float
    neighbour: float
    t_1: float = np.nan
    t_2: float = np.nan
    judge: float = np.nan


class Lifted(NamedTuple):
    """One puzzle of Table 4.1: the spanning tree alone; the best of the grid, chosen by the truth; the one that the
    judge chose, who sees no truth; and the seconds of one lift and of one assembly, in the mean."""

    image: str
    pieces: int
    tree: Outcome
    best: Outcome
    chosen: Outcome
    lift_seconds: float
    assembly_seconds: float


class Way(NamedTuple):
    """One way of Table 5.2 on one picture: `precision` and `recall` of the confirmed joins, nan where there are none."""

    direct: float
    neighbour: float
    precision: float = np.nan
    recall: float = np.nan


class Pruned(NamedTuple):
    """One picture of Table 5.2: the ways by their names."""

    image: str
    pieces: int
    ways: dict[str, Way]


class _Puzzle(NamedTuple):
    """Strips of shuffled squares, their true cells (n, 2) and the grid (columns, rows)."""

    strips: Strips
    true: np.ndarray
    grid: tuple[int, int]


def _cut(image: np.ndarray, seed: int, *, pieces: int | None = None, piece_size: int | None = None) -> _Puzzle:
    puzzle, truth = cut(image, pieces=pieces, piece_size=piece_size, seed=seed)
    px = puzzle.square or 1
    w, h = truth.sizes[0] // px
    return _Puzzle(side_strips(puzzle.rasters()), truth.position // px, (int(w), int(h)))


def table_4_1(
    images: Images,
    parameters: PuzzleParameters,
    *,
    grids: Sequence[int] = GRIDS,
    t_1: Sequence[float] = T_1,
    t_2: Sequence[float] = T_2,
    resolution: int = 168,
    seed: int = 0,
    progress: Progress = silent,
) -> list[Lifted]:
    """Corners with MatchLift against the spanning tree alone, on the central square of each picture.

    Parameters
    ----------
    images, parameters
        The pictures; of the parameters, those of the group MatchLift but the thresholds.
    grids
        A grid of g cuts the square into g × g pieces, always shuffled.
    t_1, t_2
        The thresholds that are tried (Eq 4.5, section 4.4). One lift serves all t_2.
    resolution
        The side that the square is scaled to, in pixels: the fewer, the harder. 0 leaves it as it is.
    """
    jobs = [(name, image, g) for name, image in images for g in grids]
    rows = []
    for k, (name, image, g) in enumerate(jobs):
        step = share(progress, k / len(jobs), (k + 1) / len(jobs))
        rows.append(_lifted(name, _central_square(name, image, g, resolution), g, parameters, t_1, t_2, seed, step))
    return rows


def _central_square(name: str, image: np.ndarray, grid: int, resolution: int) -> np.ndarray:
    """The largest central square, scaled to the resolution and cropped to a whole number of pixels a piece."""
    import cv2

    side = min(image.shape[:2])
    top, left = (image.shape[0] - side) // 2, (image.shape[1] - side) // 2
    square = image[top : top + side, left : left + side]
    if resolution:
        square = cv2.resize(square, (resolution, resolution), interpolation=cv2.INTER_AREA)
    whole = len(square) // grid * grid
    if whole < 4 * grid:
        raise BadInput(f"The picture {name} is too small for {grid} × {grid} pieces of 4 pixels; give a larger one.")
    start = (len(square) - whole) // 2
    return np.ascontiguousarray(square[start : start + whole, start : start + whole])


def _lifted(
    name: str, square: np.ndarray, grid: int, p: PuzzleParameters, t_1: Sequence[float], t_2: Sequence[float], seed: int,
    progress: Progress,
) -> Lifted:  # fmt: skip
    puzzle = _cut(square, seed, piece_size=len(square) // grid)
    ratios = ratios_of(MEASURE, puzzle.strips)
    halves = half_dissimilarity(MEASURE, puzzle.strips, ratios.pairs)
    tried, lifting, began = [], 0.0, time.perf_counter()
    for k, threshold in enumerate(t_1):
        progress(k / len(t_1), f"{name}, {grid * grid} pieces")
        start = time.perf_counter()
        confidence = confirm_matchlift(
            ratios.pairs, halves, count=grid * grid, universe=universe_of(*puzzle.grid), t_1=threshold, t_2=0.5,
            sparsity=p.lift_sparsity, penalty=p.lift_penalty, tolerance=p.lift_tolerance, max_steps=p.lift_steps,
            at_once=p.lift_whole, progress=share(progress, k / len(t_1), (k + 1) / len(t_1))).confidence  # fmt: skip
        lifting += time.perf_counter() - start
        tried += [
            _assembled(puzzle, ratios, np.flatnonzero(confidence >= t), puzzle.grid)._replace(t_1=threshold, t_2=t)
            for t in t_2
        ]
    assembling = (time.perf_counter() - began - lifting) / max(len(tried), 1)
    best = max(tried, key=lambda o: (o.direct, o.neighbour))
    chosen = min(tried, key=lambda o: o.judge)
    tree = _assembled(puzzle, ratios, NONE, puzzle.grid)
    return Lifted(name, grid * grid, tree, best, chosen, lifting / max(len(t_1), 1), assembling)


def _assembled(puzzle: _Puzzle, ratios: Ratios, first: np.ndarray, frame: tuple[int, int] | None) -> Outcome:
    cells = plain_tree(ratios, frame, first)
    return Outcome(*direct_and_neighbour(cells, puzzle.true, shifted=frame is None), judge=judged(ratios, cells))


WAYS = (
    ("MGC", "mgc-root", False), ("pruned, MGC", "mgc-root", True), ("EMD", "emd", False), ("pruned, EMD", "emd", True),
    ("EMD in L*a*b*", "emd-lab", False), ("pruned, EMD in L*a*b*", "emd-lab", True),
)  # fmt: skip


def table_5_2(
    images: Images,
    parameters: PuzzleParameters,
    *,
    pieces: int = PIECES,
    frame: bool = False,
    seed: int = 0,
    progress: Progress = silent,
) -> list[Pruned]:
    """Diffusion pruning against the spanning tree alone, with MGC and with EMD, at one fixed setting.

    The parameters are those of the group Diffusion pruning, none of them chosen by the truth; `frame` says whether the
    assembly may know the size of the picture.
    """
    rows = []
    for k, (name, image) in enumerate(images):
        progress(k / len(images), name)
        puzzle = _cut(image, seed, pieces=pieces)
        table = {measure: ratios_of(measure, puzzle.strips) for measure in {m for _, m, _ in WAYS}}
        ways = {label: _way(puzzle, table[m], m, pruned, parameters, frame) for label, m, pruned in WAYS}
        rows.append(Pruned(name, len(puzzle.true), ways))
    progress(1.0, "done")
    return rows


def _way(
    puzzle: _Puzzle, ratios: Ratios, measure: str, pruned: bool, p: PuzzleParameters, frame: bool
) -> Way:
    size = puzzle.grid if frame else None
    if not pruned:
        found = _assembled(puzzle, ratios, NONE, size)
        return Way(found.direct, found.neighbour)
    length = max(1, round(p.half_length * puzzle.strips.outer.shape[1]))
    kept = confirm_diffusion(
        ratios.pairs, half_dissimilarity(measure, puzzle.strips, ratios.pairs, length=length), count=len(puzzle.true),
        knn=p.prune_nearest, t_1=p.prune_similarity, t_2=p.prune_agreement, t_3=p.prune_share,
        iterations=p.prune_rounds, least=p.prune_confidence).kept  # fmt: skip
    found = _assembled(puzzle, ratios, np.flatnonzero(kept), size)
    right = _true_joins(ratios.pairs, puzzle.true)
    return Way(found.direct, found.neighbour, (kept & right).sum() / max(kept.sum(), 1), (kept & right).sum() / right.sum())


def _true_joins(pairs: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Which pairs of sides of unturned squares truly touch, (c,) bool."""
    step = np.array([(0, -1), (1, 0), (0, 1), (-1, 0)])[pairs[:, 0] % 4]
    return (true[pairs[:, 1] // 4] - true[pairs[:, 0] // 4] == step).all(axis=1)
