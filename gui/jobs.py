"""Long work in a thread: progress with an estimate, cancelling, late answers dropped. The one place that catches all."""

import contextlib
import math
import sys
import threading
import time
import traceback
from collections.abc import Callable
from typing import Any, Literal

from PySide6.QtCore import QObject, Qt, Signal

from engine.errors import Cancelled, ConcordError
from engine.progress import Progress

SUPERSEDE, FOLLOW, QUEUE = "supersede", "follow", "queue"
Policy = Literal["supersede", "follow", "queue"]
_TICK = 0.05


def remaining(elapsed: float, share: float) -> float:
    """Seconds left at the pace so far; NaN while that says nothing yet."""
    return math.nan if share < 0.03 or elapsed < 0.5 else elapsed * (1 - share) / share


def explain(error: BaseException) -> tuple[str, str]:
    """One sentence for people and the details to copy for whoever looks into it."""
    details = "".join(traceback.format_exception(error))
    if isinstance(error, ConcordError):
        return str(error), details
    if isinstance(error, MemoryError):
        return "There is not enough memory for this; close other programs or use smaller meshes.", details
    return f"Something went wrong that should not have ({type(error).__name__}: {error}).", details


class _Job:
    """One piece of work and whether somebody wants it to stop."""

    def __init__(self, channel: str, work: Callable[[Progress], Any], done: Callable[[Any], None], words: str,
                 failed: Callable[[str, str], None] | None) -> None:  # fmt: skip
        self.channel, self.work, self.done, self.words, self.failed = channel, work, done, words, failed
        self.stop = threading.Event()
        self.value: Any = None
        self.error: BaseException | None = None
        self.began = self.last = 0.0


class Jobs(QObject):
    """One worker: at most one job runs at a time, because compiled kernels share a thread pool.

    A job belongs to a channel. Starting another on the same channel either cancels the older one (`supersede`), lets
    it finish and keeps only the newest waiting (`follow`, for sliders), or waits its turn (`queue`, for votes). The
    answer of a cancelled job is dropped. All callbacks run in the thread of this object.
    """

    started = Signal(str)
    progressed = Signal(float, str, float)
    """share in [0, 1], words, seconds left or NaN"""
    idle = Signal()
    failed = Signal(str, str)
    """sentence, details"""
    _ended = Signal(object)
    _moved = Signal(object, float, str)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._waiting: list[_Job] = []
        self._running: _Job | None = None
        self._thread: threading.Thread | None = None
        self._closed = False
        self._ended.connect(self._finish, Qt.ConnectionType.QueuedConnection)
        self._moved.connect(self._show, Qt.ConnectionType.QueuedConnection)

    def start(self, channel: str, work: Callable[[Progress], Any], done: Callable[[Any], None], *, words: str = "",
              policy: Policy = SUPERSEDE, failed: Callable[[str, str], None] | None = None) -> None:  # fmt: skip
        """Run `work(progress)` in the thread and give its value to `done`; an error goes to `failed` or the signal."""
        if self._closed:
            return
        if policy != QUEUE:
            self._waiting = [job for job in self._waiting if job.channel != channel]
        if policy == SUPERSEDE and self._running is not None and self._running.channel == channel:
            self._running.stop.set()
        self._waiting.append(_Job(channel, work, done, words, failed))
        self._next()

    def busy(self, channel: str = "") -> bool:
        """Whether a job (of this channel) runs or waits and has not been cancelled."""
        jobs = [*self._waiting, *([self._running] if self._running else [])]
        return any(not job.stop.is_set() and channel in ("", job.channel) for job in jobs)

    def stopping(self) -> bool:
        """Whether a job that was cancelled has not come to its end yet."""
        return self._running is not None and self._running.stop.is_set()

    def cancel(self, channel: str = "") -> None:
        """Drop what waits and stop what runs, all or one channel, as soon as it next reports progress."""
        self._waiting = [job for job in self._waiting if channel not in ("", job.channel)]
        if self._running is not None and channel in ("", self._running.channel):
            self._running.stop.set()
        if not self.busy():
            self.idle.emit()

    def close(self, timeout: float = 10.0) -> bool:
        """Cancel everything, take no more, and wait; whether the thread has ended."""
        self._closed = True
        self._waiting.clear()
        if self._running is not None:
            self._running.stop.set()
        if self._thread is not None:
            self._thread.join(timeout)
            return not self._thread.is_alive()
        return True

    def finish(self, timeout: float = 30.0) -> bool:
        """Take no more, but let what runs and waits come to its end (votes); then wait for the thread."""
        deadline = time.monotonic() + timeout
        while self._running is not None or self._waiting:
            if self._thread is None or time.monotonic() > deadline:
                break
            self._thread.join(max(0.0, deadline - time.monotonic()))
            if self._thread.is_alive():
                break
            self._finish(self._running)
        self._closed = True
        return self._thread is None or not self._thread.is_alive()

    def _next(self) -> None:
        if self._running is not None or not self._waiting:
            return
        job = self._running = self._waiting.pop(0)
        job.began = time.monotonic()
        self.started.emit(job.words)
        self._thread = threading.Thread(target=self._run, args=(job,), name=f"concord-{job.channel}", daemon=True)
        self._thread.start()

    def _run(self, job: _Job) -> None:
        """In the thread: do the work, catch whatever comes out of it."""

        def progress(share: float, words: str) -> None:
            if job.stop.is_set():
                raise Cancelled
            now = time.monotonic()
            if now - job.last >= _TICK:
                job.last = now
                self._moved.emit(job, share, words)

        try:
            job.value = job.work(progress)
        except BaseException as error:
            job.error = error
        with contextlib.suppress(RuntimeError):  # the window is gone
            self._ended.emit(job)

    def _show(self, job: _Job, share: float, words: str) -> None:
        if job is self._running and not job.stop.is_set():
            self.progressed.emit(share, words or job.words, remaining(time.monotonic() - job.began, share))

    def _finish(self, job: _Job | None) -> None:
        if job is None or job is not self._running:
            return
        self._running = None
        stopped = job.stop.is_set() or isinstance(job.error, Cancelled)
        try:
            if not stopped and job.error is None:
                job.done(job.value)
            elif not stopped and job.error is not None:
                (job.failed or self.failed.emit)(*explain(job.error))
        finally:
            if not self._closed:
                self._next()
            if self._running is None:
                self.idle.emit()


def show_unexpected(show: Callable[[str, str], None]) -> Callable[[], None]:
    """Send what slots raise to `show(sentence, details)` instead of a terminal; returns the way back."""
    before = sys.excepthook

    def hook(kind: type[BaseException], error: BaseException, trace: Any) -> None:
        if issubclass(kind, KeyboardInterrupt):
            before(kind, error, trace)
            return
        show(*explain(error.with_traceback(trace)))

    sys.excepthook = hook

    def restore() -> None:
        if sys.excepthook is hook:
            sys.excepthook = before

    return restore
