"""How long the page of results takes to show a large study, and the longest pause of the window meanwhile:
`python tests/benchmarks/results_page.py` (5,000 matches, 60,000 votes)."""

import os
import random
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
sys.path[:0] = [str(Path(__file__).parents[2]), str(Path(__file__).parent)]

from PySide6.QtWidgets import QApplication  # noqa: E402
from study_table import fill  # noqa: E402

from annotation import study  # noqa: E402
from gui.jobs import Jobs  # noqa: E402
from gui.pages.judging import Judging  # noqa: E402
from gui.pages.results.page import ResultsPage  # noqa: E402
from gui.session import Session, State  # noqa: E402


def main() -> None:
    """Make the study, open it, and go through the sections."""
    app = QApplication([])
    session, votes, jobs = Session(State(volunteer="v0")), Jobs(), Jobs()
    judging = Judging(session, votes)
    page = ResultsPage(session, judging, jobs)

    def wait() -> tuple[float, float]:
        start, worst = time.perf_counter(), 0.0
        while votes.busy() or jobs.busy():
            before = time.perf_counter()
            app.processEvents()
            worst = max(worst, time.perf_counter() - before)
            time.sleep(0.001)
        return time.perf_counter() - start, worst

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "large.db"
        with study.create_study(path, name="Large") as handle:
            fill(handle, random.Random(0))
        judging.open(path)
        print("{:12} {:.2f} s, longest pause {:.3f} s".format("open", *wait()))
        page.resize(1280, 680)
        page.show()
        wait()
        for name in page.sections:
            page.choose(name)
            print("{:12} {:.2f} s, longest pause {:.3f} s".format(name, *wait()))
        jobs.close()
        judging.close()
        page.shutdown()


if __name__ == "__main__":
    main()
