"""A new study: what the window shows goes into the wizard, and what it asks for is made in a job."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject

from annotation.study import StudyHandle, study_name
from engine.progress import Progress

from ...folders import data_folder
from ...jobs import QUEUE
from .sources import Source, shown_sources

if TYPE_CHECKING:
    from .desk import StudyDesk
    from .wizard import Wanted

LOOKING = "Looking at what the window shows …"


class StudyMaking(QObject):
    """Opens the wizard and makes what it wants, in the jobs of the desk."""

    def __init__(self, desk: "StudyDesk") -> None:
        super().__init__(desk)
        self.desk, self.window, self.jobs = desk, desk.window, desk.jobs

    def new_study(self) -> None:
        """Ask in six steps what a new study is to be."""
        from annotation.design.knownanswers import known_by_votes

        from .wizard import StudyWizard

        handle, code = self.desk.handle, self.window.session.state.volunteer
        own = (lambda: known_by_votes(handle, code)) if handle is not None and self.window.session.state.answers else None

        def read(work: Callable[[Progress], Source], done: Callable[[Source], None], words: str,
                 failed: Callable[[str, str], None]) -> None:  # fmt: skip
            self.jobs.start("wizard", work, done, words=words, policy=QUEUE, failed=failed)

        data_folder().mkdir(parents=True, exist_ok=True)
        wizard = StudyWizard((), read, own, str(data_folder()), self.window)
        wizard.wanted.connect(lambda wanted: self._create(wizard, wanted))
        wizard.rejected.connect(lambda: self.jobs.cancel("create"))
        wizard.open()
        wizard.results.look(LOOKING)
        shown = self.sources()
        self.jobs.start("shown", lambda _: shown(), lambda found: wizard.gone or wizard.results.add_all(found), policy=QUEUE)
        if handle is not None and handle.volunteer is None:
            self._estimate(wizard, handle)

    def sources(self) -> Callable[[], list[Source]]:
        """What finds (in a thread: there may be many matches) what the pages show now and a study may be made of."""
        window = self.window
        states = window.session.state, window.collection.session.state, window.puzzle.session.state
        return lambda: shown_sources(*states)

    def _estimate(self, wizard: Any, handle: StudyHandle) -> None:
        """The calculator begins with what the votes of the open study tell."""
        from annotation.design.planning import estimated

        self.jobs.start("wizard", lambda _: estimated(handle), lambda told: wizard.gone or wizard.sample.show_estimates(told),
                        policy=QUEUE, failed=lambda *_: None)  # fmt: skip

    def _create(self, wizard: Any, wanted: "Wanted") -> None:
        from annotation.design.designing import create_design

        notes: list[str] = []

        def work(progress: Progress) -> StudyHandle:
            runs = [run for source in wanted.sources for run in source.runs]
            shapes = [shape for source in wanted.sources for shape in source.shapes]
            return create_design(wanted.place.path, runs, wanted.design, gold=wanted.gold, shapes=shapes,
                                 tell=notes.append, progress=progress)  # fmt: skip

        def done(handle: StudyHandle) -> None:
            if not wizard.gone:
                wizard.accept()
            self.window.judging.adopt(handle)
            self.window.status.text.setText(f"The study {study_name(wanted.place.path)} is made and open.")
            if notes:
                self.window.say(" ".join(notes))

        def failed(sentence: str, details: str) -> None:
            wizard.failed(sentence) if not wizard.gone else self.window.say(sentence, details)

        self.jobs.start("create", work, done, words="Making the study", policy=QUEUE, failed=failed)
