"""One SQLite file a study: opening it safely, committing safely, and saying in one sentence what is wrong.

Writers take the write lock at BEGIN (a deferred transaction that turns into a writer fails at once when another one
writes), every commit reaches the disk before it returns, and readers never wait for writers (WAL).
"""

import contextlib
import os
import sqlite3
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Self

from sqlalchemy import URL, Connection, Engine, create_engine, event
from sqlalchemy.exc import DatabaseError, IntegrityError, ProgrammingError

from engine.errors import BadInput

from . import schema
from .backup import back_up, keep_backup

BUSY_SECONDS = 30.0


class StudyFile:
    """An open study file (see `annotation.handle.StudyHandle`)."""

    volunteer: str | None = None  # anybody may vote

    def __init__(self, path: Path, busy_seconds: float = BUSY_SECONDS) -> None:
        self.path = path
        self.busy_seconds = busy_seconds
        self._inode = _inode(path)
        self._engine = _connectable(path, busy_seconds)

    @property
    def where(self) -> str:
        """The path, for sentences."""
        return str(self.path)

    @property
    def folder(self) -> Path | None:
        """Where its shapes may lie."""
        return self.path.parent

    @contextlib.contextmanager
    def reading(self) -> Iterator[Connection]:
        """A consistent snapshot of the file."""
        with self._told(), self._engine.connect().execution_options(begin="BEGIN") as connection, connection.begin():
            yield connection

    @contextlib.contextmanager
    def writing(self) -> Iterator[Connection]:
        """One transaction, on the disk when the block ends without an error, and undone whole otherwise."""
        if _inode(self.path) != self._inode:
            raise BadInput(f"{self.path} was moved, deleted or replaced while open; put it back and open it again.")
        with self._told(), self._engine.begin() as connection:
            yield connection

    def close(self) -> None:
        self._engine.dispose()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @contextlib.contextmanager
    def _told(self) -> Iterator[None]:
        try:
            yield
        except (IntegrityError, ProgrammingError):
            raise  # a fault of ours, not of the file
        except (DatabaseError, sqlite3.DatabaseError) as error:
            raise BadInput(explained(self.path, error, self.busy_seconds)) from error


def explained(path: Path, error: Exception, busy_seconds: float) -> str:
    """One sentence for a person, for what SQLite says of a file."""
    said = str(getattr(error, "orig", None) or error)
    for words, sentence in (
        ("locked", f"is held by another program for longer than {busy_seconds:g} s; close it there and try again."),
        ("readonly", "cannot be written; make it and its folder writable, or copy it to another folder."),
        ("not a database", "is not a study file (it is no SQLite file); choose another."),
        ("full", "cannot take the vote because the disk is full; make room and try again."),
        ("unable to open", "cannot be opened; check that it and its folder can be read and written."),
        ("malformed", "is damaged; use the newest copy in the folder 'backups' beside it."),
        ("disk I/O", "cannot be read or written (the disk reports an error); copy it to another disk."),
    ):
        if words in said:
            return f"{path} {sentence}"
    return f"{path} cannot be used as a study ({said}); use the newest copy in the folder 'backups' beside it."


def create_file(path: Path, fill: Callable[[Connection], None]) -> None:
    """Make a new study file, staged beside and given its name when whole; an existing file is never replaced."""
    for taken in (path, Path(f"{path}-wal")):
        if os.path.lexists(taken):
            raise BadInput(f"{taken} exists already; open that study, or choose another name.")
    try:
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{path.name}.") as folder:
            staged = Path(folder) / path.name
            engine = _connectable(staged, BUSY_SECONDS)
            with engine.connect() as connection:
                connection.exec_driver_sql("PRAGMA journal_mode=WAL")
            with engine.begin() as connection:
                connection.exec_driver_sql(f"PRAGMA application_id={schema.APPLICATION_ID}")
                connection.exec_driver_sql(f"PRAGMA user_version={schema.SCHEMA_VERSION}")
                schema.create_schema(connection)
                fill(connection)
            engine.dispose()
            _give_name(staged, path)
    except OSError as error:
        raise BadInput(f"{path} cannot be written ({error.strerror}); choose another folder or make room.") from None
    except DatabaseError as error:
        raise BadInput(explained(path, error, BUSY_SECONDS)) from error


def open_file(path: Path, *, busy_seconds: float = BUSY_SECONDS, backup: bool = True) -> StudyFile:
    """Check a study file from the outside in, keep a backup, migrate it if it is old, and open it."""
    check_outside(path)
    try:
        with contextlib.closing(sqlite3.connect(path, timeout=busy_seconds, isolation_level=None)) as raw:
            version = _check_inside(path, raw)
            if version < schema.SCHEMA_VERSION:
                back_up(raw, path, f"version-{version}")
                _migrate(raw)
            elif backup:
                keep_backup(raw, path)
            raw.execute("PRAGMA journal_mode=WAL")  # a backup put in place of the study is not in this mode
    except sqlite3.DatabaseError as error:
        raise BadInput(explained(path, error, busy_seconds)) from error
    except OSError as error:
        raise BadInput(
            f"{path} is of an older version and cannot be backed up ({error.strerror}); make room."
        ) from None
    return StudyFile(path, busy_seconds)


