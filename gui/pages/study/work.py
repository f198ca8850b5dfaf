"""What the researcher's commands do with an open study, in a thread; each returns a sentence on what was done."""

from collections.abc import Sequence
from pathlib import Path

from annotation.design.topup import top_up, top_up_study
from annotation.exchange.anonymising import Anonymous
from annotation.exchange.archive import archive
from annotation.exchange.exporting import export
from annotation.exchange.forgetting import forget
from annotation.exchange.merging import merge_handles
from annotation.exchange.packets import make_packet
from annotation.findings.datasheet import as_json, as_markdown
from annotation.findings.datasheet_facts import answered
from annotation.findings.gathering import Findings, findings
from annotation.findings.overview import overview
from annotation.findings.overview_tables import VALUES_HEAD, overview_values
from annotation.findings.precision import precision_table
from annotation.findings.report import Drawn, as_csv, as_html, draw_disputed, lead_of, written
from annotation.findings.tables import tables, values
from annotation.results.proposals import add_run
from annotation.results.studyruns import item_count
from annotation.storage.blobs import keep_shapes
from annotation.study import StudyHandle, open_study, volunteers
from engine.progress import Progress
from engine.store import write_atomically

from .sources import Source, plural

PICTURES = 6
ENDINGS = {"csv": "csv", "markdown": "md", "latex": "tex", "html": "html"}


def packet(handle: StudyHandle, progress: Progress, code: str, path: Path, items: int) -> str:
    """Write the packet of one volunteer."""
    progress(0.1, f"Packing for {code}")
    made = make_packet(handle, code, path, items or None)
    more = f" and {made.practice} to practise on" if made.practice else ""
    return f"{path.name}: {plural(made.items, 'match', 'matches')}{more} for {code}. Voting: concord vote {path.name}"


def take_in(handle: StudyHandle, progress: Progress, path: Path) -> str:
    """Merge a returned packet, or another copy of the study."""
    progress(0.1, f"Taking in {path.name}")
    with open_study(path, backup=False, writable=False) as source:
        merged = merge_handles(source, handle)
    if not any(merged):
        return f"{path.name} held nothing new: all of it was taken in before."
    parts = [plural(merged.events, "vote or undo", "votes and undos"), plural(merged.items, "match", "matches"),
             plural(merged.volunteers, "volunteer")]  # fmt: skip
    return f"Taken in from {path.name}: " + ", ".join(part for part in parts if not part.startswith("0 ")) + "."


def forgotten(handle: StudyHandle, progress: Progress, code: str, votes_too: bool) -> str:
    """Delete a volunteer who asks for it."""
    progress(0.1, "Deleting a volunteer")
    found = forget(handle, code, votes_too=votes_too)
    kept = f"{plural(found.kept, 'vote')} stay without a name, as {found.pseudonym}" if found.kept else "no vote of theirs is left"
    more = f" {plural(found.mentions, 'text')} of others still name them." if found.mentions else ""
    return f"{code} was deleted from the study and its backups; {kept}.{more}"


def exported(handle: StudyHandle, progress: Progress, folder: Path, formats: Sequence[str], gold: bool) -> str:
    """Write all tables with their dictionary into a folder."""
    progress(0.1, "Exporting")
    files = export(handle, folder, formats, gold=gold)
    return f"{len(files)} files written to {folder}; dictionary.md says what every column means."


def archived(handle: StudyHandle, progress: Progress, path: Path, anonymous: bool) -> str:
    """Write the whole study as one zip."""
    progress(0.1, "Packing the study")
    archive(handle, path, Anonymous([one.code for one in volunteers(handle)]) if anonymous else None)
    return f"The study is in {path}."


def topped_up(handle: StudyHandle, progress: Progress, sources: Sequence[Source], most: int) -> str:
    """Put new results into the study and ask what is not asked yet; votes stay."""
    new = taken(handle, progress, sources)
    asked = top_up(handle, most=most)
    count = asked or new
    if not count:
        return "There is nothing new to ask: every match is in the study already."
    return f"{plural(count, 'new match is', 'new matches are')} asked; votes given so far stay."


def taken(handle: StudyHandle, progress: Progress, sources: Sequence[Source]) -> int:
    """Put results and their shapes into the study; how many matches it did not have."""
    before = item_count(handle)
    runs = [run for source in sources for run in source.runs]
    for row, run in enumerate(runs):
        progress(0.8 * row / len(runs), "Adding results")
        add_run(handle, run)
    keep_shapes(handle, [shape for source in sources for shape in source.shapes])
    return item_count(handle) - before


def unjudged_study(handle: StudyHandle, progress: Progress, sources: Sequence[Source], path: Path, most: int) -> str:
    """Make a study of what nobody has judged yet; the open one keeps its questions as they are."""
    taken(handle, progress, sources)
    made, left = top_up_study(handle, path, most=most)
    made.close()
    return f"{path.name} asks the {plural(left, 'match', 'matches')} that nobody has judged; merge it back when it is done."


def report(handle: StudyHandle, progress: Progress, path: Path, style: str, section: str, preset: str) -> str:
    """Write what the votes say: one section as CSV, or all as Markdown, LaTeX or an HTML page with pictures."""
    progress(0.1, "Working out the figures")
    if (style, section) == ("csv", "volunteers"):
        write_atomically(path, as_csv((VALUES_HEAD, [overview_values(row) for row in overview(handle)])))
        return f"Written to {path}"
    found = findings(handle, preset=preset)
    text = report_text(handle, progress, found, style, section)
    progress(0.95, "Writing")
    write_atomically(path, text)
    return f"Written to {path}"


def report_text(handle: StudyHandle, progress: Progress, found: Findings, style: str, section: str) -> str:
    """The text of a report in a style."""
    if style == "csv":
        return as_csv(values(found, section))
    shown, lead = tables(found), lead_of(found)
    if style != "html":
        return written(lead, shown, style)
    from ...views.parts_picture import draw_parts

    progress(0.4, "Drawing pictures")
    drawn = draw_disputed(handle, found.disputed[:PICTURES], draw_parts) if found.disputed else Drawn([], ())
    return as_html(found, lead, shown, drawn)


def figure(handle: StudyHandle, progress: Progress, path: Path) -> str:
    """Write the plot of precision as a figure for a paper, in the format of the file's ending."""
    from ..results.figure import figure_bytes
    from ..results.precision import marks

    progress(0.1, "Working out the figures")
    rows = precision_table(handle)
    progress(0.6, "Drawing")
    drawn = figure_bytes(marks(rows), path.suffix.lower().lstrip("."))
    progress(0.95, "Writing")
    write_atomically(path, drawn)
    return f"Written to {path}"


def datasheet(handle: StudyHandle, progress: Progress, path: Path) -> str:
    """Write the Human Evaluation Datasheet: what the study knows, and what is left to people."""
    progress(0.1, "Filling in the datasheet")
    sheet = answered(handle)
    write_atomically(path, as_json(sheet) if path.suffix == ".json" else as_markdown(sheet))
    left = sum(bool(answer.left) for answer in sheet.answers)
    return f"Written to {path}; {plural(left, 'question is', 'questions are')} left to you."
