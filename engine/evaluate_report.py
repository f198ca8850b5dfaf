"""What an evaluation writes: tables in four forms, pictures of the best and worst pairs, and on request all matches."""

import json
import math
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from .evaluation import sheets
from .evaluation.summary import Judged, comparison_rows, set_rows
from .evaluation.tables import Table, percent, to_csv, to_latex, to_markdown
from .progress import Progress
from .report import Picture, html_table, page, pictures_html
from .runs.judging import Method, judged, matched
from .runs.pairs import FilePair, LabelledPair, Pair, load_pair
from .shapes.families.collection import integer_lines, off_text
from .shapes.truth import counts, lenient_answers
from .store import default_cache, output_folder, write_together

if TYPE_CHECKING:
    from .evaluate_commands import Outcome
    from .report import PictureMaker


def write_report(outcome: "Outcome", folder: Path, draw: "PictureMaker", pictures: int, progress: Progress) -> str:
    """Write all tables and the page; returns the first table as Markdown, with the notes."""
    rows = judged_rows(outcome)
    sets, comparisons, notes = set_rows(rows), comparison_rows(rows), all_notes(outcome)
    tables, lead = sheets.tables(sets, comparisons), lead_of(outcome)
    shown = _pictures(outcome, rows, draw, pictures, progress)
    folded = sheets.pair_table(rows)
    sections = [*(table_section(t) for t in tables), *shown, notes_section(notes),
                f"<details><summary>{escape(folded.title)}</summary>{_html(folded)}</details>"]  # fmt: skip
    write_together({
        folder / "tables.md": to_markdown(tables, lead, notes), folder / "tables.tex": to_latex(tables, lead),
        folder / "report.html": page(f"Evaluation on {outcome.collection.name}", lead, sections),
        folder / "pairs.md": to_markdown([folded], lead), folder / "pairs.tex": to_latex([folded], lead, long=True),
        folder / "pairs.csv": to_csv(sheets.PAIR_HEAD, map(sheets.pair_values, rows)),
        folder / "sets.csv": to_csv(sheets.SET_HEAD, map(sheets.set_values, sets)),
        folder / "sizes.csv": to_csv(sheets.SIZE_HEAD, sheets.size_values(sets)),
        folder / "tests.csv": to_csv(sheets.TEST_HEAD, map(sheets.comparison_values, comparisons)),
        folder / "parameters.json": json.dumps({m.name: m.parameters.model_dump() for m in outcome.methods}, indent=1) + "\n",
    })  # fmt: skip
    return to_markdown(tables[:1], lead, notes)


def judged_rows(outcome: "Outcome") -> list[Judged]:
    """One row a method and pair, methods first."""
    return [
        judged(pair, method, outcome.results[i, k])
        for k, method in enumerate(outcome.methods)
        for i, pair in enumerate(outcome.collection.pairs)
    ]


def lead_of(outcome: "Outcome") -> str:
    """What was run, in one sentence."""
    pairs, families = len(outcome.collection.pairs), len({pair.family for pair in outcome.collection.pairs})
    return (f"{pairs} {'pair' if pairs == 1 else 'pairs'} of {families} {'family' if families == 1 else 'families'} of "
            f"{outcome.collection.name}, matched by {', '.join(m.name for m in outcome.methods)}.")  # fmt: skip


def all_notes(outcome: "Outcome") -> list[str]:
    """What was left out, what failed and where nothing was found; a failure of all methods is told once."""
    notes = list(outcome.collection.notes)
    for i, pair in enumerate(outcome.collection.pairs):
        failures: dict[str, list[str]] = {}
        for k, method in enumerate(outcome.methods):
            result = outcome.results[i, k]
            if result["failure"]:
                failures.setdefault(result["failure"], []).append(method.name)
            elif not result["figures"]["judged"]:
                notes.append(f"{method.name} found no match that can be judged: {pair.family} {pair.name}.")
        notes += [f"Failed: {', '.join(names)} on {pair.family} {pair.name}: {why}" for why, names in failures.items()]
    return notes


def table_section(table: Table) -> str:
    """A table with its heading and remark as HTML."""
    remark = f"<p>{escape(table.remark)}</p>" if table.remark else ""
    return f"<h2>{escape(table.title)}</h2>{_html(table)}{remark}"


def _html(table: Table) -> str:
    return f'<div style="overflow-x:auto">{html_table(table.head, table.rows, table.numeric)}</div>'


def notes_section(notes: Sequence[str]) -> str:
    """What is worth knowing, as a list in HTML; nothing where there is nothing."""
    items = "".join(f"<li>{escape(note)}</li>" for note in notes)
    return f"<h2>Notes</h2><ul>{items}</ul>" if items else ""


