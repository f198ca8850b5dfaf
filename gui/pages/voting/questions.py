"""What the voting screen shows: an item of the study, found again as two shapes with marked parts or a puzzle's join."""

import zipfile
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from annotation.records import Item, OpenItem
from annotation.storage.blobs import kept_shapes
from annotation.storage.handle import StudyHandle
from annotation.study import DEFAULT_QUESTION, about
from annotation.voting.asking import asked_item
from engine.errors import BadInput, ConcordError
from engine.shapes.identity import match_id, mesh_id, node_id, segment_ids
from engine.shapes.segmentation import SegmentedShape

from ...views.join import JoinPicture, join_picture
from ...views.scene import Scene, prepare
from ...views.voting_pair import ReadyPair, ready_pair

MOST_KEPT = 24
JOIN_QUESTION = "Do these two pieces belong together like this?"
_DAMAGED = (ConcordError, ValueError, KeyError, TypeError, IndexError, OSError, zipfile.BadZipFile, zlib.error)


class Question(NamedTuple):
    """One match as this volunteer sees it, left and right; nothing tells what else the study knows of it."""

    asked: OpenItem
    words: str
    pair: ReadyPair
    swapped: bool


class JoinQuestion(NamedTuple):
    """A join of a puzzle, shown to everybody in the same way: a picture turned or mirrored is another one."""

    asked: OpenItem
    words: str
    picture: JoinPicture


class Unshowable(NamedTuple):
    """An item that cannot be shown here, and why (for the researcher)."""

    asked: OpenItem
    reason: str


class Known(NamedTuple):
    """A shape with the content hashes of its segments, made ready to be drawn, without its name."""

    labels: tuple[int | str, ...]
    segment_ids: tuple[str, ...]
    scene: Scene


Shapes = dict[str, list[Known]]
"""Shapes at hand by the hash of their mesh: one mesh may have been cut up in several ways."""


def keep(kept: Shapes, sha256: str, shape: SegmentedShape) -> Known:
    """Put a shape among those at hand; the oldest mesh goes when there are many."""
    ids = segment_ids(shape.mesh, shape.segmentation)
    for known in kept.get(sha256, ()):
        if known.segment_ids == ids and known.labels == shape.segmentation.names:
            return known
    while len(kept) >= MOST_KEPT and sha256 not in kept:
        kept.pop(next(iter(kept)))
    known = Known(shape.segmentation.names, ids, replace(prepare(shape), name=""))
    kept.setdefault(sha256, []).append(known)
    return known


def candidates(handle: StudyHandle, side: Mapping[str, Any], kept: Shapes) -> Iterator[Known]:
    """The shapes that one side of an item may mean, likely ones first: those at hand, those in the study, then its
    file, or one of that name beside the study, with its usual labels or any other `.seg` file of its name."""
    from engine.shapes.meshfile import load_shape

    yield from list(kept.get(side["sha256"], ()))
    inside = kept_shapes(handle, side)
    yield from (keep(kept, side["sha256"], shape) for shape in inside)
    file = Path(side.get("file") or "?")
    near = [handle.folder / file.name] if handle.folder else []
    found = next((path for path in (file, *near) if path.is_file()), None)
    if found is None:
        if inside:
            return
        raise BadInput(f"{file.name} is neither at {file} nor beside the study; put it there to be asked about it.")
    for labels in (None, *sorted(found.parent.glob(f"{found.stem}.*seg"))):
        try:
            shape = load_shape(found, labels)
        except BadInput:
            if labels is None:
                raise
            continue
        if mesh_id(shape.mesh) != side["sha256"]:
            raise BadInput(f"{found} is not the mesh that the study asks about; put back the one that was matched.")
        yield keep(kept, side["sha256"], shape)


def union_of(known: Known, labels: Iterable[int | str]) -> tuple[tuple[int, ...], str] | None:
    """The segments with these labels and the hash of their union; None where a label is missing."""
    rows = {name: k for k, name in enumerate(known.labels)}
    wanted = list(labels)
    if any(label not in rows for label in wanted):
        return None
    found = tuple(rows[label] for label in wanted)
    return found, node_id(known.segment_ids[k] for k in found)


def found_again(handle: StudyHandle, item: Item, kept: Shapes) -> Sequence[tuple[Scene, tuple[int, ...]]]:
    """The scene and the marked segments of both sides of an item of shapes.

    Only shapes whose segments hash to the item's id are shown, so that no vote falls on another match. Raises
    `BadInput` where they are not to be found.
    """
    sides = item.payload["source"], item.payload["target"]
    for first in candidates(handle, sides[0], kept):
        for second in candidates(handle, sides[1], kept):
            unions = union_of(first, sides[0]["segments"]), union_of(second, sides[1]["segments"])
            if unions[0] and unions[1] and match_id(unions[0][1], unions[1][1]) == item.id:
                return (first.scene, unions[0][0]), (second.scene, unions[1][0])
    names = " and ".join(Path(side["file"]).name for side in sides)
    raise BadInput(f"The labels of {names} are not those that were matched; put back the label files.")


def load(handle: StudyHandle, code: str, one: OpenItem, question: str, kept: Shapes) -> Question | JoinQuestion | Unshowable:
    """An open item made ready to be drawn (in a thread). Raises `BadInput` where the study itself cannot be read."""
    try:
        item, swapped = asked_item(handle, code, one.item_id)
        words = question_words(question, item)
        if item.kind == "puzzle":
            return JoinQuestion(one, words, join_picture(item.payload))
        left, right = found_again(handle, item, kept)[:: -1 if swapped else 1]
        return Question(one, words, ready_pair((left[0], right[0]), (left[1], right[1])), swapped)
    except _DAMAGED as error:
        about(handle)  # raises where it is the study that cannot be read
        return Unshowable(one, str(error))


def question_words(asked: str, item: Item) -> str:
    """The study's own question, and for puzzles that of pieces where the study asks the usual one."""
    return JOIN_QUESTION if item.kind == "puzzle" and asked == DEFAULT_QUESTION else asked
