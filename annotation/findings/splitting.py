"""A part of the pairs held out: parameters are chosen on the others, and figures told on these."""

import hashlib
from typing import NamedTuple

from engine.errors import BadParameter

from .gathering import Votes


class Split(NamedTuple):
    """The same votes over two parts of the pairs; nothing of one part is in the other. `names` are the pairs held out."""

    held_out: Votes
    others: Votes
    names: tuple[str, ...]


def split(votes: Votes, count: int, seed: int = 0) -> Split:
    """Hold out `count` pairs, drawn by their content and a seed: the same in every copy of a study.

    Raises `BadParameter` unless at least one pair is left on either side.
    """
    pairs = sorted({result.pair for result in votes.results}, key=lambda pair: _draw(seed, pair))
    if not 1 <= count < len(pairs):
        raise BadParameter(f"{count} of {len(pairs)} pairs cannot be held out; hold out at least 1 and leave at least 1.")
    chosen = frozenset(pairs[:count])
    parts = [
        votes._replace(results=tuple(r for r in votes.results if (r.pair in chosen) is inside), held_out=inside)
        for inside in (True, False)
    ]
    names = sorted({result.name or result.pair[:12] for result in parts[0].results})
    return Split(parts[0], parts[1], tuple(names))


def _draw(seed: int, pair: str) -> str:
    return hashlib.sha256(f"{seed}\nheld out\n{pair}".encode()).hexdigest()
