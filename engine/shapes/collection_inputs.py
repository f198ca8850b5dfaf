"""Which files make a collection: folders of meshes, meshes, and label files that stand with them."""

import re
from collections.abc import Sequence
from pathlib import Path

from ..errors import BadInput
from ..progress import Progress, share, silent
from ..store import Cache
from .meshfile import MESH_SUFFIXES, load_shape
from .segmentation import SegmentedShape
from .segmentationparameters import SegmentationParameters

LABELS = (".seg", ".txt")
MOST_SHAPES = 500

Files = list[tuple[Path, Path | None]]


def collection_files(inputs: Sequence[Path | str], ending: str = "") -> Files:
    """Each mesh with its label file, or None where it is to be looked for as `load_shape` does.

    Folders stand for the meshes in them. A label file among the inputs belongs to the mesh whose name it begins with;
    `ending` takes STEM.ENDING beside each other mesh. Raises `BadInput` in one sentence.
    """
    paths = [Path(path) for path in inputs]
    labels = [path for path in paths if path.suffix.lower() in LABELS]
    meshes = [mesh for path in paths if path not in labels for mesh in (meshes_in(path) if path.is_dir() else [path])]
    meshes = list(dict.fromkeys(meshes))
    if not meshes:
        raise BadInput("A collection needs meshes: name a folder that holds some, or several meshes.")
    if len(meshes) < 2 and not meshes[0].exists():
        raise BadInput(f"{meshes[0]} is not there; name a folder that holds meshes, or several meshes.")
    if len(meshes) < 2:
        raise BadInput(f"A collection needs at least two shapes, and {meshes[0]} is only one; name more of them.")
    if len(meshes) > MOST_SHAPES:
        raise BadInput(f"{len(meshes)} meshes are too many for one collection; name at most {MOST_SHAPES}.")
    return [(mesh, _labels_of(mesh, meshes, labels, ending)) for mesh in meshes]


def meshes_in(folder: Path) -> list[Path]:
    """The meshes that lie directly in a folder, 'chair 2' before 'chair 10'."""
    try:
        found = [path for path in folder.iterdir() if path.suffix.lower() in MESH_SUFFIXES and path.is_file()]
    except OSError as error:
        raise BadInput(f"The folder {folder} cannot be read ({error.strerror}).") from None
    return sorted(found, key=lambda path: _natural(path.name))


def load_collection(
    files: Files,
    *,
    automatic: SegmentationParameters | None = None,
    progress: Progress = silent,
    cache: Cache | None = None,
) -> tuple[list[SegmentedShape], list[str]]:
    """The shapes that can be read, and a sentence for each that cannot; `automatic` as `load_shape` takes it."""
    shapes, failures = [], []
    for row, (mesh, labels) in enumerate(files):
        progress(row / len(files), f"reading {mesh.name}")
        own = share(progress, row / len(files), (row + 1) / len(files))
        try:
            shapes.append(load_shape(mesh, labels, automatic=automatic, progress=own, cache=cache))
        except BadInput as error:
            failures.append(f"{mesh.name} was left out: {error}")
    return shapes, failures


def _labels_of(mesh: Path, meshes: Sequence[Path], labels: Sequence[Path], ending: str) -> Path | None:
    """The named label file that begins with the mesh's name (and with no longer one), else the one of the ending."""
    for label in labels:
        owners = [other for other in meshes if label.name.startswith(other.stem + ".")]
        if owners and mesh.stem == max(owners, key=lambda other: len(other.stem)).stem:
            return label
    if not ending:
        return None
    beside = mesh.with_name(f"{mesh.stem}.{ending.lstrip('.')}")
    if not beside.is_file():
        raise BadInput(f"There are no labels {beside}; give another --labels, or name the label files among the meshes.")
    return beside


def _natural(name: str) -> list[tuple[int, int, str]]:
    """Digits compare as numbers."""
    return [(1, int(word), "") if word.isdigit() else (0, 0, word.lower()) for word in re.split(r"(\d+)", name) if word]
