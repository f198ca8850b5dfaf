"""The tables of a study, version 2. Votes are an append-only log of events; everything said about them is a view.

The same tables serve SQLite and PostgreSQL, so types are plain TEXT, INTEGER, REAL and BLOB; times are ISO 8601 in UTC
and structured values JSON text. What a volunteer may not know (runs, scores, gold marks, others' votes) is never in a
table that a volunteer's query reads: those are `study`, `item`, `blob`, `practice`, `open_item` and the own events.
"""

from typing import Any

from sqlalchemy import (
    REAL,
    TEXT,
    BigInteger,
    CheckConstraint,
    Column,
    Connection,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    Table,
    Text,
    column,
    table,
)
from sqlalchemy.dialects.postgresql import DOUBLE_PRECISION
from sqlalchemy.types import TypeEngine

SCHEMA_VERSION = 2  # a new one for every change of tables, views or triggers: files with other rules are refused
APPLICATION_ID = 0x436E6364  # "Cncd", in the header of every study file

metadata = MetaData()
Real: TypeEngine[Any] = REAL().with_variant(DOUBLE_PRECISION(), "postgresql")
Long = Integer().with_variant(BigInteger(), "postgresql")  # 64 bits on both: an hour is 3.6 million milliseconds
Words = Text().with_variant(TEXT(collation="C"), "postgresql")  # sorted by code points, as on SQLite, whatever the server


def _text(name: str, *constraints: CheckConstraint | ForeignKey, primary_key: bool = False) -> Column[str]:
    return Column(name, Words, *constraints, nullable=False, primary_key=primary_key)


def _number(name: str, default: int = 0) -> Column[int]:
    return Column(name, Integer, nullable=False, server_default=str(default))


study = Table(
    "study", metadata,
    _text("id", primary_key=True), _text("name"), _text("question"), _text("guideline"), _text("seed"),
    _text("settings"), _text("app_version"), _text("created_at"),
    _number("votes"), _number("adaptive", 1), _number("unsure", 1),
    sqlite_strict=True,
)  # fmt: skip
"""One row. `votes` is k, how many votes an item is to get, 0 for one of everybody; `adaptive` asks no further once more
than k / 2 agree; `unsure` allows that answer."""

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
    Column("rank", Integer, nullable=False), Column("score", Real, nullable=False),
    Column("votes", Integer, nullable=False), Column("source_layer", Integer), Column("target_layer", Integer),
    sqlite_strict=True,
)  # fmt: skip

volunteer = Table(
    "volunteer", metadata,
    _text("code", primary_key=True), _text("seed"), _text("created_at"), _number("adjudicates"),
    sqlite_strict=True,
)  # fmt: skip
"""An adjudicator (`adjudicates` = 1) is asked about unresolved items alone; each vote counts like any other."""

asked = Table(
    "asked", metadata,
    _text("item_id", ForeignKey("item.id"), primary_key=True),
    _text("role", CheckConstraint("role IN ('judged', 'gold', 'practice')")),
    Column("answer", Text, CheckConstraint("answer IN ('correct', 'wrong')")), _text("reason"), _text("stratum"),
    Column("probability", Real), _number("overlapped"), _text("added_at"),
    sqlite_strict=True,
)  # fmt: skip
"""Which items are asked, and why; where it is empty, all are. `answer` is the known one of gold and practice items,
`reason` what is told after a practice item, `probability` that of being drawn into the sample (None: not drawn),
`overlapped` marks items that get all k votes, for agreement. Practice items are voted on in round 0."""

assignment = Table(
    "assignment", metadata,
    _text("item_id", ForeignKey("item.id"), primary_key=True),
    _text("volunteer", ForeignKey("volunteer.code"), primary_key=True), _text("made_at"),
    Index("assignment_of_volunteer", "volunteer"),
    sqlite_strict=True,
)  # fmt: skip
"""What was handed out in packets; a volunteer who has any is asked about these alone, and others less about them."""

