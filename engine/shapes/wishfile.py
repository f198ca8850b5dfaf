"""A file of wishes (schema concord.shape-wishes/1): matches pinned or forbidden, by the labels of their segments."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..errors import BadInput
from ..store import write_atomically
from .identity import mesh_id, node_id, segment_ids
from .segmentation import SegmentedShape
from .wishes import Node, Pair, Wishes, contradiction

SCHEMA = "concord.shape-wishes/1"
MOST_WISHES = 100_000
KEYS = ("schema", "source", "target", "pinned", "forbidden")


def wishes_to_json(wishes: Wishes, source: SegmentedShape, target: SegmentedShape) -> dict[str, Any]:
    """The wishes as a JSON object; segments go by their labels in the input, shapes by their hashes."""
    names = source.segmentation.names, target.segmentation.names

    def entries(pairs: Sequence[Pair]) -> list[dict[str, list[int | str]]]:
        return [{side: [named[i] for i in union] for side, named, union in zip(("source", "target"), names, pair, strict=True)}
                for pair in pairs]  # fmt: skip

    return {"schema": SCHEMA, "source": _shape(source), "target": _shape(target), "pinned": entries(wishes.pinned),
            "forbidden": entries(wishes.forbidden)}  # fmt: skip


def _shape(shape: SegmentedShape) -> dict[str, str]:
    return {"file": shape.file, "sha256": mesh_id(shape.mesh), "segmentation": node_id(segment_ids(shape.mesh, shape.segmentation))}


def write_wishes(path: Path | str, wishes: Wishes, source: SegmentedShape, target: SegmentedShape) -> None:
    """Write wishes so that `read_wishes` gives them back for the same shapes; raises `BadInput`."""
    content = wishes_to_json(wishes, source, target)
    write_atomically(path, json.dumps(content, indent=1, ensure_ascii=False) + "\n")


def read_wishes(path: Path | str, source: SegmentedShape, target: SegmentedShape) -> Wishes:
    """Wishes from a file, for these two shapes; a file about the same shapes in the other order is turned round.

    Hashes may be left out, as in a file written by hand; then the labels are taken as they are. Raises `BadInput` in one
    sentence for a damaged file, other shapes or labels, unknown segments, and wishes that contradict each other.
    """
    path = Path(path)
    content = _content(path)
    if _is_about(content, (target, source)) and not _is_about(content, (source, target)):
        return _wishes(path, content, target, source).turned()
    if not _is_about(content, (source, target)):
        raise BadInput(f"{path} was written for other shapes or other labels than those of {source.mesh.name} and "
                       f"{target.mesh.name}; give it with its own, or pin and forbid anew.")  # fmt: skip
    return _wishes(path, content, source, target)


def _content(path: Path) -> Mapping[str, Any]:
    try:
        content = json.loads(path.read_bytes())
    except OSError as error:
        raise BadInput(f"{path} cannot be read ({error.strerror}); give a file of wishes.") from None
    except (ValueError, RecursionError):
        raise BadInput(f"{path} is no file of wishes (it is not whole JSON); write it anew.") from None
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        raise BadInput(f'{path} is no file of wishes for shapes; it must be an object with "schema": "{SCHEMA}".')
    unknown = [key for key in content if key not in KEYS]
    if unknown:
        raise BadInput(f"{path} has '{unknown[0]}', which no file of wishes for shapes has; it takes {', '.join(KEYS)}.")
    return content


def _is_about(content: Mapping[str, Any], shapes: tuple[SegmentedShape, SegmentedShape]) -> bool:
    """Whether the hashes that a file gives are those of the shapes in this order."""
    for side, shape in zip(("source", "target"), shapes, strict=True):
        said = content.get(side)
        known = _shape(shape)
        if isinstance(said, dict) and any(said.get(key) not in (None, "", known[key]) for key in ("sha256", "segmentation")):
            return False
    return True


def _wishes(path: Path, content: Mapping[str, Any], source: SegmentedShape, target: SegmentedShape) -> Wishes:
    pinned, forbidden = (_pairs(path, content, key, (source, target)) for key in ("pinned", "forbidden"))
    names = source.segmentation.names, target.segmentation.names

    def named(pairs: Sequence[Pair]) -> list[Any]:
        return [tuple(tuple(known[i] for i in union) for known, union in zip(names, pair, strict=True)) for pair in pairs]

    sentence = contradiction(named(pinned), named(forbidden))
    if sentence:
        raise BadInput(f"In {path}, {sentence}")
    return Wishes(tuple(pinned), tuple(forbidden))


def _pairs(path: Path, content: Mapping[str, Any], key: str, shapes: tuple[SegmentedShape, SegmentedShape]) -> list[Pair]:
    entries = content.get(key, [])
    if not isinstance(entries, list) or len(entries) > MOST_WISHES or not all(isinstance(e, dict) for e in entries):
        raise BadInput(f"'{key}' in {path} must be a list of objects with the labels of 'source' and of 'target'.")
    return [(_union(path, key, k, entry, "source", shapes[0]), _union(path, key, k, entry, "target", shapes[1]))
            for k, entry in enumerate(entries)]  # fmt: skip


def _union(path: Path, key: str, number: int, entry: Mapping[str, Any], side: str, shape: SegmentedShape) -> Node:
    where = f"The {key} match {number + 1} in {path}"
    rows = {name: i for i, name in enumerate(shape.segmentation.names)}
    labels = entry.get(side)
    if not isinstance(labels, list) or not labels:
        raise BadInput(f"{where} needs a list of labels as its '{side}'.")
    for label in labels:
        if isinstance(label, bool) or not isinstance(label, int | str) or label not in rows:
            raise BadInput(f"{where} names the segment {label!r}, which {shape.mesh.name} does not have.")
    return tuple(sorted({rows[label] for label in labels}))
