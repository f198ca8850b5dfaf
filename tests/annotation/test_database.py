"""Study files: every way in which one can be unusable, and what backups and migrations keep."""

import contextlib
import os
import re
import shutil
import sqlite3
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from judging_world import LAMP, VASE, identity, study_of
from version1 import write_version1

from annotation import study
from annotation.storage import backup, filecheck, migrations, schema
from engine.errors import BadInput

ROOT = Path(__file__).parents[2]
FOOT = identity(LAMP, (0,), VASE, (0,))


@pytest.fixture
def path(tmp_path):
    """A closed study with one vote."""
    with study_of(tmp_path / "lamps.db") as handle:
        study.record_vote(handle, FOOT, "anna", "correct")
    return tmp_path / "lamps.db"


def refused(path, words: str, **options: float) -> None:
    """Opening raises one sentence that names the file and says these words, and leaves the file as it was."""
    before = path.read_bytes() if path.is_file() else None
    with pytest.raises(BadInput, match=words) as caught:
        study.open_study(path, **options)
    sentence = str(caught.value)
    assert str(path) in sentence
    assert "\n" not in sentence
    assert sentence.endswith(".")
    assert before is None or path.read_bytes() == before


def vote_count(path) -> int:
    with contextlib.closing(sqlite3.connect(path)) as raw:
        return raw.execute("SELECT count(*) FROM event").fetchone()[0]


def test_missing(tmp_path):
    refused(tmp_path / "nowhere.db", "No such file")
    assert list(tmp_path.iterdir()) == []


def test_a_folder(tmp_path):
    refused(tmp_path, "is a folder")


def test_empty(tmp_path):
    (tmp_path / "a.db").touch()
    refused(tmp_path / "a.db", "is empty")


def test_not_sqlite(tmp_path):
    (tmp_path / "a.db").write_bytes(b"solid lamp\n" * 100)
    refused(tmp_path / "a.db", "no SQLite file")


def test_sqlite_of_another_program(tmp_path):
    with contextlib.closing(sqlite3.connect(tmp_path / "a.db")) as raw:
        raw.execute("CREATE TABLE event (uuid)")
    refused(tmp_path / "a.db", "another program")


@pytest.mark.parametrize("share", [0.001, 0.01, 0.3, 0.5, 0.9, 0.99, 0.9999])
def test_truncated(path, share):
    content = path.read_bytes()
    path.write_bytes(content[: max(20, int(len(content) * share))])
    refused(path, "its end is missing|no SQLite file|another program")


def test_scribbled_over(path):
    content = bytearray(path.read_bytes())
    content[4096:12288] = b"\xff" * 8192
    path.write_bytes(content)
    refused(path, "damaged")


def test_a_table_missing(path):
    with contextlib.closing(sqlite3.connect(path)) as raw:
        raw.execute("DROP TABLE event")
    refused(path, "damaged")


@pytest.mark.parametrize("rule", [
    "DROP VIEW wanted; CREATE VIEW wanted AS WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n) SELECT x FROM n",
    "CREATE VIEW votes AS SELECT 1",
    "DROP TRIGGER event_never_updated",
    "CREATE TRIGGER more AFTER INSERT ON event BEGIN UPDATE volunteer SET seed = ''; END",
])  # fmt: skip
def test_rules_of_a_stranger(path, rule):
    with contextlib.closing(sqlite3.connect(path)) as raw:
        raw.executescript(rule)
    refused(path, "rules of counting that are not Concord's")


def test_newer(path):
    with contextlib.closing(sqlite3.connect(path)) as raw:
        raw.execute("PRAGMA user_version=99")
    refused(path, "newer Concord .study version 99")


def test_read_only(path):
    path.chmod(0o444)
    refused(path, "read-only")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write to any folder")
def test_a_read_only_folder(path):
    path.parent.chmod(0o555)
    try:
        refused(path, "read-only")
    finally:
        path.parent.chmod(0o755)