blob = Table(
    "blob", metadata,
    _text("key", primary_key=True), Column("content", LargeBinary, nullable=False),
    sqlite_strict=True,
)  # fmt: skip
"""The shapes that items show: a study can be judged where its meshes are not (see `annotation.storage.blobs`)."""

forgotten = Table(
    "forgotten", metadata,
    _text("code_hash", primary_key=True), _text("pseudonym"), _number("votes_kept", 1), _text("at"),
    sqlite_strict=True,
)  # fmt: skip
"""Volunteers who asked to be deleted, by the hash of their code, so that no merge brings them back."""

event = Table(
    "event", metadata,
    _text("uuid", primary_key=True), _text("kind", CheckConstraint("kind IN ('vote', 'retraction')")),
    _text("item_id", ForeignKey("item.id")), _text("volunteer", ForeignKey("volunteer.code")),
    Column("round", Integer, nullable=False),
    Column("answer", Text, CheckConstraint("answer IN ('correct', 'wrong', 'unsure')")), _text("comment"),
    Column("supersedes", Text, ForeignKey("event.uuid")),
    Column("clock", Integer, nullable=False), Column("shown_ms", Long), Column("active_ms", Long),
    _text("presentation"), _text("app_version"), _text("created_at"),
    CheckConstraint("(kind = 'vote') = (answer IS NOT NULL)"),
    CheckConstraint("kind = 'vote' OR supersedes IS NOT NULL"),
    Index("event_of_item", "item_id", "volunteer", "round", "clock", "kind"),
    Index("event_of_volunteer", "volunteer", "clock"), Index("event_supersedes", "supersedes", "kind"),
    sqlite_strict=True,
)  # fmt: skip

# A vote stands unless it was retracted; of a volunteer's standing votes on an item the newest is current. Age goes by
# the volunteer's own count of events (`clock`), never by the computer's time, which may be set back.
STANDING_VOTE = """CREATE VIEW standing_vote AS
SELECT * FROM event AS v WHERE v.kind = 'vote'
AND NOT EXISTS (SELECT 1 FROM event AS r WHERE r.kind = 'retraction' AND r.supersedes = v.uuid)"""
# That no newer one stands is told row by row, so that what is asked of one item or volunteer looks at no others.
CURRENT_VOTE = """CREATE VIEW current_vote AS
SELECT * FROM standing_vote AS s WHERE NOT EXISTS (SELECT 1 FROM standing_vote AS n
WHERE n.item_id = s.item_id AND n.volunteer = s.volunteer AND n.round = s.round AND n.clock >= s.clock
AND (n.clock, n.created_at, n.uuid) > (s.clock, s.created_at, s.uuid))"""

