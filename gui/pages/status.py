"""The status line: which preset, what was found and judged, how long it took, and what is running."""

import math

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QProgressBar, QSizePolicy, QToolButton, QWidget

from ..jobs import Jobs

SHOW_AFTER = 250


def seconds_text(seconds: float) -> str:
    """'0.04 s', '3.1 s', '2 min'."""
    if seconds >= 90:
        return f"{seconds / 60:.0f} min"
    return f"{seconds:.2f} s" if seconds < 1 else f"{seconds:.1f} s"


def left_text(seconds: float) -> str:
    """'about 12 s left', or nothing while it is not known."""
    if math.isnan(seconds) or seconds < 1:
        return ""
    return f"about {seconds / 60:.0f} min left" if seconds >= 90 else f"about {seconds:.0f} s left"


def judged_text(matches: int, correct: int, wrong: int, tie: int, left: int) -> str:
    """'6 of 8 matches judged, precision .83 [.44, .97]', ties, and how many of the list the volunteer has left."""
    if not matches:
        return "No matches with these parameters."
    text = "1 match" if matches == 1 else f"{matches} matches"
    judged = correct + wrong + tie
    if not judged:
        return f"{text} · none judged yet: J correct, F wrong, Space unsure"
    text = f"{judged} of {text} judged"
    if correct + wrong:
        from engine.evaluation.intervals import clustered_interval

        from .shapes.arrange import share_text

        interval = clustered_interval([correct], [correct + wrong])
        text += f", precision {share_text(correct / (correct + wrong))} [{share_text(interval.low)}, {share_text(interval.high)}]"
    if tie:
        text += f" · {tie} tied"
    return text + (f" · {left} in the list left for you" if left else " · you have judged the whole list")


class StatusLine(QWidget):
    """Preset, text, seconds, and a bar with a way to stop while something runs."""

    stopped = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("status-line")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.preset = QToolButton(self, autoRaise=True, popupMode=QToolButton.ToolButtonPopupMode.InstantPopup)
        self.preset.setToolTip("The preset; ● where parameters differ from it")
        self.preset.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.preset.hide()
        self.text, self.seconds = QLabel("", self), QLabel("", self)
        self.text.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.running = QLabel("", self)
        self.bar = QProgressBar(self, textVisible=False)
        self.bar.setRange(0, 1000)
        self.bar.setFixedWidth(140)
        self.stop = QToolButton(self, text="Stop", autoRaise=True, toolTip="Stop the running work (Esc)")
        self.stop.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.stop.clicked.connect(self.stopped)
        for label in (self.seconds, self.running):
            label.setObjectName("soft")
        row = QHBoxLayout(self)
        row.setContentsMargins(8, 2, 8, 2)
        row.setSpacing(12)
        for widget, stretch in ((self.preset, 0), (self.text, 1), (self.running, 0), (self.bar, 0), (self.stop, 0),
                                (self.seconds, 0)):  # fmt: skip
            row.addWidget(widget, stretch)
        self.setFixedHeight(34)
        self._followed: list[Jobs] = []
        self._timer = QTimer(self, singleShot=True, interval=SHOW_AFTER)
        self._timer.timeout.connect(lambda: self._show_running(True))
        self._show_running(False)

    def follow(self, jobs: Jobs) -> None:
        """Show what these jobs do, too, if it takes longer than a moment."""
        self._followed.append(jobs)
        jobs.started.connect(self._started)
        jobs.progressed.connect(self._progressed)
        jobs.idle.connect(self._idle)

    def _started(self, words: str) -> None:
        self.running.setText(words)
        self.bar.setRange(0, 0)
        if not self._timer.isActive() and self.bar.isHidden():
            self._timer.start()

    def _progressed(self, share: float, words: str, left: float) -> None:
        self.bar.setRange(0, 1000)
        self.bar.setValue(round(1000 * share))
        self.running.setText(" · ".join(text for text in (words, left_text(left)) if text))

    def _idle(self) -> None:
        if not any(jobs.busy() for jobs in self._followed):
            self._timer.stop()
            self._show_running(False)

    def _show_running(self, on: bool) -> None:
        for widget in (self.running, self.bar, self.stop):
            widget.setVisible(on)
        self.seconds.setVisible(not on)
