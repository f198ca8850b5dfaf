"""The command `segment`, which makes `.seg` files, and the automatic segments of other commands."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .cli import progress_bar
from .errors import BadInput, BadParameter
from .parameters import declared
from .progress import share
from .shapes.segmentationparameters import DEFAULT, SegmentationParameters
from .store import default_cache, output_folder, write_atomically

if TYPE_CHECKING:
    from .shapes.segmentation import SegmentedShape


def segment(
    mesh: Path,
    *,
    out: Path | None = None,
    method: str = DEFAULT.method,
    segments: int = DEFAULT.segments,
    seed: int = DEFAULT.seed,
    crease: float = DEFAULT.crease,
    concavity: float = DEFAULT.concavity,
    overwrite: bool = False,
) -> None:
    """Cut a mesh into segments and write them as a .seg file: one integer a face, in the order of the file.

    Parameters
    ----------
    mesh
        OFF, OBJ, PLY, STL or GLB; labels that it has are not looked at.
    out
        The file to write; beside the mesh, with the ending .seg, if left out.
    method
        parts (small patches joined to nearly convex parts), patches (of like size), or convex (CoACD, slow).
    segments
        How many, from 2 to 200.
    seed
        Seed of the first patch and of CoACD's search.
    crease
        How far patches keep from each other's side of a concave crease.
    concavity
        Concavity that CoACD tolerates in a part.
    overwrite
        Replace the file if it is there.
    """
    from .shapes.meshfile import load_mesh
    from .shapes.segmenting import auto_segment, segment_file_text

    chosen = DEFAULT.changed(method=method, segments=segments, seed=seed, crease=crease, concavity=concavity)
    target = out if out is not None else mesh.with_suffix(".seg")
    if target.exists() and not overwrite:
        raise BadInput(f"{target} is there already; give another name with --out, or --overwrite to replace it.")
    surface, face = load_mesh(mesh)
    output_folder(target.parent)
    with progress_bar() as progress:
        found = auto_segment(surface, chosen, progress=progress, cache=default_cache())
    write_atomically(target, segment_file_text(found.labels))
    fewer = f", not {segments}: the mesh has no more pieces to give" if found.count < segments else ""
    cut = "1 segment" if found.count == 1 else f"{found.count} segments"
    print(f"{cut} of {surface.name} ({len(face):,} {'face' if len(face) == 1 else 'faces'}) written to {target}{fewer}")


def asked_segmentation(count: int | None, method: str | None) -> SegmentationParameters | None:
    """How meshes without labels are cut, where --segments or --segmentation asks for something; raises `BadParameter`."""
    if count is None and method is None:
        return None
    methods = next(info.choices for info in declared(SegmentationParameters) if info.name == "method")
    if method is not None and method not in methods:
        raise BadParameter(f"--segmentation cannot be '{method}': it takes one of {', '.join(methods)}.")
    wanted: dict[str, Any] = {name: value for name, value in (("segments", count), ("method", method)) if value is not None}
    return DEFAULT.changed(**wanted)


def loaded(
    source: tuple[Path, Path | None], target: tuple[Path, Path | None], *, count: int | None, method: str | None
) -> "tuple[SegmentedShape, SegmentedShape]":
    """Two shapes from meshes and their label files; a mesh without labels is segmented, as asked where something is."""
    from .shapes.meshfile import load_shape

    automatic = asked_segmentation(count, method)
    shapes = []
    with progress_bar() as progress:
        for number, files in enumerate((source, target)):
            own = share(progress, number / 2, (number + 1) / 2)
            shapes.append(load_shape(*files, automatic=automatic, cache=default_cache(), progress=own))
    if automatic is not None:
        shapes = [_with_note(shape) for shape in shapes]
    return shapes[0], shapes[1]


def _with_note(shape: "SegmentedShape") -> "SegmentedShape":
    """A shape that was to be cut says so where it was not."""
    if shape.automatic:
        return shape
    note = f"{shape.mesh.name} has labels, which stand; only meshes without any are cut (--segments, --segmentation)."
    return replace(shape, notes=(*shape.notes, note))