def check_outside(path: Path) -> None:
    """What can be told without SQLite: missing, a folder, empty, foreign, write-protected (even from root)."""
    try:
        mode, size = path.stat().st_mode, path.stat().st_size
    except OSError as error:
        raise BadInput(f"{path} cannot be opened ({error.strerror}); check the name, or create the study.") from None
    if path.is_dir():
        raise BadInput(f"{path} is a folder; give the study file in it.")
    if size == 0:
        raise BadInput(f"{path} is empty and no study; use a backup, or delete it and create the study again.")
    if not mode & 0o222 or not os.access(path, os.R_OK | os.W_OK) or not os.access(path.parent, os.W_OK):
        raise BadInput(f"{path} is read-only; make it and its folder writable, or copy it to another folder.")
    with open(path, "rb") as handle:
        if handle.read(16) != b"SQLite format 3\0":
            raise BadInput(f"{path} is not a study file (it is no SQLite file); choose another.")
    # Only a file at rest can be measured: while a log lies beside it, its end may still be in there.
    if _cut_short(path) and not os.path.exists(f"{path}-wal") and _cut_short(path):
        raise BadInput(
            f"{path} is damaged (its end is missing); use the newest copy in the folder 'backups' beside it."
        )


def _cut_short(path: Path) -> bool:
    """Whether the file is shorter than its header says (SQLite file format, section 1.3)."""
    with open(path, "rb") as handle:
        header = handle.read(100)
    page = int.from_bytes(header[16:18], "big")
    return path.stat().st_size < int.from_bytes(header[28:32], "big") * (65536 if page == 1 else page)


def _check_inside(path: Path, raw: sqlite3.Connection) -> int:
    """The schema version of a whole study file; raises `BadInput` for foreign, newer, damaged ones."""
    if raw.execute("PRAGMA application_id").fetchone()[0] != schema.APPLICATION_ID:
        raise BadInput(f"{path} is an SQLite file of another program, not a study; choose another.")
    version: int = raw.execute("PRAGMA user_version").fetchone()[0]
    if version > schema.SCHEMA_VERSION:
        raise BadInput(
            f"{path} was written by a newer Concord (study version {version}, this one reads up to "
            f"{schema.SCHEMA_VERSION}); update Concord."
        )
    raw.execute("PRAGMA trusted_schema=OFF")
    found = raw.execute("PRAGMA integrity_check(1)").fetchone()[0]
    tables = {name for (name,) in raw.execute("SELECT name FROM sqlite_master")}
    if found != "ok" or version < 1 or not {"study", "item", "event"} <= tables:
        raise BadInput(f"{path} is damaged; use the newest copy in the folder 'backups' beside it.")
    return version


def _migrate(raw: sqlite3.Connection) -> None:
    """Lead an older file to this version in one transaction (another process may have done it meanwhile)."""
    raw.execute("BEGIN IMMEDIATE")
    try:
        for version in range(raw.execute("PRAGMA user_version").fetchone()[0], schema.SCHEMA_VERSION):
            for statement in schema.MIGRATIONS[version]:
                raw.execute(statement)
        raw.execute(f"PRAGMA user_version={schema.SCHEMA_VERSION}")
        raw.execute("COMMIT")
    except BaseException:
        raw.execute("ROLLBACK")
        raise


def _connectable(path: Path, busy_seconds: float) -> Engine:
    """An SQLAlchemy engine whose connections are set up for safety and whose transactions lock at BEGIN."""
    made = create_engine(URL.create("sqlite", database=str(path)), connect_args={"timeout": busy_seconds})

    @event.listens_for(made, "connect")
    def prepare(raw: Any, _record: Any) -> None:
        raw.isolation_level = None  # Concord says BEGIN itself
        for pragma in ("foreign_keys=ON", "synchronous=FULL", "trusted_schema=OFF", "recursive_triggers=ON"):
            raw.execute(f"PRAGMA {pragma}")

    @event.listens_for(made, "begin")
    def begin(connection: Connection) -> None:
        connection.exec_driver_sql(connection.get_execution_options().get("begin", "BEGIN IMMEDIATE"))

    return made


def _give_name(staged: Path, path: Path) -> None:
    """Name a staged file without ever replacing one (a second process may create the same study)."""
    try:
        os.link(staged, path)
    except FileExistsError:
        raise BadInput(f"{path} exists already; open that study, or choose another name.") from None
    except OSError:  # a file system without hard links
        os.rename(staged, path)


def _inode(path: Path) -> tuple[int, int] | None:
    with contextlib.suppress(OSError):
        found = path.stat()
        return found.st_dev, found.st_ino
    return None
