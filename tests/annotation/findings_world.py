"""Results and votes by letters: matches are named by what makes them distinct, votes are c, w and u."""

from collections.abc import Mapping

from annotation.findings.gathering import Votes
from annotation.findings.precision import Ballot, Proposed

WORDS = {"c": "correct", "w": "wrong", "u": "unsure"}


def ran(method: str, pair: str, items: str, set_name: str = "lamps") -> Proposed:
    """A method proposed matches on a pair; items are words apart."""
    return Proposed(method, method, set_name, pair, "{}", tuple(items.split()), pair)


def cast(**votes: str) -> list[Ballot]:
    """Votes by item, a letter a volunteer (anna, bert, carl, dora, …); a dot is no vote."""
    names = ("anna", "bert", "carl", "dora", "emil", "fred")
    return [Ballot(item, names[k], WORDS[letter]) for item, row in votes.items() for k, letter in enumerate(row) if letter != "."]


def read(results: list[Proposed], ballots: list[Ballot], weights: Mapping[str, float] | None = None, **values: object) -> Votes:
    """What is read of a study."""
    items = {item for result in results for item in result.items}
    return Votes("Lamps", False, tuple(results), tuple(ballots), weights, frozenset(), {}, dict.fromkeys(items, "shape"))._replace(
        **values)  # fmt: skip
