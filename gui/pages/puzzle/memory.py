"""Locks, rejections and pins are kept between two starts, by what the pieces look like."""

from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject

from engine.errors import BadInput
from engine.progress import Progress
from engine.puzzles.identity import piece_ids
from engine.puzzles.pieces import Puzzle
from engine.puzzles.solution import Wishes
from engine.puzzles.wishfile import read_wishes, write_wishes
from engine.store import digest

from ...folders import data_folder
from ...jobs import FOLLOW, Jobs
from ...session import Session
from .edits import NO_WISHES
from .state import PuzzleState


def place(puzzle: Puzzle) -> Path:
    """The file of what was decided on a puzzle: the same pieces in the same order."""
    return data_folder() / "puzzles" / f"{digest(*(piece.encode() for piece in piece_ids(puzzle)))[:32]}.json"


def remembered(puzzle: Puzzle) -> Wishes:
    """What was decided on a puzzle when it was last open; nothing where that cannot be read."""
    path = place(puzzle)
    try:
        return read_wishes(path, puzzle) if path.exists() else NO_WISHES
    except BadInput:
        return NO_WISHES


def remember(puzzle: Puzzle, wishes: Wishes) -> None:
    """Keep what was decided; raises `BadInput` where that cannot be written."""
    path = place(puzzle)
    if wishes or path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_wishes(path, wishes)


class Memory(QObject):
    """Writes what changes, in the worker of the votes, which ends before the window does."""

    def __init__(self, session: Session, jobs: Jobs, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.jobs = jobs
        session.changed.connect(self._changed)

    def _changed(self, old: PuzzleState, state: PuzzleState, names: frozenset[str]) -> None:
        if "wishes" not in names or state.puzzle is None or state.puzzle is not old.puzzle:
            return
        puzzle, wishes = state.puzzle, state.wishes

        def work(_: Progress) -> Any:
            remember(puzzle, wishes)

        self.jobs.start("puzzle-memory", work, lambda _: None, policy=FOLLOW)
