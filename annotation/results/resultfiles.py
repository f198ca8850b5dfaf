"""Results to be judged, found by files and folders, and the shapes that they are of, found by their content."""

import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from engine.errors import BadInput
from engine.progress import Progress, silent

from ..records import Run
from ..storage.blobs import shape_key
from .resultfile import read_results

if TYPE_CHECKING:
    from engine.shapes.segmentation import SegmentedShape

SCHEMAS = (b'"concord.matches/', b'"concord.solution/')
_HEAD = 4096  # bytes of a file in which it says what it is
_ABOVE = 4  # folders above a result in which its meshes are looked for
MOST_SEGMENTS = 200  # that the automatic methods make
_PLAIN = ("pairs", "matches", "results")  # folders named by the program, not by a set


class ResultFile(NamedTuple):
    """A file of results and the set that it belongs to."""

    path: Path
    set_name: str


class FoundShapes(NamedTuple):
    """The shapes of results by key, and in sentences those that were not found."""

    shapes: dict[str, "SegmentedShape"]
    missing: tuple[str, ...]


def find_results(given: Iterable[str], set_name: str = "") -> tuple[ResultFile, ...]:
    """The files that are meant by files, folders and SET=PLACE, each once; raises `BadInput` for an empty folder.

    In a folder all files of matches and of solved puzzles count, in whatever depth. Where no set is named, it is the
    folder that the folder of the result lies in, and nothing for a file that is named itself.
    """
    found: dict[Path, ResultFile] = {}
    for text in given:
        name, equals, place = text.partition("=")
        named = bool(equals) and not Path(text).exists()
        path, chosen = (Path(place), name.strip()) if named else (Path(text), set_name)
        for one in _in_folder(path, chosen) if path.is_dir() else (ResultFile(path, chosen),):
            found.setdefault(one.path.absolute(), one)
    return tuple(found.values())


def _in_folder(folder: Path, set_name: str) -> list[ResultFile]:
    files = [path for path in sorted(folder.rglob("*.json")) if _is_result(path)]
    if not files:
        raise BadInput(f"{folder} holds no results (files matches.json or solution.json); name the folder that does.")
    return [ResultFile(path, set_name or _set_of(path, folder)) for path in files]


def _is_result(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            head = file.read(_HEAD)
    except OSError:
        return False
    return any(schema in head for schema in SCHEMAS)


def _set_of(path: Path, folder: Path) -> str:
    """The folder that holds the folder of a result, as far as it lies in the folder that was named."""
    top = folder.absolute()
    above = [p for p in path.absolute().parents[1:] if p == top or top in p.parents] or [top]
    return next((p.name for p in above if p.name not in _PLAIN), above[-1].name)


def read_all(files: Sequence[ResultFile], *, progress: Progress = silent) -> tuple[Run, ...]:
    """The run of each file."""
    runs = []
    for number, file in enumerate(files):
        progress(number / len(files), f"reading {file.path.name}")
        runs.append(read_results(file.path, file.set_name))
    return tuple(runs)


def find_shapes(
    files: Sequence[ResultFile], runs: Sequence[Run], folders: Iterable[Path] = (), *, progress: Progress = silent
) -> FoundShapes:
    """The shapes that results of shapes are of; `files` tells of each run where it was read.

    Meshes are looked for where they were when the result was made, beside the result and above it, and in all of
    `folders`; only one whose content is the stated one is taken, with the same segments where the result states them.
    """
    wanted: dict[str, tuple[Any, Path]] = {}
    for file, run in zip(files, runs, strict=True):
        for side in (run.source, run.target) if run.kind == "shape" else ():
            wanted.setdefault(shape_key(side), (side, file.path))
    library = [path for folder in folders for path in sorted(folder.rglob("*"))]
    named: dict[str, list[Path]] = {}
    for path in library:
        named.setdefault(path.name.lower(), []).append(path)
    found: dict[str, SegmentedShape] = {}
    missing, meshes = [], _Meshes()
    for number, (key, (side, near)) in enumerate(wanted.items()):
        progress(number / len(wanted), f"looking for {_name(side['file'])}")
        name = _name(side["file"])
        places = (*_places(side["file"], near), *named.get(name.lower(), ()))
        shape, why = meshes.shape(side, places)
        if shape is None:
            missing.append(f"{side['file']} {why}")
        else:
            found[key] = shape
    return FoundShapes(found, tuple(missing))


def _name(file: str) -> str:
    """The name of a file, whatever system its path is of."""
    return re.split(r"[\\/]", file)[-1]


def _places(file: str, near: Path) -> Iterator[Path]:
    """Where a mesh may lie, by the name in a result and the place of the result."""
    yield Path(file)
    for folder in near.absolute().parents[:_ABOVE]:
        yield from (folder / file, folder / _name(file))


def _segmented(path: Path, count: int) -> Iterator["SegmentedShape"]:
    """A mesh with the segments that it comes with or, where it has no labels, those of the quick automatic methods."""
    from engine.shapes.meshfile import load_shape
    from engine.shapes.segmentationparameters import DEFAULT, PARTS, PATCHES
    from engine.store import default_cache

    yield load_shape(path, cache=default_cache())
    for method in (PARTS, PATCHES) if 2 <= count <= MOST_SEGMENTS else ():
        shape = load_shape(path, automatic=DEFAULT.changed(method=method, segments=count), cache=default_cache())
        if not shape.automatic:
            return
        yield shape


class _Meshes:
    """Mesh files that were read, each once."""

    def __init__(self) -> None:
        self._read: dict[Path, str | None] = {}

    def shape(self, side: Any, places: Iterable[Path]) -> tuple["SegmentedShape | None", str]:
        """The shape of a side, or why there is none."""
        from engine.shapes.identity import node_id, segment_ids

        why = "was not found"
        for path in dict.fromkeys(place.absolute() for place in places):
            if self._identity(path) != side["sha256"]:
                continue
            try:
                for shape in _segmented(path, side["segments"]):
                    if side.get("segmentation") in (None, "", node_id(segment_ids(shape.mesh, shape.segmentation))):
                        return shape, ""
                why = f"was found as {path}, but with other segments"
            except BadInput as error:
                why = f"cannot be read ({error})"
        return None, why

    def _identity(self, path: Path) -> str | None:
        """The hash of a mesh file's content; None of anything else."""
        from engine.shapes.identity import mesh_id
        from engine.shapes.meshfile import load_mesh

        if path not in self._read:
            try:
                self._read[path] = mesh_id(load_mesh(path)[0]) if path.is_file() else None
            except (BadInput, OSError, ValueError):  # also names that no system takes
                self._read[path] = None
        return self._read[path]
