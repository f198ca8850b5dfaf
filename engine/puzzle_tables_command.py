"""The command `tables`: the thesis's two tables of puzzles on any folder of pictures."""

from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from .cli import progress_bar
from .errors import BadInput, BadParameter
from .parameters import assignments
from .puzzles.parameters import PuzzleParameters

if TYPE_CHECKING:
    import numpy as np

Words = Annotated[list[str] | None, Parameter(negative="", consume_multiple=True)]
Numbers = Annotated[list[int] | None, Parameter(negative="", consume_multiple=True)]


def tables(
    table: Literal["4.1", "5.2"],
    folder: Path,
    *,
    out: Path,
    grids: Numbers = None,
    resolution: int = 168,
    pieces: int = 192,
    frame: Literal["known", "unknown"] = "unknown",
    seed: int = 0,
    set: Words = None,
) -> None:
    """Make Table 4.1 (corners and MatchLift) or 5.2 (diffusion pruning) of the thesis; table.csv, table.md, report.html.

    Parameters
    ----------
    table
        4.1 or 5.2.
    folder
        Folder of pictures.
    out
        Folder for the table; made if it is missing.
    grids
        For 4.1: pieces along a side of each picture's central square (10 12 14 if none is given).
    resolution
        For 4.1: the side that the square is scaled to, in pixels; 0 leaves it as it is.
    pieces
        For 5.2: into how many pieces a picture is cut, as nearly as its size allows.
    frame
        For 5.2: whether the assembly may know the size of the picture.
    seed
        Seed of the shuffling.
    set
        NAME=VALUE, replaces single parameters; may be given several times.
    """
    from .puzzles.benching import to_markdown
    from .store import output_folder

    values = PuzzleParameters().changed(**assignments(set or ()))
    if not 0 <= seed < 2**31:
        raise BadParameter(f"The seed {seed} is not a whole number from 0 to {2**31 - 1}.")
    images = read_pictures(folder)
    target = output_folder(out)
    with progress_bar() as progress:
        if table == "4.1":
            lead, csv_text, made = _table_4_1(images, values, tuple(grids or ()), resolution, seed, progress)
        else:
            lead, csv_text, made = _table_5_2(images, values, pieces, frame == "known", seed, progress)
    _write(target, table, folder, lead, csv_text, made)
    print(to_markdown(made, lead), end="")
    print(f"written to {target}")


def read_pictures(folder: Path) -> "list[tuple[str, np.ndarray]]":
    """All pictures of a folder, opaque RGB, by name. Raises `BadInput` in one sentence."""
    import numpy as np

    from .puzzles.imagefile import read_image
    from .puzzles.piecefolder import image_files

    if not folder.is_dir():
        raise BadInput(f"{folder} is not a folder; name a folder of pictures.")
    files = image_files(folder)
    if not files:
        raise BadInput(f"The folder {folder} holds no images; name a folder of pictures to cut.")
    return [(path.name, np.ascontiguousarray(read_image(path)[..., :3])) for path in files]


def _table_4_1(images: Any, values: Any, grids: tuple[int, ...], resolution: int, seed: int, progress: Any) -> Any:
    from .puzzles.thesis_tables import GRIDS, table_4_1
    from .puzzles.thesis_tables_text import LEAD_4_1, csv_of_4_1, table_of_4_1

    for grid in grids:
        if not 2 <= grid <= 24:
            raise BadParameter(f"A grid of {grid} × {grid} pieces is out of range; give 2 to 24.")
    if resolution and not 16 <= resolution <= 8192:
        raise BadParameter(f"A resolution of {resolution} pixels is out of range; give 16 to 8192, or 0 to keep it.")
    rows = table_4_1(images, values, grids=grids or GRIDS, resolution=resolution, seed=seed, progress=progress)
    return LEAD_4_1, csv_of_4_1(rows), table_of_4_1(rows)


def _table_5_2(images: Any, values: Any, pieces: int, frame: bool, seed: int, progress: Any) -> Any:
    from .puzzles.thesis_tables import table_5_2
    from .puzzles.thesis_tables_text import LEAD_5_2, csv_of_5_2, table_of_5_2

    if not 4 <= pieces <= 600:
        raise BadParameter(f"A table of puzzles of {pieces} pieces is out of range; give 4 to 600.")
    rows = table_5_2(images, values, pieces=pieces, frame=frame, seed=seed, progress=progress)
    return LEAD_5_2, csv_of_5_2(rows), table_of_5_2(rows)


def _write(target: Path, name: str, folder: Path, lead: str, csv_text: str, made: Any) -> None:
    from .puzzles.benching import to_markdown
    from .report import html_table, page
    from .store import write_together

    sections = [f"<h2>{escape(t.title)}</h2>{html_table(t.head, t.rows, [k > 0 for k in range(len(t.head))])}" for t in made]
    write_together({
        target / "table.csv": csv_text,
        target / "table.md": to_markdown(made, lead),
        target / "report.html": page(f"Table {name} on {folder.name}", lead, sections),
    })  # fmt: skip
