"""How soon the next question is there: milliseconds from the key to the end of the paint of the next item.

    python tests/benchmarks/voting_latency.py [--votes 40] [--items 60] [--think 1.0] [--size 1366x768]

A study of `items` matches of the bundled shapes and of joins of the bundled picture is made in a temporary folder, and
voted on in the volunteers' window with real key events, `think` seconds after each paint. Prints median and 95 % of the
whole way, of the commit within it, and of both kinds of items by themselves. Without a display it runs on Qt's offscreen
platform.
"""

import argparse
import os
import statistics
import sys
import tempfile
import time
from pathlib import Path

if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
    os.environ |= {"QT_QPA_PLATFORM": "offscreen", "VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow"}

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from annotation import study
from annotation.results.puzzlejoins import join_items
from annotation.storage.blobs import keep_shapes
from assets import example_pairs, example_picture
from engine.puzzles.cutting import cut
from engine.puzzles.imagefile import opaque, read_image
from engine.puzzles.solution import Joins
from engine.shapes.identity import match_id, mesh_id, node_id, segment_ids
from engine.shapes.meshfile import load_shape
from engine.shapes.segmentation import SegmentedShape
from gui.pages.voting import desk as voting_desk
from gui.views.join import JoinView
from gui.views.voting_pair import VotingPairView
from gui.volunteer import VolunteerWindow

PIECE = 112


def side_of(shape: SegmentedShape, ids: tuple[str, ...], segments: list[int]) -> tuple[dict, str]:
    """One side of an item, and the hash of its union."""
    names = [shape.segmentation.names[k] for k in segments]
    side = {"file": "", "sha256": mesh_id(shape.mesh), "segmentation": node_id(ids), "segments": names}
    return side, node_id(ids[k] for k in segments)


def shape_items(count: int, rng: np.random.Generator) -> tuple[list[study.Item], list[SegmentedShape]]:
    """So many distinct matches of random unions of the bundled pairs, and the shapes."""
    pairs = [tuple(load_shape(path) for path in pair[1:]) for pair in example_pairs()[:5]]
    hashes = [[segment_ids(shape.mesh, shape.segmentation) for shape in pair] for pair in pairs]
    found: dict[str, study.Item] = {}
    while len(found) < count:
        k = int(rng.integers(len(pairs)))
        unions = [sorted(rng.choice(s.segmentation.count, min(s.segmentation.count, int(rng.integers(1, 4))), replace=False).tolist())
                  for s in pairs[k]]  # fmt: skip
        (one, a), (other, b) = (side_of(s, ids, u) for s, ids, u in zip(pairs[k], hashes[k], unions, strict=True))
        found.setdefault(match_id(a, b), study.shape_item(match_id(a, b), one, other))
    return list(found.values()), [shape for pair in pairs for shape in pair]


def puzzle_items(count: int) -> list[study.Item]:
    """At most so many joins of squares of the bundled picture, right ones."""
    puzzle, truth = cut(opaque(read_image(example_picture())), piece_size=PIECE, seed=1, turned=False, name="picture")
    gaps = np.abs(truth.position[:, None] - truth.position[None]).sum(axis=2)
    pairs = [(a, b) for a, b in np.argwhere(gaps == PIECE).tolist() if a < b][:count]
    offsets = np.array([truth.position[b] - truth.position[a] for a, b in pairs])
    sides = [(a, 1 if x > 0 else 3 if x < 0 else 2 if y > 0 else 0, b, 3 if x > 0 else 1 if x < 0 else 0 if y > 0 else 2)
             for (a, b), (x, y) in zip(pairs, offsets.tolist(), strict=True)]  # fmt: skip
    ones = np.ones(len(pairs))
    return list(join_items(puzzle, Joins(np.array(sides), offsets, np.zeros(len(pairs), int), ones)))