def test_locked_while_opening(path):
    with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as raw:
        raw.execute("PRAGMA locking_mode=EXCLUSIVE")
        raw.execute("BEGIN EXCLUSIVE")
        refused(path, "held by another program for longer than 0.1 s", busy_seconds=0.1)


def test_locked_while_voting(path):
    with (
        study.open_study(path, busy_seconds=0.1) as handle,
        contextlib.closing(sqlite3.connect(path, isolation_level=None)) as raw,
    ):
        raw.execute("BEGIN IMMEDIATE")
        with pytest.raises(BadInput, match="held by another program"):
            study.record_vote(handle, FOOT, "bert", "wrong")
        assert study.answers(handle, "anna") == {FOOT: "correct"}
        raw.execute("ROLLBACK")
        study.record_vote(handle, FOOT, "bert", "wrong")
    assert vote_count(path) == 2


def test_a_short_lock_is_waited_for(path):
    with (
        study.open_study(path) as handle,
        contextlib.closing(sqlite3.connect(path, isolation_level=None, check_same_thread=False)) as raw,
    ):
        raw.execute("BEGIN IMMEDIATE")
        release = threading.Timer(0.3, raw.execute, ["COMMIT"])
        release.start()
        began = time.monotonic()
        study.record_vote(handle, FOOT, "bert", "wrong")
        assert time.monotonic() - began > 0.2
        release.join()


@pytest.mark.parametrize("fate", ["moved", "replaced"])
def test_a_file_that_vanishes_takes_no_vote_with_it(path, fate):
    """Votes would otherwise go into a file that has no name any more."""
    with study.open_study(path) as handle:
        if fate == "replaced":
            shutil.copy(path, path.with_name("copy"))
            os.replace(path.with_name("copy"), path)
        else:
            os.rename(path, path.with_name("elsewhere"))
        with pytest.raises(BadInput, match="moved, deleted or replaced"):
            study.record_vote(handle, FOOT, "bert", "wrong")


def test_a_failed_block_leaves_nothing(path):
    def half_done(handle):
        with handle.writing() as connection:
            connection.exec_driver_sql("INSERT INTO volunteer VALUES ('carl', '', '', 0)")
            raise ZeroDivisionError

    with study.open_study(path) as handle:
        with pytest.raises(ZeroDivisionError):
            half_done(handle)
        assert [voter.code for voter in study.volunteers(handle)] == ["anna"]


def test_a_study_is_never_created_over_a_file(path):
    before = path.read_bytes()
    with pytest.raises(BadInput, match="exists already"):
        study.create_study(path, name="again")
    assert path.read_bytes() == before
    with pytest.raises(BadInput, match="cannot be written"):
        study.create_study(path.parent / "no" / "a.db", name="nowhere")
    assert sorted(p.name for p in path.parent.iterdir()) == ["lamps.db"]


def test_a_log_left_of_another_study_is_not_taken_for_ours(tmp_path):
    (tmp_path / "a.db-wal").write_bytes(b"votes")
    with pytest.raises(BadInput, match=r"a\.db-wal exists already"):
        study.create_study(tmp_path / "a.db", name="a")
    assert not (tmp_path / "a.db").exists()


def test_settings_of_every_connection(path):
    with study.open_study(path) as handle, handle.reading() as connection:
        found = {
            name: connection.exec_driver_sql(f"PRAGMA {name}").scalar()
            for name in ("journal_mode", "synchronous", "foreign_keys", "trusted_schema", "busy_timeout")
        }
        strict = connection.exec_driver_sql("SELECT min(strict) FROM pragma_table_list WHERE type='table' "
                                            "AND name NOT LIKE 'sqlite%'").scalar()  # fmt: skip
    expected = {"journal_mode": "wal", "synchronous": 2, "foreign_keys": 1, "trusted_schema": 0, "busy_timeout": 30000}
    assert found == expected
    assert strict == 1


