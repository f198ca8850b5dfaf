"""Read meshes and their segment labels from files that strangers made.

trimesh parses; everything it returns is checked before it is used. Face order is that of the file, because label
files hold one integer a face in that order.
"""

import logging
import re
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..errors import BadInput
from .mesh import Mesh
from .segmentation import Segmentation, SegmentedShape, segmentation_from_labels

MESH_SUFFIXES = (".off", ".obj", ".ply", ".stl", ".glb")
LARGEST_FILE = 2 * 2**30
_PLY_LABEL_NAMES = ("segment", "segment_id", "label", "labels", "seg")
_SPLIT_VERTICES = (".stl", ".obj", ".glb")  # formats or readers that repeat a vertex for each face or part


def load_shape(path: Path | str, labels: Path | str | None = None) -> SegmentedShape:
    """Read a mesh with its segments.

    Labels are taken, in this order, from `labels` (one integer a face), a `.seg` file of the same stem beside the
    mesh, a face property of a PLY file (`segment` or `label`), the groups or objects of an OBJ file, the parts of a
    GLB file; without any, the connected components are the segments, and `notes` says so.

    Raises
    ------
    BadInput
        In one sentence, where a file is missing, empty, damaged, too large, not a mesh, or labels do not fit.
    """
    file = _existing(path)
    beside = file.with_suffix(".seg")
    if labels is None and beside.is_file():
        labels = beside
    parts = _read_parts(file, split=labels is None)
    mesh, part = _joined(file, parts)
    segmentation, note = _segments(file, labels, parts, mesh, part)
    return SegmentedShape(mesh, segmentation, str(path), (note,) if note else ())


def read_labels(path: Path | str) -> np.ndarray:
    """Read a label file: one integer a face, (m,) int64. Raises `BadInput`."""
    file = _existing(path, kind="labels file")
    try:
        words = file.read_text(encoding="ascii").split()
        return np.array([int(word) for word in words], dtype=np.int64)
    except (UnicodeDecodeError, ValueError, OverflowError):
        raise BadInput(f"The labels file {file} must hold one whole number a face and nothing else.") from None


def _existing(path: Path | str, kind: str = "mesh file") -> Path:
    file = Path(path)
    try:
        size = file.stat().st_size
        if file.is_dir():
            raise BadInput(f"{file} is a folder; give a {kind}.")
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


def _read_parts(file: Path, *, split: bool) -> list[tuple[str, Any]]:
    """The named trimesh geometries of a file, at least one; `split` keeps OBJ groups and GLB parts apart."""
    import trimesh

    logging.getLogger("trimesh").setLevel(logging.CRITICAL)
    suffix = file.suffix.lower()
    options: dict[str, Any] = {"process": False}
    if suffix == ".obj":
        groups = split and _obj_marks(file)
        options |= {"maintain_order": True, "skip_materials": True, "group_material": False}
        options |= {f"split_{groups}s": True} if groups else {}
    try:
        scene = trimesh.load_scene(file, **options)
        parts = [(name, scene.geometry[geometry].copy().apply_transform(transform))
                 for name, transform, geometry in _nodes(scene)]  # fmt: skip
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt | MemoryError):
            raise
        raise BadInput(f"{file} cannot be read as {suffix[1:].upper()} ({_reason(error)}); repair or re-export it.") from None
    parts = [(name, part) for name, part in parts if isinstance(part, trimesh.Trimesh)]
    if not parts:
        raise BadInput(f"{file} holds no triangles; Concord needs a surface mesh.")
    _complete(file, sum(len(part.faces) for _, part in parts))
    return parts


def _reason(error: BaseException) -> str:
    """The reader's own words where they are a short line, else what kind of failure it was."""
    words = str(error).strip().rstrip(".")
    return words if 0 < len(words) < 120 and "\n" not in words else f"it is damaged or misnamed: {type(error).__name__}"


def _nodes(scene: Any) -> list[tuple[str, np.ndarray, str]]:
    """Name, transform (4, 4) and geometry of each node of a scene that shows a geometry, in the file's order."""
    return [(str(node), *scene.graph[node]) for node in scene.graph.nodes_geometry]


