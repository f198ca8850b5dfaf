"""The researcher's commands on studies: new, open, on a server, top up, packets, exports. What is long is a job."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog

from annotation.study import StudyFile, StudyHandle, is_url, study_name
from engine.progress import Progress

from ..folders import data_folder
from ..jobs import QUEUE, Jobs
from .ask_dialog import AskDialog, show_secret
from .judging import checked_code
from .study_asks import (
    ARCHIVE_FIELDS,
    EXPORT_FIELDS,
    FORGET_LEAD,
    INVITE_LEAD,
    SERVER_FIELDS,
    SERVER_LEAD,
    formats_of,
    free_file,
    invite_fields,
    packet_fields,
    top_up_fields,
)
from .study_sources import Source, shown_sources
from .study_watch import StudyWatch

if TYPE_CHECKING:
    from ..main_window import MainWindow
    from .study_wizard import Wanted

NO_STUDY = "No study is open; make one with Study > New study, or open one with Study > Open study."
STUDIES = "Studies (*.db *.study *.concord)"
REPORTS = {"csv": "CSV tables (*.csv)", "markdown": "Markdown (*.md)", "latex": "LaTeX (*.tex)", "html": "Web pages (*.html)"}


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
        self._stopped, self._wanted = False, ""
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
            self.jobs.start("study", lambda progress: work(handle, progress), self.say_done, words=words, policy=QUEUE)

    def say_done(self, sentence: str) -> None:
        """Say what was done, and read the votes again."""
        self.window.status.text.setText(sentence)
        self.window.judging.refresh()  # which counts anew what is judged; the sentence comes after that
        self.window.judging.ask(lambda _: None, lambda _: self.window.status.text.setText(sentence))

    def _ask(self, *asked: Any, **more: Any) -> AskDialog:
        dialog = AskDialog(self.window, *asked, **more)
        dialog.open()
        return dialog

    def _has_study(self) -> bool:
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
        from annotation.knownanswers import known_by_votes

        from .study_wizard import StudyWizard

        handle, code = self.handle, self.window.session.state.volunteer
        own = (lambda: known_by_votes(handle, code)) if handle is not None and self.window.session.state.answers else None

        def read(work: Callable[[Progress], Source], done: Callable[[Source], None], words: str,
                 failed: Callable[[str, str], None]) -> None:  # fmt: skip
            self.jobs.start("wizard", work, done, words=words, policy=QUEUE, failed=failed)

        wizard = StudyWizard(self.sources(), read, own, str(data_folder()), self.window)
        data_folder().mkdir(parents=True, exist_ok=True)
        wizard.wanted.connect(lambda wanted: self._create(wizard, wanted))
        wizard.open()
        if handle is not None and handle.volunteer is None:
            self._estimate(wizard, handle)

    def sources(self) -> list[Source]:
        """What the pages show now and a study may be made of."""
        window = self.window
        return shown_sources(window.session.state, window.collection.session.state, window.puzzle.session.state)

    def _estimate(self, wizard: Any, handle: StudyHandle) -> None:
        """The calculator begins with what the votes of the open study tell."""
        from annotation.planning import estimated

        self.jobs.start("wizard", lambda _: estimated(handle), lambda told: wizard.gone or wizard.sample.show_estimates(told),
                        policy=QUEUE, failed=lambda *_: None)  # fmt: skip

    def _create(self, wizard: Any, wanted: "Wanted") -> None:
        from annotation.design import create_design

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

        dialog = self._ask("Open a study on a server", SERVER_LEAD, SERVER_FIELDS, "Open", check)
        dialog.given.connect(lambda values: self.open(with_password(values["address"], values["password"])))

    def open(self, where: Path | str) -> None:
        """Open a study by its path or address."""
        self.window.messages.dismiss()
        self.window.judging.open(where)

    def _opened(self) -> None:
        """Warn once of places where a study is not safe."""
        from annotation.location import location_warning

        handle = self.handle
        if isinstance(handle, StudyFile) and handle.where not in self._warned:
            self._warned.add(handle.where)
            warning = location_warning(handle.path)
            if warning:
                self.window.say(warning)

    # --- the open study

    def top_up(self) -> None:
        """Put what the window shows into the study, and ask what is not asked yet."""
        from annotation.studyruns import unasked

        if not self._has_study():
            return
        handle, sources = self.handle, self.sources()

        def ask(found: Any) -> None:
            lead, fields = top_up_fields(sources, found, free_file(self.folder, study_name(handle.where) + " top-up"))
            dialog = self._ask("Top up the study", lead, fields, "Top up")
            dialog.given.connect(lambda values: self._top_up(sources, values))

        self.jobs.start("ask", lambda _: unasked(handle), ask, policy=QUEUE)

    def _top_up(self, sources: list[Source], values: Any) -> None:
        from . import study_work as work

        if values["apart"]:
            self.run("Topping up", lambda h, p: work.unjudged_study(h, p, sources, Path(values["file"]), values["most"]))
        else:
            self.run("Topping up", lambda h, p: work.topped_up(h, p, sources, values["most"]))

    def command(self, name: str, code: str) -> None:
        """A command of the overview of volunteers."""
        {"packet": self.send_packet, "merge": lambda _: self.take_in(), "invite": lambda _: self.invite(),
         "adjudicate": self.adjudicate, "forget": self.forget}[name](code)  # fmt: skip

    def send_packet(self, code: str = "") -> None:
        """Ask for whom, and write what that volunteer is asked into one file."""
        from . import study_work as work

        if not self._has_study():
            return
        codes = tuple(row.code for row in self.window.results.volunteers.rows)

        def check(values: Any) -> str:
            checked_code(values["code"])
            return "" if values["file"] else "Choose where the packet is written."

        lead, fields = packet_fields(code, codes, self.folder, study_name(self.handle.where))
        dialog = self._ask("Send a packet", lead, fields, "Write the packet", check)
        dialog.given.connect(lambda v: self.run(
            "Packing", lambda h, p: work.packet(h, p, checked_code(v["code"]), Path(v["file"]), v["items"])))  # fmt: skip

    def take_in(self) -> None:
        """Ask for a returned packet or another copy of the study, and merge it."""
        from . import study_work as work

        if not self._has_study():
            return
        path, _ = QFileDialog.getOpenFileName(self.window, "Take in a returned file", str(self.folder), STUDIES + ";;All files (*)")
        if path:
            self.run("Taking in", lambda h, p: work.take_in(h, p, Path(path)))

    def invite(self) -> None:
        """Register a volunteer; on a server, make their personal address and show it once."""
        from annotation.invitations import invite, register
        from annotation.postgres import StudyServer

        if not self._has_study():
            return
        handle = self.handle

        def work(values: Any) -> str:
            if isinstance(handle, StudyServer):
                return invite(handle, values["code"], adjudicator=values["adjudicator"], again=values["again"])
            register(handle, values["code"], adjudicator=values["adjudicator"])
            return ""

        def done(values: Any, address: str) -> None:
            self.say_done(f"{values['code']} may vote.")
            if address:
                show_secret(self.window, f"Address of {values['code']}", INVITE_LEAD, f"concord vote '{address}'")

        fields = invite_fields(server=isinstance(handle, StudyServer))
        dialog = self._ask("Invite a volunteer", "", fields, "Invite", lambda values: checked_code(values["code"]) and "")
        dialog.given.connect(lambda values: self.jobs.start(
            "study", lambda _: work(values), lambda address: done(values, address), words="Inviting", policy=QUEUE))  # fmt: skip

    def adjudicate(self, code: str) -> None:
        """Let a volunteer judge what stays unresolved, or no longer."""
        from annotation.volunteers import make_adjudicator

        rows = {row.code: row.adjudicates for row in self.window.results.volunteers.rows}
        on = not rows.get(code, False)

        def work(handle: StudyHandle, _: Progress) -> str:
            make_adjudicator(handle, code, adjudicates=on)
            return f"{code} is asked about unresolved matches alone." if on else f"{code} is asked like everybody again."

        if code and self._has_study():
            self.run("Naming an adjudicator", work)

    def forget(self, code: str) -> None:
        """Ask once more, then delete a volunteer who asks for it."""
        from . import study_work as work

        if not code or not self._has_study():
            return

        def check(values: Any) -> str:
            return "" if values["code"] == code else f"Write {code} to delete this volunteer."

        fields = invite_fields(server=False, forget=True)
        dialog = self._ask(f"Delete {code}", FORGET_LEAD, fields, "Delete", check)
        dialog.given.connect(lambda v: self.run("Deleting", lambda h, p: work.forgotten(h, p, code, v["votes"])))

    # --- what leaves the study

    def report(self, style: str) -> None:
        """Ask where to, and write what the votes say."""
        from . import study_work as work

        if not self._has_study():
            return
        page = self.window.results
        ending = work.ENDINGS[style]
        start = self.folder / f"{study_name(self.handle.where)}.{ending}"
        path, _ = QFileDialog.getSaveFileName(self.window, "Export the results", str(start), REPORTS[style])
        if path:
            path = path if Path(path).suffix else f"{path}.{ending}"
            self.run("Writing", lambda h, p: work.report(h, p, Path(path), style, page.section, page.preset))

    def datasheet(self) -> None:
        """Ask where to, and write all that a Human Evaluation Datasheet asks and the study knows."""
        from . import study_work as work

        if not self._has_study():
            return
        start = self.folder / f"{study_name(self.handle.where)} datasheet.md"
        path, _ = QFileDialog.getSaveFileName(self.window, "Human Evaluation Datasheet", str(start), "Markdown (*.md);;JSON (*.json)")
        if path:
            self.run("Writing", lambda h, p: work.datasheet(h, p, Path(path)))

    def export(self) -> None:
        """Ask for formats and a folder, and write all votes, matches and results as tables."""
        from . import study_work as work

        if not self._has_study():
            return

        def check(values: Any) -> str:
            return "" if formats_of(values) else "Tick at least one kind of file."

        def go(values: Any) -> None:
            folder = QFileDialog.getExistingDirectory(self.window, "Folder for the tables", str(self.folder))
            if folder:
                self.run("Exporting", lambda h, p: work.exported(h, p, Path(folder), formats_of(values), values["gold"]))

        dialog = self._ask("Export votes and matches", EXPORT_FIELDS[0], EXPORT_FIELDS[1], "Choose a folder…", check)
        dialog.given.connect(go)

    def archive(self) -> None:
        """Ask where to, and pack the whole study into one zip."""
        from . import study_work as work

        if not self._has_study():
            return
        fields = ARCHIVE_FIELDS(free_file(self.folder, study_name(self.handle.where), ".zip"))
        dialog = self._ask("Archive the study", fields[0], fields[1], "Pack")
        dialog.given.connect(lambda v: self.run("Packing", lambda h, p: work.archived(h, p, Path(v["file"]), v["anonymous"])))

    def show_disputed(self, item: str) -> None:
        """Open the pair of a disputed match on the page of shapes, with the match selected."""
        from annotation.study import item as item_of

        from .match_preview import files_of

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
        if self._stopped and not self.jobs.busy():
            self._stopped = False
            self.window.status.text.setText("Stopped.")
            self.window.judging.refresh()

    def close(self) -> None:
        """Cancel what runs."""
        self.watch.stop()
        self.jobs.close()

