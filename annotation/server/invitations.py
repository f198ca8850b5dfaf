"""Inviting volunteers to a study on a server: each gets a login of their own, which may vote as them and nothing else.

Logins have random names, because every user of a server sees the names of all. Passwords are made here, hashed before
they are sent (so no log of the server holds one), and shown once.
"""

import secrets
from typing import Any

from sqlalchemy import URL, Connection, text, update

from engine.errors import BadInput, BadParameter

from ..storage import schema
from ..storage.handle import StudyHandle
from ..voting.answering import checked_code
from ..voting.answering import volunteer as known_volunteer
from .groups import group_name, ready_group
from .postgres import StudyServer

_KEPT_OPTIONS = ("host", "port", "sslmode", "sslrootcert", "connect_timeout")  # of the address, for volunteers


def register(handle: StudyHandle, code: str, *, adjudicator: bool = False) -> None:
    """Make the volunteer where there is none; an adjudicator is asked about unresolved items alone."""
    voter = known_volunteer(handle, code)
    if adjudicator and not voter.adjudicates:
        with handle.writing() as connection:
            mine = schema.volunteer.c.code == voter.code
            connection.execute(update(schema.volunteer).where(mine).values(adjudicates=1))


def invite(server: StudyServer, code: str, *, adjudicator: bool = False, again: bool = False) -> str:
    """Register a volunteer and return the personal address, which holds the password and is kept nowhere.

    `again` gives a new password to one who was invited before, and ends the old one. Raises `BadInput` where the user
    may not make logins, and where the volunteer is invited already.
    """
    code = checked_code(code)
    with server.writing() as connection:
        _check_may_invite(connection, server.where)
        _role_of(connection, code, again)
    register(server, code, adjudicator=adjudicator)
    with server.writing() as connection:
        _sweep(connection)
        return _login(connection, server.url, _role_of(connection, code, again), volunteer=code)


def invite_researcher(server: StudyServer) -> str:
    """Return the address of a new login that may do everything but change votes and invite."""
    with server.writing() as connection:
        _check_may_invite(connection, server.where)
        return _login(connection, server.url, None, volunteer=None)


def uninvite(server: StudyServer, code: str) -> None:
    """End the login of a volunteer at once, also where a window is open; the votes stay."""
    code = checked_code(code)
    with server.writing() as connection:
        _check_may_invite(connection, server.where)
        role = connection.scalar(text("DELETE FROM invited WHERE code = :code RETURNING role"), {"code": code})
        if role is None:
            raise BadInput(f"{server.where} has no invited volunteer {code}; check the code.")
        _end(connection, role)
        _sweep(connection)


def invited(server: StudyServer) -> tuple[str, ...]:
    """The codes of those who are invited at present."""
    with server.reading() as connection:
        return tuple(connection.scalars(text("SELECT code FROM invited WHERE code IS NOT NULL ORDER BY code")))


def _role_of(connection: Connection, code: str, again: bool) -> str | None:
    """The login of a volunteer, None for one who is new; raises `BadParameter` where that is not as it was said to be."""
    role: str | None = connection.scalar(text("SELECT role FROM invited WHERE code = :code"), {"code": code})
    if (role is not None) != again:
        raise BadParameter(
            f"{code} was never invited; leave out --again." if again else
            f"{code} is invited already; give --again for a new address, which ends the old one."
        )  # fmt: skip
    return role


def _sweep(connection: Connection) -> None:
    """Remove logins of volunteers who were deleted from the study."""
    members = """SELECT m.rolname FROM pg_auth_members AS a JOIN pg_roles AS g ON g.oid = a.roleid
    JOIN pg_roles AS m ON m.oid = a.member WHERE g.rolname = :name AND m.rolname ~ '^concord_[0-9a-f]{16}$'
    AND NOT EXISTS (SELECT 1 FROM invited AS i WHERE i.role = m.rolname)"""
    for role in connection.scalars(text(members), {"name": group_name(connection, "volunteers")}).all():
        _end(connection, role)


def _login(connection: Connection, url: URL, role: str | None, volunteer: str | None) -> str:
    """A login with a new password, and its address."""
    password = secrets.token_urlsafe(24)
    made = role or f"concord_{secrets.token_hex(8)}"
    verb = "CREATE" if role is None else "ALTER"
    connection.exec_driver_sql(f"{verb} ROLE {made} LOGIN PASSWORD '{_hashed(connection, made, password)}'")
    if role is None:
        group = ready_group(connection, "researchers" if volunteer is None else "volunteers")
        connection.exec_driver_sql(f"GRANT {group} TO {made}")
        values = {"role": made, "researcher": volunteer is None, "code": volunteer}
        connection.execute(text("INSERT INTO invited (role, researcher, code) VALUES (:role, :researcher, :code)"), values)
    kept = {name: value for name, value in url.query.items() if name in _KEPT_OPTIONS}
    personal = URL.create("postgresql", made, password, url.host, url.port, url.database, kept)
    return personal.render_as_string(hide_password=False)


def _check_may_invite(connection: Connection, where: str) -> None:
    query = "SELECT rolsuper OR rolcreaterole FROM pg_roles WHERE rolname = current_user"
    if not connection.scalar(text(query)):
        raise BadInput(f"{where} does not let this user make logins; connect as one who may (ALTER ROLE … CREATEROLE).")


def _end(connection: Connection, role: str) -> None:
    """Close the connections of a login and remove it."""
    connection.exec_driver_sql(f"ALTER ROLE {role} NOLOGIN")
    may_end = "SELECT rolsuper OR pg_has_role('pg_signal_backend', 'USAGE') FROM pg_roles WHERE rolname = current_user"
    if connection.scalar(text(may_end)):  # otherwise an open window stays connected, and may do nothing any more
        connection.execute(text("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE usename = :role"), {"role": role})
    connection.exec_driver_sql(f"DROP ROLE {role}")


def _hashed(connection: Connection, role: str, password: str) -> str:
    raw: Any = connection.connection.dbapi_connection
    hashed: bytes = raw.pgconn.encrypt_password(password.encode(), role.encode(), b"scram-sha-256")
    return hashed.decode()
