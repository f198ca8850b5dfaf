"""What can be wrong with a study file, told from the outside in, in one sentence each."""

import contextlib
import os
import sqlite3
from collections.abc import Iterable
from pathlib import Path

from engine.errors import BadInput

from . import schema

_BACKUPS = "use the newest copy in the folder 'backups' beside it."
_SAID = (
    ("locked", "is held by another program for longer than {busy:g} s; close it there and try again."),
    ("readonly", "cannot be written; make it and its folder writable, or copy it to another folder."),
    ("not a database", "is not a study file (it is no SQLite file); choose another."),
    ("full", "cannot be written because the disk is full (what was saved before is safe); make room and try again."),
    ("unable to open", "cannot be opened; check that it and its folder can be read and written."),
    ("malformed", f"is damaged; {_BACKUPS}"),
    ("disk I/O", "cannot be read or written (the disk reports an error, or is full); make room, or copy it to another disk."),
)


def explained(path: Path, error: Exception, busy_seconds: float) -> str:
    """One sentence for a person, for what SQLite says of a file."""
    said = str(getattr(error, "orig", None) or error)
    for words, sentence in _SAID:
        if words in said:
            return f"{path} {sentence.format(busy=busy_seconds)}"
    return f"{path} cannot be used as a study ({said}); {_BACKUPS}"


def check_outside(path: Path, *, writable: bool = True) -> None:
    """What can be told without SQLite: missing, a folder, empty, foreign, write-protected (even from root)."""
    try:
        size = path.stat().st_size
        if path.is_dir():
            raise BadInput(f"{path} is a folder; give the study file in it.")
        if size == 0:
            raise BadInput(f"{path} is empty and no study; use a backup, or delete it and create the study again.")
        if writable and not may_write(path):
            raise BadInput(f"{path} is read-only; make it and its folder writable, or copy it to another folder.")
        with open(path, "rb") as handle:
            if handle.read(16) != b"SQLite format 3\0":
                raise BadInput(f"{path} is not a study file (it is no SQLite file); choose another.")
        # Only a file at rest can be measured: while a log lies beside it, its end may still be in there.
        if _cut_short(path) and not os.path.exists(f"{path}-wal") and _cut_short(path):
            raise BadInput(f"{path} is damaged (its end is missing); {_BACKUPS}")
    except OSError as error:
        raise BadInput(f"{path} cannot be opened ({error.strerror}); check the name, or create the study.") from None


def may_write(path: Path) -> bool:
    """Whether a study of that path can be written: the file, and beside it its log and backups."""
    return not sealed(path) and os.access(path, os.R_OK | os.W_OK) and os.access(path.parent, os.W_OK)


def sealed(path: Path) -> bool:
    """Whether nobody writes it as it is: by its own mode, or because its disk is mounted read-only."""
    if hasattr(os, "statvfs") and os.statvfs(path).f_flag & os.ST_RDONLY:
        return True
    return not path.stat().st_mode & 0o222


def check_inside(path: Path, raw: sqlite3.Connection) -> int:
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
    tables = {name for (name,) in raw.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if found != "ok" or version < 1 or not {"study", "item", "event"} <= tables:
        raise BadInput(f"{path} is damaged; {_BACKUPS}")
    if not _own_rules(raw, version):
        raise BadInput(f"{path} holds rules of counting that are not Concord's; ask who gave it to you, or {_BACKUPS}")
    return version


def _own_rules(raw: sqlite3.Connection, version: int) -> bool:
    """Whether views and triggers are those that Concord writes: a stranger's could count otherwise, or never end."""
    rules = raw.execute("SELECT type, name, sql FROM sqlite_master WHERE type IN ('view', 'trigger')").fetchall()
    if _plain(sql for kind, _, sql in rules if kind == "trigger") != _plain(schema.SQLITE_TRIGGERS):
        return False
    if version == schema.SCHEMA_VERSION:
        return _plain(sql for kind, _, sql in rules if kind == "view") == _plain(schema.VIEWS)
    ours = {statement.split()[2] for statement in schema.VIEWS}  # the migration makes them anew
    return {name for kind, name, _ in rules if kind == "view"} <= ours


def _plain(statements: Iterable[str]) -> set[str]:
    """Statements whatever their spaces and line ends."""
    return {" ".join(statement.split()) for statement in statements}


def inode(path: Path) -> tuple[int, int] | None:
    """What tells a file from another that took its name; None where there is none."""
    with contextlib.suppress(OSError):
        found = path.stat()
        return found.st_dev, found.st_ino
    return None


def _cut_short(path: Path) -> bool:
    """Whether the file is shorter than its header says (SQLite file format, section 1.3)."""
    with open(path, "rb") as handle:
        header = handle.read(100)
    page = int.from_bytes(header[16:18], "big")
    return path.stat().st_size < int.from_bytes(header[28:32], "big") * (65536 if page == 1 else page)
