"""`concord study table`, `overview` and `datasheet`: what a study's votes say, for people and for papers."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from engine.errors import BadParameter
from engine.store import write_atomically

from .findings import Findings, Preset, Votes, read_votes, worked_out
from .findings_report import Drawn, Style, as_csv, as_html, draw_disputed, lead_of, written
from .findings_tables import Section, tables, values
from .splitting import Split, split
from .study import open_study

if TYPE_CHECKING:
    from engine.evaluation.tables import Table

    from .handle import StudyHandle
    from .shownitems import PartsDrawer

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
            votes, others = _parts(read_votes(handle), held_out, split_seed)
            found = worked_out(votes, preset=preset, chosen=_known(votes, tuned or ()))
            if format == "csv":
                give(as_csv(values(found, section)), out)
                return
            shown, lead = tables(found, section), lead_of(found, section)
            if others is not None:
                shown += _beside(worked_out(others.others, preset=preset, chosen=tuned or ()))
                lead += f"; {len(others.names)} pairs held out by seed {split_seed}: {', '.join(others.names)}"
            give(_page(handle, found, lead, shown, draw, pictures) if format == "html" else written(lead, shown, format), out)

    if "table" in app:
        del app["table"]
    app.command(table)


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
    from .shownitems import no_drawing

    drawn = draw_disputed(handle, found.disputed[:pictures], draw or no_drawing) if pictures else Drawn([], ())
    return as_html(found, lead, shown, drawn)


def give(text: str, out: Path | None) -> None:
    """Print a text, or write it to a file, whole or not at all."""
    if out is None:
        sys.stdout.write(text)
    else:
        write_atomically(out, text)