def test_opening_keeps_a_whole_backup(path):
    study.open_study(path).close()
    (copy,) = backup.backups(path)
    assert vote_count(copy) == 1
    shutil.copy(copy, path.with_name("restored.db"))
    with study.open_study(path.with_name("restored.db")) as handle:
        assert study.answers(handle, "anna") == {FOOT: "correct"}


def test_backups_rotate_and_rest(path, monkeypatch):
    study.open_study(path).close()
    study.open_study(path).close()
    assert len(backup.backups(path)) == 1
    monkeypatch.setattr(backup, "EVERY_SECONDS", 0.0)
    for _ in range(backup.KEPT + 2):
        with study.open_study(path) as handle:
            study.record_vote(handle, FOOT, "anna", "wrong")
    kept = backup.backups(path)
    assert len(kept) == backup.KEPT
    assert vote_count(kept[-1]) == 1 + backup.KEPT + 2


def test_a_study_that_stays_open_is_backed_up_every_hour(path, monkeypatch):
    passed = [0]
    monkeypatch.setattr(time, "monotonic", lambda: 60.0 * passed[0])
    monkeypatch.setattr(time, "time", lambda real=time.time: real() + 60 * passed[0])
    with study.open_study(path) as handle, study.open_study(path, backup=False) as packet:
        for minutes, held in ((1, 1), (59, 1), (61, 2), (100, 2), (122, 3)):
            passed[0] = minutes
            study.record_vote(handle, FOOT, "anna", "wrong")
            study.record_vote(packet, FOOT, "bert", "wrong")
            assert len(backup.backups(path)) == held
    assert [vote_count(copy) for copy in backup.backups(path)] == [1, 1 + 2 + 2 + 1, 1 + 4 + 4 + 1]


def test_a_backup_that_cannot_be_made_does_not_stop_the_work(path):
    path.with_name("backups").write_text("in the way")
    with study.open_study(path) as handle:
        study.record_vote(handle, FOOT, "bert", "wrong")
    assert vote_count(path) == 2


def test_what_a_killed_process_left_of_a_copy_goes_in_time(path):
    for age, name in ((7200, ".staged.old"), (60, ".staged.new")):
        (path.with_name("backups") / name).mkdir(parents=True)
        (path.with_name("backups") / name / "copy").write_text("half")
        os.utime(path.with_name("backups") / name, (time.time() - age,) * 2)
    study.open_study(path).close()
    names = {found.name for found in path.with_name("backups").iterdir()}
    assert names == {".staged.new", backup.backups(path)[0].name}


def newer_schema(monkeypatch, *statements: str) -> None:
    """A next version, whose step is these statements."""

    def step(operations):
        for statement in statements:
            operations.execute(statement)

    monkeypatch.setattr(migrations, "STEPS", {**migrations.STEPS, schema.SCHEMA_VERSION: step})
    monkeypatch.setattr(schema, "SCHEMA_VERSION", schema.SCHEMA_VERSION + 1)


def test_an_older_file_is_backed_up_and_migrated_once(path, monkeypatch):
    was = schema.SCHEMA_VERSION
    newer_schema(monkeypatch, "ALTER TABLE item ADD COLUMN gold TEXT")
    for _ in range(2):
        with study.open_study(path) as handle:
            assert study.answers(handle, "anna") == {FOOT: "correct"}
            with handle.reading() as connection:
                assert connection.exec_driver_sql("SELECT count(gold) FROM item").scalar() == 0
    (old,) = path.with_name("backups").glob(f"lamps.db.version-{was}.*")
    with contextlib.closing(sqlite3.connect(old)) as raw:
        assert raw.execute("PRAGMA user_version").fetchone() == (was,)
    assert vote_count(old) == 1


