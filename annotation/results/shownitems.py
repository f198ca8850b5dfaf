"""What an item shows, found again for a report: two shapes with the marked segments, or the picture of a join."""

import base64
import binascii
import io
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from engine.errors import BadInput, ConcordError

from ..records import Item
from ..storage.blobs import kept_shapes
from ..storage.handle import StudyHandle
from ..storage.payloads import two_sides

if TYPE_CHECKING:
    from engine.shapes.segmentation import SegmentedShape

Segments = tuple[int, ...]
LARGEST = 4096  # pixels of a stored side; more is no join that Concord wrote
_GAP = 12  # pixels between a join as it stands and its two pieces apart


class ShownParts(NamedTuple):
    """Two shapes and the segments that an item marks on them."""

    source: "SegmentedShape"
    target: "SegmentedShape"
    source_segments: Segments
    target_segments: Segments


PartsDrawer = Callable[[ShownParts], bytes]
"""Draws the two shapes with their marked segments as a PNG; raises `ConcordError` where that cannot be."""


def shown_parts(handle: StudyHandle, item: Item) -> ShownParts:
    """The shapes of an item of that kind: those kept in the study, or their files where they were or beside the study.

    Only shapes whose segments hash to the item's id are taken. Raises `BadInput` where there are none.
    """
    from engine.shapes.identity import match_id

    sides = two_sides(item.payload)
    found = [list(_marked(_candidates(handle, side), side["segments"])) for side in sides]
    for source, one, first in found[0]:
        for target, other, second in found[1]:
            if match_id(first, second) == item.id:
                return ShownParts(source, target, one, other)
    names = " and ".join(Path(side["file"]).name for side in sides)
    raise BadInput(f"The shapes of {names} as they were matched are neither in the study nor beside it.")


def item_picture(handle: StudyHandle, item: Item, draw: PartsDrawer) -> bytes:
    """An item as a PNG; raises `ConcordError` where it cannot be shown."""
    return join_png(item.payload) if item.kind == "puzzle" else draw(shown_parts(handle, item))


def join_png(payload: Mapping[str, Any]) -> bytes:
    """A join of a puzzle as it stands, and beside it its two pieces apart; raises `BadInput` where it is damaged."""
    from PIL import Image

    try:
        w, h = (int(side) for side in payload["size"])
        if not 0 < min(w, h) <= max(w, h) <= LARGEST:
            raise ValueError
        pieces = [(_opened(p["png"]), int(p["x"]), int(p["y"])) for p in payload["pieces"]]
        sheet = Image.new("RGBA", (w + sum(p.width + _GAP for p, _, _ in pieces), h), (0, 0, 0, 0))
        left = w + _GAP
        for piece, x, y in pieces:
            sheet.paste(piece, (x, y), piece)
            sheet.paste(piece, (left, y), piece)
            left += piece.width + _GAP
    except (KeyError, TypeError, ValueError, OverflowError, OSError, SyntaxError, binascii.Error):
        raise BadInput("The pictures of a join in this study are damaged; add its solution again.") from None
    scale = max(1, 320 // max(w, h))
    out = io.BytesIO()
    sheet.resize((sheet.width * scale, sheet.height * scale), Image.Resampling.NEAREST).save(out, "PNG")
    return out.getvalue()


def _opened(png: str) -> Any:
    """The pixels of a PNG in base 64, bounded before they are decoded."""
    from PIL import Image

    image = Image.open(io.BytesIO(base64.b64decode(png, validate=True)), formats=["PNG"])
    if max(image.size) > LARGEST:
        raise ValueError
    return image.convert("RGBA")


def _candidates(handle: StudyHandle, side: Mapping[str, Any]) -> Iterable["SegmentedShape"]:
    """The shapes that a side may mean: those in the study first, then its file with any labels that lie beside it."""
    from engine.shapes.identity import mesh_id
    from engine.shapes.meshfile import load_shape

    yield from kept_shapes(handle, side)
    file = Path(side["file"] or "?")
    places = (file, *((handle.folder / file.name,) if handle.folder else ()))
    found = next((path for path in places if path.is_file()), None)
    for labels in (None, *sorted(found.parent.glob(f"{found.stem}.*seg"))) if found else ():
        try:
            shape = load_shape(found, labels) if found else None
        except ConcordError:
            continue
        if shape and mesh_id(shape.mesh) == side["sha256"]:
            yield shape


def _marked(
    shapes: Iterable["SegmentedShape"], labels: Iterable[int | str]
) -> Iterable[tuple["SegmentedShape", Segments, str]]:
    """Those shapes that have all these labels, with the rows of the segments and the hash of their union."""
    from engine.shapes.identity import node_id, segment_ids

    wanted = list(labels)
    for shape in shapes:
        rows = {name: k for k, name in enumerate(shape.segmentation.names)}
        if all(label in rows for label in wanted):
            ids, union = segment_ids(shape.mesh, shape.segmentation), tuple(rows[label] for label in wanted)
            yield shape, union, node_id(ids[k] for k in union)


def no_drawing(_shown: ShownParts) -> bytes:
    """Shapes cannot be drawn without the window's libraries."""
    raise ConcordError("Shapes are drawn by the command `concord` with the extra 'gui' installed.")
