"""How long the window takes to open: seconds from the start of `concord` to its first paint and to matched shapes.

    python tests/benchmarks/startup.py [--times 5]

Each time is that of a fresh process. Prints the median and the slowest of them, once with an empty cache (cold) and
then with a filled one (warm). Without a display it runs on Qt's offscreen platform.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time

CHILD = """
import sys, time
from gui.display import problem
sys.exit(problem()) if problem() else None
from PySide6.QtCore import QEvent, QObject, QTimer
from PySide6.QtWidgets import QApplication
from gui.main_window import MainWindow
from gui.startup import open_window

app = QApplication(["concord"])
window = MainWindow()

class FirstPaint(QObject):
    seen = False

    def eventFilter(self, watched, event):
        if event.type() == QEvent.Type.Paint and not self.seen:
            self.seen = True
            QTimer.singleShot(0, lambda: print("painted", time.time(), flush=True))
        return False

def look():
    view = window.furnished and window.session.state.result is not None and window.shapes.view
    if view and view._drawing.links and view._shapes:
        print("matched", time.time(), flush=True)
        window.close()

paint, timer = FirstPaint(), QTimer()
window.placeholder.installEventFilter(paint)
timer.timeout.connect(look)
timer.start(5)
open_window(window)
sys.exit(app.exec())
"""


def once(environment: dict[str, str]) -> dict[str, float]:
    """Seconds to the first paint and to matched shapes of one fresh process."""
    began = time.time()
    run = subprocess.run([sys.executable, "-c", CHILD], env=environment, capture_output=True, text=True, timeout=300)
    if run.returncode:
        raise SystemExit(run.stderr.strip() or f"The window ended with code {run.returncode}.")
    return {word: float(when) - began for word, when in map(str.split, run.stdout.splitlines())}


def main() -> None:
    """Print both figures, cold and warm."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=5, help="fresh processes for each figure")
    times = parser.parse_args().times
    environment = dict(os.environ)
    if not (environment.get("DISPLAY") or environment.get("WAYLAND_DISPLAY")):
        environment |= {"QT_QPA_PLATFORM": "offscreen", "VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow"}
    with tempfile.TemporaryDirectory() as folder:
        environment["CONCORD_HOME"] = f"{folder}/home"
        warm = [environment | {"CONCORD_CACHE": f"{folder}/warm"}] * (times + 1)
        cold = [environment | {"CONCORD_CACHE": f"{folder}/cold{k}"} for k in range(times)]
        for state, runs in (("cold", [once(e) for e in cold]), ("warm", [once(e) for e in warm][1:])):
            for word in ("painted", "matched"):
                found = [run[word] for run in runs]
                middle, slowest = statistics.median(found), max(found)
                print(f"{state} cache: {word} after {middle:.2f} s (slowest of {times}: {slowest:.2f} s)")


if __name__ == "__main__":
    main()
