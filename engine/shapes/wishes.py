"""What people want of a matching: matches that must come, pinned, and matches that must not, forbidden."""

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from ..errors import BadInput

Node = tuple[int, ...]
Pair = tuple[Node, Node]


@dataclass(frozen=True, slots=True)
class Wishes:
    """Matches by the rows (0..s-1) of the segments that they unite: ((source segments), (target segments)).

    A pinned match is accepted before all others; a forbidden one is never accepted, though parts of it, or unions that
    hold it, still may be. Equal wishes are equal and hash alike; their order does not matter. Raises `BadInput` in one
    sentence where they contradict each other: a node pinned to two partners, or a match both pinned and forbidden.
    """

    pinned: tuple[Pair, ...] = ()
    forbidden: tuple[Pair, ...] = ()

    def __post_init__(self) -> None:
        pinned, forbidden = (_tidy(pairs) for pairs in (self.pinned, self.forbidden))
        sentence = contradiction(pinned, forbidden)
        if sentence:
            raise BadInput(sentence)
        object.__setattr__(self, "pinned", pinned)
        object.__setattr__(self, "forbidden", forbidden)

    def __bool__(self) -> bool:
        return bool(self.pinned or self.forbidden)

    def pin(self, pair: Pair) -> "Wishes":
        """These wishes and a pin, which takes the place of what it contradicts."""
        kept = [p for p in self.pinned if p[0] != pair[0] and p[1] != pair[1]]
        return Wishes((*kept, pair), tuple(p for p in self.forbidden if p != pair))

    def forbid(self, pair: Pair) -> "Wishes":
        """These wishes and a forbidden match, which is pinned no more."""
        return Wishes(tuple(p for p in self.pinned if p != pair), (*self.forbidden, pair))

    def without(self, pair: Pair) -> "Wishes":
        """These wishes without any about one match."""
        return Wishes(*(tuple(p for p in pairs if p != pair) for pairs in (self.pinned, self.forbidden)))

    def then(self, other: "Wishes") -> "Wishes":
        """These wishes and others, which take the place of what they contradict."""
        found = self
        for pair in other.forbidden:
            found = found.forbid(pair)
        for pair in other.pinned:
            found = found.pin(pair)
        return found

    def turned(self) -> "Wishes":
        """The same wishes with source and target exchanged."""
        return Wishes(*(tuple((t, s) for s, t in pairs) for pairs in (self.pinned, self.forbidden)))


def _tidy(pairs: Iterable[Pair]) -> tuple[Pair, ...]:
    """Each pair once, in order, its segments too; raises `BadInput` for a side without segments."""
    found = {(tuple(sorted(set(map(int, s)))), tuple(sorted(set(map(int, t))))) for s, t in pairs}
    if any(not s or not t or s[0] < 0 or t[0] < 0 for s, t in found):
        raise BadInput("A pinned or forbidden match needs at least one segment on either side, numbered from 0.")
    return tuple(sorted(found))


def contradiction(
    pinned: Iterable[tuple[tuple[Hashable, ...], tuple[Hashable, ...]]],
    forbidden: Iterable[tuple[tuple[Hashable, ...], tuple[Hashable, ...]]],
) -> str:
    """One sentence on the first wishes that exclude each other, by whatever names their segments go; '' if none do."""
    pinned, forbidden = list(pinned), set(forbidden)
    partners: tuple[dict[Any, Any], dict[Any, Any]] = ({}, {})
    for pair in pinned:
        if pair in forbidden:
            return f"{pair_text(pair)} is both pinned and forbidden; decide for one."
        for side, known in enumerate(partners):
            other = known.setdefault(pair[side], pair[1 - side])
            if other != pair[1 - side]:
                where = ("source", "target")[side]
                return (f"{union_text(pair[side])} of the {where} is pinned to both {union_text(other)} and "
                        f"{union_text(pair[1 - side])}; keep one of the two pins.")  # fmt: skip
    return ""


def union_text(segments: Sequence[Hashable]) -> str:
    """'4' or '{2, 3}'."""
    return str(segments[0]) if len(segments) == 1 else "{" + ", ".join(map(str, segments)) + "}"


def pair_text(pair: tuple[Sequence[Hashable], Sequence[Hashable]]) -> str:
    """'1 → {2, 3}'."""
    return f"{union_text(pair[0])} → {union_text(pair[1])}"


def check_segments(wishes: Wishes, source: int, target: int) -> None:
    """Raise `BadInput` where a wish names a segment that shapes of so many segments do not have."""
    for pair in (*wishes.pinned, *wishes.forbidden):
        for union, count, where in zip(pair, (source, target), ("source", "target"), strict=True):
            if union[-1] >= count:
                raise BadInput(f"The wish {pair_text(pair)} names segment {union[-1]} of the {where}, which has "
                               f"the segments 0 to {count - 1}.")  # fmt: skip


NO_WISHES = Wishes()
