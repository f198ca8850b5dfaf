"""The shapes that items show, kept in the study: it can be judged where its meshes are not."""

import io
import zipfile
import zlib
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from sqlalchemy import Connection, insert, select

from engine.errors import BadInput

from . import schema
from .handle import StudyHandle

if TYPE_CHECKING:
    from engine.shapes.segmentation import SegmentedShape

_ARRAYS = ("vertices", "faces", "labels", "names", "numbers")
MOST_BYTES = 2**30
"""Of one shape, unpacked: twenty million faces. A stranger's packet may hold a few bytes that unpack to far more."""


def shape_key(side: Mapping[str, Any]) -> str:
    """The key of the shape that one side of an item shows: its mesh and how that was cut up (where that is known)."""
    return f"{side['sha256']}:{side.get('segmentation', '')}"


def keep_shapes(handle: StudyHandle, shapes: Iterable["SegmentedShape"]) -> int:
    """Put shapes into the study; those that are there stay. Returns how many were new."""
    found = {_key(shape): shape for shape in shapes}
    with handle.reading() as connection:
        known = _known(connection, found)
    packed = {key: _packed(shape) for key, shape in found.items() if key not in known}
    if not packed:
        return 0
    with handle.writing() as connection:
        return _insert(connection, packed)


def insert_shapes(connection: Connection, shapes: Iterable["SegmentedShape"]) -> int:
    """The same in an open transaction."""
    return _insert(connection, {_key(shape): _packed(shape) for shape in shapes})


def _insert(connection: Connection, packed: Mapping[str, bytes]) -> int:
    known = _known(connection, packed)
    rows = [{"key": key, "content": content} for key, content in packed.items() if key not in known]
    if rows:
        connection.execute(insert(schema.blob), rows)
    return len(rows)


def _known(connection: Connection, keys: Iterable[str]) -> set[str]:
    return set(connection.scalars(select(schema.blob.c.key).where(schema.blob.c.key.in_(list(keys)))))


def kept_shapes(handle: StudyHandle, side: Mapping[str, Any]) -> tuple["SegmentedShape", ...]:
    """The shapes in the study that one side of an item may mean: that of its key, or else all of its mesh."""
    key, of_mesh = schema.blob.c.key, f"{side['sha256']}:"
    wanted = key == shape_key(side) if side.get("segmentation") else key.startswith(of_mesh, autoescape=True)
    with handle.reading() as connection:
        rows = connection.scalars(select(schema.blob.c.content).where(wanted).order_by(key)).all()
    return tuple(_unpacked(bytes(row)) for row in rows)


def _key(shape: "SegmentedShape") -> str:
    from engine.shapes.identity import mesh_id, node_id, segment_ids

    whole = node_id(segment_ids(shape.mesh, shape.segmentation))
    return shape_key({"sha256": mesh_id(shape.mesh), "segmentation": whole})


def _packed(shape: "SegmentedShape") -> bytes:
    """A shape as compressed arrays; the names of its segments as texts beside whether each is a number."""
    out, names = io.BytesIO(), shape.segmentation.names
    np.savez_compressed(
        out, vertices=shape.mesh.vertices, faces=shape.mesh.faces, labels=shape.segmentation.labels,
        names=np.array([str(name) for name in names]), numbers=np.array([isinstance(name, int) for name in names]),
    )  # fmt: skip
    return out.getvalue()


def _unpacked(content: bytes) -> "SegmentedShape":
    """The shape of `_packed`; raises `BadInput` where its bytes are damaged."""
    try:
        return _read(content)
    except (
        zipfile.BadZipFile, zlib.error, KeyError, ValueError, TypeError, EOFError, OSError, NotImplementedError, RuntimeError, MemoryError,
    ):  # fmt: skip
        raise BadInput("A shape that is kept in the study is damaged; use a backup, or add its result again to a new study.") from None


def _check_size(content: bytes) -> None:
    """Raise `ValueError` where the arrays are not those of a shape, or unpack to more than any shape takes."""
    with zipfile.ZipFile(io.BytesIO(content)) as packed:
        infos = packed.infolist()
    if sorted(info.filename for info in infos) != sorted(f"{name}.npy" for name in _ARRAYS):
        raise ValueError("these are not the arrays of a shape")
    if sum(info.file_size for info in infos) > MOST_BYTES:
        raise ValueError("the arrays are too large")


def _read(content: bytes) -> "SegmentedShape":
    from engine.shapes.mesh import Mesh
    from engine.shapes.segmentation import Segmentation, SegmentedShape

    _check_size(content)
    with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
        pairs = zip(arrays["names"].tolist(), arrays["numbers"].tolist(), strict=True)
        names = tuple(int(name) if number else name for name, number in pairs)
        mesh = Mesh(arrays["vertices"], arrays["faces"], "shape")
        return SegmentedShape(mesh, Segmentation(arrays["labels"], names))
