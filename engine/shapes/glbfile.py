"""The parts of a GLB file: its plan is checked against the size of the file before trimesh builds anything.

A few hundred bytes of JSON can ask for terabytes, name other files, or tie nodes into a circle; none of that is
followed. Compressed and sparse geometry is refused, because it would be read as zeros.
"""

import json
import logging
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import BadInput

MOST_PARTS = 10_000
_DEEPEST = 200
_SIZES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_HARMLESS = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_")
_FREE_VERTICES = 2_000_000

Part = tuple[str, np.ndarray, np.ndarray]  # name, vertices (n, 3) in their place, triangles (m, 3)


def read_glb(file: Path) -> list[Part]:
    """Read the parts of a GLB file, in the order of its nodes, placed in the scene. Raises `BadInput`."""
    import trimesh

    logging.getLogger("trimesh").setLevel(logging.CRITICAL)
    try:
        plan = _plan(file)
        _check_references(file, plan)
        _check_sizes(file, plan)
        _check_nodes(file, plan)
        scene = trimesh.load_scene(file, process=False, skip_materials=True)
        parts = [_part(file, str(node), scene.geometry[name], transform) for node, transform, name in _shown(scene)]
    except (BadInput, KeyboardInterrupt, MemoryError):
        raise
    except BaseException as error:
        raise BadInput(f"{file} cannot be read as GLB ({_reason(error)}); repair or re-export it.") from None
    return [part for part in parts if part is not None]


def _plan(file: Path) -> dict[str, Any]:
    """The JSON of the file, which says what its bytes mean."""
    size = file.stat().st_size
    with file.open("rb") as stream:
        head = stream.read(20)
        length = int.from_bytes(head[12:16], "little")
        if len(head) < 20 or head[:4] != b"glTF" or head[16:20] != b"JSON" or int.from_bytes(head[8:12], "little") != size:
            raise BadInput(f"{file} is no GLB file, or its size is not what its header says; re-export it.")
        plan = json.loads(stream.read(min(length, size)).decode("utf-8"))
    if not isinstance(plan, dict):
        raise ValueError("its JSON part is not a table")
    return plan


def _check_references(file: Path, plan: dict[str, Any]) -> None:
    if any("uri" in buffer for buffer in plan.get("buffers", [])):
        raise BadInput(f"{file} keeps its geometry in another file; export it as one self-contained GLB file.")
    unknown = [e for e in plan.get("extensionsRequired", []) if not str(e).startswith(_HARMLESS)]
    packed = [e for m in plan.get("meshes", []) for p in m["primitives"] for e in p.get("extensions", {}) if "draco" in e]
    packed += [e for view in plan.get("bufferViews", []) for e in view.get("extensions", {})]
    if unknown or packed:
        name = str((unknown + packed)[0])[:40]
        raise BadInput(f"{file} needs the extension {name!r}, which Concord does not read; export it without compression.")


def _check_sizes(file: Path, plan: dict[str, Any]) -> None:
    """Refuse what would take far more memory than the file has bytes, or would be read as zeros."""
    size = file.stat().st_size
    accessors = plan.get("accessors", [])
    views = [_count(view["byteLength"]) for view in plan.get("bufferViews", [])]
    needs = [_count(a["count"]) * _SIZES[a["componentType"]] * _WIDTHS[a["type"]] for a in accessors]
    for a in plan.get("accessors", []) + plan.get("bufferViews", []):
        _count(a.get("byteOffset", 0))
    if any("bufferView" not in a or "sparse" in a for a in accessors):
        raise BadInput(f"{file} has numbers that are sparse or left out, which Concord does not read; re-export it.")
    if any(n > size for n in views + needs) or sum(views) > 8 * size or sum(needs) > 8 * size:
        raise BadInput(f"{file} promises more numbers than it has bytes; it is cut off or damaged.")


def _check_nodes(file: Path, plan: dict[str, Any]) -> None:
    """Refuse nodes in circles, with two parents, too many, too deep, or that repeat too much."""
    nodes = plan.get("nodes", [])
    pieces = [len(mesh["primitives"]) for mesh in plan.get("meshes", [])]
    many = max(len(nodes), sum(pieces), sum(pieces[_count(node["mesh"])] for node in nodes if "mesh" in node))
    if many > MOST_PARTS:
        raise BadInput(f"{file} has {many:,} nodes or parts; join them to at most {MOST_PARTS:,} first.")
    level = [_count(n) for n in plan["scenes"][_count(plan.get("scene", 0))].get("nodes", [])] if plan.get("scenes") else []
    seen: set[int] = set()
    depth = 0
    while level:
        if depth > _DEEPEST or len(set(level)) < len(level) or not seen.isdisjoint(level) or max(level) >= len(nodes):
            raise BadInput(f"{file} has nodes that are no tree, or one deeper than {_DEEPEST} levels; re-export it.")
        seen.update(level)
        level = [_count(child) for n in level for child in nodes[n].get("children", [])]
        depth += 1
    weight = [sum(_weight(plan, p) for p in mesh["primitives"]) for mesh in plan.get("meshes", [])]
    placed = sum(weight[_count(nodes[n]["mesh"])] for n in seen if "mesh" in nodes[n])
    if max(placed, sum(weight)) > max(_FREE_VERTICES, file.stat().st_size):
        raise BadInput(f"{file} repeats its parts so often that they have {placed:,} vertices; simplify it first.")


def _weight(plan: dict[str, Any], primitive: dict[str, Any]) -> int:
    """Vertices and indices of a primitive."""
    used = [primitive["attributes"].get("POSITION"), primitive.get("indices")]
    return sum(_count(plan["accessors"][_count(n)]["count"]) for n in used if n is not None)


def _count(value: Any) -> int:
    """A whole number of at least 0. Raises `ValueError`."""
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise ValueError("it has a count or an index that is no whole number of at least 0")
    return value


def _shown(scene: Any) -> list[tuple[str, np.ndarray, str]]:
    """Name, transform (4, 4) and geometry of each node of a scene that shows a geometry, in the file's order."""
    return [(str(node), *scene.graph[node]) for node in scene.graph.nodes_geometry]


def _part(file: Path, name: str, geometry: Any, transform: np.ndarray) -> Part | None:
    """A part in its place, or None for lines and points."""
    if not hasattr(geometry, "faces") or not len(geometry.faces):
        return None
    faces = np.asarray(geometry.faces)
    if faces.min() < 0 or faces.max() >= len(geometry.vertices):
        raise BadInput(f"A face of part {name[:40]!r} of {file} has an index outside of its vertices; repair the file.")
    placed = geometry.copy().apply_transform(transform)
    return name, np.asarray(placed.vertices, dtype=np.float64), np.asarray(placed.faces, dtype=np.int64).reshape(-1, 3)


def _reason(error: BaseException) -> str:
    """What a reader's failure means to someone who did not write it."""
    if isinstance(error, UnicodeDecodeError | json.JSONDecodeError | RecursionError):
        return "the description of its scene is damaged"
    words = str(error).strip().rstrip(".")
    if isinstance(error, ValueError | NotImplementedError) and 10 < len(words) < 120 and words.isprintable():
        return words
    return f"its parts do not fit together: {type(error).__name__}"