def make_study(path: Path, items: int) -> None:
    """A study of shapes, and of joins to a fifth."""
    joins = puzzle_items(items // 5)
    matches, shapes = shape_items(items - len(joins), np.random.default_rng(5))
    with study.create_study(path, name="Latency", seed="5") as handle:
        study.add_items(handle, [*matches, *joins])
        keep_shapes(handle, shapes)


class Painted:
    """When a view was last painted to the end."""

    def __init__(self) -> None:
        self.at = 0.0
        for view in (VotingPairView, JoinView):
            self._watch(view)

    def _watch(self, view: type) -> None:
        before = view.paintEvent

        def paint(widget, event):
            before(widget, event)
            self.at = time.perf_counter()

        view.paintEvent = paint


def vote(path: Path, votes: int, think: float, size: tuple[int, int]) -> tuple[list[tuple[str, float]], list[float]]:
    """Vote so many times; kind of the next item and milliseconds until it was painted, and those of each commit."""
    app, painted, commits = QApplication.instance() or QApplication(sys.argv[:1]), Painted(), []
    record = study.record_vote

    def recorded(*args, **kwargs):
        began = time.perf_counter()
        found = record(*args, **kwargs)
        commits.append((time.perf_counter() - began) * 1000)
        return found

    voting_desk.study.record_vote = recorded
    window = VolunteerWindow(str(path), "anna", dark=False)
    window.resize(*size)
    window.show()
    window.begin()

    def wait(ready, patience: float = 60.0) -> None:
        end = time.perf_counter() + patience
        while not ready():
            app.processEvents()
            if time.perf_counter() > end:
                said = window.screen.trouble.words.text() or window.screen.notice.text.text()
                raise SystemExit(f"Nothing came: {said}\n{window.desk.details}")
            time.sleep(0.0005)

    wait(lambda: window.screen.notice.heading.text() == "Welcome")
    QTest.keyClick(window.screen, Qt.Key.Key_Return)
    wait(lambda: window.screen.asking)

    def once(key: Qt.Key) -> tuple[str, float]:
        rested = time.perf_counter() + think
        wait(lambda: time.perf_counter() >= rested)
        before, pressed = window.desk.question, time.perf_counter()
        QTest.keyClick(window.screen, key)
        wait(lambda: window.desk.question not in (None, before) and pressed < shown[0] <= painted.at)
        return type(window.desk.question).__name__, (painted.at - pressed) * 1000

    found = [once(Qt.Key.Key_J if number % 2 else Qt.Key.Key_F) for number in range(votes)]
    window.close()
    return found, commits


shown = [0.0]


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--votes", type=int, default=40)
    parser.add_argument("--items", type=int, default=60)
    parser.add_argument("--think", type=float, default=1.0, help="seconds between a paint and the next key")
    parser.add_argument("--size", default="1366x768")
    chosen = parser.parse_args()
    show = voting_desk.VotingDesk._show

    def stamped(desk, *args):
        shown[0] = time.perf_counter()  # what is painted from here on is the next item
        show(desk, *args)

    voting_desk.VotingDesk._show = stamped
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "latency.study"
        make_study(path, chosen.items)
        width, height = map(int, chosen.size.split("x"))
        found, commits = vote(path, chosen.votes, chosen.think, (width, height))
    print(f"{len(found)} votes in a study of {chosen.items} matches, {chosen.think:g} s after each paint, {chosen.size}")
    report("key to painted", [ms for _, ms in found])
    report("  of it commit", commits)
    for kind, words in (("Question", "  shapes next"), ("JoinQuestion", "  join next")):
        report(words, [ms for name, ms in found if name == kind])


def report(words: str, values: list[float]) -> None:
    """One line: median and 95 %."""
    if values:
        ordered = sorted(values)
        late = ordered[min(len(ordered) - 1, round(0.95 * len(ordered)))]
        print(f"{words}: median {statistics.median(values):.0f} ms, 95 % {late:.0f} ms, worst {ordered[-1]:.0f} ms ({len(values)})")


if __name__ == "__main__":
    main()
