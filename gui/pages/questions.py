"""What the voting page shows next: an item of the study with its two shapes found again on this computer."""

from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from annotation import study
from annotation.study import Item, StudyFile, VotingProgress
from engine.errors import BadInput, ConcordError
from engine.shapes.identity import mesh_id
from engine.shapes.segmentation import SegmentedShape

Shapes = dict[str, SegmentedShape]
MOST_KEPT = 12


class Question(NamedTuple):
    """One item as this volunteer sees it: shapes and segments from left to right."""

    item: Item
    shapes: tuple[SegmentedShape, SegmentedShape]
    segments: tuple[tuple[int, ...], tuple[int, ...]]
    swapped: bool


class Asked(NamedTuple):
    """The next question, or none and why; and how far the volunteer is."""

    words: str
    guideline: str
    question: Question | None
    progress: VotingProgress
    missing: tuple[str, ...]
    answer: str = ""


def find_shape(side: Mapping[str, Any], near: Path, kept: Shapes) -> SegmentedShape:
    """The shape of one side of an item: kept ones first, then its file, then one of that name beside the study."""
    from engine.shapes.meshfile import load_shape

    if side["sha256"] in kept:
        return kept[side["sha256"]]
    file = Path(side["file"] or "?")
    found = next((path for path in (file, near / file.name) if path.is_file()), None)
    if found is None:
        raise BadInput(f"{file.name} is neither at {file} nor beside the study; put it there to be asked about it.")
    shape = load_shape(found)
    if mesh_id(shape.mesh) != side["sha256"]:
        raise BadInput(f"{found} is not the mesh that the study asks about; put back the one that was matched.")
    while len(kept) >= MOST_KEPT:
        kept.pop(next(iter(kept)))
    kept[side["sha256"]] = shape
    return shape


def segment_rows(shape: SegmentedShape, labels: Iterable[int | str]) -> tuple[int, ...]:
    """Indices of the segments with these labels."""
    rows = {name: k for k, name in enumerate(shape.segmentation.names)}
    missing = [label for label in labels if label not in rows]
    if missing:
        raise BadInput(f"{shape.mesh.name} has no segment {missing[0]}; its labels are not those that were matched.")
    return tuple(rows[label] for label in labels)


def question_of(item: Item, swapped: bool, near: Path, kept: Shapes) -> Question:
    """An item with its shapes, the target on the left if `swapped`. Raises `BadInput` where a shape is missing."""
    sides = [item.payload["source"], item.payload["target"]][:: -1 if swapped else 1]
    shapes = [find_shape(side, near, kept) for side in sides]
    rows = [segment_rows(shape, side["segments"]) for shape, side in zip(shapes, sides, strict=True)]
    return Question(item, (shapes[0], shapes[1]), (rows[0], rows[1]), swapped)


def ask_next(handle: StudyFile, code: str, skipped: Collection[str], kept: Shapes, again: str = "") -> Asked:
    """The next question that can be shown, or that about the item `again`."""
    about, voter = study.about(handle), study.volunteer(handle, code)
    given = study.answers(handle, code)
    order = study.items(handle, code)
    wanted = [i for i in order if i.id == again] if again else [i for i in order if i.id not in given]
    missing: list[str] = []
    for item in sorted(wanted, key=lambda item: item.id in skipped):
        try:
            if item.kind != "shape":
                continue
            question = question_of(item, study.sides_swapped(voter, item.id), Path(handle.path).parent, kept)
        except ConcordError as error:
            missing.append(str(error))
            continue
        return Asked(about.question, about.guideline, question, study.progress(handle, code), (), given.get(item.id, ""))
    return Asked(about.question, about.guideline, None, study.progress(handle, code), tuple(dict.fromkeys(missing)))


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
        return "This study has no matches yet. On the page Shapes, choose Study > Add these matches to the study."
    return "All done, thank you!"
