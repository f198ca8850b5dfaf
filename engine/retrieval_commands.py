"""The command `descriptors`: how well each descriptor finds true partners on the same nodes, in one table."""

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cyclopts import App

from .cli import progress_bar, results_folder
from .errors import BadParameter
from .evaluate_commands import EVERYTHING, MOST_JOBS, Asked, Words, the_collection
from .parameters import assignments
from .progress import share

if TYPE_CHECKING:
    from .evaluation.tables import Table
    from .runs.collection import Collection
    from .runs.retrieving import Mix, Row
    from .runs.sweep import Result
    from .shapes.parameters import MatchParameters

EVERY_SET = "all"
REMARK = (
    "Every node is a query in both directions, the whole shapes apart. A true partner covers the same classes (Jaccard index "
    "of at least one half); queries without one are left out. Figures are means over pairs. Chance: a random order of the "
    "same candidates. Large unions overlap each other, so that many are true partners: mind the columns by size."
)


def mount_descriptors(app: App) -> None:
    """Add the command to an application."""
    app.command(descriptors)


def descriptors(
    collection: str,
    *,
    out: Path,
    asked: Asked = EVERYTHING,
    mix: Words = None,
    nodes: int = 200,
    set: Words = None,
    jobs: int = 0,
) -> None:
    """Compare descriptors, alone and together: which find the true partners of nodes?

    Writes report.html, tables.md, tables.tex, retrieval.csv, pairs.csv and parameters.json. Started again with the same --out, only what
    is missing is run.

    Parameters
    ----------
    collection
        A folder of meshes with truth labels (NAME.off, NAME.sem) and segment labels (NAME.seg), each sub-folder a
        family; or the word generated, for pairs made by seed.
    out
        Folder for the results; made if it is missing.
    mix
        Another mix of descriptors as NAME=WEIGHT,NAME=WEIGHT, such as lfd=1,phks=0.5; may be given several times.
    nodes
        Most nodes of a shape; all pairs of them are compared.
    set
        NAME=VALUE, replaces single parameters of describing; may be given several times.
    jobs
        Processes to use; 0 leaves one core free.
    """
    from .runs.retrieving import SINGLES, TOGETHER, custom_mix, retrieval_task, retrieve
    from .runs.sweep import run_tasks
    from .shapes.parameters import MatchParameters

    if not 10 <= nodes <= 1000:
        raise BadParameter(f"--nodes cannot be {nodes}: it takes 10 to 1000.")
    if not 0 <= jobs <= MOST_JOBS:
        raise BadParameter(f"--jobs cannot be {jobs}: it takes 0 to {MOST_JOBS}.")
    mixes = list({m.name: m for m in (*SINGLES, *TOGETHER, *map(custom_mix, mix or ()))}.values())
    settings = assignments(set or ())
    weights = [name for name in settings if name == "lfd" or name.endswith("_weight")]
    if weights:
        raise BadParameter(f"--set cannot change '{weights[0]}' here: every mix brings its own; give one as --mix lfd=1,size=2.")
    parameters = MatchParameters(node_cap=nodes).changed(**settings)
    with results_folder(out) as folder, progress_bar() as progress:
        found = the_collection(collection, asked, progress=share(progress, 0.0, 0.05))
        tasks = [retrieval_task(pair, parameters, mixes) for pair in found.pairs]
        processes = jobs or max(1, (os.cpu_count() or 2) - 1)
        kept = run_tasks(tasks, retrieve, folder / "runs", jobs=processes, progress=share(progress, 0.05, 1.0))
        text = _write(folder, found, parameters, mixes, [[kept[key] for key in task.keys] for task in tasks])
    print(text, end="")
    print(f"\nwritten to {out}")


