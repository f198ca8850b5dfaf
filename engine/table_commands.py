"""The commands `tables`: the thesis's tables of puzzles on any folder of pictures; those of shapes are mounted."""

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import App, Parameter

from .cli import progress_bar, results_folder
from .errors import BadInput, BadParameter
from .parameters import assignments
from .puzzles.parameters import PuzzleParameters
from .shape_table_commands import VoteReader, mount_shape_tables, no_votes

if TYPE_CHECKING:
    import numpy as np

    from .puzzles.benching import Table

Words = Annotated[list[str] | None, Parameter(negative="", consume_multiple=True)]
Integers = Annotated[list[int] | None, Parameter(negative="", consume_multiple=True)]
Numbers = Annotated[list[float] | None, Parameter(negative="", consume_multiple=True)]
NAMING = ("image",)  # columns of words; the others are numbers


def build_tables(voted: VoteReader = no_votes) -> App:
    """The application `tables`; `voted` reads studies, which the engine alone does not know."""
    app = App(name="tables", help="Make the thesis's tables on your own shapes and pictures.")
    mount_shape_tables(app, voted)
    app.command(table_4_1, name="4.1")
    app.command(table_5_2, name="5.2")
    return app


def table_4_1(
    folder: Path,
    *,
    out: Path,
    grids: Integers = None,
    t1: Numbers = None,
    t2: Numbers = None,
    resolution: int = 168,
    seed: int = 0,
    set: Words = None,
) -> None:
    """Corners with MatchLift against the spanning tree alone; the grid's best and the parameter-free choice apart.

    Parameters
    ----------
    folder
        Folder of pictures; the central square of each is taken.
    out
        Folder for table-4.1.md, .csv and .html; made if it is missing.
    grids
        Numbers g for g × g pieces (10, 12 and 14 if none is given).
    t1
        Thresholds of the input similarity to try (20 from .6 to 1 if none is given).
    t2
        Thresholds of the result to try (9 from .5 to .95 if none is given).
    resolution
        The side in pixels that the square is scaled to; 0 leaves it as it is.
    seed
        Seed of shuffling.
    set
        NAME=VALUE, replaces single parameters of MatchLift; may be given several times.
    """
    from .puzzles import thesis_tables as thesis
    from .puzzles.thesis_tables_text import LEAD_4_1, csv_of_4_1, table_of_4_1

    values = PuzzleParameters().changed(**assignments(set or ()))
    sizes, first, second = tuple(grids or thesis.GRIDS), tuple(t1 or thesis.T_1), tuple(t2 or thesis.T_2)
    if not all(2 <= g <= 40 for g in sizes):
        raise BadParameter("--grids takes whole numbers from 2 to 40, for 2 × 2 to 40 × 40 pieces.")
    if not all(0 < t <= 1 for t in (*first, *second)):
        raise BadParameter("--t1 and --t2 take thresholds above 0 and up to 1.")
    if resolution != 0 and not 8 <= resolution <= 4000:
        raise BadParameter(f"--resolution cannot be {resolution}: it takes 8 to 4000 pixels, or 0 for the picture's own.")
    images = _images(folder, seed)
    with results_folder(out) as target:
        with progress_bar() as progress:
            rows = thesis.table_4_1(images, values, grids=sizes, t_1=first, t_2=second, resolution=resolution, seed=seed,
                                    progress=progress)  # fmt: skip
        lead = f"{LEAD_4_1} {len(images)} pictures of {folder.resolve().name}, seed {seed}."
        _write(target, "table-4.1", table_of_4_1(rows), csv_of_4_1(rows), lead)


def table_5_2(
    folder: Path,
    *,
    out: Path,
    pieces: int = 192,
    frame: Literal["known", "unknown"] = "unknown",
    seed: int = 0,
    set: Words = None,
) -> None:
    """Diffusion pruning against the spanning tree alone, with MGC and with EMD, at one setting.

    Parameters
    ----------
    folder
        Folder of pictures.
    out
        Folder for table-5.2.md, .csv and .html; made if it is missing.
    pieces
        Into how many squares each picture is cut, as nearly as its size allows.
    frame
        Whether the assembly may know the size of the picture.
    seed
        Seed of shuffling.
    set
        NAME=VALUE, replaces single parameters of pruning; may be given several times.
    """
    from .puzzles import thesis_tables as thesis
    from .puzzles.thesis_tables_text import LEAD_5_2, csv_of_5_2, table_of_5_2

    values = PuzzleParameters().changed(**assignments(set or ()))
    images = _images(folder, seed)
    with results_folder(out) as target:
        with progress_bar() as progress:
            rows = thesis.table_5_2(images, values, pieces=pieces, frame=frame == "known", seed=seed, progress=progress)
        lead = f"{LEAD_5_2} {len(images)} pictures of {folder.resolve().name}, the frame {frame}, seed {seed}."
        _write(target, "table-5.2", table_of_5_2(rows), csv_of_5_2(rows), lead)


def _images(folder: Path, seed: int) -> list[tuple[str, "np.ndarray"]]:
    """All pictures of a folder by their names."""
    from .puzzles.imagefile import opaque, read_image
    from .puzzles.piecefolder import image_files

    if not 0 <= seed < 2**31:
        raise BadParameter(f"--seed cannot be {seed}: it takes a whole number from 0 to {2**31 - 1}.")
    if not folder.is_dir():
        raise BadInput(f"{folder} is not a folder; name a folder of pictures.")
    paths = image_files(folder)
    if not paths:
        raise BadInput(f"The folder {folder} holds no images; name a folder of pictures to cut.")
    return [(path.name, opaque(read_image(path))) for path in paths]


def _write(folder: Path, stem: str, tables: Sequence["Table"], csv: str, lead: str) -> None:
    """Write tables as Markdown, CSV and an HTML page, all or none, and print them."""
    from .puzzles.benching import to_markdown
    from .report import html_table, page
    from .store import write_together

    text, title = to_markdown(tables, lead), stem.replace("-", " ").capitalize()
    sections = [
        f"<h2>{escape(t.title)}</h2>{html_table(t.head, t.rows, [name not in NAMING for name in t.head])}" for t in tables
    ]
    write_together({
        folder / f"{stem}.md": text, folder / f"{stem}.csv": csv, folder / f"{stem}.html": page(title, lead, sections),
    })  # fmt: skip
    print(text, end="")
    print(f"written to {folder}")
