"""`concord study`: studies from the command line."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from engine.cli import run
from engine.store import write_atomically

from .design.commands import mount as mount_design
from .exchange.commands import mount as mount_exchange
from .exchange.exporting import votes_csv
from .exchange.merging import merge as merge_files
from .findings.commands import mount as mount_tables
from .results.votedwishes import read_voted_wishes
from .server.commands import mount as mount_invitations
from .storage.location import warn_of_place
from .storage.stamps import app_version
from .study import open_study, record_vote, shown_place
from .voting.majority import Answer
from .voting.volunteers import check_known

app = App(
    name="study",
    help="Create studies, vote, merge, and print precision tables.",
    version=app_version,
    result_action="return_value",
)
mount_design(app)

Out = Annotated[Path | None, Parameter(help="Write to this file instead of the screen.")]


@app.command
def votes(file: str, /, *, out: Out = None) -> None:
    """Export every vote as CSV, with its state: current, replaced or retracted.

    Parameters
    ----------
    file
        The study file.
    """
    with open_study(file, backup=False, writable=False) as handle:
        _give(votes_csv(handle), out)


@app.command
def vote(
    file: str, /, *, volunteer: str, item: str, answer: Answer, comment: str = "", new: Annotated[bool, Parameter(negative="")] = False
) -> None:
    """Record one vote.

    Parameters
    ----------
    file
        The study file.
    volunteer
        Code of who votes: 1 to 40 letters, digits, - and _.
    item
        Id of the match.
    answer
        The answer.
    comment
        Anything to remember.
    new
        Take a code that the study does not know as that of somebody new.
    """
    with open_study(file) as handle:
        warn_of_place(handle.where)
        if not new:
            check_known(handle, volunteer)
        record_vote(handle, item, volunteer, answer, comment=comment)
    print("Saved.")


@app.command
def wishes(
    file: str,
    source: Path,
    target: Path,
    /,
    *,
    out: Path,
    source_labels: Path | None = None,
    target_labels: Path | None = None,
    segments: int | None = None,
    segmentation: str | None = None,
) -> None:
    """Write what the majority says of the pair SOURCE, TARGET as wishes: correct is pinned, wrong is forbidden.

    `concord match --wishes` reads the file; `concord match --votes` takes both steps in one.

    Parameters
    ----------
    file
        The study file.
    source
        First mesh of the pair.
    target
        Second mesh of the pair.
    out
        The file of wishes to write.
    source_labels
        Labels of the first mesh, where they do not lie beside it.
    target_labels
        The same for the second mesh.
    segments
        As for `concord match`, of whose automatic segments the study is.
    segmentation
        The same: parts, patches or convex.
    """
    from engine.segment_commands import loaded
    from engine.shapes.wishfile import write_wishes

    shapes = loaded((source, source_labels), (target, target_labels), count=segments, method=segmentation)
    found = read_voted_wishes(file, *shapes)
    write_wishes(out, found.wishes, *shapes)
    print(f"{out}: {found.sentence()}")


@app.command
def merge(into: str, source: str, /, *, another_study: bool = False) -> None:
    """Take the votes and results of one study file into another; merging twice changes nothing.

    Parameters
    ----------
    into
        The study file that receives.
    source
        The study file taken from; it is not changed.
    another_study
        Merge although the two files were created as different studies.
    """
    warn_of_place(into)
    new = merge_files(into, source, other_study=another_study)
    print(f"{shown_place(into)}: {new.events} votes and undos, {new.items} matches, {new.runs} results are new.")


mount_tables(app)
mount_invitations(app)
mount_exchange(app)


def _give(text: str, out: Path | None) -> None:
    if out is None:
        sys.stdout.write(text)
    else:
        write_atomically(out, text)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line: 0 when done, 2 with one sentence where the input is at fault."""
    return run(app, argv)


if __name__ == "__main__":
    sys.exit(main())
