"""`python -m gui.screenshots OUT`: every page with the bundled example, light and dark, as PNG files to look at."""

import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from PySide6.QtWidgets import QWidget

    from .main_window import MainWindow

PATIENCE = 180.0


def take_all(out: Path) -> list[Path]:
    """Write the pictures to a folder and return their paths; nothing of the user's own settings or votes is touched."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    written: list[Path] = []
    for dark in (False, True):
        with tempfile.TemporaryDirectory() as data:
            os.environ["CONCORD_HOME"] = data
            written += _take(out, dark, Path(data))
    return written


def _take(out: Path, dark: bool, data: Path) -> list[Path]:
    from PySide6.QtWidgets import QApplication

    from .main_window import MainWindow
    from .screenshots_study import take_study
    from .screenshots_voting import take_voting
    from .startup import open_window

    app = QApplication.instance() or QApplication(sys.argv[:1])
    written: list[Path] = []

    def wait(ready: Callable[[], bool]) -> None:
        end = time.monotonic() + PATIENCE
        while not ready():
            if time.monotonic() > end:
                raise TimeoutError(window.messages.text.text() or "The window did not become ready.")
            app.processEvents()
            time.sleep(0.01)

    def rest(seconds: float = 0.6) -> None:
        end = time.monotonic() + seconds
        wait(lambda: time.monotonic() > end and not any(j.busy() for j in (window.study_jobs, window.jobs, window.studies.jobs)))

    def save(name: str, shown: "QWidget") -> None:
        written.append(out / f"{name}-{'dark' if dark else 'light'}.png")
        shown.grab().save(str(written[-1]))

    def shot(name: str, shown: "QWidget | None" = None) -> None:
        rest()
        save(name, shown or window)

    window = MainWindow(dark=dark)
    open_window(window)
    written.append(out / f"opening-{'dark' if dark else 'light'}.png")
    window.grab().save(str(written[-1]))
    wait(lambda: window.furnished and window.session.state.result is not None)
    shot("shapes")
    for answer in ("correct", "correct", "wrong", "correct"):
        if not window.session.state.selected:
            window.step_match(1)
        rest(0.05)
        window.answer(answer)
        rest(0.05)
    shot("judged")
    window.shapes.panel.setCurrentIndex(1)
    window.matching.choose_preset("thesis-rigid")
    window.matching.edit("delta_1", 0.3, True)
    shot("parameters")
    window.shapes.panel.setCurrentIndex(0)
    window.shapes.step_layer(1)
    window.shapes.step_layer(1)
    shot("layer")
    window.shapes.step_node(1)
    shot("node")
    window.shapes.step_layer(-2)
    window.segments.edit(0)
    wait(lambda: window.page == "segments")
    window.segments.choose((0, 1))
    shot("segments")
    window.segments.done()
    _collection(window, wait, shot)
    _puzzle(window, wait, rest, shot)
    window.show_page("study")
    wait(lambda: window.study.question is not None)
    shot("study")
    window.show_page("results")
    wait(lambda: bool(window.results.content.rows))
    shot("results")
    window.show_page("shapes")
    window.say("vase.off has no faces; Concord needs a surface made of triangles.", "details")
    shot("message")
    window.messages.dismiss()
    take_study(window, data, wait, shot)
    take_voting(window, data, wait, save)
    window.close()
    window.deleteLater()
    app.processEvents()
    return written


def _collection(window: "MainWindow", wait: Callable, shot: Callable) -> None:
    """The page of a collection: empty, in the colours of parts, one part lit up, the pairs, and one of them."""
    window.show_page("collection")
    shot("collection-empty")
    desk = window.collection
    desk.open_example()
    wait(lambda: desk.session.state.found is not None and desk.page.made.view.ready)
    shot("collection")
    desk.step_part(1)
    shot("collection-part")
    desk.page.made.panel.setCurrentIndex(1)
    window.session.update(least_support=0.5)
    shot("collection-pairs")
    desk.show_pair(0)
    shot("collection-pair")
    window.session.update(least_support=0.0)


def _puzzle(window: "MainWindow", wait: Callable, rest: Callable, shot: Callable) -> None:
    """The puzzle page: empty, the tray, the picture growing, doubtful joins, judged and locked ones, the truth."""
    window.show_page("puzzle")
    shot("puzzle-empty")
    puzzle = window.puzzle
    puzzle.open_example()
    wait(lambda: puzzle.session.state.puzzle is not None)
    shot("puzzle-tray")
    puzzle.solve()
    wait(lambda: puzzle.page.view.is_growing)
    shot("puzzle-growing")
    wait(lambda: not puzzle.page.view.is_growing)
    puzzle.session.update(below=1.0)  # every join of the example is more certain than the slider's first value
    puzzle.page.step_join(1)
    shot("puzzle-doubtful")
    for answer in ("correct", "wrong"):
        window.answer(answer)
        rest(0.1)
    puzzle.hands.lock()
    rest(0.1)
    puzzle.page.step_join(1)
    puzzle.hands.reject()
    shot("puzzle-rejected")
    puzzle.page.view.reset_view()
    puzzle.session.update(below=1.0)
    puzzle.page.toggle_truth()
    shot("puzzle-truth")
    puzzle.page.panel.setCurrentIndex(1)
    shot("puzzle-parameters")


def main() -> int:
    """Take all pictures into the folder that is named on the command line."""
    if len(sys.argv) != 2:
        print("usage: python -m gui.screenshots OUT", file=sys.stderr)
        return 2
    out = Path(sys.argv[1])
    out.mkdir(parents=True, exist_ok=True)
    for path in take_all(out):
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
