"""Pictures of the volunteers' window, of the matches and joins that the other pictures show."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from annotation.study import StudyHandle

    from .main_window import MainWindow
    from .volunteer import VolunteerWindow

GUIDELINE = (
    "Two parts correspond if they are the same part of the thing: a foot and a foot, a handle and a handle. It does not "
    "matter whether one is cut a little longer than the other."
)
REASON = "One arm holds the shade, the other the ring: they are not the same part."
JOINS = 6


def make_study(window: "MainWindow", path: Path) -> "StudyHandle":
    """A study of what the window has matched and solved, one match of it to practise on."""
    from annotation import study
    from annotation.design.designing import put_asked
    from annotation.design.sampling import Drawn
    from annotation.results.puzzlejoins import solution_items
    from annotation.storage.blobs import keep_shapes

    state, puzzle = window.session.state, window.puzzle.session.state
    handle = study.create_study(path, name="Pictures", guideline=GUIDELINE, seed="3")
    study.add_result(handle, state.result, set_name="lamps")
    keep_shapes(handle, (state.source, state.target))
    if puzzle.solution is not None:
        study.add_items(handle, solution_items(puzzle.puzzle, puzzle.solution)[:JOINS])
    first = state.result.ids[0]
    ids = [item.id for item in study.items(handle, "anna")]
    rows = [Drawn(i, "practice" if i == first else "judged", "wrong" if i == first else None,
                  REASON if i == first else "", "", None, False) for i in ids]  # fmt: skip
    with handle.writing() as connection:
        put_asked(connection, rows)
    return handle


def take_voting(window: "MainWindow", folder: Path, wait: Callable, shot: Callable) -> None:
    """Welcome, practice and what is said after it, shapes, a join, the guideline, a vote that waits, and the thanks."""
    from PySide6.QtCore import Qt
    from PySide6.QtTest import QTest

    from .volunteer import VolunteerWindow

    path = folder / "pictures.study"
    make_study(window, path).close()
    voting = VolunteerWindow(str(path), "anna", dark=window.session.state.dark)
    voting.resize(1366, 768)
    voting.show()

    def press(*keys: Qt.Key) -> None:
        for key in keys:
            QTest.keyClick(voting.screen, key)
            wait(lambda: not voting.desk.busy)

    def show(name: str) -> None:
        end = time.monotonic() + 0.5
        wait(lambda: time.monotonic() > end and not voting.desk.busy)
        shot(f"voting-{name}", voting)

    voting.begin()
    wait(lambda: voting.screen.notice.heading.text() == "Welcome")
    show("welcome")
    press(Qt.Key.Key_Return)
    wait(lambda: voting.screen.asking)
    show("practice")
    press(Qt.Key.Key_J)
    show("feedback")
    press(Qt.Key.Key_Return)
    _questions(voting, press, show)
    voting.close()
    voting.deleteLater()


def _questions(voting: "VolunteerWindow", press: Callable, show: Callable) -> None:
    """One question of each kind, what lies beside them, and the end."""
    from PySide6.QtCore import Qt

    from .pages.voting.questions import JoinQuestion

    seen: set[str] = set()
    while voting.desk.question is not None:
        kind = "join" if isinstance(voting.desk.question, JoinQuestion) else "shapes"
        if kind not in seen:
            show(kind)
            if not seen:
                press(Qt.Key.Key_G)
                show("guideline")
                press(Qt.Key.Key_G, Qt.Key.Key_C)
                show("comment")
                press(Qt.Key.Key_Escape)
                voting.desk.tell("The study cannot take the vote because the disk is full; make room and try again.", "")
                show("trouble")
        seen.add(kind)
        press(Qt.Key.Key_J)
    show("done")
