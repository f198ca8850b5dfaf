"""The researcher's commands on studies: open, on a server, top up; new ones are made beside it. What is long is a job."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog

from annotation.study import StudyFile, StudyHandle, is_url, study_name
from engine.progress import Progress

from ...folders import data_folder
from ...jobs import QUEUE, Jobs
from ..ask_dialog import AskDialog
from .asks import SERVER_FIELDS, SERVER_LEAD, STUDIES, free_file, named, top_up_fields
from .exports import StudyExports
from .making import StudyMaking
from .people import StudyPeople
from .sources import Source
from .watch import StudyWatch

if TYPE_CHECKING:
    from ...main_window import MainWindow

NO_STUDY = "No study is open; make one with Study > New study, or open one with Study > Open study."


class StudyDesk(QObject):
    """Makes and opens the studies of a window; everything that fails becomes a message, and the open study stays."""

    def __init__(self, window: "MainWindow") -> None:
        super().__init__(window)
        self.window = window
        self.jobs = Jobs(self)
        self.jobs.failed.connect(window.say)
        self.jobs.idle.connect(self._refresh_after_stop)
        window.status.follow(self.jobs)
        self.watch = StudyWatch(window.judging, self)
        self.making, self.people, self.exports = StudyMaking(self), StudyPeople(self), StudyExports(self)
        self._stopped, self._wanted, self._done = False, "", ""
        window.session.changed.connect(self._select_wanted)
        self._warned: set[str] = set()
        window.judging.opened.connect(self._opened)

    @property
    def handle(self) -> StudyHandle | None:
        """The open study."""
        return self.window.judging.handle

    @property
    def folder(self) -> Path:
        """Where files of the open study go first."""
        here = self.handle.folder if self.handle is not None else None
        here = here.parent if here is not None and here.suffix == ".concord" else here
        return here or data_folder()

    def run(self, words: str, work: Callable[[StudyHandle, Progress], str]) -> None:
        """Do something with the open study in the thread; what it returns is said in the status line."""
        handle = self.handle
        if handle is not None:
            self.window.messages.dismiss()
            self.window.status.text.setText("")  # what was done before says nothing of this
            self._done = ""

            def whole(progress: Progress) -> str:
                self._done = work(handle, progress)
                return self._done

            self.jobs.start("study", whole, self.say_done, words=words, policy=QUEUE)

    def say_done(self, sentence: str) -> None:
        """Say what was done, and read the votes again."""
        self._done = ""
        self.window.status.text.setText(sentence)
        self.window.judging.refresh()  # which counts anew what is judged; the sentence comes after that
        self.window.judging.ask(lambda _: None, lambda _: self.window.status.text.setText(sentence))

    def ask(self, *asked: Any, **more: Any) -> AskDialog:
        """Show a dialog that asks for a few things."""
        dialog = AskDialog(self.window, *asked, **more)
        dialog.open()
        return dialog

    def has_study(self) -> bool:
        """Whether a whole study is open; says what to do where it is not."""
        if self.handle is None:
            self.window.say(NO_STUDY)
        elif self.handle.volunteer is not None:
            self.window.say(f"{self.handle.where} is for {self.handle.volunteer} alone; open the whole study for this.")
        else:
            return True
        return False

    # --- making and opening

    def new_study(self) -> None:
        """Ask in six steps what a new study is to be."""
        self.making.new_study()

    def sources(self) -> Callable[[], list[Source]]:
        """What finds (in a thread) what the pages show now and a study may be made of."""
        return self.making.sources()

    def open_study(self) -> None:
        """Ask for a study file and open it."""
        path, _ = QFileDialog.getOpenFileName(self.window, "Open study", str(data_folder()), STUDIES + ";;All files (*)")
        if path:
            self.open(path)

    def open_folder(self) -> None:
        """Ask for a project folder and open the study in it."""
        path = QFileDialog.getExistingDirectory(self.window, "Open a project folder (name.concord)", str(data_folder()))
        if path:
            self.open(path)

    def open_server(self) -> None:
        """Ask for the address of a study on a server; the password is kept nowhere."""
        from .wizard_steps import with_password

        def check(values: Any) -> str:
            if not is_url(values["address"]):
                return "Write an address such as postgresql://anna@study.example.org/vases."
            with_password(values["address"], values["password"] or "-")
            return ""

        dialog = self.ask("Open a study on a server", SERVER_LEAD, SERVER_FIELDS, "Open", check)
        dialog.given.connect(lambda values: self.open(with_password(values["address"], values["password"])))

    def open(self, where: Path | str) -> None:
        """Open a study by its path or address."""
        self.window.messages.dismiss()
        self.window.status.text.setText("")
        self.window.judging.open(where)

    def _opened(self) -> None:
        """Warn once of places where a study is not safe."""
        from annotation.storage.location import location_warning

        handle = self.handle
        if isinstance(handle, StudyFile) and handle.where not in self._warned:
            self._warned.add(handle.where)
            warning = location_warning(handle.path)
            if warning:
                self.window.say(warning)

    # --- the open study

    def top_up(self) -> None:
        """Put what the window shows into the study, and ask what is not asked yet."""
        from annotation.results.studyruns import unasked

        if not self.has_study():
            return
        handle, shown = self.handle, self.sources()

        def ask(answer: tuple[Any, list[Source]]) -> None:
            found, sources = answer
            lead, fields = top_up_fields(sources, found, free_file(self.folder, study_name(handle.where) + " top-up"))
            dialog = self.ask("Top up the study", lead, fields, "Top up", lambda v: named(v) if v["apart"] else "")
            dialog.given.connect(lambda values: self._top_up(sources, values))

        self.jobs.start("ask", lambda _: (unasked(handle), shown()), ask, policy=QUEUE)

    def _top_up(self, sources: list[Source], values: Any) -> None:
        from . import work

        if values["apart"]:
            self.run("Topping up", lambda h, p: work.unjudged_study(h, p, sources, Path(values["file"]), values["most"]))
        else:
            self.run("Topping up", lambda h, p: work.topped_up(h, p, sources, values["most"]))

    def show_disputed(self, item: str) -> None:
        """Open the pair of a disputed match on the page of shapes, with the match selected."""
        from annotation.study import item as item_of

        from ..results.match_preview import files_of

        handle = self.handle

        def done(found: Any) -> None:
            files = files_of(found.payload)
            if files is None:
                self.window.say("The meshes of this match are not where they were; its picture is in the list of disputed matches.")
                return
            self._wanted = item
            self.window.files.pair(*files)

        if handle is not None:
            self.jobs.start("ask", lambda _: item_of(handle, item), done, policy=QUEUE)

    def _select_wanted(self, _old: Any, state: Any, names: frozenset[str]) -> None:
        """Select the match that its pair was opened for, once the pair is matched."""
        if self._wanted and "result" in names and state.result is not None:
            wanted, self._wanted = self._wanted, ""
            if state.match(wanted) is not None:
                self.window.session.update(selected=wanted)
            else:
                self.window.say("The method that is chosen here does not find this match; choose another preset to see it.")

    # --- stopping

    def stop(self) -> None:
        """Stop what runs."""
        self._stopped = True
        self.window.status.text.setText("Stopping …")
        self.jobs.cancel()

    def _refresh_after_stop(self) -> None:
        if self._stopped and not self.jobs.busy() and not self.jobs.stopping():
            self._stopped = False
            self.window.status.text.setText(f"It was done before it could be stopped. {self._done}" if self._done else "Stopped.")
            self._done = ""
            self.window.judging.refresh()

    def close(self) -> None:
        """Cancel what runs."""
        self.watch.stop()
        self.jobs.close()

