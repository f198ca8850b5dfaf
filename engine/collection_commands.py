"""The command of collections: `concord collection`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, Parameter

from .cli import progress_bar, results_folder
from .parameters import assignments, read_values
from .progress import share
from .segment_commands import asked_segmentation
from .shapes.collection_parameters import CollectionParameters
from .shapes.parameters import DEFAULT_PRESET, PRESETS, MatchParameters, method_preset, preset
from .store import default_cache

if TYPE_CHECKING:
    from .collection_report import CollectionDraw
    from .shapes.collection_result import CollectionResult

MOST_NOTES, MOST_PAIRS = 8, 30  # printed; the report has all
Words = Annotated[list[str] | None, Parameter(negative="", consume_multiple=True)]


def mount_collection(app: App, draw: "CollectionDraw | None" = None) -> None:
    """Add the command of collections to an application; `draw` makes the pictures of a report, none without it."""

    @app.command
    def collection(
        *inputs: Path,
        out: Path,
        labels: str = "",
        segments: int | None = None,
        segmentation: str | None = None,
        preset: str | None = None,
        method: str | None = None,
        support: Literal["cycles", "matchlift"] | None = None,
        set: Words = None,
        parameters: Path | None = None,
    ) -> None:
        """Match all pairs of a collection, with the support that the other shapes give each match, and parts that agree.

        Writes collection.json, collection.csv, parts.csv, report.html, and the matches.json of each pair under pairs.

        Parameters
        ----------
        inputs
            A folder of meshes, or meshes; label files among them belong to the mesh whose name they begin with.
        out
            Folder for the results; made if it is missing.
        labels
            Ending of the label files beside the meshes, for instance median.seg for chair.median.seg.
        segments
            Into how many segments a mesh without labels is cut (14 unless its components look like parts).
        segmentation
            How such a mesh is cut: parts, patches or convex; see `concord segment`.
        preset
            Named parameters; `concord parameters` lists them. `--method` still wins.
        method
            How matches are chosen, with the preset of its name unless one is given; `concord parameters` lists them.
        support
            cycles (the ways around by third shapes) or matchlift (one consistent solution for all).
        set
            NAME=VALUE, replaces single parameters of matching or of collections; may be given several times.
        parameters
            A parameters.json that a run has written; `--method`, `--support` and `--set` still win.
        """
        from .collection_report import collection_page
        from .collectionfile import write_collection
        from .shapes.collection_inputs import collection_files, load_collection
        from .shapes.collection_matching import match_collection

        named = preset or (method_preset(method) if method else DEFAULT_PRESET)
        values, own, name = chosen_values(named, method, support, set, parameters)
        files = collection_files(inputs, labels)
        with results_folder(out) as folder:
            with progress_bar() as progress:
                cache = default_cache()
                shapes, failures = load_collection(files, automatic=asked_segmentation(segments, segmentation),
                                                   progress=share(progress, 0.0, 0.1), cache=cache)  # fmt: skip
                found = match_collection(shapes, values, own, preset=name, failures=failures,
                                         progress=share(progress, 0.1, 1.0), cache=cache)  # fmt: skip
            write_collection(found, folder, report=collection_page(found, draw(found) if draw else ()))
        _tell(found, folder)


def chosen_values(
    asked: str, method: str | None, support: str | None, settings: list[str] | None, file: Path | None
) -> tuple[MatchParameters, CollectionParameters, str]:
    """The parameters of matching and of the collection, and the preset's name; raises `BadParameter` or `BadInput`.

    A preset, then the values of a file, then options, then single settings. The name is empty where the method is not
    the preset's.
    """
    values: dict[str, Any] = {} if file is None else read_values(file)
    options = {"method": method, "support": support}
    values |= {name: value for name, value in options.items() if value is not None}
    values |= assignments(settings or ())
    matching, own = preset(asked), CollectionParameters()
    mine = {name: value for name, value in values.items() if name in CollectionParameters.model_fields}
    found = matching.changed(**{name: value for name, value in values.items() if name not in mine})
    same = found == matching or found.method == matching.method
    equal = next((name for name, known in PRESETS.items() if known == found), "")
    return found, own.changed(**mine), asked if same else equal


def _tell(found: "CollectionResult", folder: Path) -> None:
    """Say what came out."""
    from .collectionfile import mean_support, supported

    for sentence in (*found.failures, *found.notes[:MOST_NOTES]):
        print(f"note: {sentence}")
    if len(found.notes) > MOST_NOTES:
        print(f"and {len(found.notes) - MOST_NOTES} more notes in the report")
    width = max(len(f"{found.names[a]} and {found.names[b]}") for a, b in found.pairs)
    for row, (a, b) in enumerate(found.pairs[:MOST_PAIRS]):
        mean = mean_support(found.support(row))
        words = f", {supported(found.support(row))} supported, mean support {mean:.2f}" if mean == mean else ""
        print(f"{f'{found.names[a]} and {found.names[b]}':<{width}}  {len(found.results[row].ids):>4} matches{words}")
    if len(found.pairs) > MOST_PAIRS:
        print(f"and {len(found.pairs) - MOST_PAIRS} more pairs")
    seconds = ", ".join(f"{step} {value:.2f}" for step, value in found.seconds.items())
    print(f"{found.part_count} parts in {len(found.shapes)} shapes\nseconds: {seconds}\nwritten to {folder}")
