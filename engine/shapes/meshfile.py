"""Read meshes and their segment labels from files that strangers made.

Whatever a file holds, the answer is a checked mesh or one sentence. Face order is that of the file, because label files
hold one integer a face in that order; a face of more than three corners becomes a fan of triangles with its label.
"""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from ..errors import BadInput
from ..progress import Progress, silent
from ..store import Cache
from .glbfile import Part, read_glb
from .mesh import Mesh, components, face_areas
from .plyfile import read_ply
from .polygonfile import Polygons, read_obj, read_off, read_stl, shown, whole
from .segmentation import Segmentation, SegmentedShape, segmentation_from_labels
from .segmentationparameters import DEFAULT, SegmentationParameters
from .segmenting import auto_segment, origin_words

MESH_SUFFIXES = (".off", ".obj", ".ply", ".stl", ".glb")
LARGEST_FILE = 2 * 2**30
MOST_COMPONENTS, LARGEST_COMPONENT = 100, 0.9  # in number, and as a share of the area: else they are no segments
_SPLIT_VERTICES = (".stl", ".obj", ".glb")  # formats that often repeat a vertex for each face or part
_READERS: dict[str, Callable[[Path], Polygons]] = {".off": read_off, ".obj": read_obj, ".ply": read_ply, ".stl": read_stl}


def load_shape(
    path: Path | str,
    labels: Path | str | None = None,
    *,
    automatic: SegmentationParameters | None = None,
    progress: Progress = silent,
    cache: Cache | None = None,
) -> SegmentedShape:
    """Read a mesh with its segments.

    Labels are taken, in this order, from `labels` (one integer a face), a `.seg` file of the same stem beside the
    mesh, a face property of a PLY file (`segment` or `label`), the groups or objects of an OBJ file, the parts of a
    GLB file. A mesh without any is segmented as `automatic` says; without that, its connected components are the
    segments where they look like parts (2 to 100, none nearly the whole), else `DEFAULT` is used. `notes` says so.

    Raises
    ------
    BadInput
        In one sentence, where a file is missing, empty, damaged, too large, not a mesh, or labels do not fit.
    """
    file = _existing(path)
    beside = file.with_suffix(".seg")
    if labels is None and beside.is_file():
        labels = beside
    polygons, mesh, face = _read_mesh(file)
    found = _segments(file, labels, polygons, mesh, face)
    if found is None and automatic is None:
        found = _component_segments(file, mesh)
    if found is not None:
        return SegmentedShape(mesh, found[0], str(path), (found[1],) if found[1] else ())
    chosen = automatic or DEFAULT
    segmentation = auto_segment(mesh, chosen, progress=progress, cache=cache)
    return SegmentedShape(mesh, segmentation, str(path), (origin_words(mesh, segmentation, chosen),), automatic=True)


def load_labellings(path: Path | str, labels: Sequence[Path | str]) -> tuple[Mesh, tuple[Segmentation, ...]]:
    """A mesh, read once, with a segmentation by each of several label files; raises as `load_shape`."""
    file = _existing(path)
    polygons = _read_polygons(file)
    triangles, face = polygons.triangles()
    found = tuple(_from_labels(file, one, face, len(polygons.sizes))[0] for one in labels)
    return Mesh(polygons.vertices, triangles, file.stem), found


def load_mesh(path: Path | str) -> tuple[Mesh, np.ndarray]:
    """Read a mesh without looking for labels, and for each triangle (m,) the polygon of the file that it is part of.

    Raises `BadInput` as `load_shape` does.
    """
    return _read_mesh(_existing(path))[1:]


def _read_mesh(file: Path) -> tuple[Polygons, Mesh, np.ndarray]:
    polygons = _read_polygons(file)
    triangles, face = polygons.triangles()
    return polygons, Mesh(polygons.vertices, triangles, file.stem), face


def read_labels(path: Path | str) -> np.ndarray:
    """Read a label file: one integer a face, (m,) int64; blank lines and a byte-order mark are passed over.

    Raises
    ------
    BadInput
        Names the first line that holds anything but whole numbers of 64 bits.
    """
    file = _existing(path, kind="labels file")
    data = file.read_bytes().removeprefix(b"\xef\xbb\xbf")
    try:
        return np.array([whole(word) for word in data.split()], dtype=np.int64)
    except (ValueError, OverflowError):
        number, word = next((n, w) for n, line in enumerate(data.splitlines(), start=1) for w in line.split() if not _fits(w))
        raise BadInput(f"Line {number} of the labels file {file} says {shown(word)}; give one whole number a face.") from None


