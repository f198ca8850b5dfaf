"""Polygons of PLY files: text or binary, lists of any length, segments in a property of the faces.

Text is first turned into 64-bit numbers, so that one reader serves text and both byte orders. Every count is compared
with the bytes that are left before anything is read.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import BadInput
from .polygonfile import Polygons, checked, shown

LABEL_NAMES = ("segment", "segment_id", "label", "labels", "seg")
_INDEX_NAMES = ("vertex_indices", "vertex_index")
_LARGEST_WHOLE = 2**53
_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4", "double": "f8",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "int64": "i8",
    "uint64": "u8", "float16": "f2", "float32": "f4", "float64": "f8",
}  # fmt: skip
_ORDERS = {b"ascii": "=", b"binary_little_endian": "<", b"binary_big_endian": ">"}


@dataclass(frozen=True, slots=True)
class Property:
    """A property of an element: the numpy type of its values and, for a list, of its length."""

    name: str
    kind: str
    length: str = ""


@dataclass(slots=True, eq=False)
class Element:
    """An element of the header, such as `face`, and how many rows it promises."""

    name: str
    count: int
    properties: list[Property]

    @property
    def least(self) -> int:
        """The fewest bytes that a row can have."""
        return sum(np.dtype(p.length or p.kind).itemsize for p in self.properties)


Columns = dict[str, tuple[np.ndarray, np.ndarray | None]]  # values, and the lengths where the property is a list


def read_ply(file: Path) -> Polygons:
    """Read a PLY file with its vertices, faces and, where there is one, the property that labels faces.

    Raises `BadInput` where the header, a count, an index or a label makes no sense.
    """
    elements, body = _header(file)
    position, table = 0, {}  # type: int, dict[str, Columns]
    for element in elements:
        if element.count * element.least > len(body) - position:
            raise BadInput(
                f"{file} promises {min(element.count, 10**18):,} rows of '{element.name[:20]}' but is too short; "
                "it is cut off or damaged."
            )
        table[element.name], position = _rows(file, element, body, position)
    if body[position:].strip():
        raise BadInput(f"{file} goes on after all that its header promises; repair or re-export it.")
    return _polygons(file, table)


def _header(file: Path) -> tuple[list[Element], bytes]:
    """The elements of the header, and the body as bytes; a text body becomes 64-bit numbers, as its properties do."""
    data = file.read_bytes()
    lines, start, order = [], 0, None  # type: list[list[bytes]], int, str | None
    while not lines or lines[-1] != [b"end_header"]:
        end = data.find(b"\n", start)
        if end < 0 or end > 2**16 or (not lines and data[:end].strip() != b"ply"):
            raise BadInput(f"{file} has no complete PLY header, so it is no PLY file or a damaged one; re-export it.")
        lines.append(data[start:end].split())
        start = end + 1
    elements: list[Element] = []
    for number, words in enumerate(lines[1:-1], start=2):
        try:
            order = _header_line(words, elements, order)
        except (ValueError, KeyError, IndexError):
            line = shown(b" ".join(words))
            raise BadInput(f"Line {number} of {file}, {line}, makes no sense in a PLY header; re-export it.") from None
    if order is None:
        raise BadInput(f"{file} does not say in its header whether it is text or binary; re-export it as PLY.")
    if order == "=":
        return [_as_text(e) for e in elements], _numbers(file, data[start:])
    for e in elements:
        e.properties = [Property(p.name, order + p.kind, p.length and order + p.length) for p in e.properties]
    return elements, data[start:]


def _header_line(words: list[bytes], elements: list[Element], order: str | None) -> str | None:
    """Take in one line of the header; the byte order, once it is known."""
    match [word.decode("ascii") for word in words]:
        case ["format", kind, _]:
            return _ORDERS[kind.encode()]
        case ["element", name, count] if count.isdigit() and name not in [e.name for e in elements]:
            elements.append(Element(name, int(count), []))
        case ["property", "list", length, kind, name] if name not in [p.name for p in elements[-1].properties]:
            elements[-1].properties.append(Property(name, _TYPES[kind], _TYPES[length]))
        case ["property", kind, name] if name not in [p.name for p in elements[-1].properties]:
            elements[-1].properties.append(Property(name, _TYPES[kind]))
        case [] | ["comment" | "obj_info", *_]:
            pass
        case _:
            raise ValueError
    return order


def _as_text(element: Element) -> Element:
    return Element(element.name, element.count, [Property(p.name, "=f8", "=f8" if p.length else "") for p in element.properties])


def _numbers(file: Path, text: bytes) -> bytes:
    words = text.replace(b"_", b"?").split()  # Python takes 1_0 for a number
    try:
        return np.fromiter(map(float, words), dtype=np.float64, count=len(words)).tobytes()
    except ValueError:
        raise BadInput(f"{file} holds something that is not a number after its header; repair or re-export it.") from None


def _rows(file: Path, element: Element, body: bytes, position: int) -> tuple[Columns, int]:
    """The columns of an element and the position after it: at once if its lists are equally long, else row by row."""
    if not element.count or not element.properties:
        return {p.name: (np.zeros(0), np.zeros(0, dtype=np.int64) if p.length else None) for p in element.properties}, position
    lengths = _row(file, element, body, position)[1]
    fields: list[tuple] = []
    for n, (p, length) in enumerate(zip(element.properties, lengths, strict=True)):
        fields += [(f"n{n}", p.length), (f"v{n}", p.kind, (length,))] if p.length else [(f"v{n}", p.kind)]
    row = np.dtype(fields)
    if element.count * row.itemsize <= len(body) - position:
        rows = np.frombuffer(body, dtype=row, count=element.count, offset=position)
        lists = [n for n, p in enumerate(element.properties) if p.length]
        if all((rows[f"n{n}"] == lengths[n]).all() for n in lists):
            columns = {p.name: (rows[f"v{n}"].ravel(), np.full(element.count, lengths[n]) if p.length else None)
                       for n, p in enumerate(element.properties)}  # fmt: skip
            return columns, position + element.count * row.itemsize
    return _uneven_rows(file, element, body, position)


def _uneven_rows(file: Path, element: Element, body: bytes, position: int) -> tuple[Columns, int]:
    values: list[list[np.ndarray]] = [[] for _ in element.properties]
    sizes: list[list[int]] = [[] for _ in element.properties]
    for _ in range(element.count):
        found, lengths, position = _row(file, element, body, position)
        for n in range(len(found)):
            values[n].append(found[n])
            sizes[n].append(lengths[n])
    return {p.name: (np.concatenate(values[n]), np.array(sizes[n]) if p.length else None)
            for n, p in enumerate(element.properties)}, position  # fmt: skip


def _row(file: Path, element: Element, body: bytes, position: int) -> tuple[list[np.ndarray], list[int], int]:
    """Values and length of each property of one row, and the position after it."""
    values, lengths = [], []
    for p in element.properties:
        length = 1
        if p.length:
            counted, position = _take(file, body, position, p.length, 1)
            if not 0 <= counted[0] <= len(body) or counted[0] != int(counted[0]):
                raise BadInput(f"{file} has a list of impossible length in '{element.name[:20]}'; it is damaged.")
            length = int(counted[0])
        taken, position = _take(file, body, position, p.kind, length)
        values.append(taken)
        lengths.append(length)
    return values, lengths, position


def _take(file: Path, body: bytes, position: int, kind: str, count: int) -> tuple[np.ndarray, int]:
    end = position + np.dtype(kind).itemsize * count
    if end > len(body):
        raise BadInput(f"{file} ends before all that its header promises; it is cut off or damaged.")
    return np.frombuffer(body, dtype=kind, count=count, offset=position), end


def _polygons(file: Path, table: dict[str, Columns]) -> Polygons:
    vertex, face = table.get("vertex", {}), table.get("face", {})
    index = next((name for name in _INDEX_NAMES if name in face), "")
    if not {"x", "y", "z"} <= vertex.keys() or not index or face[index][1] is None:
        raise BadInput(f"{file} has no vertices with x, y and z or no faces; Concord needs a PLY file of a surface.")
    points = np.column_stack([vertex[axis][0].astype(np.float64) for axis in "xyz"])
    corners = _whole(file, face[index][0], "an index")
    sizes = face[index][1]
    polygons = checked(file, points.ravel(), sizes if sizes is not None else corners[:0], corners)
    name = next((name for name in LABEL_NAMES if name in face and face[name][1] is None), "")
    if not name:
        return polygons
    labels = _whole(file, face[name][0], f"a {name}")
    return Polygons(polygons.vertices, polygons.sizes, polygons.corners, labels, (), f"the PLY face property '{name}'")


def _whole(file: Path, values: np.ndarray, what: str) -> np.ndarray:
    """Values as int64, refused where they are no whole numbers or beyond 2^53."""
    numbers = values.astype(np.float64)
    if not (np.isfinite(numbers) & (np.abs(numbers) <= _LARGEST_WHOLE)).all() or (numbers != np.floor(numbers)).any():
        raise BadInput(f"{file} has faces with {what} that is no whole number, or too large a one; repair or re-export it.")
    return values.astype(np.int64)
