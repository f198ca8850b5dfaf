"""Results with matches by number, to be designed with: sets, pairs and sizes are named, nothing is computed."""

from collections.abc import Mapping

from annotation.records import Item, Practice, Proposal, Run


def run_of(set_name: str, pair: str, items: list[str], method: str = "learned") -> Run:
    """A run of a method that proposes items, each named by what makes it distinct."""
    shown = (Item(name, "puzzle", {"size": [1, 1], "pieces": []}) for name in items)
    return Run("puzzle", method, method, {}, set_name, {"file": pair, "sha256": pair, "pieces": 2}, {}, {"all": 1.0},
               tuple(Proposal(item, 1.0, 1) for item in shown))  # fmt: skip


def runs_of(sizes: Mapping[str, int], set_name: str = "lamps") -> list[Run]:
    """A run for each pair with so many matches, named "pair-number"."""
    return [run_of(set_name, pair, [f"{pair}-{n}" for n in range(size)]) for pair, size in sizes.items()]


def known(items: list[str]) -> dict[str, Practice]:
    """Answers to items, correct and wrong by turns."""
    return {name: Practice(("correct", "wrong")[n % 2], f"because of {name}") for n, name in enumerate(items)}
