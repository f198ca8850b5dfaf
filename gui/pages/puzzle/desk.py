"""Everything behind the puzzle page, wired together: its session, the solver, hands, votes and files."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject

from engine.errors import ConcordError

from ...session import Session
from ..status import seconds_text
from .files import PuzzleFiles
from .hands import Hands
from .judging import PuzzleJudging
from .memory import Memory
from .page import PuzzlePage
from .solving import Solving
from .state import PuzzleState, counts_text

if TYPE_CHECKING:
    from ...main_window import MainWindow


class PuzzleDesk(QObject):
    """What the window needs of puzzles: a page, commands, and a line of status."""

    def __init__(self, window: "MainWindow") -> None:
        super().__init__(window)
        self.window = window
        shapes = window.session.state
        self.session = Session(PuzzleState(volunteer=shapes.volunteer, dark=shapes.dark), self)
        self.solving = Solving(self.session, window.jobs, self)
        self.hands = Hands(self.session, self)
        self.judging = PuzzleJudging(self.session, window.session, window.judging, window.study_jobs, self)
        self.page = PuzzlePage(self.session, self.solving, self.hands, self.judging, window)
        self.files = PuzzleFiles(self)
        self.memory = Memory(self.session, window.study_jobs, self)
        self.seconds = ""
        self._connect()

    def _connect(self) -> None:
        self.solving.failed.connect(self.window.say)
        self.solving.took.connect(self._took)
        self.solving.opened.connect(self._opened)
        self.hands.said.connect(self.window.status.text.setText)
        self.session.changed.connect(self._changed)
        self.window.session.changed.connect(self._follow)
        self.window.jobs.idle.connect(self.show_status)
        self.page.folder_wanted.connect(self.files.open_folder)
        self.page.picture_wanted.connect(self.files.open_picture)
        self.page.view.files_dropped.connect(lambda paths: self.window.files.drop(paths))
        self.page.join.judge.named.connect(self.window.shapes.name_volunteer)

    def open(self, work: Callable[[], object]) -> None:
        """Show the page and start to open something there."""
        self.window.messages.dismiss()
        self.window.show_page("puzzle")
        work()

    def open_example(self) -> None:
        """Open the bundled picture, cut into pieces."""
        self.open(self.solving.open_example)

    def takes(self, paths: list[str]) -> bool:
        """Whether what was dropped is meant for a puzzle: folders and pictures."""
        from engine.puzzles.imagefile import SUFFIXES

        return bool(paths) and all(Path(path).is_dir() or Path(path).suffix.lower() in SUFFIXES for path in paths)

    def drop(self, paths: list[str]) -> None:
        """Open what was dropped onto the page."""
        try:
            self.files.drop(paths)
        except ConcordError as error:
            self.window.say(str(error))

    def solve(self) -> None:
        """Solve, or solve again around the locks."""
        self.window.messages.dismiss()
        self.solving.solve()

    def show_status(self) -> None:
        """What the status line says while the page is shown."""
        if self.window.page == "puzzle":
            self.window.status.text.setText(counts_text(self.session.state))
            self.window.status.seconds.setText(self.seconds)

    def _took(self, seconds: float) -> None:
        self.seconds = seconds_text(seconds)

    def _opened(self, origin: str) -> None:
        name = Path(origin).name if origin != "example" else "Example puzzle"
        self.window.setWindowTitle(f"{name} · Concord")
        for note in self.session.state.puzzle.notes[:1]:
            self.window.say(note)

    def _changed(self, _old: PuzzleState, _state: PuzzleState, names: frozenset[str]) -> None:
        self.show_status()
        if names & {"solution", "wishes"}:
            self.window.messages.dismiss() if "wishes" in names else None
        self.window.show_history()

    def _follow(self, _old: Any, state: Any, names: frozenset[str]) -> None:
        """The theme and the volunteer are those of the window."""
        if names & {"dark", "volunteer"}:
            self.session.update(record=False, dark=state.dark, volunteer=state.volunteer)
