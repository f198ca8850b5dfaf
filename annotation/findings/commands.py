"""`concord study table`, `overview` and `datasheet`: what a study's votes say, for people and for papers."""

import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import App, Parameter

from engine.errors import BadParameter
from engine.store import output_folder, write_atomically, write_together

from ..exchange.csvtext import csv_text
from ..study import about, open_study
from .gathering import Findings, Preset, Votes, read_votes, worked_out
from .report import Drawn, Style, as_csv, as_html, draw_disputed, lead_of, written
from .splitting import Split, split
from .tables import Section, tables, values

if TYPE_CHECKING:
    from engine.evaluation.tables import Table

    from ..results.shownitems import PartsDrawer
    from ..storage.handle import StudyHandle

Out = Annotated[Path | None, Parameter(help="Write to this file instead of the screen.")]


def mount(app: App, draw: "PartsDrawer | None" = None) -> None:
    """Add the commands to the application of studies, or replace them; `draw` makes the pictures of shapes in reports."""

    def table(
        file: str,
        /,
        *,
        format: Style = "text",
        preset: Preset = "modern",
        section: Section = "all",
        tuned: Annotated[list[str] | None, Parameter(negative=())] = None,
        held_out: int = 0,
        split_seed: int = 0,
        pictures: int = 6,
        out: Out = None,
    ) -> None:
        """Print what the votes say: precision with intervals, agreement, methods compared, how firm it all is.

        Parameters
        ----------
        file
            The study: a file, a project folder, or the address of a database.
        format
            How to write the tables; CSV holds one section, HTML is one page with a chart and pictures.
        preset
            "thesis" gives the table of precision as in Tables 3.1 and 3.2.
        section
            One section alone; CSV takes that of precision where none is named.
        tuned
            Methods or presets whose parameters were chosen on votes or a truth; they are reported apart.
        held_out
            So many pairs, drawn by --split-seed, are held out: figures are told of them, and beside it of the others.
        split_seed
            Seed of that draw.
        pictures
            How many of the most disputed matches an HTML page shows.
        """
        if not 0 <= pictures <= 100:
            raise BadParameter(f"--pictures cannot be {pictures}: it takes 0 to 100.")
        with open_study(file, backup=False, writable=False) as handle:
            every = read_votes(handle)
            named = _known(every, tuned or ())
            votes, others = _parts(every, held_out, split_seed)
            found = worked_out(votes, preset=preset, chosen=named)
            if format == "csv":
                give(as_csv(values(found, section)), out)
                return
            shown, lead = tables(found, section), lead_of(found, section)
            if others is not None:
                shown += _beside(worked_out(others.others, preset=preset, chosen=named))
                pairs = "1 pair" if held_out == 1 else f"{held_out} pairs"
                lead += f"; {pairs} held out by seed {split_seed}: {', '.join(others.names)}"
            if format == "html":
                give(_page(handle, found, lead, shown, draw, pictures), out)
            else:
                give(written(lead, shown, format, screen_width(out)), out)

    for command in (table, overview, datasheet):
        if command.__name__ in app:
            del app[command.__name__]
        app.command(command)


def overview(file: str, /, *, format: Literal["text", "csv", "markdown"] = "text", out: Out = None) -> None:
    """Print who has done how much, how fast and how well; nothing is ever removed for it.

    Parameters
    ----------
    file
        The study: a file, a project folder, or the address of a database.
    format
        How to write the table.
    """
    from ..results.unseen import unseen, unseen_words
    from .overview import overview as read_overview
    from .overview_tables import VALUES_HEAD, overview_table, overview_values

    with open_study(file, backup=False, writable=False) as handle:
        rows, study, warning = read_overview(handle), about(handle), unseen_words(unseen(handle))
    if format == "csv":
        give(csv_text(VALUES_HEAD, map(overview_values, rows)), out)
    else:
        people = "1 volunteer" if len(rows) == 1 else f"{len(rows)} volunteers"
        text = written(f"Study {study.name}: {people}", [overview_table(rows)], format, screen_width(out))
        give(f"{text}\n{warning}\n" if warning else text, out)


def datasheet(file: str, /, *, out: Path) -> None:
    """Write a Human Evaluation Datasheet (Shimorina and Belz 2022) of the study, with blanks for what only people know.

    Parameters
    ----------
    file
        The study: a file, a project folder, or the address of a database.
    out
        Folder for datasheet.md and datasheet.json; made if it is missing.
    """
    from .datasheet import as_json, as_markdown
    from .datasheet_facts import answered

    with open_study(file, backup=False, writable=False) as handle:
        sheet = answered(handle)
    folder = output_folder(out)
    write_together({folder / "datasheet.md": as_markdown(sheet), folder / "datasheet.json": as_json(sheet)})
    blanks = sum(answer.blank for answer in sheet.answers)
    print(f"{len(sheet.answers) - blanks} of {len(sheet.answers)} questions are answered in {folder}; {blanks} are left to you.")


def _parts(votes: Votes, held_out: int, seed: int) -> tuple[Votes, Split | None]:
    """What figures are told of, and the split where pairs are held out."""
    if not held_out:
        return votes, None
    parts = split(votes, held_out, seed)
    return parts.held_out, parts


def _known(votes: Votes, tuned: "list[str] | tuple[str, ...]") -> tuple[str, ...]:
    """The names, all of methods or presets of the study; raises `BadParameter` otherwise."""
    names = sorted({name for result in votes.results for name in (result.method, result.preset) if name})
    unknown = [name for name in tuned if name not in names]
    if unknown:
        raise BadParameter(f"The study has no method or preset {unknown[0]!r}; it has {', '.join(names) or 'none'}.")
    return tuple(tuned)


def _beside(found: Findings) -> "list[Table]":
    """Precision on the pairs that were not held out."""
    return [table._replace(title=f"{table.title}: the pairs that were not held out") for table in tables(found, "precision")]


def _page(
    handle: "StudyHandle", found: Findings, lead: str, shown: "list[Table]", draw: "PartsDrawer | None", pictures: int
) -> str:
    """The HTML page; without a way to draw shapes, joins of puzzles are shown alone."""
    from ..results.shownitems import no_drawing

    drawn = draw_disputed(handle, found.disputed[:pictures], draw or no_drawing) if pictures else Drawn([], ())
    return as_html(found, lead, shown, drawn)


def screen_width(out: Path | None) -> int:
    """The columns of the terminal that is written to; 0 for a file or another program, which take any width."""
    return 0 if out is not None or not sys.stdout.isatty() else shutil.get_terminal_size().columns


def give(text: str, out: Path | None) -> None:
    """Print a text, or write it to a file, whole or not at all."""
    if out is None:
        sys.stdout.write(text)
    else:
        write_atomically(out, text)
