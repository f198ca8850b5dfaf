"""Notices that another window or volunteer has written to the open study, by the time and size of its files."""

from pathlib import Path

from PySide6.QtCore import QObject, QTimer

from annotation.study import StudyFile, StudyHandle

from ..judging import Judging

EVERY_MS = 2500
Stamp = tuple[tuple[int, int], ...]


def stamp(handle: StudyHandle | None) -> Stamp:
    """Time and size of the files of a study; nothing for one on a server, which is read when the window comes to the front."""
    if not isinstance(handle, StudyFile):
        return ()
    return tuple(_stat(Path(f"{handle.path}{ending}")) for ending in ("", "-wal"))


def _stat(path: Path) -> tuple[int, int]:
    try:
        found = path.stat()
    except OSError:
        return (0, 0)
    return found.st_mtime_ns, found.st_size


class StudyWatch(QObject):
    """Reads the votes again after somebody else wrote; what this window wrote it has read already."""

    def __init__(self, judging: Judging, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.judging = judging
        self.seen: tuple[StudyHandle | None, Stamp] = (None, ())
        judging.refreshed.connect(self.note)
        self.timer = QTimer(self, interval=EVERY_MS)
        self.timer.timeout.connect(self.look)
        self.timer.start()

    def note(self) -> None:
        """Remember the files as they are: the votes were read just now."""
        self.seen = self.judging.handle, stamp(self.judging.handle)

    def look(self) -> None:
        """Read the votes again if the files have changed since."""
        handle = self.judging.handle
        if handle is None or self.judging.saving or self.judging.jobs.busy():
            return
        now = stamp(handle)
        if self.seen != (handle, now):
            self.seen = handle, now
            self.judging.refresh()

    def stop(self) -> None:
        """Look no more."""
        self.timer.stop()
