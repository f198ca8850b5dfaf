"""The headless command line, `python -m engine`; also mounted by `concord`, which adds pictures and the window."""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from . import evaluate_commands
from .cli import progress_bar, results_folder, run
from .collection_commands import mount_collection
from .errors import BadInput
from .parameters import Parameters, assignments, declared, read_values
from .puzzle_commands import mount
from .puzzles.parameters import PuzzleParameters
from .retrieval_commands import mount_descriptors
from .segment_commands import segment
from .shape_table_commands import VoteReader, no_votes
from .shapes.collection_parameters import CollectionParameters
from .shapes.parameters import DEFAULT_PRESET, PRESETS, MatchParameters, method_preset, preset
from .shapes.segmentationparameters import SegmentationParameters
from .store import default_cache, output_folder
from .table_commands import build_tables

if TYPE_CHECKING:
    from collections.abc import Callable

    from .collection_report import CollectionDraw
    from .report import Picture, PictureMaker
    from .shapes.result import MatchResult
    from .shapes.segmentation import SegmentedShape
    from .shapes.wishes import Wishes

    Judged = Callable[[str, SegmentedShape, SegmentedShape], Wishes]


def no_pictures(
    source: "SegmentedShape", target: "SegmentedShape", result: "MatchResult", states: Mapping[str, str] | None = None
) -> "list[Picture]":
    """Reports of the bare engine have no pictures: drawing needs VTK."""
    return []


def no_studies(place: str, source: "SegmentedShape", target: "SegmentedShape") -> "Wishes":
    """The engine alone knows no studies."""
    raise BadInput("Votes are not read here: that needs `concord match --votes`, or a file of `concord study wishes`.")


Source = Annotated[Path, Parameter(help="First mesh: OFF, OBJ, PLY, STL or GLB.")]
Target = Annotated[Path, Parameter(help="Second mesh.")]
SourceLabels = Annotated[Path | None, Parameter(help="One integer a face; without it, a .seg file of the same stem, "
                                                     "labels in the mesh file, its components, or an automatic "
                                                     "segmentation.")]  # fmt: skip
TargetLabels = Annotated[Path | None, Parameter(help="The same for the second mesh.")]
Words = Annotated[list[str] | None, Parameter(negative="", consume_multiple=True)]


def build_app(
    draw: "PictureMaker" = no_pictures, draw_collection: "CollectionDraw | None" = None, voted: VoteReader = no_votes,
    judged: "Judged" = no_studies,
) -> App:  # fmt: skip
    """The engine's commands; `draw` makes the pictures of a report, `draw_collection` those of a collection, `voted`
    reads the votes of a study for the thesis's tables, and `judged` those on a pair as wishes."""
    words = "Find consistent correspondences between segmented shapes, and between the pieces of puzzles."
    app = App(name="concord", help=words, version=_version)
    app.command(list_parameters, name="parameters")
    app.command(make_shapes, name="make-shapes")
    mount(app)
    app.command(build_tables(voted))
    evaluate_commands.mount(app, draw)
    mount_descriptors(app)
    mount_collection(app, draw_collection)
    app.command(segment)

    @app.command
    def match(
        source: Source,
        target: Target,
        *,
        out: Path,
        source_labels: SourceLabels = None,
        target_labels: TargetLabels = None,
        method: str | None = None,
        preset: str | None = None,
        set: Words = None,
        parameters: Path | None = None,
        wishes: Path | None = None,
        votes: str | None = None,
        segments: int | None = None,
        segmentation: str | None = None,
    ) -> None:
        """Match two meshes and write matches.json, matches.csv, parameters.json and report.html.

        Parameters
        ----------
        out
            Folder for the results; made if it is missing.
        method
            How matches are chosen, such as thesis, shed or spectral; `concord parameters` lists all. Starts from its own
            preset unless one is given.
        preset
            Named parameters; `concord parameters` lists them. `--method` still wins.
        set
            NAME=VALUE, replaces single parameters; may be given several times.
        parameters
            A parameters.json that a run has written; `--set` still wins.
        wishes
            A file of wishes: matches that are pinned come in any case, forbidden ones do not.
        votes
            A study (a file, a folder or postgresql://...): what the majority calls correct is pinned, what it calls wrong
            forbidden. `--wishes` still win.
        segments
            Into how many segments a mesh without labels is cut (14 unless its components look like parts).
        segmentation
            How such a mesh is cut: parts, patches or convex; see `concord segment`.
        """
        from .segment_commands import loaded

        named = preset or (method_preset(method) if method else DEFAULT_PRESET)
        values = chosen_parameters(named, set or (), parameters, method=method)
        shapes = loaded((source, source_labels), (target, target_labels), count=segments, method=segmentation)
        wanted = asked_wishes(wishes, votes, *shapes, judged)
        with results_folder(out) as folder:
            match_into(folder, *shapes, values, preset_name(values, named), draw, wanted)

    return app


def list_parameters() -> None:
    """List the presets and all parameters with their ranges, defaults, units and equations."""
    print(parameter_text())


