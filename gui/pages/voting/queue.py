"""In which order one volunteer is asked, as it stands in one window: a frozen list that every vote makes anew."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Self

from annotation.records import OpenItem, VotingProgress
from annotation.voting.answering import seconds_each


@dataclass(frozen=True, slots=True)
class Queue:
    """What is open by the study as it was last read, and what happened since in this window.

    `open` is in the volunteer's order, practice first. `answered` says at which `step` an item was answered here,
    `skipped` what was left for the end, `hidden` what cannot be shown here; `spent` are the milliseconds (None: unknown)
    of each vote that counts, practice apart.
    """

    open: tuple[OpenItem, ...] = ()
    answered: Mapping[OpenItem, int] = field(default_factory=dict)
    skipped: tuple[OpenItem, ...] = ()
    hidden: frozenset[OpenItem] = frozenset()
    spent: tuple[int | None, ...] = ()
    step: int = 0

    def upcoming(self, most: int = 64) -> tuple[OpenItem, ...]:
        """What is to be asked next, at most so many; what was skipped comes after all else, in the order of skipping."""
        later, found = set(self.skipped), []
        for one in self.open:
            if one not in self.answered and one not in self.hidden and one not in later:
                found.append(one)
                if len(found) == most:
                    return tuple(found)
        waiting = set(self.open) - self.answered.keys() - self.hidden
        return tuple([*found, *(one for one in self.skipped if one in waiting)][:most])

    def answer(self, one: OpenItem, milliseconds: int | None, *, again: bool = False) -> Self:
        """An item was answered (`again`: its earlier answer was replaced)."""
        spent = self.spent if again or one.round == 0 else (*self.spent, milliseconds)
        return replace(self, answered={**self.answered, one: self.step + 1}, spent=spent, step=self.step + 1)

    def elsewhere(self, ones: Iterable[OpenItem]) -> Self:
        """Items that the same volunteer has answered in another window."""
        queue = self
        for one in ones:
            queue = queue.answer(one, None)
        return queue

    def settle(self, ones: Iterable[OpenItem]) -> Self:
        """Items that the votes of others have settled."""
        gone = set(ones)
        return replace(self, open=tuple(one for one in self.open if one not in gone)) if gone else self

    def skip(self, one: OpenItem) -> Self:
        """Leave an item for the end, after those that were left before."""
        return replace(self, skipped=(*(other for other in self.skipped if other != one), one))

    def hide(self, one: OpenItem) -> Self:
        """An item cannot be shown here."""
        return replace(self, hidden=self.hidden | {one})

    def reopen(self, one: OpenItem, *, standing: bool = False) -> Self:
        """An answer was taken back: its item comes first; `standing` where an older answer to it counts again."""
        rest = tuple(other for other in self.open if other != one)
        left = {other: step for other, step in self.answered.items() if other != one}
        spent = self.spent if one.round == 0 or standing else self.spent[:-1]
        return replace(self, open=(one, *rest), answered=left, spent=spent, step=self.step + 1,
                       skipped=tuple(other for other in self.skipped if other != one))  # fmt: skip

    def refresh(self, found: Iterable[OpenItem], step: int) -> Self:
        """The study was read again, beginning after `step`; what was answered here since then stays answered."""
        later = {one: when for one, when in self.answered.items() if when > step}
        kept = self.open if self.step > step else ()  # something taken back meanwhile is not lost
        new = tuple(found)
        known = set(new)
        first = tuple(one for one in kept[:1] if one not in known and one not in self.answered)
        return replace(self, open=(*first, *new), answered=later)

    def progress(self) -> VotingProgress:
        """How many of how many are answered (practice and what cannot be shown apart), and the seconds left."""
        left = sum(one.round > 0 and one not in self.answered and one not in self.hidden for one in self.open)
        pace = seconds_each([ms for ms in self.spent if ms is not None])
        return VotingProgress(len(self.spent), len(self.spent) + left, None if pace is None else pace * left)

    def practising(self, one: OpenItem) -> tuple[int, int]:
        """Which of how many practice items an item is, as far as this window knows."""
        items = [other for other in {**dict.fromkeys(self.answered), **dict.fromkeys(self.open)} if other.round == 0]
        before = sum(other in self.answered and other != one for other in items)
        return before + 1, max(len(items), before + 1)
