"""One SQLite file a study: opening it safely, committing safely, and saying in one sentence what is wrong.

Writers take the write lock at BEGIN (a deferred transaction that turns into a writer fails at once when another one
writes), every commit reaches the disk before it returns, and readers never wait for writers (WAL).
"""

import contextlib
import json
import os
import random
import sqlite3
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Self
from urllib.parse import quote_from_bytes

from sqlalchemy import Connection, Engine, QueuePool, create_engine, event, select
from sqlalchemy.exc import DatabaseError, IntegrityError, OperationalError, ProgrammingError

from engine.errors import BadInput

from . import backup as backups
from . import places, schema
from .filecheck import check_inside, check_outside, explained, inode, may_write, sealed
from .migrations import migrate

BUSY_SECONDS = 30.0


class StudyFile:
    """An open study file (see `annotation.storage.handle.StudyHandle`); without `writable` its content stays as it is.

    In a packet its `volunteer` alone may vote, in a whole study anybody.
    """

    def __init__(
        self,
        path: Path,
        busy_seconds: float = BUSY_SECONDS,
        *,
        writable: bool = True,
        backup: bool = False,
        options: str = "mode=rw",
        copy: "tuple[Path, tempfile.TemporaryDirectory[str]] | None" = None,
    ) -> None:
        self.path = path
        self.busy_seconds = busy_seconds
        self.writable = writable
        self._backup_due = time.monotonic() + backups.EVERY_SECONDS if backup else None
        self._inode = inode(path)
        self._copy = copy
        self._engine = connectable(copy[0] if copy else path, busy_seconds, options)
        self.volunteer = self._packet_of()

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
        if not self.writable:
            raise BadInput(f"{self.path} is open for reading only; open it for writing where it can be written.")
        if inode(self.path) != self._inode:
            raise BadInput(f"{self.path} was moved, deleted or replaced while open; put it back and open it again.")
        with self._told(), self._engine.begin() as connection:
            yield connection
        self._back_up_in_time()

    def _back_up_in_time(self) -> None:
        """Keep a copy an hour of a study that stays open, too; what was written is safe without it."""
        if self._backup_due is None or time.monotonic() < self._backup_due:
            return
        self._backup_due = time.monotonic() + backups.EVERY_SECONDS
        with contextlib.suppress(OSError, sqlite3.Error), _raw(self.path, self.busy_seconds) as raw:
            backups.keep_backup(raw, self.path)

    @contextlib.contextmanager
    def rewriting(self) -> Iterator[Connection]:
        """As `writing()`, but votes may be changed and removed: for volunteers who asked to be deleted, and no others."""
        with self.writing() as connection:
            for trigger in schema.SQLITE_TRIGGERS:
                connection.exec_driver_sql(f"DROP TRIGGER {trigger.split()[2]}")
            yield connection
            for trigger in schema.SQLITE_TRIGGERS:
                connection.exec_driver_sql(trigger)

    def purge(self) -> None:
        """Write the whole file anew and empty its log, so that nothing of what was removed can be read from them."""
        with self._told(), _raw(self.path, self.busy_seconds) as raw:
            raw.execute("VACUUM")
            if raw.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone()[0]:
                raise BadInput(f"{self.path} is being read by another program, so what was removed is still in its log; "
                               "close it there and do this again.")  # fmt: skip

    def close(self) -> None:
        self._engine.dispose()
        if self._copy is not None:
            self._copy[1].cleanup()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _packet_of(self) -> str | None:
        """The volunteer that the file is a packet of."""
        with self.reading() as connection:
            rows = connection.execute(select(schema.study).limit(2)).all()
        if len(rows) != 1:
            raise BadInput(f"{self.path} is damaged (it holds no study, or several); use the newest copy in the folder 'backups' "
                           "beside it.")  # fmt: skip
        try:
            found = json.loads(rows[0].settings).get("packet")
        except (ValueError, AttributeError):
            raise BadInput(f"{self.path} is damaged (its settings cannot be read); use the newest copy in the folder "
                           "'backups' beside it.") from None  # fmt: skip
        return None if found is None else str(found)

    @contextlib.contextmanager
    def _told(self) -> Iterator[None]:
        try:
            yield
        except (IntegrityError, ProgrammingError):
            raise  # a fault of ours, not of the file
        except (DatabaseError, sqlite3.DatabaseError) as error:
            raise BadInput(explained(self.path, error, self.busy_seconds)) from error


