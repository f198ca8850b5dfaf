"""`concord`: the window, and beside it the commands of the engine and of studies, which need neither Qt nor VTK."""

import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

if TYPE_CHECKING:
    from annotation.results.shownitems import ShownParts
    from engine.shapes.collection_result import CollectionResult
    from engine.shapes.result import MatchResult
    from engine.shapes.segmentation import SegmentedShape
    from engine.shapes.wishes import Wishes


def open_window(files: Sequence[str] = (), labels: tuple[str | None, str | None] = (None, None)) -> int:
    """Open the window on two meshes, on one picture or folder of pieces, or on the example; 2 where there can be no window."""
    from .display import problem

    sentence = problem()
    if sentence is not None:
        print(f"concord: {sentence}", file=sys.stderr)
        return 2
    from .startup import run

    return run(files, labels)


def open_voting(where: str = "", code: str = "") -> int:
    """Open the volunteers' window on a study, a packet or a server; 2 where there can be no window."""
    from .display import problem

    sentence = problem()
    if sentence is not None:
        print(f"concord: {sentence}", file=sys.stderr)
        return 2
    from .volunteer import run

    return run(where, code)


def report_pictures(
    source: "SegmentedShape", target: "SegmentedShape", result: "MatchResult", states: Mapping[str, str] | None = None
) -> list[tuple[str, bytes]]:
    """Pictures for a report where this computer can draw them; none, and a note, where it cannot."""
    def draw() -> list[tuple[str, bytes]]:
        from .views.pictures import report_pictures as drawn

        return drawn(source, target, result, states)

    return _where_possible(draw)


def collection_pictures(found: "CollectionResult") -> list[tuple[str, bytes]]:
    """The same for a collection: all its shapes in the colours of their parts."""

    def draw() -> list[tuple[str, bytes]]:
        from .views.collection_pictures import collection_pictures as drawn

        return drawn(found)

    return _where_possible(draw)


def match_picture(shown: "ShownParts") -> bytes:
    """One match for the report of a study; raises `ConcordError` or `ImportError` where it cannot be drawn."""
    from .views.parts_picture import draw_parts

    return draw_parts(shown)


def _where_possible(draw: Callable[[], list[tuple[str, bytes]]]) -> list[tuple[str, bytes]]:
    from engine.errors import ConcordError

    try:
        return draw()
    except (ImportError, ConcordError) as error:
        reason = str(error) if isinstance(error, ConcordError) else "the extra 'gui' is not installed."
        print(f"note: the report has no pictures: {reason}")
        return []


def puzzle_path(path: Path) -> Path:
    """The path of a picture or a folder of pieces; raises `BadInput` for anything else."""
    from engine.errors import BadInput
    from engine.puzzles.imagefile import SUFFIXES

    if not path.exists():
        raise BadInput(f"There is no {path}; name two meshes, a picture, or a folder of pieces.")
    if not path.is_dir() and path.suffix.lower() not in SUFFIXES:
        raise BadInput(f"{path} is neither a picture nor a folder of pieces; to compare meshes, name two.")
    return path


def judged_wishes(place: str, source: "SegmentedShape", target: "SegmentedShape") -> "Wishes":
    """What the majority of a study's votes says of a pair, as wishes; prints what that is."""
    from annotation.results.votedwishes import read_voted_wishes

    found = read_voted_wishes(place, source, target)
    print(found.sentence())
    return found.wishes


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command `concord` and return its exit code: 130 where it was stopped, also while it still loads."""
    try:
        return _main(argv)
    except KeyboardInterrupt:
        print("concord: stopped.", file=sys.stderr)
        return 130


def _main(argv: Sequence[str] | None) -> int:
    arguments = list(sys.argv[1:] if argv is None else argv)
    if not arguments:
        return open_window()
    from cyclopts import Parameter

    from annotation.__main__ import app as study
    from annotation.findings.commands import mount as mount_tables
    from annotation.findings.thesistables import voted_precision
    from engine.__main__ import SourceLabels, TargetLabels, build_app
    from engine.cli import run

    app = build_app(report_pictures, collection_pictures, voted_precision, judged_wishes)
    mount_tables(study, match_picture)
    app.command(study, name="study")

    @app.command(name="open")
    def open_files(
        source: Annotated[Path, Parameter(help="First mesh; or, alone, a folder of meshes, a picture to cut or a folder of pieces.")],
        target: Annotated[Path | None, Parameter(help="Second mesh.")] = None,
        *,
        source_labels: SourceLabels = None,
        target_labels: TargetLabels = None,
    ) -> int:
        """Open the window on two meshes, a folder of meshes, a picture to be cut into pieces, or a folder of pieces."""
        if target is None:
            return open_window((str(puzzle_path(source)),))
        first, second = (str(file) if file else None for file in (source_labels, target_labels))
        return open_window((str(source), str(target)), (first, second))

    @app.command
    def vote(study_or_packet: str = "", /, *, volunteer: str = "") -> int:
        """Open the window for volunteers: one question after the other, and nothing else.

        Parameters
        ----------
        study_or_packet
            A study, the packet of one volunteer, or the address of a study on a server (postgresql://...).
        volunteer
            The code to vote under; that of the packet or of the login if left out, else the window asks for it.
        """
        return open_voting(study_or_packet, volunteer)

    @app.command
    def demo(*, out: Path) -> None:
        """Match and judge the bundled examples: results, report, a study and its table of precision.

        Parameters
        ----------
        out
            Folder for the results; made if it is missing.
        """
        from annotation.demo import run_demo
        from engine.store import output_folder

        run_demo(output_folder(out), report_pictures)

    return run(app, arguments)


if __name__ == "__main__":
    sys.exit(main())
