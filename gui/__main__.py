"""`concord`: the window, and beside it the commands of the engine and of studies, which need neither Qt nor VTK."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from engine.shapes.result import MatchResult
    from engine.shapes.segmentation import SegmentedShape


def open_window(pair: Sequence[str] = (), labels: tuple[str | None, str | None] = (None, None)) -> int:
    """Open the window on a pair of files or on the example; 2 and one sentence where there can be no window."""
    from .display import problem

    sentence = problem()
    if sentence is not None:
        print(f"concord: {sentence}", file=sys.stderr)
        return 2
    from .startup import run

    return run(pair, labels)


def report_pictures(
    source: "SegmentedShape", target: "SegmentedShape", result: "MatchResult"
) -> list[tuple[str, bytes]]:
    """Pictures for a report where this computer can draw them; none, and a note, where it cannot."""
    from engine.errors import ConcordError

    try:
        from .views.pictures import report_pictures as draw

        return draw(source, target, result)
    except (ImportError, ConcordError) as error:
        reason = str(error) if isinstance(error, ConcordError) else "the extra 'gui' is not installed."
        print(f"note: the report has no pictures: {reason}")
        return []


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command `concord` and return its exit code."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    if not arguments:
        return open_window()
    from annotation.__main__ import app as study
    from engine.__main__ import Source, SourceLabels, Target, TargetLabels, build_app
    from engine.cli import run

    app = build_app(report_pictures)
    app.command(study, name="study")

    @app.command(name="open")
    def open_pair(
        source: Source, target: Target, *, source_labels: SourceLabels = None, target_labels: TargetLabels = None
    ) -> int:
        """Open the window on two meshes."""
        first, second = (str(file) if file else None for file in (source_labels, target_labels))
        return open_window((str(source), str(target)), (first, second))

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
