"""Which pairs a collection holds: a folder of labelled meshes, each sub-folder a family, or families made by seed."""

import re
from collections.abc import Iterator, Sequence
from itertools import islice, pairwise
from pathlib import Path
from typing import NamedTuple

from ..errors import BadInput, BadParameter
from ..progress import Progress, share, silent
from ..shapes.families import FAMILIES, POSES, VARIANTS
from ..shapes.families.collection import check_segments
from ..shapes.families.generated import check_choice
from ..shapes.meshfile import MESH_SUFFIXES, load_labellings
from .pairs import FilePair, MadePair, Pair, ShapeFiles

GENERATED = "generated"
AUTO, ALL = "auto", "all"
MOST_PAIRS = 100_000
LEFT_OUT = "Left out of"


class Layout(NamedTuple):
    """How shapes of a folder are paired and labelled.

    `source_labels`, `target_labels` and `truth` are what stands behind a mesh's stem, such as ".coarse.seg". Where none
    are named and there are no .seg files, or with `cut`, the truth is cut at random into `segments` pieces. `pairs` is
    "auto" (NAME_a with NAME_b, else each shape with the next), "all", or how many of each family.
    """

    source_labels: str = ""
    target_labels: str = ""
    truth: str = ".sem"
    segments: tuple[int, int] = (10, 16)
    cut: bool = False
    seed: int = 0
    pairs: str = AUTO
    families: tuple[str, ...] = ()


class Collection(NamedTuple):
    """The pairs, and what was left out and why, in sentences."""

    name: str
    pairs: tuple[Pair, ...]
    notes: tuple[str, ...]


def generated_collection(layout: Layout, variants: Sequence[str], pose: str) -> Collection:
    """Pairs of every family, each pair of its own seed: pair n of family f of F has seed + n F + f.

    The variants take turns within a family. Raises `BadParameter`.
    """
    chosen = layout.families or tuple(FAMILIES)
    for family in chosen:
        check_choice("shape family", family, tuple(FAMILIES))
    for variant in variants:
        check_choice("variant", variant, VARIANTS)
    check_choice("pose", pose, POSES)
    check_segments(layout.segments)
    if layout.pairs == ALL:
        raise BadParameter("Of generated shapes there are as many pairs as wanted; say how many, as in --pairs 6.")
    count = 1 if layout.pairs == AUTO else _count(layout.pairs)
    pairs: list[Pair] = []
    for n in range(count):
        for f, family in enumerate(chosen):
            seed, variant = layout.seed + n * len(chosen) + f, variants[n % len(variants)]
            pairs.append(MadePair(family, f"{seed} {variant}", seed, variant, layout.segments, pose))
    return Collection(GENERATED, tuple(sorted(pairs, key=lambda p: chosen.index(p.family))), ())


def folder_collection(folder: Path, layout: Layout, *, progress: Progress = silent) -> Collection:
    """The pairs of a folder, every shape in them read once to be sure that its labels fit.

    Raises
    ------
    BadInput
        In one sentence, where there are no meshes, labels or truth, or they do not fit.
    """
    found = families(folder)
    chosen = {name: found[name] for name in layout.families or found if name in found}
    unknown = [name for name in layout.families if name not in found]
    if unknown:
        raise BadInput(f"{folder} has no family '{unknown[0]}'; its families are {', '.join(found)}.")
    layout = completed(folder, [mesh for meshes in chosen.values() for mesh in meshes], layout)
    notes: list[str] = []
    pairs: list[Pair] = []
    for number, (family, meshes) in enumerate(chosen.items()):
        usable = _Usable(family, layout, notes, share(progress, number / len(chosen), (number + 1) / len(chosen)))
        most = _count(layout.pairs) if layout.pairs not in (AUTO, ALL) else MOST_PAIRS
        mine = list(islice((pair for pair in _paired(family, meshes, layout) if usable(pair)), most))
        if not mine:
            notes.append(f"The family {family} has no pair of two shapes with at least two segments each.")
        elif most != MOST_PAIRS and len(mine) < most:
            notes.append(f"The family {family} has {len(mine)} pairs only.")
        pairs += mine
    if not pairs:
        why = f" ({notes[0].rstrip('.')})" if notes and notes[0].startswith(LEFT_OUT) else ""
        raise BadInput(f"{folder} holds no pair of labelled shapes{why}; put at least two meshes of a kind into one folder.")
    return Collection(folder.resolve().name, tuple(pairs), tuple(dict.fromkeys(notes)))


def families(folder: Path) -> dict[str, list[Path]]:
    """The meshes of a folder and its sub-folders by family, in natural order (2 before 10)."""
    if not folder.is_dir():
        what = "not a folder" if folder.exists() else "not there"
        raise BadInput(f"The collection {folder} is {what}; name a folder of labelled meshes, or '{GENERATED}'.")
    try:
        files = [path for path in folder.rglob("*") if path.suffix.lower() in MESH_SUFFIXES and path.is_file()]
    except OSError as error:
        raise BadInput(f"The folder {folder} cannot be read: {error.strerror}.") from None
    files = [path for path in files if not any(part.startswith(".") for part in path.relative_to(folder).parts)]
    if not files:
        raise BadInput(f"The folder {folder} holds no meshes ({', '.join(MESH_SUFFIXES)}); name a folder of labelled meshes.")
    groups: dict[str, list[Path]] = {}
    stems: dict[Path, Path] = {}
    for path in sorted(files, key=lambda p: [natural(part) for part in p.relative_to(folder).parts]):
        if stems.setdefault(path.with_suffix(""), path) != path:
            raise BadInput(f"{stems[path.with_suffix('')]} and {path.name} would share their labels; keep one of them.")
        name = path.parent.relative_to(folder).as_posix()
        groups.setdefault(folder.resolve().name if name == "." else name, []).append(path)
    return groups


