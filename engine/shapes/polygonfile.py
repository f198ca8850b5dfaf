"""Polygons of OFF, OBJ and STL files, read strictly: what cannot be understood is refused, with its line.

A lenient reader that skips a damaged line shifts every label after it, so that nothing here is skipped: counts are
compared with what is there before anything is built, and faces keep the order of the file.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ..errors import BadInput

_OBJ_IGNORED = frozenset(
    b"vt vn vp s l p mtllib usemtl usemap maplib mg deg bmat step cstype curv curv2 surf parm trim hole scrv sp end con "
    b"bevel c_interp d_interp lod shadow_obj trace_obj ctech stech call csh".split()
)
_OBJ_OTHERS = re.compile(rb"(-?\d+)?(/(-?\d+)?)?")


@dataclass(frozen=True, slots=True, eq=False)
class Polygons:
    """Faces with any number of corners, in the order of the file.

    `vertices` (n, 3) float64, `sizes` (f,) int64 >= 3, `corners` (sum of sizes,) int64 in 0..n-1. Where the file says
    to which part each face belongs, `part` (f,) int64 holds either indices into `part_names` or, if that is empty,
    whole numbers; `origin` says in words where these came from, such as "the groups of the file".
    """

    vertices: np.ndarray
    sizes: np.ndarray
    corners: np.ndarray
    part: np.ndarray | None = None
    part_names: tuple[str, ...] = ()
    origin: str = ""

    def triangles(self) -> tuple[np.ndarray, np.ndarray]:
        """Fans of all faces, (m, 3) int64, and the face of each triangle, (m,) int64; both in the order of the file."""
        face = np.repeat(np.arange(len(self.sizes)), self.sizes - 2)
        first = np.cumsum(self.sizes) - self.sizes
        step = np.arange(len(face)) - np.repeat(np.cumsum(self.sizes - 2) - (self.sizes - 2), self.sizes - 2)
        start = first[face]
        return self.corners[np.column_stack([start, start + step + 1, start + step + 2])].reshape(-1, 3), face


def shown(word: bytes) -> str:
    """A word of a file as it can stand in a sentence: short, printable, quoted."""
    text = word[:20].decode("ascii", errors="replace")
    return "'" + "".join(c if c.isprintable() else "?" for c in text) + ("…'" if len(word) > 20 else "'")


def whole(word: bytes) -> int:
    """A whole number; unlike `int`, without underscores. Raises `ValueError`."""
    if b"_" in word:
        raise ValueError
    return int(word)


def checked(file: Path, vertices: ArrayLike, sizes: ArrayLike, corners: ArrayLike) -> Polygons:
    """Polygons of flat numbers; refuses faces of fewer than three corners and corners that are no vertex."""
    points = np.asarray(vertices, dtype=np.float64).reshape(-1, 3)
    try:
        size, corner = np.asarray(sizes, dtype=np.int64), np.asarray(corners, dtype=np.int64)
    except OverflowError:
        raise BadInput(f"A face of {file} has an index beyond 64 bits; repair or re-export the file.") from None
    if (size < 3).any():
        raise BadInput(f"Face {int(np.argmax(size < 3))} of {file} has fewer than three corners; remove or repair it.")
    wrong = (corner < 0) | (corner >= len(points))
    if wrong.any():
        face = int(np.searchsorted(np.cumsum(size), np.argmax(wrong), side="right"))
        raise BadInput(f"Face {face} of {file} has an index outside of its {len(points):,} vertices; repair the file.")
    return Polygons(points, size, corner)


def read_off(file: Path) -> Polygons:
    """Read an OFF file (also COFF, NOFF, STOFF; colours and normals are passed over). Raises `BadInput`."""
    lines = file.read_bytes().removeprefix(b"\xef\xbb\xbf").replace(b"_", b"?").splitlines()  # 1_0 is no number
    rows = [(n, words) for n, line in enumerate(lines, start=1) if (words := line.split(b"#", 1)[0].split())]
    head = re.fullmatch(rb"(?:ST)?C?N?OFF(\d*)", rows[0][1][0]) if rows else None
    if head is None:
        raise BadInput(f"{file} does not start with the word OFF, so it is no OFF file; repair or re-export it.")
    counts = ([head[1]] if head[1] else []) + rows[0][1][1:]
    body = rows[1:] if counts else rows[2:]
    many, faces = _off_counts(file, counts or [word for _, words in rows[1:2] for word in words], len(body))
    width = len(body[0][1]) if many else 3
    points: list[float] = []
    sizes: list[int] = []
    corners: list[int] = []
    number = 0
    try:
        for number, words in body[:many]:
            if len(words) != width or width < 3:
                raise BadInput(f"Line {number} of {file} has {len(words)} numbers where a vertex needs {max(width, 3)}.")
            points.extend(map(float, words[:3]))
        for number, words in body[many : many + faces]:
            size = int(words[0])
            if not 3 <= size < len(words):
                raise BadInput(f"Line {number} of {file} is no face: it should be the number of corners, then as many vertices.")
            sizes.append(size)
            corners.extend(map(int, words[1 : size + 1]))
    except (ValueError, OverflowError):
        raise BadInput(f"Line {number} of {file} holds something that is not a number; repair or re-export the file.") from None
    return checked(file, points, sizes, corners)


def _off_counts(file: Path, words: list[bytes], lines: int) -> tuple[int, int]:
    """Numbers of vertices and faces in the header, compared with the number of lines that follow."""
    try:
        vertices, faces = whole(words[0]), whole(words[1])
    except (IndexError, ValueError):
        raise BadInput(f"{file} does not say after OFF how many vertices and faces it has; repair or re-export it.") from None
    if vertices < 0 or faces < 0:
        raise BadInput(f"{file} promises a negative number of vertices or faces; repair or re-export it.")
    if vertices + faces > lines:
        held = f"{lines - vertices:,} faces" if vertices <= lines else f"only {lines:,} lines"
        raise BadInput(
            f"{file} promises {min(vertices, 10**18):,} vertices and {min(faces, 10**18):,} faces but holds {held}; "
            "the file is cut off or damaged."
        )
    if vertices + faces < lines:
        raise BadInput(f"{file} goes on after the {vertices:,} vertices and {faces:,} faces that it promises; repair its counts.")
    return vertices, faces


def read_obj(file: Path) -> Polygons:
    """Read an OBJ file: vertices, faces (also with indices counted back from the end), and groups or objects.

    Parts are the groups where at least two have faces, else the objects where at least two have. Raises `BadInput`.
    """
    points: list[float] = []
    sizes: list[int] = []
    corners: list[int] = []
    current, marks = [b"", b""], ([], [])  # type: tuple[list[bytes], tuple[list[bytes], list[bytes]]]
    for number, line in enumerate(_obj_lines(file), start=1):
        words = line.split(b"#", 1)[0].split()
        if not words:
            continue
        try:
            if words[0] == b"v":
                x, y, z = words[1:4]
                points += (float(x), float(y), float(z))
            elif words[0] == b"f":
                count = len(points) // 3
                corners += [_obj_corner(word, count) for word in words[1:]]
                sizes.append(len(words) - 1)
                for kind in (0, 1):
                    marks[kind].append(current[kind])
            elif words[0] in (b"g", b"o"):
                current[words[0] == b"o"] = b" ".join(words[1:])
            elif words[0] not in _OBJ_IGNORED:
                raise BadInput(f"Line {number} of {file} starts with {shown(words[0])}, which no OBJ file has; repair the file.")
            if b"_" in line and words[0] in (b"v", b"f") and b"_" in b"".join(words):  # Python takes 1_0 for a number
                raise ValueError
        except ValueError:
            thing = "vertex" if words[0] == b"v" else "face"
            raise BadInput(f"Line {number} of {file} is no {thing} that can be understood; repair or re-export the file.") from None
    return _with_parts(checked(file, points, sizes, corners), marks)


def _obj_lines(file: Path) -> list[bytes]:
    """Lines of an OBJ file; a line that ends in a backslash takes in the next, which leaves an empty one behind."""
    lines = file.read_bytes().removeprefix(b"\xef\xbb\xbf").splitlines()
    joined: list[bytes] = []
    held: list[bytes] = []
    for line in lines:
        held.append(line.removesuffix(b"\\"))
        if not line.endswith(b"\\"):
            joined += [b" ".join(held), *[b""] * (len(held) - 1)]
            held = []
    return [*joined, b" ".join(held)]


def _obj_corner(word: bytes, vertices: int) -> int:
    """Vertex of a corner such as `7`, `7/1`, `7//3` or `-1`, counted from 0. Raises `ValueError`."""
    index, slash, others = word.partition(b"/")
    number = int(index)
    if number == 0 or (slash and not _OBJ_OTHERS.fullmatch(others)):
        raise ValueError
    return number - 1 if number > 0 else max(vertices + number, -1)


def _with_parts(polygons: Polygons, marks: tuple[list[bytes], list[bytes]]) -> Polygons:
    for kind, origin in enumerate(("the groups of the file", "the objects of the file")):
        if len(set(marks[kind])) > 1:
            return _parted(polygons, marks[kind], origin)
    return polygons


def _parted(polygons: Polygons, names: list[bytes], origin: str) -> Polygons:
    """Polygons with the part of each face, from its name; a face without a name is in the part `default`."""
    text_of = {name: name.decode("utf-8", errors="replace") or "default" for name in set(names)}
    texts = tuple(sorted(set(text_of.values())))
    number = {name: texts.index(text) for name, text in text_of.items()}
    part = np.fromiter((number[name] for name in names), dtype=np.int64)
    return Polygons(polygons.vertices, polygons.sizes, polygons.corners, part, texts, origin)


def read_stl(file: Path) -> Polygons:
    """Read an STL file, binary if its size is what its own count of triangles says, else text. Raises `BadInput`."""
    data = file.read_bytes()
    count = int.from_bytes(data[80:84], "little")
    if len(data) == 84 + 50 * count:
        row = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("spare", "<u2")])
        points = np.frombuffer(data, dtype=row, offset=84)["corners"].astype(np.float64).reshape(-1, 3)
        return Polygons(points, np.full(count, 3), np.arange(3 * count))
    if not re.match(rb"(\xef\xbb\xbf)?\s*solid\b", data) or b"facet" not in data:
        raise BadInput(
            f"{file} is neither text nor a whole binary STL file: its header promises {count:,} triangles, "
            f"its size fits {max(len(data) - 84, 0) // 50:,}."
        )
    return _read_stl_text(file, data)


def _read_stl_text(file: Path, data: bytes) -> Polygons:
    points: list[float] = []
    name, names, open_solid = b"", [], False  # type: bytes, list[bytes], bool
    for number, line in enumerate(data.removeprefix(b"\xef\xbb\xbf").splitlines(), start=1):
        words = line.split() or [b""]
        key = words[0].lower()
        try:
            if key == b"vertex":
                x, y, z = words[1:]
                points += (float(x), float(y), float(z))
            elif key == b"endfacet":
                names.append(name)
            elif key in (b"solid", b"endsolid"):
                open_solid, name = key == b"solid", b" ".join(words[1:])
            odd = key == b"endfacet" and len(points) != 9 * len(names)
            if odd or key not in _STL_WORDS or (key == b"vertex" and b"_" in line):
                raise ValueError
        except ValueError:
            raise BadInput(f"Line {number} of {file} does not belong in an STL file; repair or re-export it.") from None
    if open_solid or len(points) != 9 * len(names):
        raise BadInput(f"{file} ends inside a solid; the file is cut off or damaged.")
    polygons = checked(file, points, np.full(len(names), 3), np.arange(len(points) // 3))
    return _parted(polygons, names, "the solids of the file") if len(set(names)) > 1 else polygons


_STL_WORDS = frozenset((b"", b"solid", b"facet", b"outer", b"vertex", b"endloop", b"endfacet", b"endsolid"))
