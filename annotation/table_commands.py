"""`concord study table`, `overview` and `datasheet`: what a study's votes say, for people and for papers."""

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from engine.store import write_atomically

from .precision import ballots, precision_table
from .study import open_study
from .tabletext import TableFormat, render

Out = Annotated[Path | None, Parameter(help="Write to this file instead of the screen.")]


def mount(app: App) -> None:
    """Add the commands to the application of studies."""
    app.command(table)


def table(file: str, /, *, format: TableFormat = "text", out: Out = None) -> None:
    """Print the precision of each method and set by majority votes.

    Parameters
    ----------
    file
        The study file.
    format
        How to write the table.
    """
    with open_study(file, backup=False, writable=False) as handle:
        give(render(precision_table(handle), ballots(handle), format), out)


def give(text: str, out: Path | None) -> None:
    """Print a text, or write it to a file, whole or not at all."""
    if out is None:
        sys.stdout.write(text)
    else:
        write_atomically(out, text)
