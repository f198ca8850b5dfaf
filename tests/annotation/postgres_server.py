"""A PostgreSQL server of the tests' own: made in a temporary folder, on a socket and a free port, and always stopped."""

import contextlib
import os
import shutil
import socket
import subprocess
import tempfile
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

PASSWORD = "of-the-owner"


class Unavailable(Exception):
    """Why there is no server."""


class Server(NamedTuple):
    """A running server; its superuser is `postgres`, and everybody else has to know a password."""

    port: int
    folder: Path
    binaries: Path

    def url(self, database: str = "postgres", user: str = "postgres", password: str = PASSWORD) -> str:
        return f"postgresql://{user}:{password}@127.0.0.1:{self.port}/{database}"

    def sql(self, statement: str, database: str = "postgres", **who: str) -> list[tuple]:
        """Say something as the superuser (or whoever is named), outside of any transaction."""
        import psycopg

        with psycopg.connect(self.url(database, **who), autocommit=True) as connection:
            cursor = connection.execute(statement)
            return cursor.fetchall() if cursor.description else []

    @property
    def version(self) -> int:
        return int(self.sql("SHOW server_version_num")[0][0])

    def database(self) -> str:
        """The address of a new, empty database that sorts as English does, unlike a study."""
        name = f"study_{uuid.uuid4().hex[:12]}"
        sorting = "TEMPLATE template0 LOCALE_PROVIDER icu ICU_LOCALE 'en-US'" if self.version >= 150000 else ""
        self.sql(f"CREATE DATABASE {name} {sorting}")
        return self.url(name)

    def drop(self, address: str) -> None:
        """Remove a database that is needed no more; a server recovers the sooner the less there is."""
        self.sql(f"DROP DATABASE {address.rpartition('/')[2]} WITH (FORCE)")

    def control(self, *arguments: str) -> None:
        """Tell `pg_ctl` to stop or start the server."""
        command = [self.binaries / "pg_ctl", "-D", self.folder / "data", "-w", "-l", self.folder / "log", *arguments]
        _run(command, self.folder)


def binaries() -> Path:
    """The folder of the newest server programs; raises `Unavailable` where there are none."""
    found = [path.parent for path in Path("/usr/lib/postgresql").glob("*/bin/initdb")]
    on_path = shutil.which("initdb")
    found += [Path(os.path.realpath(on_path)).parent] if on_path else []
    if not found:
        raise Unavailable("PostgreSQL is not installed (Debian's package is postgresql)")
    return max(found, key=lambda path: [int(part) for part in path.parent.name.split(".") if part.isdigit()])


@contextlib.contextmanager
def running(**settings: str) -> Iterator[Server]:
    """A server for the block. It does not wait for its disk, and is thrown away, also where this process is killed."""
    programs, folder = binaries(), Path(tempfile.mkdtemp(prefix="concord-pg-", dir="/tmp"))
    with _ended_with_us(programs, folder):
        if os.geteuid() == 0:
            shutil.chown(folder, user=_unprivileged())
        (folder / "password").write_text(PASSWORD)
        (folder / "password").chmod(0o644)
        _run([programs / "initdb", "-D", folder / "data", "-U", "postgres", "-E", "UTF8", "--locale=C.UTF-8", "-N",
              "--auth=scram-sha-256", f"--pwfile={folder / 'password'}"], folder)  # fmt: skip
        server = Server(_free_port(), folder, programs)
        chosen = {
            "listen_addresses": "127.0.0.1", "port": str(server.port), "unix_socket_directories": str(folder),
            "fsync": "off", "max_connections": "120", "lc_messages": "C", **settings,
        }  # fmt: skip
        with (folder / "data" / "postgresql.conf").open("a") as conf:
            conf.writelines(f"{key} = '{value}'\n" for key, value in chosen.items())
        server.control("start")
        yield server


@contextlib.contextmanager
def _ended_with_us(programs: Path, folder: Path) -> Iterator[None]:
    """A shell that stops the server and removes its folder as soon as the pipe from this process closes, however it ends."""
    stop = _unprivileged_words([programs / "pg_ctl", "-D", folder / "data", "-w", "-m", "immediate", "stop"])
    script = 'read -r _; "$@" >/dev/null 2>&1; rm -rf -- "$0"'
    keeper = subprocess.Popen(["sh", "-c", script, str(folder), *stop], cwd="/", stdin=subprocess.PIPE, start_new_session=True)
    try:
        yield
    finally:
        keeper.communicate(timeout=120)


def _run(command: list[object], folder: Path) -> None:
    """Run one of the server's programs and say what it said if it fails."""
    done = subprocess.run(
        _unprivileged_words(command), cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        timeout=60, env={**os.environ, "LC_ALL": "C"},
    )  # fmt: skip
    if done.returncode:
        raise Unavailable(f"{Path(str(command[0])).name} failed: {done.stdout.strip()[-300:]} {_log(folder)}")


def _unprivileged_words(command: list[object]) -> list[str]:
    """The command, for somebody else where we are root, whom the server's programs refuse."""
    words = [str(word) for word in command]
    if os.geteuid() == 0:
        return ["setpriv", f"--reuid={_unprivileged()}", "--clear-groups", f"--regid={_group()}", *words]
    return words


def _unprivileged() -> str:
    import pwd

    names = {entry.pw_name for entry in pwd.getpwall()}
    return "postgres" if "postgres" in names else "nobody"


def _group() -> int:
    import pwd

    return pwd.getpwnam(_unprivileged()).pw_gid


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _log(folder: Path) -> str:
    """The end of what the server itself said."""
    return (folder / "log").read_text(errors="replace")[-300:] if (folder / "log").exists() else ""
