"""The commands `tables 3.1` and `tables 3.2`: precision of methods on sets of shapes, from the truth or from votes."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from .cli import progress_bar, results_folder
from .errors import BadInput, BadParameter
from .evaluate_commands import EVERYTHING, Asked, methods_of, run
from .evaluation.tables import Table, to_csv, to_latex, to_markdown
from .evaluation.thesis_tables import HEAD, SetPrecision, thesis_table
from .parameters import assignments

if TYPE_CHECKING:
    from .evaluate_commands import Outcome

Words = Annotated[list[str] | None, Parameter(negative="", consume_multiple=True)]
VoteReader = Callable[[str], tuple[list[SetPrecision], Table] | None]
METHODS = {"3.1": ("thesis-rigid", "shed"), "3.2": ("thesis-nonrigid", "shed")}
_BESIDE = "and beside it the modern table with intervals and chance."
FROM_TRUTH = ("A match is right where the classes of its two sides overlap by at least half (the lenient rule), for which the "
              "thesis asked volunteers.")  # fmt: skip
FROM_VOTES = "A match is right or wrong by the majority of the votes; those undecided are in no precision."


def no_votes(place: str) -> tuple[list[SetPrecision], Table] | None:
    """The engine alone knows no studies."""
    if Path(place).is_file():
        raise BadInput(f"{place} is a file; name a folder of labelled meshes (studies are read by `concord tables`).")
    return None


def mount_shape_tables(app: App, voted: VoteReader) -> None:
    """Add both tables to the application `tables`; `voted` reads the precision of a study's votes."""
    app.command(_command("3.1", voted), name="3.1", help=f"Precision on rigid sets, {_BESIDE}")
    app.command(_command("3.2", voted), name="3.2", help=f"Precision on non-rigid sets, {_BESIDE}")


def _command(number: str, voted: VoteReader) -> Callable[..., None]:
    def table(
        source: str,
        *,
        out: Path,
        methods: Words = None,
        layers: Words = None,
        asked: Asked = EVERYTHING,
        set: Words = None,
        jobs: int = 0,
    ) -> None:
        """Make one table.

        Parameters
        ----------
        source
            A folder of labelled meshes, each sub-folder a set, or the word generated: see `concord evaluate`. Or a
            study (a file, a folder or postgresql://...), whose votes are counted.
        out
            Folder for the table as .md, .csv, .tex and .html; made if it is missing.
        methods
            Presets or methods; that of the thesis and shed if none is named. Of a study, all its methods.
        layers
            SET=NUMBER, the number of layers for single sets, as in vases=4 candles=4; the thesis adjusts nothing else.
        set
            NAME=VALUE, replaces single parameters of all methods; may be given several times.
        jobs
            Processes to use; 0 leaves one core free.
        """
        make(number, source, out, methods, layers, asked, set, jobs, voted)

    return table


def make(
    number: str,
    source: str,
    out: Path,
    methods: Sequence[str] | None,
    layers: Sequence[str] | None,
    asked: Asked,
    settings: Sequence[str] | None,
    jobs: int,
    voted: VoteReader,
) -> None:
    """Make one table of a study's votes or of a collection's truth, and write it in four forms."""
    found = voted(source)
    if found is not None:
        if methods or layers or settings or asked != EVERYTHING:
            raise BadParameter("A study has its results already; leave out --methods, --layers, --set and "
                               "the options that choose pairs.")  # fmt: skip
        with results_folder(out) as folder:
            _write(folder, number, found[0], [found[1]], f"{Path(source.partition('?')[0]).name}. {FROM_VOTES}", [])
        return
    from .evaluate_report import all_notes, judged_rows, lead_of
    from .evaluation import sheets
    from .evaluation.summary import ALL_SETS, set_rows

    chosen, of_set = methods_of(methods or METHODS[number], settings or ()), _layers(layers or ())
    with results_folder(out) as folder:
        with progress_bar() as progress:
            outcome = run(source, asked, chosen, folder, layers=of_set, jobs=jobs, progress=progress)
        rows = set_rows(judged_rows(outcome))
        cells = [SetPrecision(r.method, r.set_name, r.lenient.micro, r.pairs - r.failed, _layers_of(outcome, r.method, r.set_name))
                 for r in rows if r.set_name != ALL_SETS]  # fmt: skip
        modern = [sheets.pooled(rows), sheets.means(rows), sheets.by_size(rows)]
        _write(folder, number, cells, modern, f"{lead_of(outcome)} {FROM_TRUTH}", all_notes(outcome))


def _layers(texts: Sequence[str]) -> dict[str, int]:
    """Numbers of layers by set, from SET=NUMBER."""
    found = {}
    for name, text in assignments(texts).items():
        if not text.isdecimal():
            raise BadParameter(f"--layers takes SET=NUMBER, as in vases=4, not {name}={text}.")
        found[name] = int(text)
    return found


def _layers_of(outcome: "Outcome", method: str, set_name: str) -> int:
    """The number of layers that a set was matched with."""
    base = next(m.parameters.layers for m in outcome.methods if m.name == method)
    return outcome.layers.get(set_name, base)


def _write(
    folder: Path, number: str, cells: Sequence[SetPrecision], modern: Sequence[Table], lead: str, notes: Sequence[str]
) -> None:
    """Write the table with the modern ones as Markdown, LaTeX and HTML, and its cells as CSV; print it."""
    from .evaluate_report import notes_section, table_section
    from .report import page
    from .store import write_together

    tables, stem = [thesis_table(number, cells), *modern], f"table-{number}"
    sections = [*map(table_section, tables), notes_section(notes)]
    write_together({
        folder / f"{stem}.md": to_markdown(tables, lead, notes), folder / f"{stem}.tex": to_latex(tables, lead),
        folder / f"{stem}.csv": to_csv(HEAD, cells), folder / f"{stem}.html": page(f"Table {number}", lead, sections),
    })  # fmt: skip
    print(to_markdown(tables[:2], lead, notes), end="")
    print(f"\nwritten to {folder}")
