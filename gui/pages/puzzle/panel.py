"""The right panel of the puzzle page: one join from close by, what else its side could join, and what to do with it."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QMenu, QPushButton, QToolButton, QVBoxLayout, QWidget

from ...palette import Theme
from ...views.join_closeup import JoinCloseup, Pair, Partner, PartnerStrip
from ..shapes.panels import JudgeStrip


class Asked(NamedTuple):
    """What the strip of answers shows."""

    selected: str
    answers: Mapping[str, str]
    volunteer: str
    dark: bool


class Shown(NamedTuple):
    """What the panel says of a join."""

    heading: str
    facts: str
    pair: Pair | None
    partners: tuple[Partner, ...]
    partners_heading: str
    locked: bool
    tried: bool


class JoinPanel(QWidget):
    """Shows what it is told of one join; says which button was pressed."""

    stepped = Signal(int)
    locked = Signal()
    rejected = Signal()
    cleared = Signal()
    other_side = Signal()
    partner_picked = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.heading = QLabel("", self)
        self.heading.setObjectName("group-heading")
        self.facts, self.partners_heading = QLabel("", self, wordWrap=True), QLabel("", self)
        for label in (self.facts, self.partners_heading):
            label.setObjectName("soft")
            label.setTextFormat(Qt.TextFormat.PlainText)
        self.closeup, self.strip, self.judge = JoinCloseup(self), PartnerStrip(self), JudgeStrip(self)
        self.contrast = self._tool("◐", "Spread the tones, so that dark or pale borders can be told apart (C)", lambda: None)
        self.contrast.setCheckable(True)
        self.contrast.toggled.connect(self.closeup.stretch)
        self.contrast.toggled.connect(self.strip.stretch)
        self.back = self._tool("‹", "The join before, in the order of doubt (P)", lambda: self.stepped.emit(-1))
        self.on = self._tool("›", "The next join, the most doubtful first (N)", lambda: self.stepped.emit(1))
        self.turn_round = self._tool("⇄", "Partners of the other piece's side", self.other_side.emit)
        self.lock = self._button("Lock  (L)", "Hold this join or piece whatever the solver thinks (L)", self.locked.emit)
        self.reject = self._button("Reject  (X)", "Forbid this join, or all joins of the chosen piece (X)", self.rejected.emit)
        self.wishes = self._button("", "What was locked, rejected and pinned; choose one to take it back", lambda: None)
        self.wishes.setObjectName("plain")
        self.menu = QMenu(self.wishes)
        self.menu.aboutToShow.connect(self._fill_menu)
        self.wishes.setMenu(self.menu)
        self.wishes_of: Callable[[], Sequence[tuple[str, Callable[[], object]]]] = lambda: ()
        self.strip.picked.connect(self.partner_picked)
        self._lay_out()

    def _tool(self, text: str, tip: str, pressed: Callable[[], object]) -> QToolButton:
        button = QToolButton(self, text=text, autoRaise=True, toolTip=tip)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        button.setFixedSize(26, 24)
        button.clicked.connect(lambda _=False: pressed())
        return button

    def _button(self, text: str, tip: str, pressed: Callable[[], object]) -> QPushButton:
        button = QPushButton(text, self, toolTip=tip)
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        button.clicked.connect(lambda _=False: pressed())
        return button

    def _lay_out(self) -> None:
        column = QVBoxLayout(self)
        column.setContentsMargins(8, 8, 8, 8)
        column.setSpacing(6)
        column.addLayout(_row(self.heading, None, self.contrast, self.back, self.on))
        column.addWidget(self.closeup)
        column.addWidget(self.facts)
        column.addLayout(_row(self.partners_heading, None, self.turn_round))
        column.addWidget(self.strip)
        buttons = QHBoxLayout()
        buttons.setSpacing(4)
        buttons.addWidget(self.lock, 1)
        buttons.addWidget(self.reject, 1)
        column.addLayout(buttons)
        column.addLayout(_row(self.wishes, None))
        column.addStretch(1)
        column.addWidget(self.judge)

    def set_theme(self, theme: Theme) -> None:
        """Take other colours."""
        self.closeup.set_theme(theme)
        self.strip.set_theme(theme)

    def _fill_menu(self) -> None:
        self.menu.clear()
        for words, take_back in self.wishes_of():
            self.menu.addAction(words).triggered.connect(lambda _=False, take_back=take_back: take_back())
        self.menu.addSeparator()
        self.menu.addAction("Take back all of them").triggered.connect(lambda _=False: self.cleared.emit())

    def show_join(self, shown: Shown) -> None:
        """Show a join, or how to choose one."""
        self.heading.setText(shown.heading)
        self.facts.setText(shown.facts)
        self.closeup.show_pair(shown.pair)
        self.strip.show_partners(shown.partners)
        self.partners_heading.setText(shown.partners_heading)
        for widget in (self.strip, self.partners_heading, self.turn_round):
            widget.setVisible(bool(shown.partners))
        self.lock.setText("Unlock  (L)" if shown.locked else "Lock this one  (L)" if shown.tried else "Lock  (L)")

    def show_actions(self, lock: bool, wishes: str, asked: Asked) -> None:
        """Enable what can be done with what is chosen, and say what was decided so far."""
        self.lock.setEnabled(lock)
        self.reject.setEnabled(lock)
        self.wishes.setText(wishes)
        self.wishes.setVisible(bool(wishes))
        self.judge.show_state(asked)


def _row(*widgets: QWidget | None) -> QHBoxLayout:
    """Widgets side by side; None is the stretch between them."""
    row = QHBoxLayout()
    row.setContentsMargins(0, 0, 0, 0)
    row.setSpacing(4)
    for widget in widgets:
        if widget is None:
            row.addStretch(1)
        else:
            row.addWidget(widget)
    return row
