"""The command `segment`, which makes `.seg` files, and the automatic segments of other commands."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from .cli import progress_bar
from .errors import BadInput
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
    print(f"{found.count} segments of {surface.name} ({len(face):,} faces) written to {target}{fewer}")


def loaded(
    source: tuple[Path, Path | None], target: tuple[Path, Path | None], *, count: int | None, method: str | None
) -> "tuple[SegmentedShape, SegmentedShape]":
    """Two shapes from meshes and their label files; a mesh without labels is segmented, as asked where something is."""
    from .shapes.meshfile import load_shape

    wanted: dict[str, Any] = {name: value for name, value in (("segments", count), ("method", method)) if value is not None}
    automatic: SegmentationParameters | None = DEFAULT.changed(**wanted) if wanted else None
    with progress_bar() as progress:
        cache = default_cache()
        first = load_shape(*source, automatic=automatic, cache=cache, progress=share(progress, 0.0, 0.5))
        return first, load_shape(*target, automatic=automatic, cache=cache, progress=share(progress, 0.5, 1.0))
