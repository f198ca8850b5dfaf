"""A study file as version 1 wrote it: its tables word for word, and some votes."""

import contextlib
import sqlite3
from pathlib import Path

TABLES = """
CREATE TABLE study ( id TEXT NOT NULL, name TEXT NOT NULL, question TEXT NOT NULL, guideline TEXT NOT NULL, seed
TEXT NOT NULL, settings TEXT NOT NULL, app_version TEXT NOT NULL, created_at TEXT NOT NULL, PRIMARY KEY (id) )
STRICT;
CREATE TABLE item ( id TEXT NOT NULL, kind TEXT NOT NULL CHECK (kind IN ('shape', 'puzzle')), payload TEXT NOT NULL,
created_at TEXT NOT NULL, PRIMARY KEY (id) ) STRICT;
CREATE TABLE run ( id TEXT NOT NULL, kind TEXT NOT NULL, method TEXT NOT NULL, preset TEXT NOT NULL, parameters TEXT
NOT NULL, set_name TEXT NOT NULL, pair TEXT NOT NULL, source TEXT NOT NULL, target TEXT NOT NULL, seconds TEXT NOT
NULL, app_version TEXT NOT NULL, added_at TEXT NOT NULL, PRIMARY KEY (id) ) STRICT;
CREATE TABLE volunteer ( code TEXT NOT NULL, seed TEXT NOT NULL, created_at TEXT NOT NULL, PRIMARY KEY (code) )
STRICT;
CREATE TABLE run_match ( run_id TEXT NOT NULL, item_id TEXT NOT NULL, rank INTEGER NOT NULL, score REAL NOT NULL,
votes INTEGER NOT NULL, source_layer INTEGER, target_layer INTEGER, PRIMARY KEY (run_id, item_id), FOREIGN
KEY(run_id) REFERENCES run (id), FOREIGN KEY(item_id) REFERENCES item (id) ) STRICT;
CREATE TABLE event ( uuid TEXT NOT NULL, kind TEXT NOT NULL CHECK (kind IN ('vote', 'retraction')), item_id TEXT NOT
NULL, volunteer TEXT NOT NULL, round INTEGER NOT NULL, answer TEXT CHECK (answer IN ('correct', 'wrong', 'unsure')),
comment TEXT NOT NULL, supersedes TEXT, clock INTEGER NOT NULL, shown_ms INTEGER, active_ms INTEGER, presentation
TEXT NOT NULL, app_version TEXT NOT NULL, created_at TEXT NOT NULL, PRIMARY KEY (uuid), CHECK ((kind = 'vote') =
(answer IS NOT NULL)), CHECK (kind = 'vote' OR supersedes IS NOT NULL), FOREIGN KEY(item_id) REFERENCES item (id),
FOREIGN KEY(volunteer) REFERENCES volunteer (code), FOREIGN KEY(supersedes) REFERENCES event (uuid) ) STRICT;
CREATE INDEX event_of_item ON event (item_id, volunteer, round);
CREATE INDEX event_supersedes ON event (supersedes);
CREATE INDEX event_of_volunteer ON event (volunteer, clock);
CREATE VIEW standing_vote AS SELECT * FROM event AS v WHERE v.kind = 'vote' AND NOT EXISTS (SELECT 1 FROM event AS r
WHERE r.kind = 'retraction' AND r.supersedes = v.uuid);
CREATE VIEW current_vote AS SELECT * FROM (SELECT s.*, row_number() OVER (PARTITION BY s.item_id, s.volunteer,
s.round ORDER BY s.clock DESC, s.created_at DESC, s.uuid DESC) AS age FROM standing_vote AS s) AS ordered WHERE age
= 1;
CREATE TRIGGER event_never_updated BEFORE UPDATE ON event BEGIN SELECT RAISE(ABORT, 'votes are only ever added:
nothing may change or remove one'); END;
CREATE TRIGGER event_never_deleted BEFORE DELETE ON event BEGIN SELECT RAISE(ABORT, 'votes are only ever added:
nothing may change or remove one'); END;
CREATE TRIGGER event_never_replaced BEFORE INSERT ON event WHEN EXISTS (SELECT 1 FROM event WHERE uuid = NEW.uuid)
BEGIN SELECT RAISE(ABORT, 'votes are only ever added: nothing may change or remove one'); END;
"""


def write_version1(path: Path, items: int = 3, votes: int = 2) -> dict[str, tuple[str, str]]:
    """Make such a file with answers of the volunteer "anna"; what she answered, as uuid -> (item, answer)."""
    said = {f"vote-{n}": (f"item-{n % items}", ("correct", "wrong", "unsure")[n % 3]) for n in range(votes)}
    with contextlib.closing(sqlite3.connect(path)) as raw:
        raw.executescript(f"PRAGMA application_id={0x436E6364}; PRAGMA user_version=1; PRAGMA journal_mode=WAL; {TABLES}")
        raw.execute("INSERT INTO study VALUES ('s', 'Lamps', 'Same?', '', 'seed', '{}', '0.1.0', '2026-01-01')")
        raw.execute("INSERT INTO volunteer VALUES ('anna', 'seed', '2026-01-01')")
        raw.executemany("INSERT INTO item VALUES (?, 'puzzle', '{}', '2026-01-01')", [(f"item-{n}",) for n in range(items)])
        raw.executemany(
            "INSERT INTO event VALUES (?, 'vote', ?, 'anna', 1, ?, '', NULL, ?, NULL, NULL, '{}', '0.1.0', '2026-01-01')",
            [(uuid, *answer, clock) for clock, (uuid, answer) in enumerate(said.items(), 1)],
        )
        raw.commit()
    return said
