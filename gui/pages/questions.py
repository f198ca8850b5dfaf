"""What the voting page shows next: an item of the study, a match with its two shapes found again, or a puzzle's join."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from annotation import study
from annotation.study import Item, StudyHandle, Volunteer, VotingProgress
from engine.errors import BadInput, ConcordError
from engine.shapes.identity import match_id, mesh_id, node_id, segment_ids
from engine.shapes.segmentation import SegmentedShape

from ..views.join import JoinPicture, join_picture

MOST_KEPT = 12
JOIN_QUESTION = "Do these two pieces belong together like this?"


class Question(NamedTuple):
    """One item as this volunteer sees it: shapes and segments from left to right."""

    item: Item
    shapes: tuple[SegmentedShape, SegmentedShape]
    segments: tuple[tuple[int, ...], tuple[int, ...]]
    swapped: bool


class JoinQuestion(NamedTuple):
    """A join of a puzzle, shown to everybody in the same way: a picture turned or mirrored is another one."""

    item: Item
    picture: JoinPicture


class Asked(NamedTuple):
    """The next question, or none and why; and how far the volunteer is."""

    words: str
    guideline: str
    question: Question | JoinQuestion | None
    progress: VotingProgress
    missing: tuple[str, ...]
    answer: str = ""


class Known(NamedTuple):
    """A shape with the content hashes of its segments."""

    shape: SegmentedShape
    segment_ids: tuple[str, ...]


Shapes = dict[str, list[Known]]
"""Shapes at hand by the hash of their mesh: one mesh may have been cut up in several ways."""


def keep(kept: Shapes, sha256: str, shape: SegmentedShape) -> Known:
    """Put a shape among those at hand; the oldest mesh goes when there are many."""
    for known in kept.get(sha256, ()):
        if known.shape is shape:
            return known
    while len(kept) >= MOST_KEPT and sha256 not in kept:
        kept.pop(next(iter(kept)))
    known = Known(shape, segment_ids(shape.mesh, shape.segmentation))
    kept.setdefault(sha256, []).append(known)
    return known


def candidates(side: Mapping[str, Any], near: Path, kept: Shapes) -> Iterator[Known]:
    """The shapes that one side of an item may mean, likely ones first: those at hand, then its file, or one of that
    name beside the study, with its usual labels or any other `.seg` file of its name."""
    from engine.shapes.meshfile import load_shape

    yield from list(kept.get(side["sha256"], ()))
    file = Path(side["file"] or "?")
    found = next((path for path in (file, near / file.name) if path.is_file()), None)
    if found is None:
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
    rows = {name: k for k, name in enumerate(known.shape.segmentation.names)}
    wanted = list(labels)
    if any(label not in rows for label in wanted):
        return None
    found = tuple(rows[label] for label in wanted)
    return found, node_id(known.segment_ids[k] for k in found)


def question_of(item: Item, swapped: bool, near: Path, kept: Shapes) -> Question:
    """An item with its shapes, the target on the left if `swapped`.

    Only shapes whose segments hash to the item's id are shown, so that no vote falls on another match. Raises
    `BadInput` where they are not to be found.
    """
    sides = item.payload["source"], item.payload["target"]
    for first in candidates(sides[0], near, kept):
        for second in candidates(sides[1], near, kept):
            unions = union_of(first, sides[0]["segments"]), union_of(second, sides[1]["segments"])
            if unions[0] and unions[1] and match_id(unions[0][1], unions[1][1]) == item.id:
                step = -1 if swapped else 1
                return Question(item, (first.shape, second.shape)[::step], (unions[0][0], unions[1][0])[::step], swapped)
    names = " and ".join(Path(side["file"]).name for side in sides)
    raise BadInput(f"The labels of {names} are not those that were matched; put back the label files.")


def ask_next(handle: StudyHandle, code: str, skipped: Collection[str], kept: Shapes, again: str = "") -> Asked:
    """The next question that can be shown, or that about the item `again`."""
    about, voter = study.about(handle), study.volunteer(handle, code)
    given = study.answers(handle, code)
    order = [again] if again else [i for i in study.ordered_ids(handle, code) if i not in given]
    missing: list[str] = []
    for item_id in sorted(order, key=lambda item_id: item_id in skipped):
        try:
            question = shown_as(study.item(handle, item_id), voter, handle.folder or Path(), kept)
        except ConcordError as error:
            missing.append(str(error))
            continue
        words = question_words(about.question, question.item)
        return Asked(words, about.guideline, question, study.progress(handle, code), (), given.get(item_id, ""))
    return Asked(about.question, about.guideline, None, study.progress(handle, code), tuple(dict.fromkeys(missing)))


def shown_as(item: Item, voter: Volunteer, near: Path, kept: Shapes) -> Question | JoinQuestion:
    """An item as this volunteer sees it; raises `BadInput` where it cannot be shown."""
    if item.kind == "puzzle":
        return JoinQuestion(item, join_picture(item.payload))
    return question_of(item, study.sides_swapped(voter, item.id), near, kept)


def question_words(asked: str, item: Item) -> str:
    """The study's own question, and for puzzles that of pieces where the study asks the usual one."""
    return JOIN_QUESTION if item.kind == "puzzle" and asked == study.DEFAULT_QUESTION else asked


def progress_text(progress: VotingProgress) -> str:
    """'37 of 240 · about 25 min left'."""
    text = f"{progress.done} of {progress.total}"
    if progress.seconds_left is None or progress.done >= progress.total:
        return text
    minutes = progress.seconds_left / 60
    return f"{text} · " + (f"about {minutes:.0f} min left" if minutes >= 1.5 else "about a minute left")


def empty_text(asked: Asked) -> str:
    """What to read where there is no question."""
    if asked.missing:
        more = f" (and {len(asked.missing) - 1} more)" if len(asked.missing) > 1 else ""
        return asked.missing[0] + more
    if asked.progress.total == 0:
        return "This study has no matches yet. On the page Shapes or Puzzle, choose Study > Add these matches to the study."
    return "All done, thank you!"
