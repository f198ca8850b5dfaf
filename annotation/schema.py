"""The tables of a study, version 1. Votes are an append-only log of events; everything said about them is a view.

The same tables serve other databases by URL later, so types are plain TEXT, INTEGER and REAL; times are ISO 8601 in
UTC and structured values JSON text.
"""

from sqlalchemy import (
    REAL,
    CheckConstraint,
    Column,
    Connection,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    Table,
    Text,
    column,
    table,
)

SCHEMA_VERSION = 1
APPLICATION_ID = 0x436E6364  # "Cncd", in the header of every study file
MIGRATIONS: dict[int, tuple[str, ...]] = {}  # statements that lead from a version to the next

metadata = MetaData()


def _text(name: str, *constraints: CheckConstraint | ForeignKey, primary_key: bool = False) -> Column[str]:
    return Column(name, Text, *constraints, nullable=False, primary_key=primary_key)


study = Table(
    "study", metadata,
    _text("id", primary_key=True), _text("name"), _text("question"), _text("guideline"), _text("seed"),
    _text("settings"), _text("app_version"), _text("created_at"),
    sqlite_strict=True,
)  # fmt: skip

item = Table(
    "item", metadata,
    _text("id", primary_key=True), _text("kind", CheckConstraint("kind IN ('shape', 'puzzle')")), _text("payload"),
    _text("created_at"),
    sqlite_strict=True,
)  # fmt: skip

run = Table(
    "run", metadata,
    _text("id", primary_key=True), _text("kind"), _text("method"), _text("preset"), _text("parameters"),
    _text("set_name"), _text("pair"), _text("source"), _text("target"), _text("seconds"), _text("app_version"),
    _text("added_at"),
    sqlite_strict=True,
)  # fmt: skip

run_match = Table(
    "run_match", metadata,
    _text("run_id", ForeignKey("run.id"), primary_key=True),
    _text("item_id", ForeignKey("item.id"), primary_key=True),
    Column("rank", Integer, nullable=False), Column("score", REAL, nullable=False),
    Column("votes", Integer, nullable=False), Column("source_layer", Integer), Column("target_layer", Integer),
    sqlite_strict=True,
)  # fmt: skip

volunteer = Table(
    "volunteer", metadata,
    _text("code", primary_key=True), _text("seed"), _text("created_at"),
    sqlite_strict=True,
)  # fmt: skip

event = Table(
    "event", metadata,
    _text("uuid", primary_key=True), _text("kind", CheckConstraint("kind IN ('vote', 'retraction')")),
    _text("item_id", ForeignKey("item.id")), _text("volunteer", ForeignKey("volunteer.code")),
    Column("round", Integer, nullable=False),
    Column("answer", Text, CheckConstraint("answer IN ('correct', 'wrong', 'unsure')")), _text("comment"),
    Column("supersedes", Text, ForeignKey("event.uuid")),
    Column("clock", Integer, nullable=False), Column("shown_ms", Integer), Column("active_ms", Integer),
    _text("presentation"), _text("app_version"), _text("created_at"),
    CheckConstraint("(kind = 'vote') = (answer IS NOT NULL)"),
    CheckConstraint("kind = 'vote' OR supersedes IS NOT NULL"),
    Index("event_of_item", "item_id", "volunteer", "round"), Index("event_of_volunteer", "volunteer", "clock"),
    Index("event_supersedes", "supersedes"),
    sqlite_strict=True,
)  # fmt: skip

# A vote stands unless it was retracted; of a volunteer's standing votes on an item the newest is current. Age goes by
# the volunteer's own count of events (`clock`), never by the computer's time, which may be set back.
STANDING_VOTE = """CREATE VIEW standing_vote AS
SELECT * FROM event AS v WHERE v.kind = 'vote'
AND NOT EXISTS (SELECT 1 FROM event AS r WHERE r.kind = 'retraction' AND r.supersedes = v.uuid)"""
CURRENT_VOTE = """CREATE VIEW current_vote AS
SELECT * FROM (SELECT s.*, row_number() OVER (PARTITION BY s.item_id, s.volunteer, s.round
ORDER BY s.clock DESC, s.created_at DESC, s.uuid DESC) AS age FROM standing_vote AS s) AS ordered WHERE age = 1"""

_FORBIDDEN = "votes are only ever added: nothing may change or remove one"
SQLITE_TRIGGERS = tuple(
    f"CREATE TRIGGER event_{name} BEFORE {action} BEGIN SELECT RAISE(ABORT, '{_FORBIDDEN}'); END"
    for name, action in (
        ("never_updated", "UPDATE ON event"),
        ("never_deleted", "DELETE ON event"),
        ("never_replaced", "INSERT ON event WHEN EXISTS (SELECT 1 FROM event WHERE uuid = NEW.uuid)"),
    )
)

standing_vote, current_vote = (
    table(name, *(column(c.name, c.type) for c in event.columns)) for name in ("standing_vote", "current_vote")
)


def create_schema(connection: Connection) -> None:
    """All tables, views and triggers, in an open transaction on an empty database."""
    metadata.create_all(connection, checkfirst=False)
    for statement in (STANDING_VOTE, CURRENT_VOTE, *SQLITE_TRIGGERS):
        connection.exec_driver_sql(statement)
