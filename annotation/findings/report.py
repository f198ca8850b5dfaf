"""What a study's votes say as text, Markdown, LaTeX, CSV, or one self-contained HTML page with pictures."""

import textwrap
from collections.abc import Sequence
from html import escape
from typing import Literal, NamedTuple

from engine.errors import ConcordError
from engine.evaluation.tables import Table, split_wide, to_latex, to_markdown

from ..exchange.csvtext import csv_text
from ..results.shownitems import PartsDrawer, item_picture
from ..storage.handle import StudyHandle
from ..voting.answering import item
from .chart import precision_chart
from .gathering import Disputed, Findings
from .tables import Section, Values, tuned_note
from .tabletext import aligned

Style = Literal["text", "csv", "markdown", "latex", "html"]
_WIDTH = 110
_PAPER = 112  # characters of small print across a page of A4 or letter with narrow margins
_LEGEND = "The dot is the precision, the line its 95 % interval, the band what the undecided matches could make of it."


class Drawn(NamedTuple):
    """Pictures of disputed matches, title and PNG, and why some have none."""

    pictures: list[tuple[str, bytes]]
    missing: tuple[str, ...]


def written(lead: str, tables: Sequence[Table], style: Literal["text", "markdown", "latex"], width: int = 0) -> str:
    """Tables with their remarks, below a first line; those wider than `width` characters are split (0: none), in LaTeX
    those too wide for a page. What cannot be printed, such as commands to a terminal, is shown as a blank."""
    lead, tables = _printable(lead), [_cleaned(table) for table in tables]
    if style == "latex":
        return to_latex([part for table in tables for part in split_wide(table, _PAPER)], lead)
    if style == "markdown":
        return to_markdown(tables, lead)
    parts, shown = [lead], [part for table in tables for part in split_wide(table, width)] if width else tables
    for table in shown:
        parts.append("\n".join([table.title, "", *aligned([table.head, *table.rows], table.words)]))
        parts += [textwrap.fill(table.remark, min(width or _WIDTH, _WIDTH))] if table.remark else []
    return "\n\n".join(parts) + "\n"


def _cleaned(table: Table) -> Table:
    head, rows = tuple(map(_printable, table.head)), [tuple(map(_printable, row)) for row in table.rows]
    return table._replace(head=head, rows=rows, remark=_printable(table.remark))


def _printable(text: str) -> str:
    return text if text.isprintable() else "".join(c if c.isprintable() else " " for c in text)


def as_csv(values: Values) -> str:
    """One section; shares in [0, 1], what is not known is empty."""
    return csv_text(*values)


def as_html(found: Findings, lead: str, tables: Sequence[Table], drawn: Drawn) -> str:
    """One page that needs no other file: the chart, the tables, and pictures of the most disputed matches."""
    from engine.report import page, pictures_html

    chart = precision_chart((*found.rows, *found.chosen))
    head = f"<h2>Precision with intervals</h2>{_wide(chart)}<p>{escape(_LEGEND + tuned_note(found))}</p>" if chart else ""
    sections = [head, *(_section(table) for table in tables)]
    if drawn.pictures or drawn.missing:
        told = "".join(f"<p>{escape(sentence)}</p>" for sentence in drawn.missing)
        sections.append(f"<h2>Pictures of the most disputed matches</h2>{pictures_html(drawn.pictures)}{told}")
    return page(found.study, lead, sections)


def draw_disputed(handle: StudyHandle, disputed: Sequence[Disputed], draw: PartsDrawer) -> Drawn:
    """A picture of each; where one cannot be drawn, a sentence that says why, once."""
    pictures, missing = [], []
    for number, one in enumerate(disputed, start=1):
        try:
            png = item_picture(handle, item(handle, one.item), draw)
        except (ConcordError, ImportError) as error:
            missing.append(str(error) if isinstance(error, ConcordError) else "Shapes need the extra 'gui' to be drawn.")
            continue
        pictures.append((f"{number}. {caption(one)}", png))
    return Drawn(pictures, tuple(dict.fromkeys(missing)))


def caption(one: Disputed) -> str:
    """The pair, how the votes fell, and what was said."""
    m = one.majority
    unsure = f", {m.unsure} unsure" if m.unsure else ""
    said = "".join(f" “{comment}”" for comment in one.comments)
    return f"{one.pair} ({', '.join(one.sets)}): {m.correct} correct, {m.wrong} wrong{unsure}.{said}"


def lead_of(found: Findings, section: Section = "all") -> str:
    """The first line: the study, and how much was voted."""
    votes = sum(row.votes for row in found.volunteers)
    people = f"{len(found.volunteers)} volunteer" + ("" if len(found.volunteers) == 1 else "s")
    part = "" if section == "all" else f", {section}"
    return f"Study {found.study}{part}: {votes} decisive votes of {people}"


def _section(table: Table) -> str:
    from engine.report import html_table

    remark = f"<p>{escape(table.remark)}</p>" if table.remark else ""
    return f"<h2>{escape(table.title)}</h2>{_wide(html_table(table.head, table.rows, table.numeric))}{remark}"


def _wide(content: str) -> str:
    """What may be wider than the page scrolls by itself."""
    return f'<div class="wide">{content}</div>'