def _fits(word: bytes) -> bool:
    try:
        return -(2**63) <= whole(word) < 2**63
    except ValueError:
        return False


def _existing(path: Path | str, kind: str = "mesh file") -> Path:
    file = Path(path)
    try:
        size = file.stat().st_size
        if file.is_dir():
            raise BadInput(f"{file} is a folder; give a {kind}.")
        if not file.is_file():
            raise BadInput(f"{file} is no ordinary file; give a {kind}.")
        with file.open("rb"):
            pass
    except OSError as error:
        raise BadInput(f"The {kind} {file} cannot be read: {error.strerror}.") from None
    if size == 0:
        raise BadInput(f"The {kind} {file} is empty.")
    if size > LARGEST_FILE:
        raise BadInput(f"The {kind} {file} is larger than 2 GiB; simplify it first.")
    if kind == "mesh file" and file.suffix.lower() not in MESH_SUFFIXES:
        wanted = ", ".join(MESH_SUFFIXES)
        raise BadInput(f"{file} is not of a kind that Concord reads; convert it to one of {wanted}.")
    return file


def _read_polygons(file: Path) -> Polygons:
    """The faces of a file, at least one, with the parts that it names."""
    suffix = file.suffix.lower()
    try:
        polygons = _of_parts(read_glb(file)) if suffix == ".glb" else _READERS[suffix](file)
    except MemoryError:
        raise BadInput(f"{file} needs more memory than there is; simplify it first.") from None
    if not len(polygons.sizes):
        raise BadInput(f"{file} has no faces: it holds no triangles; Concord needs a surface mesh.")
    return polygons


def _of_parts(parts: list[Part]) -> Polygons:
    """Polygons of all parts of a scene, each with its part."""
    if not parts:
        return Polygons(np.zeros((0, 3)), np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64))
    names, vertices, faces = zip(*parts, strict=True)
    offsets = np.cumsum([0, *map(len, vertices)])
    corners = np.concatenate([rows.ravel() + start for rows, start in zip(faces, offsets, strict=False)])
    unique, inverse = np.unique(names, return_inverse=True)
    part = np.repeat(inverse.ravel(), [len(rows) for rows in faces]) if len(unique) > 1 else None
    sizes = np.full(len(corners) // 3, 3)
    return Polygons(np.concatenate(vertices), sizes, corners, part, tuple(map(str, unique)), "the parts of the file")


def _segments(
    file: Path, labels: Path | str | None, polygons: Polygons, mesh: Mesh, face: np.ndarray
) -> tuple[Segmentation, str] | None:
    """Segments and a sentence on where they came from, if any; `face` (m,) is the polygon of each triangle."""
    if labels is not None:
        return _from_labels(file, labels, face, len(polygons.sizes))
    if polygons.part is not None:
        note = f"Segments of {mesh.name} are {polygons.origin}."
        found = segmentation_from_labels(polygons.part[face])
        names = tuple(polygons.part_names[int(n)] for n in found.names) if polygons.part_names else found.names
        return Segmentation(found.labels, names), note
    return None


def _component_segments(file: Path, mesh: Mesh) -> tuple[Segmentation, str] | None:
    """The connected components where they look like parts."""
    found = segmentation_from_labels(components(mesh, merge=file.suffix.lower() in _SPLIT_VERTICES))
    area = np.bincount(found.labels, face_areas(mesh))
    if not 2 <= found.count <= MOST_COMPONENTS or area.max() > LARGEST_COMPONENT * area.sum():
        return None
    return found, f"{mesh.name} has no labels: its connected components are the segments."


def _from_labels(file: Path, labels: Path | str, face: np.ndarray, count: int) -> tuple[Segmentation, str]:
    """Segments from a label file with one label a polygon or, where the file has polygons, one a triangle of them."""
    values = read_labels(labels)
    if len(values) == count:
        return segmentation_from_labels(values[face]), ""
    if len(values) == len(face):
        note = f"{file.name} has polygons; its labels are taken as one for each triangle of them, in the order of the file."
        return segmentation_from_labels(values), note
    cut = len(face) > count
    faces = f"{count:,} polygons, which are {len(face):,} triangles" if cut else f"{count:,} faces"
    advice = "give one label a polygon, or one a triangle" if cut else "give one label a face"
    raise BadInput(f"The labels file {labels} has {len(values):,} labels but {file} has {faces}; {advice}, in the file's order.")