def natural(text: str) -> list[tuple[int, int, str]]:
    """A key that sorts numbers in texts by their value."""
    return [(0, int(part), "") if part.isdigit() else (1, 0, part) for part in re.findall(r"\d+|\D+", text)]


def completed(folder: Path, meshes: Sequence[Path], layout: Layout) -> Layout:
    """The layout with labels that the folder has, if none were named; raises `BadInput` where it is not clear which."""
    if not any(_beside(mesh, layout.truth).is_file() for mesh in meshes):
        others = sorted({end for mesh in meshes for end in _ends(mesh) if end.lower() not in MESH_SUFFIXES})
        there = f" (beside the meshes there are {', '.join(others)})" if others else ""
        raise BadInput(f"The meshes of {folder} have no truth labels{there}; put one class a face into NAME{layout.truth}, "
                       "or name the ending of the truth with --truth.")  # fmt: skip
    if not layout.source_labels and not layout.cut and any(_beside(mesh, ".seg").is_file() for mesh in meshes):
        layout = layout._replace(source_labels=".seg", target_labels=".seg")
    kinds = [] if layout.source_labels or layout.cut else _kinds(meshes)
    if kinds:
        raise BadInput(f"The segmentations in {folder} have names: {', '.join(kinds)}; choose one for either side with --case, "
                       f"as in --case {kinds[0]}-{kinds[-1]}.")  # fmt: skip
    for mesh in meshes:
        for end, what in ((layout.truth, "truth"), (layout.source_labels, "segment"), (layout.target_labels, "segment")):
            if end and not _beside(mesh, end).is_file():
                raise BadInput(f"{mesh} has no {what} labels; add {_beside(mesh, end).name}, or move the mesh away.")
    return layout


def _ends(mesh: Path) -> list[str]:
    """What stands behind the mesh's stem in the names of the files beside it."""
    return [path.name[len(mesh.stem) :] for path in mesh.parent.glob("*") if path.name.startswith(f"{mesh.stem}.")]


def _kinds(meshes: Sequence[Path]) -> list[str]:
    """The names of segmentations, as coarse in NAME.coarse.seg."""
    return sorted({end[1:-4] for mesh in meshes for end in _ends(mesh) if end[1:].endswith(".seg")})


def _beside(mesh: Path, end: str) -> Path:
    return mesh.with_name(mesh.stem + end)


def _paired(family: str, meshes: Sequence[Path], layout: Layout) -> Iterator[FilePair]:
    """All pairs of a family that the layout asks for, near ones first."""
    for i, j in _indices([mesh.stem for mesh in meshes], layout):
        source, target = (_files(meshes[k], end, layout, k) for k, end in ((i, layout.source_labels), (j, layout.target_labels)))
        yield FilePair(family, f"{meshes[i].stem} {meshes[j].stem}", source, target)


def _indices(stems: Sequence[str], layout: Layout) -> Iterator[tuple[int, int]]:
    """Which shape with which: couples NAME_a, NAME_b; or shapes 1 apart, 2 apart and so on, then the other way round.

    The other way round only where source and target are segmented differently, for else it would be the same pair.
    """
    row = {stem: number for number, stem in enumerate(stems)}
    couples = [(row[s], row[s[:-2] + "_b"]) for s in stems if s.endswith("_a") and s[:-2] + "_b" in row]
    if layout.pairs != ALL and 2 * len(couples) == len(stems):
        yield from couples
        return
    if layout.pairs == AUTO:
        yield from pairwise(range(len(stems)))
        return
    apart = [(i, i + d) for d in range(1, len(stems)) for i in range(len(stems) - d)]
    yield from apart
    if layout.source_labels != layout.target_labels:
        yield from ((j, i) for i, j in apart)


def _files(mesh: Path, labels: str, layout: Layout, number: int) -> ShapeFiles:
    truth = str(_beside(mesh, layout.truth))
    if labels:
        return ShapeFiles(str(mesh), truth, str(_beside(mesh, labels)))
    return ShapeFiles(str(mesh), truth, "", layout.segments, layout.seed + number)


class _Usable:
    """Whether both shapes of a pair have two segments; each mesh is read once, and what is left out is noted."""

    def __init__(self, family: str, layout: Layout, notes: list[str], progress: Progress) -> None:
        self.family, self.notes, self.progress = family, notes, progress
        self.ends = [end for end in dict.fromkeys((layout.source_labels, layout.target_labels)) if end]
        self.segments: dict[str, int] = {}

    def __call__(self, pair: FilePair) -> bool:
        counts = [self._segments(files) for files in (pair.source, pair.target)]
        return min(counts) > 1

    def _segments(self, files: ShapeFiles) -> int:
        """The number of segments of a shape; 2 stands for a random cut, which is made where the shape is matched."""
        key = files.labels or files.mesh
        if key not in self.segments:
            mesh = Path(files.mesh)
            self.progress(0.0, f"reading {mesh.name}")
            paths = [_beside(mesh, end) for end in self.ends]
            _, (_, *cuts) = load_labellings(mesh, [files.truth, *paths])
            self.segments[files.mesh] = 2
            self.segments |= {str(path): cut.count for path, cut in zip(paths, cuts, strict=True)}
            self.notes += [f"{LEFT_OUT} {self.family}: {path.name} has one single segment."
                           for path, cut in zip(paths, cuts, strict=True) if cut.count < 2]  # fmt: skip
        return self.segments[key]


def _count(pairs: str) -> int:
    if not pairs.isdecimal() or not 1 <= int(pairs) <= MOST_PAIRS:
        raise BadParameter(f"--pairs cannot be {pairs}: it takes {AUTO}, {ALL}, or how many pairs of each family are wanted.")
    return int(pairs)
