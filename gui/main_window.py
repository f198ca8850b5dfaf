"""The window: a rail of pages, one page, one status line. It is light, and furnished after its first paint."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, Qt, QTimer
from PySide6.QtGui import QCloseEvent, QDragEnterEvent, QDropEvent
from PySide6.QtWidgets import (
    QAbstractButton,
    QApplication,
    QComboBox,
    QHBoxLayout,
    QLabel,
    QMainWindow,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from engine.errors import ConcordError

from . import actions, menus
from .folders import remember_pair, settings
from .jobs import Jobs, show_unexpected
from .pages.help import show_about, show_keys
from .pages.messages import MessageBar
from .pages.rail import Rail
from .pages.status import StatusLine, judged_text, seconds_text
from .pages.style import window_style
from .palette import apply_theme, system_is_dark, theme

if TYPE_CHECKING:
    from .session import Session, State

_SHOWN_DARK = "concord-shown-dark"


class MainWindow(QMainWindow):
    """Lays out the pages and hands the commands of the menus on."""

    def __init__(self, dark: bool | None = None) -> None:
        super().__init__()
        self.setWindowTitle("Concord")
        self.resize(1366, 768)
        self.setAcceptDrops(True)
        chosen = settings().value("dark", "system") if dark is None else ("yes" if dark else "no")
        self._dark = system_is_dark(QApplication.instance()) if chosen == "system" else chosen == "yes"
        self.jobs, self.study_jobs = Jobs(self), Jobs(self)
        self.messages, self.status = MessageBar(self), StatusLine(self)
        self.stack = QStackedWidget(self)
        self.placeholder = QLabel("Concord is opening …", self, alignment=Qt.AlignmentFlag.AlignCenter)
        self.placeholder.setObjectName("placeholder")
        self.stack.addWidget(self.placeholder)
        self.furnished = False
        self.pages: dict[str, QWidget] = {}
        self.inspectors: list[QWidget] = []
        self._lay_out()
        self._restore_hook = show_unexpected(self.say)
        self.jobs.failed.connect(self.say)
        self._apply_theme()

    def _lay_out(self) -> None:
        self.rail = Rail(self)
        self.rail.chosen.connect(self.show_page)
        right = QVBoxLayout()
        right.setSpacing(0)
        right.addWidget(self.messages)
        right.addWidget(self.stack, 1)
        row = QHBoxLayout()
        row.setSpacing(0)
        row.addWidget(self.rail)
        row.addLayout(right, 1)
        whole = QWidget(self)
        outer = QVBoxLayout(whole)
        outer.setContentsMargins(0, 0, 0, 0)
        outer.setSpacing(0)
        outer.addLayout(row, 1)
        outer.addWidget(self.status)
        self.setCentralWidget(whole)

    # --- furnishing

    def furnish(self) -> None:
        """Make session, pages and menus; the modules that this imports should be loaded already."""
        from .pages.collection.desk import CollectionDesk
        from .pages.files import Files
        from .pages.judging import Judging
        from .pages.puzzle.desk import PuzzleDesk
        from .pages.results.page import ResultsPage
        from .pages.segments.desk import SegmentDesk
        from .pages.shapes.automatic import Automatic
        from .pages.shapes.matching import Matching
        from .pages.shapes.page import ShapesPage
        from .pages.shapes.wishing import WishFiles, Wishing
        from .pages.study.desk import StudyDesk
        from .pages.voting.page import StudyPage
        from .session import Session, State

        volunteer = str(settings().value("volunteer", "me"))
        self.session = Session(State(volunteer=volunteer, dark=self._dark), self)
        self.matching = Matching(self.session, self.jobs, self)
        self.judging = Judging(self.session, self.study_jobs, self)
        self.wishing, self.wish_files = Wishing(self.session, self.judging, self), WishFiles(self)
        self.shapes = ShapesPage(self.session, self.matching, self.judging, self)
        self.study = StudyPage(self.session, self.judging, self)
        self.studies = StudyDesk(self)
        self.results = ResultsPage(self.session, self.judging, self.studies.jobs, self)
        self.puzzle = PuzzleDesk(self)
        self.collection = CollectionDesk(self)
        self.segments = SegmentDesk(self)
        self.automatic = Automatic(self.session, self.jobs, self.matching, self)
        self.pages = {"shapes": self.shapes, "collection": self.collection.page, "puzzle": self.puzzle.page,
                      "study": self.study, "results": self.results, "segments": self.segments.page}  # fmt: skip
        self.files = Files(self)
        self.study.who.clicked.connect(self.files.name_volunteer)
        for page in self.pages.values():
            self.stack.addWidget(page)
            page.failed.connect(self.say)
        self._connect()
        menus.furnish_menus(self)
        menus.furnish_wishes(self)
        menus.furnish_exports(self)
        self.furnished = True
        self._add_icons()
        self.show_page("shapes")
        self._changed(State(), self.session.state, frozenset({"preset", "parameters", "linked"}))
        self.judging.open()

    def _connect(self) -> None:
        self.session.changed.connect(self._changed)
        self.judging.failed.connect(self.say)
        self.results.volunteers.wanted.connect(self.studies.people.command)
        self.results.disputed.opened.connect(self.studies.show_disputed)
        self.shapes.view.files_dropped.connect(self.files.drop)
        self.shapes.automatic.numbered.connect(self.automatic.number)
        self.shapes.automatic.edited.connect(self.segments.edit)
        self.automatic.refused.connect(self.shapes.show_automatic)
        self.matching.opened.connect(remember_pair)
        self.matching.dropped.connect(self.say)
        self.wishing.said.connect(self.say)
        self.shapes.wish.wished.connect(lambda wish: self.wishing.pin() if wish == "pinned" else self.wishing.forbid())
        self.jobs.started.connect(lambda _: self._show_waiting())
        self.jobs.idle.connect(self._show_waiting)
        self.matching.took.connect(self._show_seconds)
        self.status.follow(self.jobs)
        self.status.stopped.connect(self.stop)
        QApplication.instance().styleHints().colorSchemeChanged.connect(self._system_theme)

    def open_example(self, name: str = "") -> None:
        """Open a bundled pair, the first without a name."""
        from assets import example_pairs

        if not self.segments.may_leave():
            return
        found, source, target = next(pair for pair in example_pairs() if name in ("", pair[0]))
        self.show_page("shapes")
        self.matching.open_pair(str(source), str(target), set_name=found)

    # --- messages

    def say(self, sentence: str, details: str = "") -> None:
        """Show one sentence above the page."""
        self.messages.show_message(sentence, details)

    def attempt(self, work: Callable[[], object], done: str) -> None:
        """Do something quick that may fail for a reason that people understand."""
        try:
            work()
        except ConcordError as error:
            self.say(str(error))
        else:
            self.messages.dismiss()
            self.status.text.setText(done)

    # --- commands

    @property
    def page(self) -> str:
        """Name of the page that is shown."""
        return next((name for name, page in self.pages.items() if page is self.stack.currentWidget()), "")

    def show_page(self, name: str) -> None:
        """Bring a page to the front and let it read what may have changed."""
        if not self.furnished:
            return
        page = self.pages[name]
        if name == "collection":
            page.begin()
        self.stack.setCurrentWidget(page)
        self.rail.check("shapes" if name == "segments" else name)
        actions.enable_for(self.actions_by_id, name)
        self.show_history()
        self.status.preset.setVisible(name not in ("puzzle", "results"))
        desks = {"puzzle": self.puzzle, "collection": self.collection, "segments": self.segments}
        desks[name].show_status() if name in desks else self._show_status(self.session.state)
        self.status.setVisible(name != "study" and self.rail.isVisibleTo(self))  # a volunteer sees no results
        if hasattr(page, "begin"):
            page.begin()
        self.view_of(name).setFocus()

    def view_of(self, name: str) -> QWidget:
        """The view of a page, or the page itself where it has none."""
        page = self.pages[name]
        page = getattr(page, "made", None) or page
        return getattr(page, "view", page)

    def answer(self, answer: str) -> None:
        """An answer by its key, to whichever page asks; Space still presses the button that has the focus."""
        focus = QApplication.focusWidget()
        if answer == "unsure" and isinstance(focus, QAbstractButton):
            focus.click()
        elif answer == "unsure" and isinstance(focus, QComboBox):
            focus.showPopup()
        elif self.page == "study":
            self.study.answer(answer)
        elif self.page == "shapes":
            self.judging.answer(answer)
        elif self.page == "puzzle":
            self.puzzle.judging.answer(answer)

    def undo_vote(self) -> None:
        """Take back the volunteer's last vote."""
        if self.page == "segments":
            return
        {"study": self.study, "puzzle": self.puzzle.judging}.get(self.page, self.judging).undo()

    def undo(self, by: int = -1) -> None:
        """Go one step back on the page that is shown, or do it again."""
        history = self.history
        history.undo() if by < 0 else history.redo()

    def enrol(self) -> None:
        """Put what the page has found into the study, so that volunteers are asked about it."""
        self.puzzle.judging.enrol(told=True) if self.page == "puzzle" else self.judging.enrol()

    def comment(self) -> None:
        """Ask for a comment that goes with the next answer on the voting page."""
        if self.page == "study":
            self.study.ask_comment()
        else:
            self.say("Comments go with the answers of the voting page; open it with Ctrl+4.")

    def step_match(self, by: int) -> None:
        """Go to the next or previous match; on the voting page, leave the question for the end."""
        if self.page == "study":
            self.study.skip()
        else:
            self.shapes.step_match(by)

    def toggle_linked(self) -> None:
        """Turn both shapes together, or each on its own."""
        self.session.update(linked=not self.session.state.linked)

    def reset_view(self) -> None:
        """Show the shapes from the usual side."""
        view = self.view_of(self.page)
        if hasattr(view, "reset_view"):
            view.reset_view()

    def turn(self) -> None:
        """Turn the shapes slowly, or stop that."""
        if self.page == "study":
            self.study.turn()
            return
        on = self.actions_by_id["turntable"].isChecked()
        self.shapes.view.turntable(on)

    def stop(self) -> None:
        """Stop what runs; leave the page-alone mode if nothing does."""
        if self.jobs.busy():
            self.matching.cancel()
            self.puzzle.solving.cancel()
            self.collection.stopped()
            self.shapes.show_automatic()
            self.status.text.setText("Stopped.")
        elif self.studies.jobs.busy():
            self.studies.stop()
        elif not self.rail.isVisible():
            self.toggle_alone()
        elif self.page == "segments":
            self.segments.deselect()

    def match_again(self) -> None:
        """Start the matching that was stopped or failed."""
        self.messages.dismiss()
        self.matching.again()

    def toggle_panel(self) -> None:
        """Show or hide the right panel of the shapes, the collection or the puzzle page."""
        own = {"puzzle": self.puzzle.page, "segments": self.segments.page, "collection": self.collection.page.made}
        panel = own.get(self.page, self.shapes).panel
        panel.setVisible(panel.isHidden())

    def toggle_alone(self) -> None:
        """Show the page without rail, menus and status line, or with them again."""
        alone = self.rail.isVisible()
        for part in (self.rail, self.menuBar()):
            part.setVisible(not alone)
        self.status.setVisible(not alone and self.page != "study")

    def toggle_dark(self) -> None:
        """Change between light and dark; the system is followed again where both agree."""
        dark = not self._dark
        same = dark == system_is_dark(QApplication.instance())
        settings().setValue("dark", "system" if same else "yes" if dark else "no")
        self.session.update(dark=dark)

    def inspect(self, side: int) -> None:
        """Open one shape by itself in its own window."""
        state = self.session.state
        shape = state.target if side else state.source
        if shape is None:
            self.say("There is no shape to inspect yet; open two meshes first.")
            return
        from .views.inspector import Inspector

        def show() -> None:
            inspector = Inspector(shape, theme(self._dark))
            self.inspectors.append(inspector)
            inspector.destroyed.connect(lambda _: self.inspectors.remove(inspector))
            inspector.show()

        self.attempt(show, f"{shape.mesh.name} opened by itself.")

    def show_keys(self) -> None:
        """All keys, and the guideline of the study where it has one."""
        show_keys(self, actions.keys_table(self.page), self.study.guideline() if self.page == "study" else "")

    def show_about(self) -> None:
        """What this is."""
        show_about(self)

    # --- following the state

    def _changed(self, old: "State", state: "State", names: frozenset[str]) -> None:
        if "dark" in names:
            self._dark = state.dark
            self._apply_theme()
        if names & {"source", "target"} and state.source is not None and state.target is not None:
            self.setWindowTitle(f"{state.source.mesh.name} – {state.target.mesh.name} · Concord")
        if names & {"preset", "parameters"}:
            from engine.shapes.parameters import PRESETS

            differs = state.parameters != PRESETS[state.preset]
            self.status.preset.setText(state.preset + (" ●" if differs else "") + "  ▾")
            for action in self.preset_group.actions():
                action.setChecked(action.text() == state.preset)
        if names & {"result", "answers", "verdicts", "shown", "source", "target"}:
            self._show_status(state)
        if "bound" in names:
            self.actions_by_id["bind-answers"].setChecked(state.bound)
        self.show_history()

    @property
    def history(self) -> "Session":
        """The session whose steps are undone on the page that is shown."""
        own = {"puzzle": self.puzzle, "collection": self.collection, "segments": self.segments}
        return own[self.page].session if self.page in own else self.session

    def show_history(self) -> None:
        """Enable undo and redo where the page has steps."""
        self.actions_by_id["undo"].setEnabled(self.history.can_undo)
        self.actions_by_id["redo"].setEnabled(self.history.can_redo)

    def _show_seconds(self, seconds: float) -> None:
        self.status.seconds.setText(seconds_text(seconds))

    def _show_status(self, state: "State") -> None:
        if self.page in ("puzzle", "collection", "segments"):
            return
        if state.result is None:
            waiting = "Matching …" if self.jobs.busy() else "Not matched; choose Edit > Match again, or other files."
            self.status.text.setText("" if state.source is None else waiting)
            return
        from .pages.shapes.arrange import listed

        ids = state.result.ids
        given = [state.verdicts.get(i) for i in ids]
        counts = [given.count(verdict) for verdict in ("correct", "wrong", "tie")]
        left = sum(match.id not in state.answers for match in listed(state))
        self.status.text.setText(judged_text(len(ids), *counts, left))

    def _show_waiting(self) -> None:
        if self.session.state.result is None:
            self._show_status(self.session.state)

    def _system_theme(self) -> None:
        if settings().value("dark", "system") == "system":
            self.session.update(dark=system_is_dark(QApplication.instance()))

    def _apply_theme(self) -> None:
        app, colours = QApplication.instance(), theme(self._dark)
        if app.property(_SHOWN_DARK) != self._dark:  # styling every widget again takes a third of a second
            apply_theme(app, self._dark)
            app.setProperty(_SHOWN_DARK, self._dark)
        self.setStyleSheet(window_style(colours))
        if self.furnished:
            self._add_icons()

    def _add_icons(self) -> None:
        actions.add_icons(self.actions_by_id, theme(self._dark).ink)
        for name in self.rail.buttons:
            self.rail.set_icon(name, self.actions_by_id[f"page-{name}"].icon())

    # --- files dropped beside the view, and the end

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        if self.furnished and event.mimeData().hasUrls():
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        paths = [url.toLocalFile() for url in event.mimeData().urls() if url.isLocalFile()]
        event.acceptProposedAction()
        QTimer.singleShot(0, lambda: self.files.drop(paths) if paths else None)

    def changeEvent(self, event: QEvent) -> None:
        """Read the votes again when the window comes to the front: other windows write to the same study."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.ActivationChange and self.isActiveWindow() and self.furnished:
            self.judging.refresh()

    def closeEvent(self, event: QCloseEvent) -> None:
        """Cancel, wait, let votes reach the disk, give the graphics back, and only then go."""
        if self.furnished and not self.segments.may_leave():
            event.ignore()
            return
        self.jobs.close()
        if self.furnished:
            self.studies.close()
            self.judging.close()
            for page in self.pages.values():
                page.shutdown()
        self.study_jobs.close()
        for inspector in list(self.inspectors):
            inspector.close()
        self._restore_hook()
        super().closeEvent(event)
