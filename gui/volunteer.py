"""The volunteer's window: the voting screen by itself. Nothing in it leads to results, or names how a match was found."""

import signal
import sys

from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QCloseEvent, QDragEnterEvent, QDropEvent, QKeyEvent
from PySide6.QtWidgets import QApplication, QFileDialog, QMainWindow

from annotation import study
from annotation.storage.handle import StudyHandle
from annotation.voting.asking import own_code

from .jobs import QUEUE, Jobs, show_unexpected
from .pages.style import window_style
from .pages.voting.desk import VotingDesk
from .pages.voting.notice import Choice
from .pages.voting.sayings import ENTER, NEXT
from .pages.voting.screen import VotingScreen
from .pages.voting.words import NO_CODE
from .palette import apply_theme, system_is_dark, theme

SMALLEST = (720, 520)
OPENING = ("One moment", "Opening …")


class VolunteerWindow(QMainWindow):
    """Opens one study for one volunteer, asks for what it was not told, and shows the voting screen."""

    def __init__(self, where: str = "", code: str = "", *, dark: bool | None = None) -> None:
        super().__init__()
        self.where, self.code = where, code
        self.handle: StudyHandle | None = None
        self._leaving = self._closing = False
        self.opener = Jobs(self)
        self.desk = VotingDesk(parent=self)
        self.screen = VotingScreen(self.desk, self, own_window=True)
        self.setCentralWidget(self.screen)
        self.setWindowTitle("Concord")
        self.setMinimumSize(*SMALLEST)
        self.resize(1280, 760)
        self.setAcceptDrops(True)
        self.screen.left.connect(self.close)
        self.screen.given_up.connect(self._give_up)
        self.desk.refused.connect(self._ask_code)
        self.desk.saved.connect(self._saved)
        self.desk.failed.connect(lambda _: setattr(self, "_closing", False))
        self._restore_hook = show_unexpected(self.desk.tell)
        hints = QApplication.instance().styleHints()
        self._follow_system = dark is None
        hints.colorSchemeChanged.connect(self._theme_changed)
        self.set_dark(system_is_dark(QApplication.instance()) if dark is None else dark)
        self.screen.say(*OPENING)

    def set_dark(self, dark: bool) -> None:
        """Change between light and dark."""
        apply_theme(QApplication.instance(), dark)
        self.setStyleSheet(window_style(theme(dark)))
        self.screen.set_theme(theme(dark))

    def _theme_changed(self) -> None:
        if self._follow_system:
            self.set_dark(system_is_dark(QApplication.instance()))

    # --- beginning

    def begin(self) -> None:
        """Open the study that was named, or ask for one."""
        if not self.where:
            self._ask_study()
            return
        self.screen.say(*OPENING)
        where = self.where
        self.opener.start("study", lambda _: opened(where), self._opened, policy=QUEUE,
                          failed=lambda *said: self._ask_study(self.desk.plainly(*said)))  # fmt: skip

    def _opened(self, handle: StudyHandle) -> None:
        if self.handle is not None:
            self.handle.close()
        self.handle = handle
        code = self.code or own_code(handle) or ""
        if code:
            self._vote_as(code)
        else:
            self._ask_code()

    def _vote_as(self, code: str, *, new: bool = False) -> None:
        self.code = code
        self.screen.say(*OPENING)
        self.desk.open(self.handle, code, new=new)

    def _ask_study(self, trouble: str = "") -> None:
        """Which file? Asked where none was named, or it cannot be used."""
        choose = Choice("Open the file that you were given", NEXT, "Enter", self._choose)
        choices = [choose, Choice("Close", (Qt.Key.Key_Escape,), "Esc", self.close)]
        if trouble:
            choices[1:1] = [Choice("Try again", (Qt.Key.Key_R,), "R", self.begin), *self._copying()]
        heading = "This did not work" if trouble else "Welcome"
        self.screen.say(heading, "" if trouble else "Open the file that you were given, or drop it here.", *choices, trouble=trouble)

    def _choose(self) -> None:
        path, _ = QFileDialog.getOpenFileName(self, "Open the file that you were given")
        if path:
            self.where = path
            self.begin()

    def _ask_code(self, trouble: str = "") -> None:
        """Who votes? Asked where nothing tells, or the study does not know the code."""
        choices = [Choice("Go on", ENTER, "Enter", self._take_code)]
        anybody = self.handle is not None and own_code(self.handle) is None
        if trouble and anybody and "knows no volunteer" in trouble:
            choices.append(Choice("I am new here", (), "", lambda: self._take_code(new=True)))
        choices += [*(self._copying() if trouble else ()), Choice("Close", (Qt.Key.Key_Escape,), "Esc", self.close)]
        self.screen.say("What is your code?", NO_CODE, *choices, field="your code", trouble=trouble)
        self.screen.notice.field.setText(self.code)
        self.screen.notice.field.selectAll()

    def _copying(self) -> tuple[Choice, ...]:
        """A way to hand on what is known of a fault that nobody foresaw."""
        return (Choice("Copy details", (), "", self.screen.copy_details),) if self.desk.details else ()

    def _take_code(self, *, new: bool = False) -> None:
        code = self.screen.notice.field.text().strip()
        if code and self.handle is not None:
            self._vote_as(code, new=new)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Keys work also before anything in the window has the focus."""
        if self.focusWidget() is None or self.focusWidget() is self:
            self.screen.keyPressEvent(event)
        else:
            super().keyPressEvent(event)

    # --- files dropped on it, and the end

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Take a file while none is open."""
        if self.handle is None and event.mimeData().hasUrls():
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        """Open the file that was dropped."""
        paths = [url.toLocalFile() for url in event.mimeData().urls() if url.isLocalFile()]
        event.acceptProposedAction()
        if paths:
            self.where = paths[0]
            QTimer.singleShot(0, self.begin)

    def _saved(self, _: str) -> None:
        self._leaving = False
        if self._closing:
            self.close()

    def _give_up(self) -> None:
        self._leaving = True
        self.close()

    def closeEvent(self, event: QCloseEvent) -> None:
        """Let the last answer reach the disk; if that fails or takes long, go only when asked once more."""
        if self.desk.saving and not self._closing:
            self._closing = True
            event.ignore()
            return
        if self.desk.unsaved and not self.desk.saving and not self._leaving:
            self._leaving = True
            self.screen.leave()
            event.ignore()
            return
        self.opener.close()
        self.desk.close()
        self.screen.shutdown()
        if self.handle is not None:
            self.handle.close()
            self.handle = None
        self._restore_hook()
        super().closeEvent(event)


def opened(where: str) -> StudyHandle:
    """Open a study, a packet or a server (in a thread), and meanwhile load what draws shapes."""
    from . import glprobe

    handle = study.open_study(where)
    glprobe.problem()
    from .views import pair  # noqa: F401

    return handle


def run(where: str = "", code: str = "") -> int:
    """Open the volunteer's window and stay until it is closed; returns the exit code."""
    app = QApplication.instance() or QApplication(sys.argv[:1])
    app.setApplicationName("Concord")
    app.setDesktopFileName("concord")
    window = VolunteerWindow(where, code)
    window.showMaximized()
    QTimer.singleShot(0, window.begin)
    signal.signal(signal.SIGINT, lambda *_: window.close())
    awake = QTimer(window, interval=200)  # lets Python see the signal while Qt waits for events
    awake.timeout.connect(lambda: None)
    awake.start()
    return app.exec()
