"""A study on a PostgreSQL server: one study a database, in its schema `concord`, for people who vote at the same time.

A researcher's transaction that writes has the study to itself, as on a file; a volunteer's has the volunteer to itself
and runs beside those of others. So the clock numbers of one volunteer's events never collide, whatever windows are open.
"""

import contextlib
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Self

from sqlalchemy import URL, Connection, Engine, create_engine, event, make_url, text
from sqlalchemy.exc import ArgumentError, DBAPIError, IntegrityError, ProgrammingError
from sqlalchemy.exc import TimeoutError as PoolTimeout

from engine.errors import BadInput

from ..storage import schema
from . import rules as serverrules
from .errors import LOCK_SECONDS, explained
from .groups import grant_again

CONNECT_SECONDS = 10
_STUDY_LOCK = 0x436E6364  # key of the advisory lock of the study; that of a volunteer is 1 and the number of the login
_NETWORK = {
    "connect_timeout": CONNECT_SECONDS, "application_name": "concord", "prepare_threshold": None,
    "keepalives_idle": 30, "keepalives_interval": 10, "keepalives_count": 3, "tcp_user_timeout": 30_000,
}  # fmt: skip


class StudyServer:
    """An open study on a server (see `annotation.storage.handle.StudyHandle`)."""

    folder: Path | None = None

    def __init__(self, url: URL, volunteer: str | None) -> None:
        self.where = named(url)
        self.url = url
        self.volunteer = volunteer
        path = serverrules.RESEARCHER_PATH if volunteer is None else serverrules.VOLUNTEER_PATH
        self._engine = _connectable(url, path)

    @contextlib.contextmanager
    def reading(self) -> Iterator[Connection]:
        """A consistent snapshot of the study."""
        options = {"isolation_level": "REPEATABLE READ", "postgresql_readonly": True}
        with _told(self.where, self.volunteer), self._engine.connect() as connection:
            connection.execution_options(**options)
            with connection.begin():
                yield connection

    @contextlib.contextmanager
    def writing(self) -> Iterator[Connection]:
        """One transaction, on the server's disk when the block ends without an error, and undone whole otherwise."""
        with _told(self.where, self.volunteer), self._engine.begin() as connection:
            _wait_for_turn(connection, self.volunteer)
            yield connection

    @contextlib.contextmanager
    def rewriting(self) -> Iterator[Connection]:
        """As `writing`, but events may be changed and removed; only for the owner, and only to forget somebody."""
        with self.writing() as connection:
            connection.exec_driver_sql(f"ALTER TABLE concord.event DISABLE TRIGGER {serverrules.NEVER_CHANGED}")
            yield connection
            connection.exec_driver_sql(f"ALTER TABLE concord.event ENABLE ALWAYS TRIGGER {serverrules.NEVER_CHANGED}")

    def purge(self) -> None:
        """Write the tables anew, so that the server's files hold nothing of what was removed (its backups may)."""
        with _told(self.where, self.volunteer), self._engine.connect() as connection:
            connection.execution_options(isolation_level="AUTOCOMMIT")
            connection.exec_driver_sql(f"VACUUM FULL {', '.join(f'concord.{name}' for name in schema.metadata.tables)}")

    def close(self) -> None:
        self._engine.dispose()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def is_url(address: object) -> bool:
    """Whether this is the address of a server rather than a path."""
    return re.match(r"postgres(ql)?(\+psycopg)?:", str(address)) is not None


def server_url(address: str) -> URL:
    """The parsed address; raises `BadInput`, which does not repeat it, for it may hold a password."""
    try:
        url = make_url(address)
    except (ArgumentError, ValueError):
        url = None
    if url is None or not url.database:
        raise BadInput("That is no address of a study on a server; write postgresql://USER@HOST:PORT/DATABASE.")
    return url.set(drivername="postgresql+psycopg")


def named(url: URL) -> str:
    """The address without user, password and options, for sentences."""
    return URL.create("postgresql", host=url.host, port=url.port, database=url.database).render_as_string()


def create_server(address: str, fill: Callable[[Connection], None]) -> None:
    """Make a study in a database that has none, in one transaction."""
    url = server_url(address)
    engine = _connectable(url, serverrules.RESEARCHER_PATH)
    try:
        with _told(named(url), opened=False), engine.begin() as connection:
            connection.execute(text("SELECT pg_advisory_xact_lock(:key)"), {"key": _STUDY_LOCK})
            found = connection.scalar(text("SELECT count(*) FROM pg_namespace WHERE nspname IN ('concord', 'blind')"))
            if found:
                raise BadInput(f"{named(url)} holds a study already; open that, or choose another database.")
            _build(connection)
            fill(connection)
    finally:
        engine.dispose()


