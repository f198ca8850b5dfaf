"""How smooth the puzzle canvas is.

    python tests/benchmarks/canvas.py [--pieces 3300] [--width 954] [--height 677]

Prints, for a made-up picture of so many 28 px squares with all their joins (at most 6,500 for 3,300), the milliseconds of
a frame while the view pans and zooms, with all joins, with the doubtful ones, from close by, and while a piece is
carried; and what is paid once for a new solution. Median and slowest of 40 frames, painted off the screen.
"""

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import replace

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
from PySide6.QtCore import QPointF
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QApplication

from engine.puzzles.cutting import cut
from engine.puzzles.parameters import PuzzleParameters
from engine.puzzles.solution import Joins, PuzzleSolution
from gui.views.puzzle_canvas import PuzzleCanvas
from gui.views.puzzle_layout import Layout, arrange
from gui.views.puzzle_painting import Overlay
from gui.views.puzzle_scene import View, bins, hit_join, hit_piece, seams, shown_joins
from gui.views.puzzle_sheet import compose

PX, FRAMES = 28, 40


def world(pieces: int) -> tuple[PuzzleSolution, Layout]:
    """A solved puzzle of about so many squares; confidences as a solver's: nine in ten certain."""
    rng = np.random.default_rng(0)
    columns = round((pieces * 4 / 3) ** 0.5)
    rows = round(pieces / columns)
    image = np.repeat(np.repeat(rng.integers(0, 255, (rows * 4, columns * 4, 3), dtype=np.uint8), 7, 0), 7, 1)
    puzzle, truth = cut(image, piece_size=PX, seed=1)
    grid = np.zeros((rows, columns), np.int64)
    grid[truth.position[:, 1] // PX, truth.position[:, 0] // PX] = np.arange(puzzle.count)
    across = np.stack([grid[:, :-1].ravel(), np.full(grid[:, :-1].size, 1), grid[:, 1:].ravel(), np.full(grid[:, 1:].size, 3)], 1)
    down = np.stack([grid[:-1].ravel(), np.full(grid[:-1].size, 2), grid[1:].ravel(), np.full(grid[1:].size, 0)], 1)
    sides = np.concatenate([across, down])
    offset = np.where((sides[:, 1] == 1)[:, None], (PX, 0), (0, PX))
    sure = np.where(rng.random(len(sides)) < 0.9, rng.uniform(0.95, 1, len(sides)), rng.random(len(sides)))
    joins = Joins(sides, offset, np.zeros(len(sides)), sure)
    solution = PuzzleSolution("made up", truth.picture, truth.position, truth.turns, truth.sizes, joins, "", "", PuzzleParameters())
    return solution, arrange(puzzle, solution)


def timed(action: Callable[[int], object], times: int = FRAMES) -> str:
    """Median and slowest of a few runs, in words."""
    taken = []
    for k in range(times):
        start = time.perf_counter()
        action(k)
        taken.append(1000 * (time.perf_counter() - start))
    return f"{np.median(taken):6.1f} ms, slowest {max(taken):6.1f}"


def frames(canvas: PuzzleCanvas, image: QImage, views: Callable[[int], View]) -> str:
    """Milliseconds of a frame while the view moves."""

    def paint(k: int) -> None:
        canvas.view = views(k)
        canvas._refresh()
        canvas.render(image)

    paint(0)
    return timed(paint)


def main() -> None:
    """Print all figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pieces", type=int, default=3300)
    parser.add_argument("--width", type=int, default=954)
    parser.add_argument("--height", type=int, default=677)
    options = parser.parse_args()
    app = QApplication([])
    solution, layout = world(options.pieces)
    joins, none = solution.joins, np.zeros(len(solution.joins), bool)
    print(f"{len(layout.placed)} pieces, {len(joins)} joins, {options.width} × {options.height}")
    print("once, a new solution:  lay out    ", timed(lambda _: arrange(layout.puzzle, solution), 5))
    print("                       all pixels ", timed(lambda _: compose(layout), 5))
    print("                       seams      ", timed(lambda _: seams(layout, joins), 5))
    canvas = PuzzleCanvas()
    canvas.resize(options.width, options.height)
    canvas.show()
    canvas.show_layout(layout)
    image = QImage(options.width, options.height, QImage.Format.Format_ARGB32_Premultiplied)
    whole = canvas.view
    middle = (options.width / 2, options.height / 2)
    segments = seams(layout, joins)
    for words, below in (("all joins", 1.0), ("doubtful joins", 0.95), ("no joins", 0.0)):
        shown = shown_joins(joins, below, -1, none)
        canvas.show_overlay(Overlay(segments, bins(joins.confidence), shown, {}, none))
        print(f"a frame, {words} ({int(shown.sum())}):")
        print("   panned, seen whole  ", frames(canvas, image, lambda k: whole.moved(k, k / 2)))
        print("   zoomed              ", frames(canvas, image, lambda k: whole.zoomed(1.05**k, *middle)))
        print("   from close by (12×) ", frames(canvas, image, lambda k: whole.zoomed(12, *middle).moved(3 * k, k)))
    judged = {k: ("correct", "wrong", "tie")[k % 3] for k in range(0, len(joins), 20)}
    canvas.show_overlay(replace(canvas.overlay, shown=~none, judged=judged, locked=np.arange(len(joins)) % 40 == 0))
    print(f"a frame, all joins, {len(judged)} judged, some locked:", frames(canvas, image, lambda k: whole.moved(k, 0)))
    canvas.view = whole
    screen = whole.to_screen(segments)
    print("under a hand:  hit a join ", timed(lambda k: hit_join(screen, 20.0 * k, 10.0 * k, 6)))
    print("               hit a piece", timed(lambda k: hit_piece(layout, 40.0 * k, 30.0 * k)))
    canvas.take_up(5, QPointF(*whole.to_screen(layout.position[5] + 3)))

    def carry(k: int) -> None:
        canvas.carry_to(QPointF(20.0 * k, 15.0 * k))
        canvas.render(image)

    print("               carry      ", timed(carry))
    canvas.close()
    app.processEvents()


if __name__ == "__main__":
    main()