def _write(
    folder: Path, found: "Collection", parameters: "MatchParameters", mixes: "Sequence[Mix]",
    results: "Sequence[Sequence[Result]]",
) -> str:  # fmt: skip
    """Write the tables in all forms; returns them as Markdown."""
    from .evaluate_report import notes_section, table_section
    from .evaluation.retrieval import MEASURES
    from .evaluation.tables import to_csv, to_latex, to_markdown
    from .report import page
    from .runs.retrieving import SIZES, row_of
    from .store import write_together

    families = list(dict.fromkeys(pair.family for pair in found.pairs))
    members = {EVERY_SET: range(len(found.pairs))} | {
        family: [i for i, pair in enumerate(found.pairs) if pair.family == family] for family in families
    }
    rows = {
        (mix.name, name, size): row_of(mix.name, name, size, (results[i][k] for i in those))
        for k, mix in enumerate(mixes) for name, those in members.items() for size in SIZES
    }  # fmt: skip
    single = [
        row_of(mix.name, f"{pair.family} {pair.name}", size, [results[i][k]])
        for i, pair in enumerate(found.pairs) for k, mix in enumerate(mixes) for size in SIZES
    ]  # fmt: skip
    names = [mix.name for mix in mixes]
    tables = [_overall(names, rows), *([_by_family(names, rows, families)] if len(families) > 1 else [])]
    failed = dict.fromkeys(f"Failed: {pair.family} {pair.name}: {result['failure']}"
                           for pair, some in zip(found.pairs, results, strict=True) for result in some if result["failure"])  # fmt: skip
    pairs = "1 pair" if len(found.pairs) == 1 else f"{len(found.pairs)} pairs"
    lead = f"{pairs} of {found.name}: all nodes of every pair, at most {parameters.node_cap} a shape, by each descriptor."
    weights = {mix.name: ", ".join(f"{name} {value:g}" for name, value in mix.weights) for mix in mixes if len(mix.weights) > 1}
    notes = [*found.notes, *failed, *(f"Weights of {name}: {values}." for name, values in weights.items())]
    head = ("descriptor", "set", "segments", "pairs", "queries", *MEASURES, *(f"chance of {measure}" for measure in MEASURES))
    values = [_values(row) for row in rows.values()], [_values(row) for row in single]
    text = to_markdown(tables, lead, notes)
    sections = [*map(table_section, tables), notes_section(notes)]
    write_together({
        folder / "tables.md": text, folder / "tables.tex": to_latex(tables, lead),
        folder / "report.html": page(f"Descriptors on {found.name}", lead, sections),
        folder / "retrieval.csv": to_csv(head, values[0]), folder / "pairs.csv": to_csv(head, values[1]),
        folder / "parameters.json": json.dumps(parameters.model_dump(), indent=1) + "\n",
    })  # fmt: skip
    return text


def _values(row: "Row") -> tuple[object, ...]:
    return (*row[:5], *row.figures, *row.chance)


def _overall(names: Sequence[str], rows: "dict[tuple[str, str, str], Row]") -> "Table":
    """All measures of each mix over all pairs, and how often the first candidate is true by size of the query."""
    from .evaluation.retrieval import MEASURES
    from .evaluation.tables import Table, percent
    from .runs.retrieving import ALL_SIZES, SIZES

    def cells(name: str, kind: str) -> tuple[str, ...]:
        every = getattr(rows[name, EVERY_SET, ALL_SIZES], kind)
        return (*map(percent, every), *(percent(getattr(rows[name, EVERY_SET, size], kind)[0]) for size in SIZES[1:]))

    sizes = tuple(f"top-1, {size} segment{'' if size == '1' else 's'}" for size in SIZES[1:])
    body = [(name, *cells(name, "figures")) for name in names]
    body.append(("chance", *cells(names[0], "chance")))
    queries = rows[names[0], EVERY_SET, ALL_SIZES].queries
    return Table("Retrieval on the same nodes, in %", ("descriptor", *MEASURES, *sizes), body, 1,
                 f"{queries:,} queries. {REMARK}")  # fmt: skip


def _by_family(names: Sequence[str], rows: "dict[tuple[str, str, str], Row]", families: Sequence[str]) -> "Table":
    """How often the first candidate is true, for each family."""
    from .evaluation.tables import Table, percent
    from .runs.retrieving import ALL_SIZES

    body = [(name, *(percent(rows[name, family, ALL_SIZES].figures[0]) for family in families)) for name in names]
    body.append(("chance", *(percent(rows[names[0], family, ALL_SIZES].chance[0]) for family in families)))
    return Table("Top-1 by family, in %", ("descriptor", *families), body, 1)
