"""Keeps the result in step with the inputs and parameters of the session: what has to run, and running it."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from engine.parameters import declared
from engine.progress import Progress, share
from engine.shapes.carrying import carried
from engine.shapes.parameters import LEARNED, MatchParameters, preset
from engine.shapes.segmentation import SegmentedShape
from engine.shapes.wishes import NO_WISHES, Wishes
from engine.store import default_cache

from ...jobs import FOLLOW, Jobs
from ...session import Session, State
from .arrange import main_ids

if TYPE_CHECKING:
    from engine.shapes.proposing import Proposals

NOTHING, REMATCH, JUDGE, MATCH = "nothing", "rematch", "judge", "match"
_SLOW = tuple(info.name for info in declared(MatchParameters) if not info.live)


def slow_values(parameters: MatchParameters) -> tuple[Any, ...]:
    """The values whose change needs more than the affinity, pruning and voting."""
    return tuple(getattr(parameters, name) for name in _SLOW)


def needed(state: State) -> str:
    """What has to run so that the result is that of the inputs and parameters."""
    if state.source is None or state.target is None:
        return NOTHING
    wanted = (state.parameters, state.preset, state.wishes)
    if state.result is not None and (state.result.parameters, state.result.preset, state.result.wishes) == wanted:
        return NOTHING
    ready = state.proposals is not None and state.prepared_with is not None
    if not ready or slow_values(state.prepared_with) != slow_values(state.parameters):
        return MATCH
    if state.parameters.method != LEARNED:
        return REMATCH
    from engine.shapes.proposing import is_judged

    return REMATCH if is_judged(state.proposals) else JUDGE


def lost_text(lost: int) -> str:
    """What happened to wishes that other labels do not have."""
    one = lost == 1
    return (f"{lost} pinned or forbidden {'match does' if one else 'matches do'} not fit the new labels and "
            f"{'was' if one else 'were'} dropped.")  # fmt: skip


def set_name_of(path: str) -> str:
    """The set that a pair belongs to unless said otherwise: the folder of the source."""
    return Path(path).resolve().parent.name


class Matching(QObject):
    """Loads pairs, runs the matching in a worker, and re-matches while a live parameter moves."""

    opened = Signal(str, str)
    took = Signal(float)
    """seconds that the last answer took"""
    dropped = Signal(str)
    """a sentence on pinned or forbidden matches that other labels do not have"""

    def __init__(self, session: Session, jobs: Jobs, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.session, self.jobs = session, jobs
        self.cache = default_cache()
        self._key: tuple[Any, ...] = ()
        self._judging: Any = None
        session.changed.connect(self._changed)

    def open_pair(self, source: str, target: str, labels: tuple[str | None, str | None] = (None, None),
                  set_name: str = "", choose: str = "") -> None:  # fmt: skip
        """Read two files in the worker, then show and match them; the pair shown before stays if one is bad."""

        def work(progress: Progress) -> tuple[SegmentedShape, SegmentedShape]:
            from engine.shapes.meshfile import load_shape

            progress(0.0, "Reading")
            first = load_shape(source, labels[0], progress=share(progress, 0.0, 0.5), cache=self.cache)
            progress(0.5, "Reading")
            return first, load_shape(target, labels[1], progress=share(progress, 0.5, 1.0), cache=self.cache)

        def done(pair: tuple[SegmentedShape, SegmentedShape]) -> None:
            self.show_pair(*pair, set_name=set_name or set_name_of(source), choose=choose)
            self.opened.emit(source, target)

        self.jobs.cancel("match")
        self.jobs.start("load", work, done, words="Reading")

    def show_pair(self, source: SegmentedShape, target: SegmentedShape, set_name: str = "", choose: str = "") -> None:
        """Put two shapes on the table and match them; wishes stay as far as the labels still have what they are about."""
        before = self.session.state
        wishes = self._carried(before, source, target)
        chosen = {"preset": choose, "parameters": preset(choose)} if choose else {}
        self.session.update(source=source, target=target, set_name=set_name, proposals=None, prepared_with=None,
                            result=None, main=frozenset(), selected="", layer=0, node=-1, wishes=wishes, **chosen)  # fmt: skip

    def edit(self, name: str, value: Any, settled: bool) -> None:
        """Change one parameter; successive changes while a hand moves are one step of the history."""
        parameters = self.session.state.parameters.changed(**{name: value})
        self.session.update(merge=name, parameters=parameters)
        if settled:
            self.session.settle()

    def choose_preset(self, name: str) -> None:
        """Take all values of a preset."""
        self.session.update(preset=name, parameters=preset(name))

    def cancel(self) -> None:
        """Stop what runs and go back to the parameters that the shown matches were found with."""
        self.jobs.cancel()
        self._key = ()
        result = self.session.state.result
        state = self.session.state
        if result is not None and (result.parameters, result.wishes) != (state.parameters, state.wishes):
            self.session.update(parameters=result.parameters, preset=result.preset or state.preset, wishes=result.wishes)

    def again(self) -> None:
        """Match the pair that is shown if that was stopped or failed."""
        self._changed(self.session.state, self.session.state, frozenset({"parameters"}))

    def prepare(self) -> None:
        """Make ready what the layers and live parameters need, for a result that came from elsewhere."""
        state = self.session.state
        if state.source is not None and state.target is not None and state.proposals is None:
            self._start_match(state)

    def _changed(self, old: State, state: State, names: frozenset[str]) -> None:
        if names & {"source", "target"} and state.wishes and state.wishes is old.wishes and self._carry(old, state):
            return
        if not names & {"source", "target", "parameters", "preset", "proposals", "result", "wishes"}:
            return
        what = needed(state)
        for channel in ({"match"} if what != MATCH else set()) | ({"judge"} if what != JUDGE else set()):
            if self.jobs.busy(channel):
                self.jobs.cancel(channel)
        if what == REMATCH:
            self._start_rematch(state)
        elif what == JUDGE:
            self._start_judging(state.proposals)
        elif what == MATCH:
            self._start_match(state)

    def _carry(self, old: State, state: State) -> bool:
        """Let wishes follow shapes that were exchanged under them (segments edited); whether they had to change."""
        found = self._carried(old, state.source, state.target)
        if found == state.wishes:
            return False
        self.session.update(record=False, wishes=found)
        return True

    def _carried(self, old: State, source: SegmentedShape | None, target: SegmentedShape | None) -> Wishes:
        """The wishes of a state for other shapes; says what is lost where only the labels are others."""
        if not old.wishes or None in (old.source, old.target, source, target):
            return NO_WISHES
        found, lost = carried(old.wishes, (old.source, old.target), (source, target))
        if lost and (old.source.mesh.name, old.target.mesh.name) == (source.mesh.name, target.mesh.name):
            self.dropped.emit(lost_text(lost))
        return found

    def _start_rematch(self, state: State) -> None:
        from engine.shapes.matching import rematch

        proposals, parameters, chosen, wishes = state.proposals, state.parameters, state.preset, state.wishes

        def work(_: Progress) -> tuple[Any, frozenset[str]]:
            result = rematch(proposals, parameters, preset=chosen, wishes=wishes)
            return result, main_ids(result)

        def done(answer: tuple[tuple[Any, frozenset[str]], float]) -> None:
            (result, main), seconds = answer
            if self.session.state.proposals is proposals:
                self._take(seconds, result=result, main=main)

        self.jobs.start("rematch", _timed(work), done, policy=FOLLOW)

    def _start_judging(self, proposals: "Proposals") -> None:
        """Let the learned method look at pairs that were made for another one, which takes a second or two."""
        from engine.shapes.proposing import with_judgement

        if self._judging is proposals and self.jobs.busy("judge"):
            return  # under way; what is live follows when it has come
        self._judging = proposals
        self.jobs.start("judge", lambda progress: with_judgement(proposals, progress=progress), lambda _: self.again(),
                        words="Judging pairs")  # fmt: skip

    def _start_match(self, state: State) -> None:
        key = (id(state.source), id(state.target), slow_values(state.parameters))
        if key == self._key and self.jobs.busy("match"):
            return  # under way; what is live follows when it has come
        self._key = key
        source, target, parameters, chosen, cache = state.source, state.target, state.parameters, state.preset, self.cache
        wishes = state.wishes

        def work(progress: Progress) -> tuple[Any, Any, frozenset[str]]:
            from engine.shapes.matching import describe, propose, rematch

            first = describe(source, parameters, progress=share(progress, 0.0, 0.45), cache=cache)
            second = describe(target, parameters, progress=share(progress, 0.45, 0.9), cache=cache)
            proposals = propose(first, second, parameters, progress=share(progress, 0.9, 0.98), cache=cache)
            result = rematch(proposals, parameters, preset=chosen, wishes=wishes)
            return proposals, result, main_ids(result)

        def done(answer: tuple[tuple[Any, Any, frozenset[str]], float]) -> None:
            now = self.session.state
            if now.source is source and now.target is target and slow_values(now.parameters) == key[2]:
                (proposals, result, main), seconds = answer
                self._take(seconds, proposals=proposals, prepared_with=parameters, result=result, main=main)

        self.jobs.start("match", _timed(work), done, words="Matching", failed=self._failed)

    def _failed(self, sentence: str, details: str) -> None:
        self._key = ()
        self.jobs.failed.emit(sentence, details)

    def _take(self, seconds: float, **changes: Any) -> None:
        """Amend the present state by an answer; keep the selection if the match is still there."""
        kept = self.session.state.selected
        if kept not in changes["result"].ids:
            changes["selected"] = ""
        self.took.emit(seconds)
        self.session.update(record=False, **changes)


def _timed(work: Callable[[Progress], Any]) -> Callable[[Progress], tuple[Any, float]]:
    def run(progress: Progress) -> tuple[Any, float]:
        began = time.perf_counter()
        value = work(progress)
        return value, time.perf_counter() - began

    return run