def extremes(rows: Sequence[Judged], count: int) -> tuple[list[Judged], list[Judged]]:
    """The best and the worst pairs of one method, no pair in both: by lenient precision times the recall of transfer."""

    def merit(row: Judged) -> float:
        e = row.figures
        value = e.lenient * e.transfer_recall if e is not None and e.judged else 0.0
        return 0.0 if math.isnan(value) else value

    order = sorted((row for row in rows if row.figures is not None), key=lambda row: -merit(row))
    count = min(count, (len(order) + 1) // 2)
    worst = order[max(len(order) - count, count) :]
    return order[:count], worst[::-1]


def _pictures(
    outcome: "Outcome", rows: Sequence[Judged], draw: "PictureMaker", count: int, progress: Progress
) -> list[str]:
    """Sections with the best and worst pairs of each method; none where nothing can be drawn."""
    known = {(pair.family, pair.name): pair for pair in outcome.collection.pairs}
    sections = []
    for k, method in enumerate(outcome.methods):
        parts = []
        for title, chosen in zip(("Best", "Worst"), extremes([r for r in rows if r.method == method.name], count), strict=True):
            for row in chosen:
                progress(k / len(outcome.methods), f"drawing {row.set_name} {row.pair}")
                drawn = _drawn(known[row.set_name, row.pair], method, draw)
                if not drawn:
                    return []
                parts.append(f"<h3>{title}: {escape(_caption(row))}</h3>" + pictures_html(drawn))
        if parts:
            words = ("By lenient precision times recall of transfer. Solid links with a tick are right by the lenient rule, "
                     "dashed ones with a cross wrong; matches of a whole shape are not judged.")  # fmt: skip
            sections.append(f"<h2>Best and worst pairs of {escape(method.name)}</h2><p>{words}</p>" + "".join(parts))
    return sections


def _drawn(pair: Pair, method: Method, draw: "PictureMaker") -> list[Picture]:
    """Pictures of one pair, its matches marked by the lenient verdict where they are judged."""
    loaded = load_pair(pair)
    result = matched(loaded, method, default_cache())
    answers = lenient_answers(loaded.source, loaded.target, loaded.source_label, loaded.target_label, result)
    judged = counts(loaded.source, loaded.target, result)
    states = {match: "correct" if right else "wrong" for match, right, is_judged in zip(result.ids, answers, judged, strict=True)
              if is_judged}  # fmt: skip
    return draw(loaded.source, loaded.target, result, states)


def _caption(row: Judged) -> str:
    e = row.figures
    if e is None or not e.judged:
        return f"{row.set_name} {row.pair}, no match that can be judged"
    number = "1 match" if e.judged == 1 else f"{e.judged} matches"
    return (f"{row.set_name} {row.pair}, {number}, lenient {percent(e.lenient)} %, strict {percent(e.strict)} %, "
            f"transfer {percent(e.transfer_precision)} / {percent(e.transfer_recall)} %")  # fmt: skip


def write_matches_of(outcome: "Outcome", folder: Path) -> None:
    """OUT/matches/FAMILY/PAIR/METHOD.json of schema concord.matches/1; beside them what was made by seed: meshes, labels."""
    for i, pair in enumerate(outcome.collection.pairs):
        place = output_folder(folder / "matches" / pair.family / pair.name.replace(" ", "-"))
        meshes = (pair.source.mesh, pair.target.mesh) if isinstance(pair, FilePair) else (place / "source.off", place / "target.off")
        files: dict[Path, bytes | str] = {}
        for k, method in enumerate(outcome.methods):
            if not outcome.results[i, k]["failure"]:
                found = {**outcome.results[i, k]["matches"]}
                found |= {side: {**found[side], "file": str(mesh)} for side, mesh in zip(("source", "target"), meshes, strict=True)}
                files[place / f"{method.name}.json"] = json.dumps(found, indent=1) + "\n"
        if not isinstance(pair, FilePair) or not pair.source.labels:
            files |= _made(load_pair(pair), place, meshes=not isinstance(pair, FilePair))
        write_together(files, synced=False)


def _made(pair: LabelledPair, place: Path, *, meshes: bool) -> dict[Path, bytes | str]:
    """The segment labels of a pair that has none in files and, for generated shapes, meshes and truth."""
    files: dict[Path, bytes | str] = {}
    for side, shape, label in (("source", pair.source, pair.source_label), ("target", pair.target, pair.target_label)):
        files[place / f"{side}.seg"] = integer_lines(shape.segmentation.labels)
        if meshes:
            files |= {place / f"{side}.off": off_text(shape.mesh), place / f"{side}.sem": integer_lines(label)}
    return files