def make_shapes(
    *,
    out: Path,
    family: Words = None,
    pairs: int = 1,
    seed: int = 0,
    variant: str = "touching",
    segments: str = "10-16",
    pose: str = "upright",
) -> None:
    """Write generated pairs of shapes with known truth: meshes, over-segmented labels and semantic labels.

    Parameters
    ----------
    out
        Folder for the shapes; made if it is missing.
    family
        Families of shapes (all if none is named).
    pairs
        Number of pairs of each family.
    seed
        Seed of the first pair; the same seed gives the same files.
    variant
        touching (parts share no vertices) or welded (one surface).
    segments
        Fewest and most segments of a shape, as LOW-HIGH.
    pose
        upright, or turned (each shape rotated at random).
    """
    from .shapes.families.collection import make_collection

    folder = output_folder(out)
    with progress_bar() as progress:
        written = make_collection(
            folder, families=family or (), count=pairs, seed=seed, variant=variant, segments=segments, pose=pose,
            progress=progress)  # fmt: skip
    counts = [len(set(path.with_suffix(".seg").read_text().split())) for path in written]
    print(f"{len(written)} meshes of {min(counts)} to {max(counts)} segments written to {folder}, "
          "with their labels (.seg) and truth (.sem)")  # fmt: skip


def asked_wishes(
    file: Path | None, study: str | None, source: "SegmentedShape", target: "SegmentedShape", judged: "Judged"
) -> "Wishes":
    """The wishes of a study's votes and those of a file, which take the place of what they contradict."""
    from .shapes.wishes import NO_WISHES
    from .shapes.wishfile import read_wishes

    found = judged(study, source, target) if study is not None else NO_WISHES
    return found.then(read_wishes(file, source, target)) if file is not None else found


def match_into(
    folder: Path,
    source: "SegmentedShape",
    target: "SegmentedShape",
    parameters: MatchParameters,
    name: str,
    draw: "PictureMaker" = no_pictures,
    wishes: "Wishes | None" = None,
) -> "MatchResult":
    """Match two shapes, print what came out and write the four result files; `name` is that of the preset."""
    from .matchfile import write_matches
    from .report import report_page
    from .shapes.matching import match_shapes
    from .shapes.wishes import NO_WISHES

    with progress_bar() as progress:
        result = match_shapes(
            source, target, parameters, preset=name, wishes=wishes or NO_WISHES, progress=progress, cache=default_cache())  # fmt: skip
    write_matches(result, folder, report=report_page(result, draw(source, target, result)))
    for note in result.notes:
        print(f"note: {note}")
    if result.wishes:
        print(f"wishes honoured: {len(result.wishes.pinned)} pinned, {len(result.wishes.forbidden)} forbidden")
    seconds = ", ".join(f"{step} {value:.2f}" for step, value in result.seconds.items())
    print(f"{len(result.ids)} matches between {source.mesh.name} ({source.segmentation.count} segments, "
          f"{result.source_nodes} nodes) and {target.mesh.name} ({target.segmentation.count} segments, "
          f"{result.target_nodes} nodes)\nseconds: {seconds}\nwritten to {folder}")  # fmt: skip
    return result


def preset_name(values: MatchParameters, asked: str) -> str:
    """The preset that a result goes by: the one that was asked for, another that has these values, or none.

    None where the method is not that of the preset asked for, as a parameters file may make it.
    """
    equal = [name for name, known in PRESETS.items() if known == values]
    if equal:
        return asked if asked in equal else equal[0]
    return asked if PRESETS[asked].method == values.method else ""


def chosen_parameters(
    preset_name: str, settings: Sequence[str], file: Path | None, *, method: str | None = None
) -> MatchParameters:
    """A preset, then the values of a file, the method, and single settings; raises `BadParameter` or `BadInput`."""
    values = preset(preset_name)
    if file is not None:
        values = values.changed(**read_values(file))
    if method is not None:
        values = values.changed(method=method)
    return values.changed(**assignments(settings))


def parameter_text() -> str:
    """Presets and parameters as plain text."""
    lines = ["Presets of shapes (values that differ from the defaults):"]
    default = MatchParameters()
    for name, values in PRESETS.items():
        changes = ", ".join(f"{k}={v}" for k, v in values.differences(default).items()) or "the defaults"
        lines.append(f"  {name:<24}{changes}{'  [default]' if name == DEFAULT_PRESET else ''}")
    for title, model in (("Parameters of shapes", MatchParameters),
                         ("Parameters of automatic segmentation", SegmentationParameters),
                         ("Parameters of collections", CollectionParameters),
                         ("Parameters of puzzles", PuzzleParameters)):  # fmt: skip
        lines += ["", f"{title}", *_described(model)]
    return "\n".join(lines)


def _described(model: type[Parameters]) -> list[str]:
    """The parameters of a model, one line each, under the names of their groups."""
    groups: dict[str, list[str]] = {}
    for info in declared(model):
        kinds = "|".join(info.choices) if info.choices else "true|false" if info.kind == "switch" else f"{info.low:g}..{info.high:g}"
        details = [d for d in (info.symbol, info.unit, info.source, *info.methods) if d]
        line = f"  {info.name:<20}{info.default!s:<12}{kinds:<38}  {info.doc}" + (f" [{', '.join(details)}]" if details else "")
        groups.setdefault(info.group, []).append(line)
    return [line for group, lines in groups.items() for line in ("", f"{group}:", *lines)]


def _version() -> str:
    from importlib.metadata import version

    return version("concord-correspondences")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the headless command line."""
    return run(build_app(), arguments)


if __name__ == "__main__":
    sys.exit(main())