def create_file(path: Path, fill: Callable[[Connection], None]) -> None:
    """Make a new study file, or a project folder with one, whole or not at all; nothing that exists is replaced."""
    path = places.study_file(path)
    try:
        with places.whole(path) as staged:
            engine = connectable(staged, BUSY_SECONDS, "mode=rwc")
            with engine.connect() as connection:
                connection.exec_driver_sql("PRAGMA journal_mode=WAL")
            with engine.begin() as connection:
                connection.exec_driver_sql(f"PRAGMA application_id={schema.APPLICATION_ID}")
                connection.exec_driver_sql(f"PRAGMA user_version={schema.SCHEMA_VERSION}")
                schema.create_schema(connection)
                fill(connection)
            engine.dispose()
    except DatabaseError as error:
        raise BadInput(explained(path, error, BUSY_SECONDS)) from error


def open_file(
    path: Path, *, busy_seconds: float = BUSY_SECONDS, backup: bool = True, writable: bool = True
) -> StudyFile:
    """Check a study file from the outside in, keep a backup, migrate it if it is old, and open it.

    Without `writable` nothing of it is changed, and it may lie where nothing can be written.
    """
    path = places.study_file(path)
    check_outside(path, writable=writable)
    try:
        if not writable:
            return _open_for_reading(path, busy_seconds)
        with _raw(path, busy_seconds) as raw:
            version = check_inside(path, raw)
            if version < schema.SCHEMA_VERSION:
                _back_up_first(raw, path, version)
            elif backup:
                backups.keep_backup(raw, path)
            raw.execute("PRAGMA journal_mode=WAL")  # a backup put in place of the study is not in this mode
        if version < schema.SCHEMA_VERSION:
            _migrate(path, busy_seconds)
    except (sqlite3.DatabaseError, DatabaseError) as error:
        raise BadInput(explained(path, error, busy_seconds)) from error
    except OSError as error:
        raise BadInput(f"{path} cannot be opened ({error.strerror}); make room for a copy, or check its disk.") from None
    return StudyFile(path, busy_seconds, backup=backup)


def _back_up_first(raw: sqlite3.Connection, path: Path, version: int) -> None:
    try:
        backups.back_up(raw, path, f"version-{version}")
    except OSError as error:
        raise BadInput(f"{path} is of an older version and cannot be backed up ({error.strerror}); make room.") from None


def _open_for_reading(path: Path, busy_seconds: float) -> StudyFile:
    """Open the file where it lies if SQLite can read it there, or else a copy of it.

    A file in WAL mode can only be read where its log may be written, or where nobody writes at all (`immutable`). One
    whose log was left on a read-only disk, or which is of an older version, is read from a copy of both.
    """
    logged, shared = (Path(f"{path}{part}").exists() for part in ("-wal", "-shm"))
    if sealed(path) and logged and not shared:
        return _open_copy(path, busy_seconds)
    options = "mode=rw" if may_write(path) else "immutable=1" if sealed(path) and not logged else "mode=ro"
    try:
        with _raw(path, busy_seconds, options) as raw:
            if check_inside(path, raw) < schema.SCHEMA_VERSION:
                return _open_copy(path, busy_seconds, raw)
        return StudyFile(path, busy_seconds, writable=False, options=options)
    except sqlite3.OperationalError as error:
        if not any(words in str(error) for words in ("unable to open", "readonly", "disk I/O", "full")):
            raise
    return _open_copy(path, busy_seconds)


