"""The benchmark of puzzles: every picture cut, worn, solved and scored in every way; resumable, one file a run."""

import csv
import hashlib
import io
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import BadInput
from ..progress import Progress, share, silent
from ..spreadsheet import safe_cell
from ..store import write_atomically
from . import learned, polygonmodels
from .gathering import Cutting, cut_images, without_frame
from .imagefile import plain_text
from .parameters import PuzzleParameters
from .piecefolder import image_files
from .pieces import Puzzle, Truth
from .scoring import score
from .solving import assemble, prepare
from .wearing import WEAR, check_wear, worn

FORM = "2"  # of what a run file holds; old ones are made anew
FITTED = (learned.FILE, polygonmodels.FILE)  # the numbers behind every probability
NO_WEAR = "none"
NAMING = ("image", "wear", "measure", "method")  # columns of words; the others are numbers
HEAD = ("image", "seed", "wear", "measure", "method", "pieces", "direct", "neighbour", "perfect", "direct_tie_aware",
        "neighbour_tie_aware", "perfect_tie_aware", "largest_component", "seconds")  # fmt: skip


class Plan(NamedTuple):
    """What is run: all combinations of seeds, kinds of wear, measures and methods on each picture of a folder."""

    folder: Path
    how: Cutting
    seeds: tuple[int, ...]
    wear: tuple[str, ...]
    measures: tuple[str, ...]
    methods: tuple[str, ...]
    parameters: PuzzleParameters


def checked_plan(plan: Plan) -> Plan:
    """The plan, each thing named in it once, or `BadInput` in one sentence for what cannot be run.

    Every picture is read and cut to find out.
    """
    plan = plan._replace(seeds=tuple(dict.fromkeys(plan.seeds)), wear=tuple(dict.fromkeys(plan.wear)),
                         measures=tuple(dict.fromkeys(plan.measures)), methods=tuple(dict.fromkeys(plan.methods)))  # fmt: skip
    if not image_files(plan.folder):
        raise BadInput(f"The folder {plan.folder} holds no images; name a folder of pictures to cut.")
    for kind in plan.wear:
        if kind != NO_WEAR and kind not in WEAR:
            raise BadInput(f"There is no wear '{kind}'; the kinds are {', '.join([NO_WEAR, *WEAR])}.")
        if kind != NO_WEAR and plan.how.kind != "squares":
            raise BadInput(f"The wear '{kind}' is for squares; leave out --cut {plan.how.kind}.")
    for measure in plan.measures:
        for method in plan.methods:
            plan.parameters.changed(measure=measure, method=method)
    for image in image_files(plan.folder):
        try:
            puzzle, _ = cut_images([image], plan.how)
            for kind in plan.wear:
                if kind != NO_WEAR:
                    check_wear(puzzle, kind)
        except BadInput as error:
            raise BadInput(str(error) if image.name in str(error) else f"{image}: {error}") from None
    return plan


def run_plan(plan: Plan, runs: Path, *, progress: Progress = silent) -> list[dict[str, Any]]:
    """Run what has not been run; each result is kept in a file of the folder `runs`. Returns all results in order."""
    images = image_files(plan.folder)
    groups = [(image, seed, wear) for image in images for seed in plan.seeds for wear in plan.wear]
    fitted = tuple(hashlib.sha256(file.read_bytes()).hexdigest() for file in FITTED)
    results: list[dict[str, Any]] = []
    for k, (image, seed, wear) in enumerate(groups):
        step = share(progress, k / len(groups), (k + 1) / len(groups))
        results += _group(plan, image, seed, wear, runs, fitted, step)
    progress(1.0, "done")
    return results


def _group(
    plan: Plan, image: Path, seed: int, wear: str, runs: Path, fitted: tuple[str, ...], progress: Progress
) -> Iterator[dict[str, Any]]:
    """All measures and methods on one puzzle, which is cut and prepared only where something is left to run.

    A result is kept by all that it depends on: the picture, how it was cut and worn, the parameters, the version and
    the digests of the `fitted` numbers.
    """
    content = hashlib.sha256(image.read_bytes()).hexdigest()
    made = None
    for number, measure in enumerate(plan.measures):
        prepared = None
        part = share(progress, number / len(plan.measures), (number + 1) / len(plan.measures))
        for turn, method in enumerate(plan.methods):
            assembly = share(part, 0.6 + 0.4 * turn / len(plan.methods), 0.6 + 0.4 * (turn + 1) / len(plan.methods))
            parameters = plan.parameters.changed(measure=measure, method=method)
            values = sorted(parameters.model_dump().items())
            how = plan.how._replace(seed=seed)
            key = (FORM, version("concord-correspondences"), *fitted, content, seed, wear, *how, values)
            path = runs / f"{hashlib.sha256(repr(key).encode()).hexdigest()[:24]}.json"
            found = _kept(path)
            if found is None:
                if made is None:
                    made = _made(image, how, wear, plan.parameters.frame == "unknown")
                if prepared is None:
                    prepared = prepare(made[0], parameters, progress=share(part, 0.0, 0.6))
                assembly(0.0, f"{image.name}: {method}")
                solution = assemble(prepared, parameters, progress=assembly)
                seconds = sum(solution.seconds.values())
                found = {"pieces": made[0].count, **asdict(score(*made, solution)), "seconds": round(seconds, 4)}
                write_atomically(path, json.dumps(found) + "\n")
            yield {"image": plain_text(image.name), "seed": seed, "wear": wear, "measure": measure, "method": method, **found}


