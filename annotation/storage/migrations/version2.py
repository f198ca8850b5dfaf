"""From version 1 to 2: how many votes an item gets, what is asked of whom, kept shapes, forgotten volunteers.

Indexes of events answer by themselves which votes of an item stand.
"""

from typing import TYPE_CHECKING

from sqlalchemy import REAL, CheckConstraint, Column, ForeignKey, Integer, LargeBinary, Text
from sqlalchemy.dialects.postgresql import DOUBLE_PRECISION

if TYPE_CHECKING:
    from alembic.operations import Operations


def upgrade(op: "Operations") -> None:
    """A study of version 1 asks everybody everything, once."""
    for name, default in (("votes", 0), ("adaptive", 1), ("unsure", 1)):
        op.add_column("study", _number(name, default))
    op.add_column("volunteer", _number("adjudicates"))
    op.create_table(
        "asked",
        Column("item_id", Text, ForeignKey("item.id"), primary_key=True, nullable=False),
        Column("role", Text, CheckConstraint("role IN ('judged', 'gold', 'practice')"), nullable=False),
        Column("answer", Text, CheckConstraint("answer IN ('correct', 'wrong')")),
        *(Column(name, Text, nullable=False) for name in ("reason", "stratum")),
        Column("probability", REAL().with_variant(DOUBLE_PRECISION(), "postgresql")),
        _number("overlapped"),
        Column("added_at", Text, nullable=False),
        sqlite_strict=True,
    )
    op.create_table(
        "assignment",
        Column("item_id", Text, ForeignKey("item.id"), primary_key=True, nullable=False),
        Column("volunteer", Text, ForeignKey("volunteer.code"), primary_key=True, nullable=False),
        Column("made_at", Text, nullable=False),
        sqlite_strict=True,
    )
    op.create_index("assignment_of_volunteer", "assignment", ["volunteer"])
    op.create_table(
        "blob",
        Column("key", Text, primary_key=True, nullable=False),
        Column("content", LargeBinary, nullable=False),
        sqlite_strict=True,
    )
    op.create_table(
        "forgotten",
        Column("code_hash", Text, primary_key=True, nullable=False),
        Column("pseudonym", Text, nullable=False),
        _number("votes_kept", 1),
        Column("at", Text, nullable=False),
        sqlite_strict=True,
    )
    for index, more in (("event_of_item", ["item_id", "volunteer", "round", "clock", "kind"]),
                        ("event_supersedes", ["supersedes", "kind"])):  # fmt: skip
        op.drop_index(index, "event")
        op.create_index(index, "event", more)


def _number(name: str, default: int = 0) -> "Column[int]":
    return Column(name, Integer, nullable=False, server_default=str(default))
