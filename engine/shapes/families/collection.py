"""Generated pairs as files: meshes, segmentations and the truth."""

import io
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...errors import BadParameter
from ...progress import Progress, silent
from ...store import output_folder, write_atomically
from ..mesh import Mesh
from ..segmentation import Segmentation
from .generated import DIGITS, FAMILIES, VARIANTS, check_choice
from .pairs import GeneratedPair, make_pair

MOST_PAIRS = 10_000
MOST_SEGMENTS = 500


def write_shape(
    folder: Path | str, name: str, mesh: Mesh, segmentation: Segmentation, label: np.ndarray, names: Sequence[str]
) -> Path:
    """Write NAME.off, NAME.seg, NAME.sem (one integer a face) and the folder's labels.json; gives the mesh's path.

    `label` (m,) indexes `names`. The folder is made if it is missing. Raises `BadInput` where it cannot be written.
    """
    target = output_folder(folder)
    write_atomically(target / "labels.json", json.dumps({"label_names": list(names)}, indent=1) + "\n")
    write_atomically(target / f"{name}.seg", integer_lines(segmentation.labels))
    write_atomically(target / f"{name}.sem", integer_lines(label))
    write_atomically(target / f"{name}.off", off_text(mesh))
    return target / f"{name}.off"


def off_text(mesh: Mesh) -> str:
    """The mesh as plain OFF, coordinates to six digits behind the point."""
    text = io.StringIO()
    text.write(f"OFF\n{len(mesh.vertices)} {len(mesh.faces)} 0\n")
    np.savetxt(text, mesh.vertices, fmt=f"%.{DIGITS}f")
    np.savetxt(text, np.c_[np.full(len(mesh.faces), 3), mesh.faces], fmt="%d")
    return text.getvalue()


def integer_lines(values: np.ndarray) -> str:
    """One integer a line."""
    return "\n".join(map(str, values.tolist())) + "\n"


def write_pair(folder: Path | str, stem: str, pair: GeneratedPair) -> tuple[Path, Path]:
    """Write both shapes of a pair as STEM_a and STEM_b; gives the paths of the two meshes."""
    source, target = (
        write_shape(folder, f"{stem}_{letter}", shape.mesh, shape.segmentation, label, pair.label_names)
        for letter, shape, label in (("a", pair.source, pair.source_label), ("b", pair.target, pair.target_label))
    )
    return source, target


def make_collection(
    out: Path | str,
    families: Sequence[str] = (),
    count: int = 1,
    seed: int = 0,
    variant: str = "touching",
    segments: tuple[int, int] | str = (10, 16),
    *,
    pose: str = "turned",
    progress: Progress = silent,
) -> list[Path]:
    """Write `count` pairs of each family (all where none is named) into OUT/FAMILY; gives the paths of the meshes.

    Pair k of a family has the seed `seed` + k. `segments` is (low, high) or "LOW-HIGH". Raises `BadParameter` before
    anything is written.
    """
    chosen = tuple(dict.fromkeys(families)) or tuple(FAMILIES)
    for family in chosen:
        check_choice("shape family", family, tuple(FAMILIES))
    check_choice("variant", variant, VARIANTS)
    if not 1 <= count <= MOST_PAIRS:
        raise BadParameter(f"The number of pairs must lie in 1..{MOST_PAIRS}, not {count}.")
    if seed < 0:
        raise BadParameter(f"The seed must be 0 or larger, not {seed}.")
    span = parse_segments(segments) if isinstance(segments, str) else segments
    check_segments(span)
    folder = output_folder(out)
    written: list[Path] = []
    for k in range(count * len(chosen)):
        family, number = chosen[k // count], seed + k % count
        progress(k / (count * len(chosen)), f"{family} {number}")
        pair = make_pair(family, number, variant=variant, segments=span, pose=pose)
        written.extend(write_pair(folder / family, f"{family}_{number:03d}", pair))
    progress(1.0, f"{len(written)} shapes")
    return written


def parse_segments(text: str) -> tuple[int, int]:
    """LOW-HIGH or a single number as a range of segment counts; raises `BadParameter`."""
    low, dash, high = text.partition("-")
    if not low.strip().isdigit() or (dash and not high.strip().isdigit()):
        raise BadParameter(f"The range of segments must be LOW-HIGH, such as 10-16, not '{text}'.")
    segments = int(low), int(high if dash else low)
    check_segments(segments)
    return segments


def check_segments(segments: tuple[int, int]) -> None:
    """Raise `BadParameter` where the range of segment counts is empty or out of bounds."""
    low, high = segments
    if not 2 <= low <= high <= MOST_SEGMENTS:
        raise BadParameter(
            f"The range of segments must be LOW-HIGH with 2 <= LOW <= HIGH <= {MOST_SEGMENTS}, not {low}-{high}."
        )