def test_a_migration_that_fails_changes_nothing(path, monkeypatch):
    before = inside(path)
    newer_schema(monkeypatch, "ALTER TABLE item ADD COLUMN gold TEXT", "nonsense")
    with pytest.raises(BadInput):
        study.open_study(path)
    assert inside(path) == before
    monkeypatch.undo()
    with study.open_study(path) as handle:
        assert study.answers(handle, "anna") == {FOOT: "correct"}


def inside(path) -> tuple[int, set[tuple[str, ...]]]:
    """The version of a file, and all that its schema says, but for spaces."""
    with contextlib.closing(sqlite3.connect(path)) as raw:
        found = raw.execute("SELECT type, name, tbl_name, sql FROM sqlite_master").fetchall()
        told = {(kind, name, of, re.sub(r"\s+|(?<=[(,])|(?=[(),])", "", sql or "")) for kind, name, of, sql in found}
        return raw.execute("PRAGMA user_version").fetchone()[0], told


def test_a_file_of_version_1_becomes_one_like_any_other(path, tmp_path):
    said = write_version1(tmp_path / "old.db")
    with study.open_study(tmp_path / "old.db") as handle:
        assert study.answers(handle, "anna") == dict(said.values())
        assert [one.item_id for one in study.open_items(handle, "anna")] == ["item-2"]
        assert (study.about(handle).votes, study.about(handle).adaptive, study.about(handle).unsure) == (0, True, True)
        study.record_vote(handle, "item-2", "bert", "unsure")
    assert inside(tmp_path / "old.db") == inside(path)
    assert vote_count(tmp_path / "old.db") == len(said) + 1


def test_alembic_is_loaded_where_it_is_needed(path):
    code = "import sys; from annotation import study; study.open_study(sys.argv[1]).close(); print('alembic' in sys.modules)"
    said = subprocess.run([sys.executable, "-c", code, str(path)], cwd=ROOT, capture_output=True, text=True, check=True)
    assert said.stdout == "False\n"


def test_sentences_for_what_sqlite_says():
    said = {
        "database or disk is full": "disk is full",
        "attempt to write a readonly database": "cannot be written",
        "database disk image is malformed": "damaged",
        "unable to open database file": "cannot be opened",
        "disk I/O error": "disk reports an error",
        "something new": "something new",
    }
    for words, expected in said.items():
        assert expected in filecheck.explained(Path("a.db"), sqlite3.OperationalError(words), 30)


def test_a_full_disk_refuses_the_vote_and_keeps_the_others(path):
    with study.open_study(path) as handle:
        with handle.reading() as connection:
            pages = connection.exec_driver_sql("PRAGMA page_count").scalar()
            connection.exec_driver_sql(f"PRAGMA max_page_count={pages}")
        with pytest.raises(BadInput, match="disk is full"):
            study.record_vote(handle, FOOT, "bert", "wrong", comment="x" * 100_000)
        assert study.majority(handle)[FOOT] == (1, 0, 0, "correct")
    assert vote_count(path) == 1


def test_threads_share_a_handle(path):
    with study.open_study(path) as handle:
        voters = [threading.Thread(target=vote_often, args=(handle, f"t{n}")) for n in range(6)]
        for voter in voters:
            voter.start()
        for voter in voters:
            voter.join()
        assert study.majority(handle)[FOOT] == (7, 0, 0, "correct")
    assert vote_count(path) == 1 + 6 * 20


def vote_often(handle, code):
    for _ in range(20):
        study.record_vote(handle, FOOT, code, "correct")


def test_two_who_create_the_same_study_at_once(tmp_path):
    made, refusals = [], []

    def create():
        try:
            study.create_study(tmp_path / "a.db", name="a").close()
            made.append(1)
        except BadInput as error:
            refusals.append(str(error))

    rivals = [threading.Thread(target=create) for _ in range(4)]
    for rival in rivals:
        rival.start()
    for rival in rivals:
        rival.join()
    assert (len(made), len(refusals)) == (1, 3)
    assert all("exists already" in sentence for sentence in refusals)
    study.open_study(tmp_path / "a.db").close()
