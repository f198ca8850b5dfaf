"""Which matches a study asks about: a sample in strata, and which of it are overlapped, gold and practice. All pure.

Every draw is a hash of the seed and the item, a permanent random number (Ohlsson, in Business Survey Methods, 1995): a
larger sample holds the smaller one, and what is added later does not change what was drawn before.
"""

import hashlib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

from ..records import Practice

Known = Mapping[str, Practice]
NOTHING: Known = MappingProxyType({})


class Drawn(NamedTuple):
    """An item that is asked, as a row of the table `asked` (see `annotation.storage.schema`)."""

    item_id: str
    role: str
    answer: str | None
    reason: str
    stratum: str
    probability: float | None
    overlapped: bool


def draw(seed: str, purpose: str, of: str) -> str:
    """A reproducible random number, as hexadecimal digits."""
    return hashlib.sha256(f"{seed}\n{purpose}\n{of}".encode()).hexdigest()


def ordered(items: Iterable[str], seed: str, purpose: str) -> list[str]:
    """Items in an order drawn for a purpose."""
    return sorted(items, key=lambda item: draw(seed, purpose, item))


def sample(strata: Mapping[str, str], most: int, seed: str) -> dict[str, float]:
    """At most `most` items (all for 0), each with the probability with which it was drawn; `strata` tells that of each.

    Each stratum gives one item first and then in proportion to its size, by the rule of Sainte-Laguë, which never takes
    an item back when `most` grows; within it each item is as likely as any other. Where there are more strata than
    items to be asked, the strata are drawn as well.
    """
    if not most or most >= len(strata):
        return dict.fromkeys(sorted(strata), 1.0)
    groups: dict[str, list[str]] = {}
    for item in ordered(strata, seed, "sample"):
        groups.setdefault(strata[item], []).append(item)
    places = [
        ((0, 0.0) if rank == 0 else (1, -len(items) / (2 * rank + 1)), draw(seed, "stratum", name), name, item)
        for name, items in groups.items()
        for rank, item in enumerate(items)
    ]
    chosen = sorted(places)[:most]
    taken: dict[str, int] = {}
    for _, _, name, _ in chosen:
        taken[name] = taken.get(name, 0) + 1
    drawn = min(1.0, most / len(groups))  # of the strata
    return {item: drawn * taken[name] / len(groups[name]) for _, _, name, item in chosen}


def balanced(pool: Known, count: int, seed: str, purpose: str, first: Callable[[str], bool]) -> list[str]:
    """`count` items of known answer, those first that are `first`, and of these correct and wrong ones by turns."""
    turns: list[tuple[bool, int, str]] = []
    for liked in (True, False):
        for answer in ("correct", "wrong"):
            row = ordered((i for i, known in pool.items() if known.answer == answer and first(i) is liked), seed, purpose)
            turns += [(not liked, place, item) for place, item in enumerate(row)]
    return [item for _, _, item in sorted(turns, key=lambda turn: (*turn[:2], draw(seed, purpose, turn[2])))][:count]


def gold_wanted(items: int, share: float, least: int) -> int:
    """How many gold items a study of so many is to have; none where the share is 0."""
    return max(least, math.ceil(share * items - 1e-9)) if share else 0


def overlapped(items: Sequence[str], share: float, seed: str) -> frozenset[str]:
    """The share of the items that gets all votes."""
    return frozenset(ordered(items, seed, "overlap")[: math.ceil(share * len(items) - 1e-9)])
