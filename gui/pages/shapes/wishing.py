"""Pinning and forbidding matches by hand, by the volunteer's own answers, or by the majority of the study's votes."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QFileDialog

from engine.shapes.wishes import NO_WISHES, Pair, Wishes

from ...session import Session, State
from ..judging import Judging

if TYPE_CHECKING:
    from ...main_window import MainWindow

WISHES = "Pinned and forbidden matches (*.json)"
FILE_NAME = "wishes.json"


def answered_wishes(wishes: Wishes, answers: Mapping[str, str], pairs: Mapping[str, Pair]) -> Wishes:
    """The wishes after the answers to known matches: correct is pinned, wrong forbidden, unsure neither.

    Of two that contradict each other the later answer stays.
    """
    for match_id, answer in answers.items():
        if match_id in pairs:
            pair = pairs[match_id]
            wishes = {"correct": wishes.pin, "wrong": wishes.forbid}.get(answer, wishes.without)(pair)
    return wishes


def wish_of(state: State, match_id: str) -> str:
    """'pinned', 'forbidden' or '' for a match of a state."""
    match = state.match(match_id)
    pair = None if match is None else (match.source, match.target)
    return "pinned" if pair in state.wishes.pinned else "forbidden" if pair in state.wishes.forbidden else ""


def count_text(wishes: Wishes) -> str:
    """'2 pinned, 1 forbidden', or how to begin."""
    parts = [f"{len(pairs)} {word}" for pairs, word in ((wishes.pinned, "pinned"), (wishes.forbidden, "forbidden")) if pairs]
    return ", ".join(parts) or "nothing pinned or forbidden"


class Wishing(QObject):
    """What a hand or the votes wish of the matching goes into the session; the matching follows by itself."""

    said = Signal(str)

    def __init__(self, session: Session, judging: Judging, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.session, self.judging = session, judging
        self._pairs: dict[str, Pair] = {}
        session.changed.connect(self._changed)

    def pin(self) -> None:
        """Pin the selected match, or let it go again."""
        self._turn("pinned")

    def forbid(self) -> None:
        """Forbid the selected match, or allow it again."""
        self._turn("forbidden")

    def clear(self) -> None:
        """Forget all wishes and follow answers no longer."""
        self.session.update(wishes=NO_WISHES, bound=False)

    def bind(self, on: bool) -> None:
        """Let every answer make a wish, those given already too; or no longer."""
        if on == self.session.state.bound:
            return
        state = self.session.state
        if not on or state.source is None or state.target is None:
            self.session.update(bound=on)
        else:
            self._use_answers(state, record=True)

    def _use_answers(self, state: State, *, record: bool) -> None:
        """Make wishes of the answers given so far on a pair, and of all to come; `record` makes that a step of its own."""
        from annotation.results.votedwishes import known_pairs

        source, target = state.source, state.target

        def done(pairs: dict[str, Pair]) -> None:
            now = self.session.state
            if now.source is source and now.target is target:
                self._pairs |= pairs
                wishes = answered_wishes(now.wishes, now.answers, self._pairs)
                self.session.update(record=record, bound=True, wishes=wishes)

        self.judging.ask(lambda handle: known_pairs(handle, source, target), done)

    def use_votes(self) -> None:
        """Pin what the majority of the open study calls correct, and forbid what it calls wrong."""
        state = self.session.state
        if state.source is None or state.target is None:
            self.said.emit("There is no pair to take votes for; open two meshes first.")
            return
        source, target = state.source, state.target
        from annotation.results.votedwishes import VotedWishes, voted_wishes

        def done(found: VotedWishes) -> None:
            now = self.session.state
            if now.source is source and now.target is target:
                if found.wishes:
                    self.session.update(wishes=now.wishes.then(found.wishes))
                self.said.emit(found.sentence())

        self.judging.ask(lambda handle: voted_wishes(handle, source, target), done)

    def _turn(self, wish: str) -> None:
        state = self.session.state
        match = state.match(state.selected)
        if match is None:
            self.said.emit("Select a match first, in the list or in the view.")
            return
        pair = (match.source, match.target)
        now = wish_of(state, match.id)
        change = state.wishes.without if now == wish else state.wishes.pin if wish == "pinned" else state.wishes.forbid
        self.session.update(wishes=change(pair))

    def _changed(self, old: State, state: State, names: frozenset[str]) -> None:
        if names & {"source", "target"}:
            self._pairs.clear()
            if state.bound and state.result is None and state.source is not None and state.target is not None:
                self._use_answers(state, record=False)
        if "result" in names:
            self._pairs |= {m.id: (m.source, m.target) for m in state.matches()}
        if "answers" in names and state.bound and "volunteer" not in names:
            new = {i: state.answers.get(i, "unsure") for i in {*old.answers, *state.answers}
                   if state.answers.get(i) != old.answers.get(i)}  # fmt: skip
            self.session.update(wishes=answered_wishes(state.wishes, new, self._pairs))


class WishFiles(QObject):
    """Writing and reading the wishes of the shown pair; everything that fails becomes a message."""

    def __init__(self, window: "MainWindow") -> None:
        super().__init__(window)
        self.window = window

    def save(self) -> None:
        """Ask where to, and write the wishes."""
        if not self.window.session.state.wishes:
            self.window.say("Nothing is pinned or forbidden yet; select a match and press K or X.")
            return
        start = str(Path(self.window.files.folder) / FILE_NAME)
        path, _ = QFileDialog.getSaveFileName(self.window, "Save what is pinned and forbidden", start, WISHES)
        if path:
            self.write(Path(path))

    def write(self, path: Path) -> None:
        """Write the wishes to a file."""
        from engine.shapes.wishfile import write_wishes

        state = self.window.session.state
        self.window.attempt(lambda: write_wishes(path, state.wishes, state.source, state.target), f"{count_text(state.wishes)}: {path}")

    def open(self) -> None:
        """Ask for a file of wishes and take them over."""
        if self.window.session.state.source is None:
            self.window.say("There is no pair to pin matches of; open two meshes first.")
            return
        path, _ = QFileDialog.getOpenFileName(self.window, "Open pinned and forbidden matches", self.window.files.folder, WISHES)
        if path:
            self.read(Path(path))

    def read(self, path: Path) -> None:
        """Take over the wishes of a file."""
        from engine.shapes.wishfile import read_wishes

        state = self.window.session.state

        def work() -> None:
            self.window.session.update(wishes=read_wishes(path, state.source, state.target))

        self.window.attempt(work, f"Taken from {path}")
