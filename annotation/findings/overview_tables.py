"""The researcher's overview as a table for people and as values for programs."""

from collections.abc import Sequence

from engine.evaluation.tables import NOTHING, Table

from .overview import VolunteerRow
from .tabletext import number

VALUES_HEAD = (
    "volunteer", "adjudicates", "judged", "open", "comments", "unsure_share", "median_seconds", "first_vote", "last_vote",
    "agreement_with_others", "gold_right", "gold_wrong", "flags",
)  # fmt: skip
_HEAD = ("volunteer", "judged", "open", "comments", "unsure %", "seconds a vote", "first vote", "last vote",
         "with the others %", "gold right", "gold wrong")  # fmt: skip
_REMARK = ("Seconds are the median, pauses cut at 60 s; with the others: votes that are those of the majority of the others; times in "
           "UTC.")  # fmt: skip
_ADVICE = "Flags are for a person to think about; no vote is ever left out or removed for them."


def overview_table(rows: Sequence[VolunteerRow]) -> Table:
    """The volunteers, and below them what is worth a look."""
    flags = [f"{row.code} {flag}." for row in rows for flag in row.flags]
    remark = " ".join([_REMARK, *flags, *([_ADVICE] if flags else [])]) if rows else "Nobody has a code yet."
    return Table("Volunteers", _HEAD, [_cells(row) for row in rows], 1, remark)


def _cells(row: VolunteerRow) -> tuple[str, ...]:
    name = row.code + (" (adjudicates)" if row.adjudicates else "") + (" !" if row.flags else "")
    pace = NOTHING if row.seconds is None else f"{row.seconds:.1f}"
    return (
        name, str(row.judged), str(row.open), str(row.comments), number(row.unsure), pace, _minute(row.first), _minute(row.last),
        number(row.agreement), str(row.gold_right), str(row.gold_wrong),
    )  # fmt: skip


def overview_values(row: VolunteerRow) -> tuple[object, ...]:
    """The values of `VALUES_HEAD`."""
    return (*row[:1], int(row.adjudicates), *row[2:-1], "; ".join(row.flags))


def _minute(stamp: str) -> str:
    """A time of ISO 8601 to the minute."""
    return stamp[:16].replace("T", " ") or NOTHING
