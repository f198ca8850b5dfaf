"""The groups of a study's volunteers and of its researchers on a server: roles that hold rights and cannot log in."""

from collections.abc import Callable, Iterator

from sqlalchemy import Connection, text

from .rules import researcher_grants, volunteer_grants

GRANTS: dict[str, Callable[[str], Iterator[str]]] = {"volunteers": volunteer_grants, "researchers": researcher_grants}


def ready_group(connection: Connection, members: str) -> str:
    """The group of all "volunteers" or "researchers" of this database, with its rights (granting twice does no harm)."""
    group = group_name(connection, members)
    if not _exists(connection, group):
        connection.exec_driver_sql(f"CREATE ROLE {group} NOLOGIN")
    _grant(connection, members, group)
    database = str(connection.scalar(text("SELECT current_database()")))
    quoted = connection.dialect.identifier_preparer.quote_identifier(database)
    ours = "SELECT pg_has_role(datdba, 'USAGE') FROM pg_database WHERE datname = current_database()"
    if connection.scalar(text(ours)):
        connection.exec_driver_sql(f"REVOKE CONNECT, TEMPORARY ON DATABASE {quoted} FROM PUBLIC")
        connection.exec_driver_sql(f"GRANT CONNECT ON DATABASE {quoted} TO {group}")
    return group


def grant_again(connection: Connection) -> None:
    """Grant the groups that there are what they may do, after views were made anew."""
    for members in GRANTS:
        group = group_name(connection, members)
        if _exists(connection, group):
            _grant(connection, members, group)


def _grant(connection: Connection, members: str, group: str) -> None:
    for statement in GRANTS[members](group):
        connection.exec_driver_sql(statement)


def _exists(connection: Connection, group: str) -> bool:
    return connection.scalar(text("SELECT 1 FROM pg_roles WHERE rolname = :name"), {"name": group}) is not None


def group_name(connection: Connection, members: str) -> str:
    """Roles are known to all databases of a server; the number of this one tells its groups apart."""
    number = connection.scalar(text("SELECT oid FROM pg_database WHERE datname = current_database()"))
    return f"concord_{members}_{number}"
