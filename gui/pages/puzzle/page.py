"""The page of a puzzle: pieces in a tray and the picture that they make, one join from close by, the parameters."""

from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QPushButton,
    QScrollArea,
    QStyle,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from engine.errors import ConcordError
from engine.puzzles.parameters import PuzzleParameters

from ...palette import theme
from ...parameter_form import ParameterForm
from ...session import Session
from ...views.puzzle_canvas import PuzzleCanvas
from ...views.puzzle_layout import arrange
from ...views.puzzle_scene import growth_order, join_key, seams
from .bar import PuzzleBar
from .edits import group
from .facts import PuzzleFacts
from .hands import Hands
from .judging import PuzzleJudging
from .looking import Looking
from .overlay import overlay_of, tip_text
from .panel import JoinPanel
from .partners import next_best
from .solving import Solving, moved_pieces
from .state import PuzzleState

PANEL_WIDTH = 340
_MARKS = {"puzzle", "prepared", "solution", "marks", "items", "wishes", "selected", "preview", "piece", "below", "overlay",
          "verdicts", "dark"}  # fmt: skip
EMPTY = "Drop a folder with the images of the pieces here, or a picture to be cut into pieces"


class PuzzlePage(QWidget):
    """Draws the state of the puzzle's session; what a hand does goes to the hands, the solving and the judging."""

    failed = Signal(str, str)
    folder_wanted = Signal()
    picture_wanted = Signal()

    def __init__(self, session: Session, solving: Solving, hands: Hands, judging: PuzzleJudging,
                 parent: QWidget | None = None) -> None:  # fmt: skip
        super().__init__(parent)
        self.session, self.solving, self.hands, self.judging = session, solving, hands, judging
        self.view, self.bar, self.join = PuzzleCanvas(self), PuzzleBar(self), JoinPanel(self)
        self.facts, self.form = PuzzleFacts(self), ParameterForm(PuzzleParameters, self)
        self.looking = Looking(session, self.join, self)
        self.panel = self._panel()
        column = QVBoxLayout()
        column.setSpacing(0)
        column.addWidget(self.view, 1)
        column.addWidget(self.bar)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(0)
        row.addLayout(column, 1)
        row.addWidget(self.panel)
        self.invitation = self._invitation()
        self._connect()
        self.apply(PuzzleState(), session.state, frozenset(PuzzleState.__slots__))

    def _panel(self) -> QTabWidget:
        area = QScrollArea(self, widgetResizable=True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        inside = QWidget(area)
        whole = QVBoxLayout(inside)
        whole.setContentsMargins(0, 0, 0, 0)
        whole.addWidget(self.facts)
        whole.addWidget(self.form, 1)
        area.setWidget(inside)
        tabs = QTabWidget(self)
        tabs.setFixedWidth(PANEL_WIDTH)
        tabs.setDocumentMode(True)
        tabs.tabBar().setDrawBase(False)
        tabs.tabBar().setFocusPolicy(Qt.FocusPolicy.TabFocus)
        tabs.addTab(self.join, "Joins")
        tabs.addTab(area, "Parameters")
        return tabs

    def _invitation(self) -> QWidget:
        """The buttons of the empty canvas."""
        box = QWidget(self.view)
        row = QHBoxLayout(box)
        row.setSpacing(12)
        buttons = (("Open a folder of pieces…", self.folder_wanted.emit), ("Cut a picture…", self.picture_wanted.emit),
                   ("Try the example", self.solving.open_example))  # fmt: skip
        for text, pressed in buttons:
            button = QPushButton(text, box)
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.clicked.connect(lambda _=False, pressed=pressed: pressed())
            row.addWidget(button)
        self.view.set_invitation(EMPTY, box)
        return box

    def _connect(self) -> None:
        update = self.session.update
        self.session.changed.connect(self.apply)
        self.view.group_of = self._group
        self.view.tip_of = lambda row: tip_text(self.session.state, row)
        self.view.join_clicked.connect(self._join_clicked)
        self.view.piece_clicked.connect(self._piece_clicked)
        self.view.background_clicked.connect(lambda: update(piece=-1, selected=None, preview=None))
        self.view.carried.connect(lambda piece, x, y: self.hands.carry(self.view.layout_shown, piece, x, y))
        self.view.grown.connect(self._grown)
        self.bar.solve.connect(self.solving.solve)
        self.bar.below.connect(lambda below: update(below=below))
        self.bar.truth.connect(lambda on: update(overlay=on))
        self.bar.fit.connect(self.view.reset_view)
        self.form.edited.connect(self._edited)
        self.facts.declared.connect(self.hands.declare)
        self.join.stepped.connect(self.step_join)
        self.join.locked.connect(self.hands.lock)
        self.join.rejected.connect(self.hands.reject)
        self.join.cleared.connect(self.hands.clear)
        self.join.wishes_of = self.hands.taken_back
        self.join.judge.answered.connect(self.judging.answer)
        self.judging.saved.connect(self.join.judge.state.setText)
        self.judging.advanced.connect(self.look)
        self.solving.jobs.started.connect(lambda _: self._show_bar())
        self.solving.jobs.idle.connect(self._show_bar)

    # --- what a hand does

    def _group(self, piece: int) -> frozenset[int]:
        """What a hand takes along: the placed pieces that are locked to a placed one."""
        placed = self.view.layout_shown.placed
        if not placed[piece]:
            return frozenset({piece})
        return frozenset(k for k in group(piece, self.session.state.wishes.locked) if placed[k])

    def _join_clicked(self, row: int) -> None:
        joins = self.session.state.solution.joins
        self.session.update(selected=join_key(joins.sides[row]), preview=None, piece=-1)
        self.panel.setCurrentIndex(0)

    def _piece_clicked(self, piece: int) -> None:
        """Choose a piece; of one in the tray, look at its best partner, of its next side if it is clicked again."""
        state = self.session.state
        lies = state.solution is not None and not state.solution.placed[piece]
        best = next_best(state, piece) if lies and state.asked else None
        self.session.update(piece=piece, selected=None, preview=best)

    def step_join(self, by: int) -> None:
        """Go to the next most doubtful join, or back, and look at it."""
        self.hands.step(by)
        self.look()

    def look(self) -> None:
        """Bring the selected join into sight."""
        state = self.session.state
        if state.row >= 0 and self.view.layout_shown is not None:
            self.view.look_at(seams(self.view.layout_shown, state.solution.joins)[state.row])

    def _edited(self, name: str, value: Any, settled: bool) -> None:
        try:
            self.solving.edit(name, value, settled)
        except ConcordError as error:
            self.failed.emit(str(error), "")
            self._show_parameters(self.session.state)

    def toggle_truth(self) -> None:
        """Mark the errors where the truth is known, or mark them no more."""
        state = self.session.state
        if state.marks is None:
            self.failed.emit("There is nothing to compare: only a solved puzzle that was cut from a picture has a truth.", "")
        else:
            self.session.update(overlay=not state.overlay)

    # --- what the state says

    def apply(self, old: PuzzleState, state: PuzzleState, names: frozenset[str]) -> None:
        """Draw the difference between two states."""
        if "dark" in names:
            for part in (self.view, self.bar, self.join):
                part.set_theme(theme(state.dark))
        if "puzzle" in names:
            self.facts.show_puzzle(state.puzzle)
            for part in (self.panel, self.bar):
                part.setVisible(state.puzzle is not None)
        if names & {"puzzle", "solution"}:
            self._show_layout(old, state)
        if names & _MARKS:
            self._show_overlay(state)
        if names & {"parameters"}:
            self._show_parameters(state)
        self._show_bar()

    def _show_layout(self, old: PuzzleState, state: PuzzleState) -> None:
        self.invitation.setVisible(state.puzzle is None)
        if state.puzzle is None:
            self.view.show_layout(None)
            return
        same = old.puzzle is state.puzzle
        solved = state.solution is not None and len(state.solution.joins) > 0
        before = 0 if old.solution is None else int(old.solution.placed.sum())
        if same and solved and before < 0.1 * state.puzzle.count and self._lively():
            waiting = state.solution.placed if old.solution is None else state.solution.placed & ~old.solution.placed
            full = arrange(state.puzzle, state.solution, self.view.aspect, waiting)
            order = growth_order(state.solution.joins, state.solution.placed)
            self.view.grow(full, arrange(state.puzzle, state.solution, self.view.aspect), order[waiting[order]])
            return
        self.view.show_layout(arrange(state.puzzle, state.solution, self.view.aspect))
        if same and solved and old.solution is not None and len(old.solution.joins):
            self.view.flash(moved_pieces(old.solution, state.solution))

    def _lively(self) -> bool:
        """Whether the desktop wants things to move; a hidden page does not."""
        hint = QStyle.StyleHint.SH_Widget_Animation_Duration
        return self.isVisible() and self.style().styleHint(hint, None, self) > 0

    def _grown(self) -> None:
        state = self.session.state
        self.view.show_layout(arrange(state.puzzle, state.solution, self.view.aspect))
        self._show_overlay(state)

    def _show_overlay(self, state: PuzzleState) -> None:
        layout = self.view.layout_shown
        if layout is not None and not self.view.is_growing:
            self.view.show_overlay(overlay_of(state, layout))

    def _show_parameters(self, state: PuzzleState) -> None:
        self.form.show_values(state.parameters, PuzzleParameters())

    def _show_bar(self) -> None:
        self.bar.show_state(self.session.state, self.solving.jobs.busy("puzzle"))

    def shutdown(self) -> None:
        """Nothing of the graphics system is held."""
