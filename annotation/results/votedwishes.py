"""The majority of a study's votes as wishes for matching again: what most call correct is pinned, wrong is forbidden."""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from sqlalchemy import select

from engine.errors import BadInput
from engine.shapes.identity import match_id, node_id, segment_ids
from engine.shapes.segmentation import SegmentedShape
from engine.shapes.wishes import Node, Pair, Wishes

from ..storage import schema
from ..storage.handle import StudyHandle
from ..study import open_study
from ..voting.answering import majority
from ..voting.majority import Majority


class VotedWishes(NamedTuple):
    """Wishes of a pair and how they came: items of the pair, those undecided, and pins that others excluded."""

    wishes: Wishes
    items: int
    undecided: int
    excluded: int

    def sentence(self) -> str:
        """What was taken, for a person."""
        wishes = self.wishes
        matches = "1 match" if self.items == 1 else f"{self.items} matches"
        text = f"{len(wishes.pinned)} pinned and {len(wishes.forbidden)} forbidden by the votes on {matches} of this pair"
        if self.undecided:
            text += f"; {self.undecided} {'is' if self.undecided == 1 else 'are'} undecided"
        if self.excluded:
            text += f"; {self.excluded} called correct exclude others with more votes and were left out"
        return text + "."


def read_voted_wishes(path: Path | str, source: SegmentedShape, target: SegmentedShape) -> VotedWishes:
    """The wishes that the votes of a study file make for two shapes; raises `BadInput`, also where it holds none of their matches."""
    with open_study(path, backup=False, writable=False) as handle:
        found = voted_wishes(handle, source, target)
        where = handle.where
    if not found.items:
        raise BadInput(f"{where} holds no match of {source.mesh.name} and {target.mesh.name} with these segments; give the study "
                       "that their results are in, and the labels that they had.")  # fmt: skip
    return found


def voted_wishes(handle: StudyHandle, source: SegmentedShape, target: SegmentedShape, *, round: int = 1) -> VotedWishes:
    """The majority of every item on two shapes as wishes; ties and items without a decisive vote make none.

    Items are recognised by their content hashes, so renamed files, other methods and another order of the two shapes do
    not matter, and other labels of the same mesh are other shapes. Where two matches called correct share a union, the
    one with more votes for it is pinned.
    """
    verdicts = majority(handle, round=round)
    known = _items(handle, source, target)
    found = {item: (verdicts[item], pairs) for item, pairs in known.items() if item in verdicts}
    pinned, excluded = _compatible((said, pairs) for said, pairs in found.values() if said.verdict == "correct")
    forbidden = tuple(pair for said, pairs in found.values() if said.verdict == "wrong" for pair in pairs)
    undecided = sum(said.verdict not in ("correct", "wrong") for said, _ in found.values())
    return VotedWishes(Wishes(pinned, forbidden), len(found), undecided, excluded)


def known_pairs(handle: StudyHandle, source: SegmentedShape, target: SegmentedShape) -> dict[str, Pair]:
    """The matches of two shapes that a study holds, by item."""
    return {item: pairs[0] for item, pairs in _items(handle, source, target).items()}


def _items(handle: StudyHandle, source: SegmentedShape, target: SegmentedShape) -> dict[str, tuple[Pair, ...]]:
    """The items on two shapes and the matches that they stand for."""
    with handle.reading() as connection:
        rows = connection.execute(select(schema.item).where(schema.item.c.kind == "shape")).all()
    known = _Known(source), _Known(target)
    return {row.id: pairs for row in rows if (pairs := _pairs(row.id, json.loads(row.payload), known))}


class _Known:
    """The segments of a shape by their labels, and their hashes."""

    def __init__(self, shape: SegmentedShape) -> None:
        self.ids = segment_ids(shape.mesh, shape.segmentation)
        self.rows = {name: i for i, name in enumerate(shape.segmentation.names)}

    def union(self, side: Mapping[str, Any]) -> Node:
        """The rows of a side's labels; none where one is unknown."""
        labels = side.get("segments", ())
        return tuple(sorted({self.rows[n] for n in labels})) if all(n in self.rows for n in labels) else ()

    def node(self, union: Node) -> str:
        return node_id(self.ids[i] for i in union)


def _pairs(item_id: str, payload: Mapping[str, Any], known: tuple[_Known, _Known]) -> tuple[Pair, ...]:
    """The matches from source to target that an item stands for: one, none if it is about other shapes or labels, and
    for a shape against itself both directions."""
    found = set()
    for first, second in (("source", "target"), ("target", "source")):
        a, b = known[0].union(payload[first]), known[1].union(payload[second])
        if a and b and match_id(known[0].node(a), known[1].node(b)) == item_id:
            found.add((a, b))
    return tuple(sorted(found))


def _compatible(correct: Iterable[tuple[Majority, tuple[Pair, ...]]]) -> tuple[tuple[Pair, ...], int]:
    """The pairs to be pinned, those with most votes for them first, and how many items others exclude."""
    partners: tuple[dict[Node, Node], dict[Node, Node]] = ({}, {})
    pinned: list[Pair] = []
    excluded = 0
    for _, pairs in sorted(correct, key=lambda entry: (entry[0].wrong - entry[0].correct, entry[0].wrong, entry[1])):
        if any(partners[0].get(a, b) != b or partners[1].get(b, a) != a for a, b in pairs):
            excluded += 1
            continue
        for a, b in pairs:
            partners[0][a], partners[1][b] = b, a
            pinned.append((a, b))
    return tuple(pinned), excluded
