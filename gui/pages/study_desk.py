"""The researcher's commands on studies: new, open, on a server, top up, packets, exports. What is long is a job."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog

from annotation.study import StudyHandle
from engine.progress import Progress

from ..folders import data_folder
from ..jobs import QUEUE, Jobs
from .study_watch import StudyWatch

if TYPE_CHECKING:
    from ..main_window import MainWindow

STUDIES = "Studies (*.db *.study)"


class StudyDesk(QObject):
    """Makes and opens the studies of a window; everything that fails becomes a message, and the open study stays."""

    def __init__(self, window: "MainWindow") -> None:
        super().__init__(window)
        self.window = window
        self.jobs = Jobs(self)
        self.jobs.failed.connect(window.say)
        window.status.follow(self.jobs)
        self.watch = StudyWatch(window.judging, self)

    @property
    def handle(self) -> StudyHandle | None:
        """The open study."""
        return self.window.judging.handle

    def run(self, words: str, work: Callable[[StudyHandle, Progress], Any], done: Callable[[Any], None]) -> None:
        """Do something with the open study in the thread, with progress and a way to stop it; say so where none is open."""
        handle = self.handle
        if handle is None:
            self.window.say("No study is open; make one with Study > New study, or open one with Study > Open study.")
            return
        self.window.messages.dismiss()
        self.jobs.start("study", lambda progress: work(handle, progress), done, words=words, policy=QUEUE)

    def told(self, sentence: str) -> Callable[[Any], None]:
        """Say in the status line that something is done, and read the votes again."""

        def tell(_: Any) -> None:
            self.say_done(sentence)

        return tell

    def say_done(self, sentence: str) -> None:
        """Say in the status line what was done, and read the votes again."""
        self.window.status.text.setText(sentence)
        self.window.judging.refresh()

    def open_study(self) -> None:
        """Ask for a study file and open it."""
        path, _ = QFileDialog.getOpenFileName(self.window, "Open study", str(data_folder()), STUDIES + ";;All files (*)")
        if path:
            self.open(path)

    def open(self, where: Path | str) -> None:
        """Open a study by its path."""
        self.window.judging.open(where)

    def stop(self) -> None:
        """Stop what runs; nothing of it is kept."""
        self.jobs.cancel()
        self.window.status.text.setText("Stopped; the study is as it was.")

    def close(self) -> None:
        """Cancel what runs."""
        self.watch.stop()
        self.jobs.close()