def _open_copy(path: Path, busy_seconds: float, opened: sqlite3.Connection | None = None) -> StudyFile:
    """Read a copy, made by SQLite where it could open the file, or else of the file and its log as they lie there."""
    folder = tempfile.TemporaryDirectory(prefix="concord-")
    try:
        copy = Path(folder.name) / path.name
        if opened is None:
            places.copy_with_log(path, copy)
        else:
            with _raw(copy, busy_seconds, "mode=rwc") as raw:
                opened.backup(raw)
        with _raw(copy, busy_seconds) as raw:
            check_inside(path, raw)
        _migrate(copy, busy_seconds)
        return StudyFile(path, busy_seconds, writable=False, copy=(copy, folder))
    except BaseException:
        folder.cleanup()
        raise


def _migrate(path: Path, busy_seconds: float) -> None:
    """Lead an older file to this version in one transaction (another process may have done it meanwhile)."""
    engine = connectable(path, busy_seconds)
    try:
        with engine.begin() as connection:
            version = connection.exec_driver_sql("PRAGMA user_version").scalar_one()
            if version < schema.SCHEMA_VERSION:
                migrate(connection, version)
                connection.exec_driver_sql(f"PRAGMA user_version={schema.SCHEMA_VERSION}")
    finally:
        engine.dispose()


@contextlib.contextmanager
def _raw(path: Path, busy_seconds: float, options: str = "mode=rw") -> Iterator[sqlite3.Connection]:
    uri = _uri(path, options)
    with contextlib.closing(sqlite3.connect(uri, uri=True, timeout=busy_seconds, isolation_level=None)) as raw:
        yield raw


def _uri(path: Path, options: str) -> str:
    """How SQLite names a file with options (`Path.as_uri` names those on shares of Windows in another way)."""
    quoted = quote_from_bytes(os.fsencode(path.as_posix()))
    return f"file://{quoted if quoted.startswith('/') else '/' + quoted}?{options}"


def connectable(path: Path, busy_seconds: float, options: str = "mode=rw") -> Engine:
    """An SQLAlchemy engine whose connections are set up for safety and whose transactions lock at BEGIN."""
    uri = _uri(path, options)

    def connect() -> sqlite3.Connection:
        raw = sqlite3.connect(uri, uri=True, timeout=busy_seconds, isolation_level=None, check_same_thread=False)
        for pragma in ("foreign_keys=ON", "synchronous=FULL", "trusted_schema=OFF", "recursive_triggers=ON",
                       "secure_delete=ON"):  # fmt: skip
            raw.execute(f"PRAGMA {pragma}")
        return raw

    # Any number of threads may hold a connection; five stay open.
    made = create_engine("sqlite://", creator=connect, poolclass=QueuePool, pool_size=5, max_overflow=-1)

    @event.listens_for(made, "begin")
    def begin(connection: Connection) -> None:
        if connection.get_execution_options().get("begin") == "BEGIN":
            connection.exec_driver_sql("BEGIN")
        else:
            _take_turn(connection, busy_seconds)

    return made


def _take_turn(connection: Connection, busy_seconds: float) -> None:
    """Take the write lock, asking for it again every few milliseconds.

    SQLite's own waiting asks ever more seldom, so that who waits longest waits longer still.
    """
    end = time.monotonic() + busy_seconds
    connection.exec_driver_sql("PRAGMA busy_timeout=0")
    try:
        while True:
            try:
                connection.exec_driver_sql("BEGIN IMMEDIATE")
                return
            except OperationalError as error:
                if "locked" not in str(error.orig) or time.monotonic() > end:
                    raise
            time.sleep(random.uniform(0.001, 0.008))
    finally:
        connection.exec_driver_sql(f"PRAGMA busy_timeout={round(1000 * busy_seconds)}")