def _obj_marks(file: Path) -> str:
    """'group' or 'object' where an OBJ file names at least two of them, else ''."""
    text = file.read_bytes()
    for mark, word in ((b"g", "group"), (b"o", "object")):
        if len(set(re.findall(rb"^" + mark + rb"[ \t]+(\S.*?)\s*$", text, flags=re.MULTILINE))) > 1:
            return word
    return ""


def _complete(file: Path, faces: int) -> None:
    """Refuse an OFF file that ends before the faces that its header promises."""
    if file.suffix.lower() != ".off":
        return
    words = re.sub(r"#.*", "", file.read_bytes()[:4096].decode("latin-1")).replace("OFF", " ", 1).split()
    if len(words) > 1 and words[1].isdigit() and faces < int(words[1]):
        raise BadInput(f"{file} promises {int(words[1]):,} faces but holds {faces:,}; the file is cut off or damaged.")


def _joined(file: Path, parts: list[tuple[str, Any]]) -> tuple[Mesh, np.ndarray]:
    """One mesh of all parts and the part of each face, (m,) int64."""
    offsets = np.cumsum([0, *(len(part.vertices) for _, part in parts)])
    vertices = np.concatenate([np.asarray(part.vertices, dtype=np.float64) for _, part in parts])
    rows = [np.asarray(part.faces, dtype=np.int64).reshape(-1, 3) for _, part in parts]
    faces = np.concatenate([part + start for part, start in zip(rows, offsets, strict=False)])
    owner = np.repeat(np.arange(len(parts)), [len(part.faces) for _, part in parts])
    return Mesh(vertices, faces, file.stem), owner


def _segments(
    file: Path, labels: Path | str | None, parts: list[tuple[str, Any]], mesh: Mesh, part: np.ndarray
) -> tuple[Segmentation, str]:
    if labels is not None:
        values = read_labels(labels)
        if len(values) != len(mesh.faces):
            raise BadInput(
                f"The labels file {labels} has {len(values):,} labels but {file} has {len(mesh.faces):,} faces; "
                "give one label a face, in face order."
            )
        return segmentation_from_labels(values), ""
    if file.suffix.lower() == ".ply":
        found, name = _ply_labels(parts[0][1], len(mesh.faces))
        if found is not None:
            return segmentation_from_labels(found), f"Segments of {mesh.name} are the PLY face property '{name}'."
    if len(parts) > 1:
        kind = "groups" if file.suffix.lower() == ".obj" else "parts"
        names, inverse = np.unique([name for name, _ in parts], return_inverse=True)
        used, labels_of_faces = np.unique(inverse[part], return_inverse=True)
        chosen = tuple(str(names[u]) for u in used)
        return Segmentation(labels_of_faces, chosen), f"Segments of {mesh.name} are the {kind} of the file."
    note = f"{mesh.name} has no labels: its connected components are the segments."
    return segmentation_from_labels(components(mesh, merge=file.suffix.lower() in _SPLIT_VERTICES)), note


def _ply_labels(part: Any, faces: int) -> tuple[np.ndarray | None, str]:
    data = part.metadata.get("_ply_raw", {}).get("face", {}).get("data")
    fields = data.dtype.names if data is not None and getattr(data, "dtype", None) is not None else data
    for name in _PLY_LABEL_NAMES:
        if fields is not None and name in fields:
            values = np.asarray(data[name]).ravel()
            if len(values) == faces and np.isfinite(values.astype(float)).all():
                return values.astype(np.int64), name
    return None, ""


def merged_vertices(mesh: Mesh) -> np.ndarray:
    """For each vertex, (n,) int64, the number of its position: equal positions have equal numbers."""
    return np.unique(mesh.vertices + 0.0, axis=0, return_inverse=True)[1].ravel()


def components(mesh: Mesh, *, merge: bool = False) -> np.ndarray:
    """Connected component of each face, (m,) int64; `merge` joins vertices at equal positions first."""
    faces = merged_vertices(mesh)[mesh.faces] if merge else mesh.faces
    count = len(mesh.vertices)
    rows, columns = faces[:, [0, 1]].ravel(), faces[:, [1, 2]].ravel()
    graph = coo_array((np.ones(len(rows), dtype=bool), (rows, columns)), shape=(count, count))
    return connected_components(graph, directed=False)[1][faces[:, 0]].astype(np.int64)
