"""Opens puzzles and keeps the solution in step with wishes and parameters: what has to run, and running it."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from PySide6.QtCore import QObject, Signal

from engine.errors import BadInput
from engine.progress import Progress, share
from engine.puzzles.pieces import Puzzle, Truth
from engine.puzzles.solution import PuzzleSolution, Wishes

from ...jobs import FOLLOW, SUPERSEDE, Jobs
from ...session import Session
from .edits import shifted
from .memory import remembered
from .state import ASSEMBLE, NOTHING, PREPARE, Marks, PuzzleState, frame_known, needed, opened, slow_values

EXAMPLE_PIECES = 300
QUICK = 0.3  # seconds: an assembly as quick as this is shown at every step of a slider
_FOLLOWED = {"puzzle", "parameters", "wishes", "asked", "prepared", "solution", "solved_with"}


@dataclass(frozen=True, slots=True)
class Cut:
    """How a picture is cut into pieces."""

    kind: Literal["squares", "merged", "rectangles", "triangles"] = "squares"
    pieces: int = 150
    turned: bool = False
    seed: int = 0


def read_picture(path: str) -> np.ndarray:
    """The pixels (h, w, 3) uint8 of a picture; where it is seen through it lies on white."""
    from engine.puzzles.imagefile import opaque, read_image

    return opaque(read_image(path))


def cut_picture(image: np.ndarray, how: Cut, name: str) -> tuple[Puzzle, Truth]:
    """Cut a picture (h, w, 3) uint8."""
    from engine.puzzles.cutting import cut

    return cut(image, kind=how.kind, pieces=how.pieces, turned=how.turned, seed=how.seed, name=name)


def marks_of(puzzle: Puzzle, truth: Truth, solution: PuzzleSolution) -> Marks:
    """What the truth says of a solution."""
    from engine.puzzles.scoring import right_joins, right_places, score

    return Marks(score(puzzle, truth, solution), right_places(puzzle, truth, solution), right_joins(puzzle, truth, solution))


class Solving(QObject):
    """Loads puzzles and runs the solver in a worker; what no longer belongs to the state is dropped."""

    took = Signal(float)
    """seconds that the last answer took"""
    failed = Signal(str, str)
    opened = Signal(str)

    def __init__(self, session: Session, jobs: Jobs, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.session, self.jobs = session, jobs
        self._key: tuple[Any, ...] = ()
        self._last = 0.0
        session.changed.connect(self._changed)

    # --- opening

    def look_at_picture(self, path: str, done: Callable[[np.ndarray], None]) -> None:
        """Read a picture in the worker and hand its pixels (h, w, 3) on."""
        self.jobs.start("puzzle-open", lambda _: read_picture(path), done, words="Reading the picture", failed=self.failed.emit)

    def open_picture(self, image: np.ndarray, how: Cut, path: str) -> None:
        """Cut a picture (h, w, 3) into a puzzle; the one shown before stays if that fails."""
        self._open(lambda _: cut_picture(image, how, Path(path).stem), path)

    def open_folder(self, path: str) -> None:
        """Read a folder of pieces, whose truth nobody knows."""

        def work(progress: Progress) -> tuple[Puzzle, None]:
            from engine.puzzles.piecefolder import read_pieces

            return read_pieces(path, progress=progress), None

        self._open(work, path)

    def open_example(self) -> None:
        """Cut the bundled picture."""
        from assets import example_picture

        path = str(example_picture())
        self._open(lambda _: cut_picture(read_picture(path), Cut(pieces=EXAMPLE_PIECES), Path(path).stem), "example")

    def _open(self, work: Callable[[Progress], tuple[Puzzle, Truth | None]], origin: str) -> None:
        def read(progress: Progress) -> tuple[Puzzle, Truth | None, Wishes]:
            puzzle, truth = work(progress)
            return puzzle, truth, remembered(puzzle)

        def done(answer: tuple[Puzzle, Truth | None, Wishes]) -> None:
            puzzle, truth, wishes = answer
            self.session.update(**opened(puzzle, truth, origin, wishes))
            self.opened.emit(origin)

        self.jobs.cancel("puzzle")
        self.jobs.start("puzzle-open", read, done, words="Reading the pieces", failed=self.failed.emit)

    # --- solving

    def solve(self) -> None:
        """Solve what is on the table, around the wishes; the solution then follows every change."""
        if self.session.state.puzzle is None:
            self.failed.emit("There are no pieces yet; open a picture or a folder of pieces first.", "")
        elif self.session.state.asked:
            self.session.update(record=False, solved_with=None)
        else:
            self.session.update(asked=True)

    def edit(self, name: str, value: Any, settled: bool) -> None:
        """Change one parameter; successive changes while a hand moves are one step of the history."""
        self.session.update(merge=name, parameters=self.session.state.parameters.changed(**{name: value}))
        if settled:
            self.session.settle()

    def cancel(self) -> None:
        """Stop what runs, and go back to what the shown solution was made with."""
        state = self.session.state
        self.jobs.cancel()
        self._key = ()
        if needed(state) == NOTHING:
            return
        if state.solution is not None and state.solved_with is not None:
            self.session.update(record=False, parameters=state.solution.parameters, wishes=state.solved_with)
        else:
            self.session.update(record=False, asked=False)

    def _changed(self, _old: PuzzleState, state: PuzzleState, names: frozenset[str]) -> None:
        if not names & _FOLLOWED:
            return
        what = needed(state)
        if what == NOTHING:
            self.jobs.cancel("puzzle")
        elif what == ASSEMBLE:
            self._start(state, state.prepared)
        elif what == PREPARE:
            self._start(state, None)

    def _start(self, state: PuzzleState, prepared: Any) -> None:
        puzzle, truth, parameters, wishes = state.puzzle, state.truth, state.parameters, state.wishes
        key = (id(puzzle), id(prepared), parameters, id(wishes))
        if key == self._key and self.jobs.busy("puzzle"):
            return
        waits_for_same = self._key[:1] == key[:1] and prepared is None and self.jobs.busy("puzzle")
        if waits_for_same and slow_values(self._key[2]) == slow_values(parameters):
            return  # what is slow is under way; the rest follows when it has come
        self._key = key

        def work(progress: Progress) -> tuple[Any, PuzzleSolution, Marks | None, float]:
            from engine.puzzles.solving import assemble, prepare

            began = time.perf_counter()
            ready = prepared
            if ready is None:
                ready = prepare(puzzle, parameters, progress=share(progress, 0.0, 0.6))
            rest = share(progress, 0.6, 1.0) if prepared is None else progress
            solution = assemble(ready, parameters, wishes=wishes, progress=rest)
            seconds = time.perf_counter() - began
            return ready, solution, None if truth is None else marks_of(puzzle, truth, solution), seconds

        def done(answer: tuple[Any, PuzzleSolution, Marks | None, float]) -> None:
            self._take(puzzle, parameters, wishes, *answer)

        quick = prepared is not None and self._last < QUICK
        self.jobs.start("puzzle", work, done, words="Solving", policy=FOLLOW if quick else SUPERSEDE,
                        failed=lambda *said: self._give_up(wishes, *said))  # fmt: skip

    def _take(self, puzzle: Puzzle, parameters: Any, wishes: Wishes, prepared: Any, solution: PuzzleSolution,
              marks: Marks | None, seconds: float) -> None:  # fmt: skip
        """Amend the present state by an answer; one that came too late gives at most what is still of use."""
        now = self.session.state
        self._key = ()
        if now.puzzle is not puzzle or not now.asked or slow_values(now.parameters) != slow_values(parameters):
            return
        self._last = seconds
        ready = {"prepared": prepared, "prepared_with": parameters}
        if now.prepared is prepared:
            ready = {}
        if now.wishes is not wishes:
            self.session.update(record=False, **ready)
            return
        self.took.emit(seconds)
        if not frame_known(now):  # then only relative places count, and pictures begin at (0, 0)
            solution, wishes = shifted(puzzle, solution, wishes)
        self.session.update(record=False, **ready, solution=solution, wishes=wishes, solved_with=wishes, marks=marks,
                            items=(), preview=None)  # fmt: skip

    def _give_up(self, wishes: Wishes, sentence: str, details: str) -> None:
        """What cannot be solved is taken back: the last wishes, or having asked."""
        self._key = ()
        state = self.session.state
        if state.wishes is wishes and wishes and self.session.can_undo and state.prepared is not None:
            self.session.undo()
        else:
            self.session.update(record=False, asked=False)
        self.failed.emit(sentence, details)


def check_droppable(paths: list[str]) -> tuple[str, str]:
    """What was dropped: ("folder", path) or ("picture", path); raises one sentence for anything else."""
    folders = [path for path in paths if Path(path).is_dir()]
    if len(paths) == 1:
        return ("folder" if folders else "picture"), paths[0]
    raise BadInput("Drop one picture, to be cut into pieces, or the one folder that holds the images of the pieces.")


def moved_pieces(before: PuzzleSolution | None, after: PuzzleSolution) -> np.ndarray:
    """The pieces (k,) that another solution puts elsewhere, apart from a shift that most of them share."""
    if before is None or len(before.picture) != len(after.picture):
        return np.zeros(0, np.int64)
    step = after.position - before.position
    both = before.placed & after.placed
    if both.any():
        shifts, count = np.unique(step[both], axis=0, return_counts=True)
        step = step - shifts[count.argmax()]
    stays = (before.picture == after.picture) & (before.turns == after.turns) & ((step == 0).all(axis=1) | ~both)
    return np.flatnonzero(~stays)
