"""Keeps the panel in step with the join that is looked at, and asks the solver who else could be its partner."""

from PySide6.QtCore import QObject

from engine.puzzles.pieces import Puzzle
from engine.puzzles.solution import Joins

from ...palette import theme
from ...session import Session
from ...views.join_closeup import Partner, PartnerStrip, pair_of
from ...views.puzzle_scene import bin_colours, bins, join_key, join_keys
from ..shapes.arrange import share_text
from .contacts import alike, turned_round
from .edits import one, together
from .judging import shown_join
from .overlay import join_text, side_text, why_text
from .panel import Asked, JoinPanel, Shown
from .partners import partners_of_side
from .state import PuzzleState, by_worst, wishes_counts

_SHOWN = {"selected", "preview", "solution", "piece", "wishes", "dark", "below", "puzzle", "prepared", "asked"}


class Looking(QObject):
    """Shows the selected join, or one that is tried out, in the panel."""

    def __init__(self, session: Session, panel: JoinPanel, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.session, self.panel = session, panel
        self.from_b = False  # whether the partners shown are those of piece b's side
        self._candidates: Joins | None = None
        session.changed.connect(self._changed)
        panel.partner_picked.connect(self._try)
        panel.other_side.connect(self._turn_round)
        self.show(session.state)

    def _changed(self, _old: PuzzleState, state: PuzzleState, names: frozenset[str]) -> None:
        if "selected" in names:
            self.from_b = False
        if names & _SHOWN:
            self.show(state)
        elif names & {"answers", "items", "volunteer"}:
            self._show_actions(state)

    def show(self, state: PuzzleState) -> None:
        """Show what a state looks at."""
        self._candidates = None
        joins, row = shown_join(state)
        if joins is None:
            self.panel.show_join(Shown(_heading(state), _advice(state), None, (), "", _pinned(state), False))
        else:
            self.panel.show_join(self._shown(state, joins, row))
        self._show_actions(state)

    def _show_actions(self, state: PuzzleState) -> None:
        joins, _ = shown_join(state)
        placed = state.solution is not None and state.piece >= 0 and bool(state.solution.placed[state.piece])
        wishes = " · ".join(f"{len(what)} {word}" for what, word in wishes_counts(state.wishes) if len(what))
        item = state.item or ("?" if joins is not None else "")
        self.panel.show_actions(joins is not None or placed, wishes, Asked(item, state.answers, state.volunteer, state.dark))

    def _shown(self, state: PuzzleState, joins: Joins, row: int) -> Shown:
        turns = state.solution.turns
        key = join_key(joins.sides[row])
        locked = key in join_keys(state.wishes.locked)
        facts = f"{join_text(state.puzzle, turns, joins, row)}\n{why_text(joins, row, locked)}"
        pair = pair_of(state.puzzle, joins, row, int(turns[joins.sides[row, 0]]))
        heading = "Tried out, not in the picture" if state.preview is not None else _rank(state)
        partners, words = self._partners(state, joins, row)
        return Shown(heading, facts, pair, partners, words, locked, state.preview is not None)

    def _partners(self, state: PuzzleState, joins: Joins, row: int) -> tuple[tuple[Partner, ...], str]:
        """The likeliest partners of one side of the selected join, and the one that it has."""
        chosen = state.selected or tuple(joins.sides[row].tolist())
        piece, side = chosen[2:] if self.from_b else chosen[:2]
        self._candidates = found = partners_of_side(state, piece, side)
        if found is None:
            return (), ""
        count = min(len(found), PartnerStrip.MOST)
        here = [k for k in range(len(found)) if alike(state.puzzle, joins, row, found, k)]
        listed = bool(here) and here[0] < count
        if state.preview is None and not listed:  # the solver has others in mind, but the picture has this one
            own = one(joins, row)
            found = together(own if own.sides[0, 0] == piece else turned_round(state.puzzle, joins, row), found)
            count, here = min(len(found), PartnerStrip.MOST), [0]
        self._candidates = found
        colours = bin_colours(theme(state.dark))[bins(found.confidence)]
        turns = state.solution.turns
        partners = tuple(
            Partner(pair_of(state.puzzle, found, k, int(turns[found.sides[k, 0]])), share_text(float(found.confidence[k])),
                    "#" + bytes(colours[k]).hex(), here[:1] == [k], partner_tip(state.puzzle, found, k, turns))
            for k in range(count)
        )  # fmt: skip
        return partners, f"Partners of {side_text(state.puzzle, turns, piece, side)}"

    def _try(self, k: int) -> None:
        """Look at another partner of the side: the one in the picture is selected, others are tried out."""
        state = self.session.state
        if self._candidates is None or k >= len(self._candidates):
            return
        there = state.row >= 0 and alike(state.puzzle, state.solution.joins, state.row, self._candidates, k)
        self.session.update(preview=None if there else one(self._candidates, k))

    def _turn_round(self) -> None:
        self.from_b = not self.from_b
        self.show(self.session.state)


def partner_tip(puzzle: Puzzle, found: Joins, k: int, turns: object) -> str:
    """What hovering over a partner says."""
    return f"{join_text(puzzle, turns, found, k)}\nClick to look at it; Lock then puts it into the picture."


def _heading(state: PuzzleState) -> str:
    if state.piece >= 0 and state.puzzle is not None:
        name = state.puzzle.pieces[state.piece].name
        return name.replace("piece", "Piece", 1) if name.startswith("piece ") else name or f"Piece {state.piece + 1}"
    return "Joins"


def _advice(state: PuzzleState) -> str:
    """What to do where no join is selected."""
    if state.puzzle is None:
        return ""
    if state.asked and state.solution is None:
        return "The picture will grow here. Esc stops."
    if state.solution is None or not len(state.solution.joins):
        return "Press Solve, or drag pieces out of the tray: they snap to each other."
    if state.piece >= 0 and not state.solution.placed[state.piece]:
        why = state.solution.why_unplaced.get(state.piece, "")
        return f"In the tray{': ' + why if why else ''}. Drag it to where it belongs; click it again for its other sides."
    if state.piece >= 0:
        return "Lock holds it where it stands; Reject takes it out; dragging moves it."
    return "N goes to the most doubtful join. Reject what is wrong, and the rest is arranged anew around it."


def _pinned(state: PuzzleState) -> bool:
    return any(p.piece == state.piece for p in state.wishes.pinned)


def _rank(state: PuzzleState) -> str:
    """'Join 3 of 17, most doubtful first'."""
    order = by_worst(state)
    return f"Join {order.index(state.row) + 1} of {len(order)} by doubt" if state.row in order else "Join"
