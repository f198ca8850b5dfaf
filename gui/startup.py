"""Start of the window: painted at once, furnished when the heavy modules have been imported in a thread."""

import importlib
import signal
import sys
from collections.abc import Sequence

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication

from engine.progress import Progress

from . import glprobe
from .main_window import MainWindow

Labels = tuple[str | None, str | None]
HEAVY = (
    "gui.session", "gui.pages.shapes.page", "gui.views.pair", "gui.pages.voting.page", "gui.pages.results.page", "gui.pages.puzzle.desk",
    "gui.pages.collection.desk", "qtawesome", "assets", "engine.shapes.meshfile", "engine.shapes.matching",
)  # fmt: skip


def load_modules(progress: Progress) -> None:
    """Import what the pages need, and try the graphics; in the thread behind the placeholder."""
    for k, name in enumerate(HEAVY):
        progress(k / len(HEAVY), "Opening")
        importlib.import_module(name)
        if name == "gui.views.pair":
            glprobe.problem()


def open_window(window: MainWindow, files: Sequence[str] = (), labels: Labels = (None, None)) -> None:
    """Show the window, furnish it behind its first paint, and open two meshes, a collection, one puzzle or the example."""

    def furnished(_: None) -> None:
        window.furnish()
        if len(files) == 2:
            window.files.pair(*files, labels)
        elif files and window.collection.takes(list(files)):
            window.collection.open(list(files))
        elif files:
            window.puzzle.drop(list(files))
        else:
            window.open_example()

    window.show()
    QTimer.singleShot(0, lambda: window.jobs.start("modules", load_modules, furnished, words="Opening"))


def run(files: Sequence[str] = (), labels: Labels = (None, None)) -> int:
    """Open the window and stay until it is closed; returns the exit code."""
    app = QApplication.instance() or QApplication(sys.argv[:1])
    app.setApplicationName("Concord")
    app.setDesktopFileName("concord")
    window = MainWindow()
    open_window(window, files, labels)
    signal.signal(signal.SIGINT, lambda *_: window.close())  # Ctrl+C in the terminal closes as the mouse does
    awake = QTimer(window, interval=200)  # lets Python see the signal while Qt waits for events
    awake.timeout.connect(lambda: None)
    awake.start()
    return app.exec()