def _build(connection: Connection) -> None:
    connection.exec_driver_sql("CREATE SCHEMA concord")
    schema.create_schema(connection)
    for statement in serverrules.guards():
        connection.exec_driver_sql(statement)
    connection.execute(text("INSERT INTO concord.version VALUES (:number)"), {"number": schema.SCHEMA_VERSION})


def open_server(address: str) -> StudyServer:
    """Check the study on a server, migrate it if it is old, and open it.

    Raises `BadInput` in one sentence if the server is out of reach, refuses the user, or has no study of a version that
    this program knows.
    """
    url = server_url(address)
    engine = _connectable(url, serverrules.RESEARCHER_PATH)
    try:
        with _told(named(url), opened=False), engine.begin() as connection:
            version = connection.scalar(text("SELECT number FROM concord.version"))
            code = connection.scalar(text("SELECT concord.own_code()"))
            _check_version(named(url), version, code)
            if version < schema.SCHEMA_VERSION:
                _migrate(connection)
    finally:
        engine.dispose()
    return StudyServer(url, code)


def _check_version(where: str, version: int | None, code: str | None) -> None:
    if version is None:
        raise BadInput(f"{where} holds no whole study; restore the database from a backup.")
    if version > schema.SCHEMA_VERSION:
        raise BadInput(
            f"{where} was written by a newer Concord (study version {version}, this one reads up to "
            f"{schema.SCHEMA_VERSION}); update Concord."
        )
    if version < schema.SCHEMA_VERSION and code is not None:
        raise BadInput(f"{where} is of an older version; the researcher has to open it once with this Concord.")


def _migrate(connection: Connection) -> None:
    """Lead an older study to this version (another process may have done it meanwhile)."""
    from ..storage.migrations import migrate

    connection.execute(text("SELECT pg_advisory_xact_lock(:key)"), {"key": _STUDY_LOCK})
    version = connection.scalar(text("SELECT number FROM concord.version FOR UPDATE"))
    if version is None or version >= schema.SCHEMA_VERSION:
        return
    connection.exec_driver_sql(f"DROP SCHEMA {serverrules.BLIND} CASCADE")
    migrate(connection, version)
    for statement in serverrules.guards_again():
        connection.exec_driver_sql(statement)
    connection.execute(text("UPDATE concord.version SET number = :number"), {"number": schema.SCHEMA_VERSION})
    grant_again(connection)


def _wait_for_turn(connection: Connection, volunteer: str | None) -> None:
    """Take the study for a researcher, or a share of it and all of the volunteer's own, until the transaction ends."""
    if volunteer is None:
        connection.execute(text("SELECT pg_advisory_xact_lock(:key)"), {"key": _STUDY_LOCK})
    else:
        own = "CAST(CAST(CAST(session_user AS regrole) AS oid) AS integer)"  # which tells others less than the code would
        both = f"SELECT pg_advisory_xact_lock_shared(:key), pg_advisory_xact_lock(1, {own})"
        connection.execute(text(both), {"key": _STUDY_LOCK})


def _connectable(url: URL, search_path: str) -> Engine:
    """An SQLAlchemy engine whose connections are checked before each use and wait neither for ever nor unnoticed."""
    arguments = {name: value for name, value in _NETWORK.items() if name not in url.query}
    try:
        made = create_engine(url, connect_args=arguments, pool_pre_ping=True, pool_size=3, max_overflow=20)
    except ImportError as error:
        raise BadInput(f"A study on a server needs psycopg ({error}); install it with pip install 'psycopg[binary]'.") from None

    @event.listens_for(made, "connect")
    def prepare(raw: Any, _record: Any) -> None:
        with raw.cursor() as cursor:
            cursor.execute(f"SET search_path = {search_path}")
            cursor.execute(f"SET lock_timeout = '{LOCK_SECONDS}s'")
            cursor.execute("SET jit = off")  # compiling what is open to whom takes 0.6 s, running it 3 ms
        raw.commit()

    return made


@contextlib.contextmanager
def _told(where: str, volunteer: str | None = None, *, opened: bool = True) -> Iterator[None]:
    import psycopg

    try:
        yield
    except IntegrityError:
        raise  # a fault of ours, not of the server
    except PoolTimeout:
        raise BadInput(f"{where} is used by too many at once in this program; try again.") from None
    except (DBAPIError, psycopg.Error) as error:
        state = getattr(getattr(error, "orig", error), "sqlstate", None)
        if isinstance(error, ProgrammingError) and state not in ("42501", "42P01", "3F000", "42703", "42883"):
            raise  # likewise
        raise BadInput(explained(where, error, opened=opened, volunteer=volunteer)) from error