def _made(image: Path, how: Cutting, wear: str, frame_unknown: bool) -> tuple[Puzzle, Truth]:
    """A picture cut and worn; an unknown frame is known neither to the solver nor to the scores."""
    puzzle, truth = cut_images([image], how)
    if wear != NO_WEAR:
        puzzle, truth = worn(puzzle, truth, wear, how.seed)
    return (without_frame(puzzle) if frame_unknown else puzzle), truth


def _kept(path: Path) -> dict[str, Any] | None:
    """The result of an earlier run, None where there is none or it is damaged."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) and set(HEAD[5:]) <= set(found) else None


def results_to_csv(results: Sequence[dict[str, Any]]) -> str:
    """One line a run."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(HEAD)
    writer.writerows([safe_cell(str(value)) if isinstance(value, str) else value for value in (r[k] for k in HEAD)] for r in results)
    return text.getvalue()


class Table(NamedTuple):
    """A table for people: a title, column heads, rows of texts; the last row is the mean."""

    title: str
    head: tuple[str, ...]
    rows: list[tuple[str, ...]]


def overview(results: Sequence[dict[str, Any]]) -> Table:
    """The means of each way over all pictures and seeds, and how many puzzles came out perfect."""
    rows = [
        (*way, *_means(group), f"{sum(r['perfect'] for r in group)} of {len(group)}",
         f"{sum(r['perfect_tie_aware'] for r in group)} of {len(group)}", f"{_mean(group, 'seconds'):.2f}")
        for way, group in _ways(results).items()
    ]  # fmt: skip
    head = ("wear", "measure", "method", "direct", "neighbour", "direct, tie-aware", "neighbour, tie-aware", "perfect",
            "perfect, tie-aware", "seconds")  # fmt: skip
    return Table("Means over all pictures", head, rows)


def by_image(results: Sequence[dict[str, Any]]) -> list[Table]:
    """For each way a table with one row a picture (the mean over its seeds) and their mean."""
    head = ("image", "pieces", "direct", "neighbour", "direct, tie-aware", "neighbour, tie-aware", "perfect", "seconds")
    tables = []
    for (wear, measure, method), group in _ways(results).items():
        rows = []
        for name in dict.fromkeys(r["image"] for r in group):
            mine = [r for r in group if r["image"] == name]
            rows.append((name, str(mine[0]["pieces"]), *_means(mine), _perfect(mine), f"{_mean(mine, 'seconds'):.2f}"))
        rows.append(("mean", "", *_means(group), _perfect(group), f"{_mean(group, 'seconds'):.2f}"))
        worn_words = "" if wear == NO_WEAR else f", {wear}"
        tables.append(Table(f"{method} on {measure}{worn_words}", head, rows))
    return tables


def _ways(results: Sequence[dict[str, Any]]) -> dict[tuple[str, str, str], list[dict[str, Any]]]:
    ways: dict[tuple[str, str, str], list[dict[str, Any]]] = {}
    for r in results:
        ways.setdefault((r["wear"], r["measure"], r["method"]), []).append(r)
    return ways


def _mean(group: Sequence[dict[str, Any]], key: str) -> float:
    return sum(float(r[key]) for r in group) / len(group)


def _means(group: Sequence[dict[str, Any]]) -> tuple[str, ...]:
    keys = ("direct", "neighbour", "direct_tie_aware", "neighbour_tie_aware")
    return tuple(f"{100 * _mean(group, key):.1f}" for key in keys)


def _perfect(group: Sequence[dict[str, Any]]) -> str:
    return f"{sum(r['perfect'] for r in group)} of {len(group)}" if len(group) > 1 else ("yes" if group[0]["perfect"] else "no")


def to_markdown(tables: Sequence[Table], lead: str) -> str:
    """The tables as Markdown."""
    parts = [lead]
    for table in tables:
        lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in (table.head, *table.rows)]
        lines.insert(1, "|" + "---|" * len(table.head))
        parts.append(f"## {table.title}\n\n" + "\n".join(lines))
    return "\n\n".join(parts) + "\n"
