"""Matches that volunteers may not be able to see: those whose shapes the study does not keep."""

from sqlalchemy import select

from engine.errors import BadInput

from ..storage import schema
from ..storage.blobs import shape_key
from ..storage.handle import StudyHandle
from ..storage.payloads import read_payload, two_sides

_item, _asked = schema.item.c, schema.asked.c


def unseen(handle: StudyHandle) -> int:
    """How many matches of shapes are asked though a shape of theirs is not kept in the study (or a match is damaged).

    They can be shown only where the mesh files lie where they lay, or beside the study.
    """
    with handle.reading() as connection:
        keys = set(connection.scalars(select(schema.blob.c.key)))
        asked = set(connection.scalars(select(_asked.item_id)))
        rows = connection.execute(select(_item.id, _item.payload).where(_item.kind == "shape")).all()
    meshes = {key.split(":")[0] for key in keys}
    return sum((not asked or row.id in asked) and not _kept(row.payload, keys, meshes) for row in rows)


def _kept(payload: str, keys: set[str], meshes: set[str]) -> bool:
    try:
        sides = two_sides(read_payload(payload))
    except BadInput:
        return False
    return all(shape_key(one) in keys if one.get("segmentation") else one["sha256"] in meshes for one in sides)


def unseen_words(count: int) -> str:
    """The same as a sentence; "" where all can be seen."""
    if not count:
        return ""
    matches = "1 match is" if count == 1 else f"{count} matches are"
    return (f"{matches} asked of shapes that the study does not keep: volunteers can see them only where the mesh files lie. "
            "Give them with `concord study add STUDY RESULTS --shapes FOLDER`.")  # fmt: skip
