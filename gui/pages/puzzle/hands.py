"""What hands do to a puzzle, as changes of the session: lock, reject, carry, turn, take back."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from PySide6.QtCore import QObject, Signal

from engine.puzzles.solution import Pin, PuzzleSolution, Wishes

from ...session import Session
from ...views.puzzle_layout import Layout, outlines, turned_sizes
from ...views.puzzle_scene import join_key, join_keys, next_in
from .contacts import contacts
from .edits import (
    NO_WISHES,
    chosen,
    empty_solution,
    forbid,
    group,
    joins_of_piece,
    lock,
    one,
    pin,
    placed_by_hand,
    released,
    shifted,
    taken_out,
    unpin,
    upright,
    without,
)
from .judging import shown_join
from .overlay import join_text
from .state import PuzzleState, by_worst, frame_known, opened


class Hands(QObject):
    """Turns what a hand does into wishes, and shows at once what it did; the solver follows."""

    said = Signal(str)
    """a sentence for a hand that asked for what cannot be done"""

    def __init__(self, session: Session, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.session = session

    def lock(self) -> None:
        """Hold the join that is looked at, or the chosen piece where it stands; or let it go."""
        state: PuzzleState = self.session.state
        joins, row = shown_join(state)
        if joins is not None:
            wanted = one(joins, row)
            self._wish(lock(state.wishes, wanted, single=state.puzzle.square is not None), selected=join_keys(wanted)[0], preview=None)
        elif state.piece >= 0 and any(p.piece == state.piece for p in state.wishes.pinned):
            self._wish(unpin(state.wishes, [state.piece]))
        elif state.piece >= 0 and state.solution is not None and state.solution.placed[state.piece]:
            self._wish(pin(state.wishes, [pin_of(state.solution, state.piece)]))
        else:
            self.said.emit("Choose a join or a placed piece first, then lock it; N goes to the most doubtful join.")

    def reject(self) -> None:
        """Forbid the join that is looked at, or all joins of the chosen piece."""
        state: PuzzleState = self.session.state
        joins, row = shown_join(state)
        if joins is not None:
            self._wish(forbid(state.wishes, one(joins, row)), selected=None, preview=None)
        elif state.piece >= 0 and state.solution is not None and state.solution.placed[state.piece]:
            self.put_back(state.piece)
        else:
            self.said.emit("Choose a join or a placed piece first, then reject it; N goes to the most doubtful join.")

    def put_back(self, piece: int) -> None:
        """Take a piece out of the picture: the joins that it has there may not come back."""
        state: PuzzleState = self.session.state
        wrong = joins_of_piece(state.solution.joins, piece)
        wishes = unpin(state.wishes, [piece])
        wishes = forbid(wishes, wrong) if len(wrong) else wishes
        self._wish(wishes, solution=taken_out(state.solution, [piece]), selected=None, preview=None, piece=piece)

    def carry(self, layout: Layout, piece: int, x: int, y: int) -> None:
        """Put a piece, with what is locked to it, where a hand has let it go: it stays there, or lies in the tray."""
        state: PuzzleState = self.session.state
        middle = np.array([x, y]) + layout.size[piece] / 2
        placed = state.solution is not None and bool(state.solution.placed[piece])
        if layout.tray is not None and layout.tray.holds(*middle):
            if placed:
                self.put_back(piece)
            return
        before = state.solution or empty_solution(state.puzzle, state.parameters)
        picture = nearest_picture(layout, middle)
        corner = layout.pictures[picture][:2] if layout.pictures else (x, y)
        turns = int(before.turns[piece]) if placed else 0
        goal = Pin(piece, x - int(corner[0]), y - int(corner[1]), turns)
        goal = within(state, goal, layout.pictures[picture][2:] if layout.pictures else None)
        carried = [goal]
        if placed:
            step = (goal.x - int(before.position[piece][0]), goal.y - int(before.position[piece][1]))
            others = [pin_of(before, k) for k in group(piece, state.wishes.locked) - {piece} if before.placed[k]]
            carried += [p._replace(x=p.x + step[0], y=p.y + step[1]) for p in others]
        pinned = {p.piece for p in state.wishes.pinned}
        held = [goal, *(p for p in carried[1:] if p.piece in pinned)]
        self._hold(before, carried, pin(state.wishes, held), picture, piece)

    def _settled(self, before: PuzzleSolution, after: PuzzleSolution, moved: frozenset[int], wishes: Wishes) -> Wishes:
        """Without a frame a place means its neighbours: hold the joins at the new place, forbid those that were left."""
        puzzle = self.session.state.puzzle
        there = contacts(puzzle, after, moved)
        new = set(join_keys(there))
        ours = np.isin(before.joins.sides[:, [0, 2]], list(moved))
        left = chosen(before.joins, ours.any(axis=1) & ~ours.all(axis=1))
        left = without(left, new)
        wishes = forbid(wishes, left) if len(left) else wishes
        for row, key in enumerate(join_keys(there)):
            if key not in join_keys(wishes.locked):
                wishes = lock(wishes, one(there, row), single=puzzle.square is not None)
        return wishes

    def turn(self) -> None:
        """Turn the chosen piece clockwise by a quarter where it stands."""
        state: PuzzleState = self.session.state
        if state.piece < 0 or state.solution is None or not state.solution.placed[state.piece]:
            self.said.emit("Choose a placed piece first, then turn it; pieces in the tray are turned where they are put.")
            return
        if not state.puzzle.turned:
            self.said.emit("These pieces are not turned; say under Parameters that they may be.")
            return
        old = pin_of(state.solution, state.piece)
        new = old._replace(quarter_turns=(old.quarter_turns + 1) % 4)
        self._hold(state.solution, [new], pin(state.wishes, [new]), int(state.solution.picture[state.piece]), state.piece)

    def declare(self, turned: bool, pictures: int) -> None:
        """Say that pieces may be turned, or that several pictures are mixed; what was solved is solved again."""
        state: PuzzleState = self.session.state
        puzzle = state.puzzle
        if puzzle is None or (puzzle.turned, puzzle.pictures) == (turned, pictures):
            return
        wishes = state.wishes if turned or not state.wishes else upright(state.wishes)
        frame = puzzle.frame if pictures == 1 else None  # the size of one picture says nothing of several
        self.session.update(**opened(replace(puzzle, turned=turned, pictures=pictures, frame=frame), state.truth, state.origin,
                                     wishes) | {"asked": state.asked})  # fmt: skip

    def taken_back(self) -> list[tuple[str, Callable[[], object]]]:
        """Every lock, rejection and pin in words, the newest first, and what takes it back."""
        state: PuzzleState = self.session.state
        if state.puzzle is None:
            return []
        turns = np.zeros(state.puzzle.count, np.int64) if state.solution is None else state.solution.turns
        found: list[tuple[str, Callable[[], object]]] = []
        for joins, word in ((state.wishes.locked, "Locked"), (state.wishes.forbidden, "Rejected")):
            for row, key in enumerate(join_keys(joins)):
                words = f"{word}:  {join_text(state.puzzle, turns, joins, row)}"
                found.append((words, lambda key=key: self._wish(released(self.session.state.wishes, key))))
        for p in state.wishes.pinned:
            words = f"Pinned:  {state.puzzle.pieces[p.piece].name or f'piece {p.piece + 1}'}"
            found.append((words, lambda piece=p.piece: self._wish(unpin(self.session.state.wishes, [piece]))))
        return found[::-1]

    def clear(self) -> None:
        """Forget all locks, rejections and pins."""
        if self.session.state.wishes:
            self._wish(NO_WISHES)

    def step(self, by: int) -> None:
        """Look at the next join in the order of doubt, or the one before."""
        state: PuzzleState = self.session.state
        if state.solution is None or not len(state.solution.joins):
            self.said.emit("There are no joins yet; press Solve first.")
            return
        row = next_in(np.array(by_worst(state), np.int64), state.row, by)
        if row >= 0:
            self.session.update(selected=join_key(state.solution.joins.sides[row]), preview=None, piece=-1)
        else:
            self.said.emit("No join is less certain than the slider says; move it to the right to see more.")

    def _hold(self, before: PuzzleSolution, carried: list[Pin], wishes: Wishes, picture: int, piece: int) -> None:
        puzzle = self.session.state.puzzle
        solution = placed_by_hand(puzzle, before, carried, picture)
        if not frame_known(self.session.state):
            wishes = self._settled(before, solution, frozenset(p.piece for p in carried), wishes)
            solution, wishes = shifted(puzzle, solution, wishes)
        self._wish(wishes, solution=solution, selected=None, preview=None, piece=piece)

    def _wish(self, wishes: Wishes, **changes: Any) -> None:
        """One step of the history; `marks` and names belong to a solution and go when a hand changes it."""
        gone = {"marks": None, "items": (), "solved_with": None} if "solution" in changes else {}
        self.session.update(wishes=wishes, **changes, **gone)


def pin_of(solution: PuzzleSolution, piece: int) -> Pin:
    """A piece held where a solution has it."""
    x, y = solution.position[piece].tolist()
    return Pin(piece, x, y, int(solution.turns[piece]))


def within(state: PuzzleState, goal: Pin, size: tuple[float, float] | None) -> Pin:
    """A pin that does not reach out of a picture of known size (w, h); equal squares stand on their grid."""
    px = state.puzzle.square
    if px:
        goal = goal._replace(x=px * round(goal.x / px), y=px * round(goal.y / px))
    if size is None or not frame_known(state):
        return goal
    w, h = turned_sizes(outlines(state.puzzle).size[[goal.piece]], np.array([goal.quarter_turns]))[0].tolist()
    return goal._replace(x=max(0, min(goal.x, int(size[0]) - w)), y=max(0, min(goal.y, int(size[1]) - h)))


def nearest_picture(layout: Layout, at: np.ndarray) -> int:
    """The picture whose area is nearest to a point, 0 where there is none."""
    away = [max(a.x - at[0], at[0] - a.x - a.w, 0) + max(a.y - at[1], at[1] - a.y - a.h, 0) for a in layout.pictures]
    return int(np.argmin(away)) if away else 0