# Round 1 alone decides: practice is round 0.
TALLY = """CREATE VIEW tally AS SELECT item_id, COUNT(*) AS votes,
SUM(CASE WHEN answer = 'correct' THEN 1 ELSE 0 END) AS correct, SUM(CASE WHEN answer = 'wrong' THEN 1 ELSE 0 END) AS wrong
FROM current_vote WHERE round = 1 GROUP BY item_id"""
# An item wants another vote until it has k, or, where the study is adaptive and the item not overlapped, until more than
# k / 2 agree. An item that is unresolved after k votes (two of them at least) wants one more, of a further volunteer or
# of an adjudicator, whoever comes first; if that leaves it unresolved, it is for adjudicators alone. What waits in
# packets may still settle it: `packets` counts the volunteers who hold it and have not answered yet. Votes are counted
# here and not taken from `tally`, so that what is asked about one item looks at no others.
WANTED = """CREATE VIEW wanted AS
SELECT f.item_id, f.role, CASE
WHEN f.k = 0 OR f.role <> 'judged' THEN 1
WHEN f.votes + f.packets < f.k
AND (f.adaptive = 0 OR f.overlapped = 1 OR 2 * (CASE WHEN f.correct > f.wrong THEN f.correct ELSE f.wrong END + f.packets) <= f.k)
THEN 1
WHEN f.votes = f.k AND f.packets = 0 AND f.correct = f.wrong THEN 1
ELSE 0 END AS open,
CASE WHEN f.correct = f.wrong AND f.packets = 0 AND f.votes >= f.k AND f.votes > 1 THEN 1 ELSE 0 END AS disputed
FROM (SELECT i.id AS item_id, COALESCE(q.role, 'judged') AS role, COALESCE(q.overlapped, 0) AS overlapped,
s.votes AS k, s.adaptive AS adaptive, COUNT(t.uuid) AS votes,
SUM(CASE WHEN t.answer = 'correct' THEN 1 ELSE 0 END) AS correct, SUM(CASE WHEN t.answer = 'wrong' THEN 1 ELSE 0 END) AS wrong,
(SELECT COUNT(*) FROM assignment AS a WHERE a.item_id = i.id AND NOT EXISTS (SELECT 1 FROM event AS e
WHERE e.item_id = a.item_id AND e.volunteer = a.volunteer AND e.round = 1)) AS packets
FROM item AS i CROSS JOIN study AS s LEFT JOIN asked AS q ON q.item_id = i.id
LEFT JOIN current_vote AS t ON t.item_id = i.id AND t.round = 1
WHERE q.item_id IS NOT NULL OR NOT EXISTS (SELECT 1 FROM asked)
GROUP BY i.id, q.role, q.overlapped, s.votes, s.adaptive) AS f"""
# A packet fixes what its volunteer is asked; practice comes on top, but for adjudicators.
OPEN_ITEM = """CREATE VIEW open_item AS
SELECT v.code AS volunteer, w.item_id AS item_id, CASE WHEN w.role = 'practice' THEN 0 ELSE 1 END AS round
FROM volunteer AS v CROSS JOIN wanted AS w
WHERE NOT EXISTS (SELECT 1 FROM standing_vote AS e WHERE e.item_id = w.item_id AND e.volunteer = v.code
AND e.round = CASE WHEN w.role = 'practice' THEN 0 ELSE 1 END)
AND CASE WHEN w.role <> 'practice' AND EXISTS (SELECT 1 FROM assignment AS a WHERE a.volunteer = v.code)
THEN EXISTS (SELECT 1 FROM assignment AS a WHERE a.volunteer = v.code AND a.item_id = w.item_id)
WHEN v.adjudicates = 1 THEN w.disputed = 1 AND w.role <> 'practice'
WHEN w.role = 'practice' THEN 1 = 1
ELSE w.open = 1 END"""
PRACTICE = "CREATE VIEW practice AS SELECT item_id, answer, reason FROM asked WHERE role = 'practice'"
VIEWS = (STANDING_VOTE, CURRENT_VOTE, TALLY, WANTED, OPEN_ITEM, PRACTICE)

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
open_item = table("open_item", column("volunteer", Text()), column("item_id", Text()), column("round", Integer()))
tally = table(
    "tally", column("item_id", Text()), column("votes", Integer()), column("correct", Integer()), column("wrong", Integer())
)
wanted = table(
    "wanted", column("item_id", Text()), column("role", Text()), column("open", Integer()), column("disputed", Integer())
)
practice = table("practice", column("item_id", Text()), column("answer", Text()), column("reason", Text()))


def create_schema(connection: Connection) -> None:
    """All tables and views, and on SQLite triggers, in an open transaction on an empty database.

    What guards a study on a server is in `annotation.server.rules`.
    """
    metadata.create_all(connection, checkfirst=False)
    create_views(connection)
    if connection.dialect.name == "sqlite":
        for statement in SQLITE_TRIGGERS:
            connection.exec_driver_sql(statement)


def create_views(connection: Connection) -> None:
    """All views, in the order in which one reads another."""
    for statement in VIEWS:
        connection.exec_driver_sql(statement)


def drop_views(connection: Connection) -> None:
    """Those views that are there."""
    for statement in reversed(VIEWS):
        connection.exec_driver_sql(f"DROP VIEW IF EXISTS {statement.split()[2]}")
