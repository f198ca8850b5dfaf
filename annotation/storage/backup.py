"""Copies of a study kept beside it in `backups/`: whole (by SQLite's own copying), few, and never in the way."""

import contextlib
import os
import shutil
import sqlite3
import tempfile
import time
from datetime import UTC, datetime, timedelta
from glob import escape
from pathlib import Path

from .places import sync_folder

KEPT = 5
EVERY_SECONDS = 3600.0
_STAGED, _LEFT_SECONDS = ".staged.", 3600.0
_STAMP, _TICK = "%Y%m%dT%H%M%S.%f", timedelta(microseconds=1)


def keep_backup(raw: sqlite3.Connection, path: Path) -> Path | None:
    """Back up unless a copy exists that is younger than an hour, or than the last change; keep the newest five.

    A backup that cannot be written (a full disk) never stops the work: votes have their own commit. A copy from a time
    that has not come yet (the clock was set back) says nothing of its age.
    """
    kept = backups(path)
    changed = max(_mtime(path), _mtime(Path(f"{path}-wal")))
    age = time.time() - _mtime(kept[-1]) if kept else -1.0
    if age >= 0 and (_mtime(kept[-1]) >= changed or age < EVERY_SECONDS):
        return None
    with contextlib.suppress(OSError, sqlite3.Error):
        made = back_up(raw, path)
        for old in backups(path)[:-KEPT]:
            old.unlink(missing_ok=True)
        return made
    return None


def backups(path: Path) -> list[Path]:
    """The rotating copies, oldest first (those made before a migration are not among them, and stay)."""
    return sorted(_folder(path).glob(f"{escape(path.name)}.2*"))


def every_backup(path: Path) -> list[Path]:
    """All copies, those made before a migration too."""
    return sorted(_folder(path).glob(f"{escape(path.name)}.*"))


def back_up(raw: sqlite3.Connection, path: Path, label: str = "") -> Path:
    """Copy the study as it stands to `backups/NAME.TIME`, or `backups/NAME.LABEL.TIME`, staged and renamed.

    The names say in which order copies were made: after one from the future, the time is a microsecond later than that.
    """
    stamp = datetime.now(UTC)
    for last in backups(path)[-1:]:
        with contextlib.suppress(ValueError, OverflowError):
            stamp = max(stamp, datetime.strptime(last.name[len(path.name) + 1 :] + "Z", f"{_STAMP}%z") + _TICK)
    target = _folder(path) / ".".join(filter(None, (path.name, label, stamp.strftime(_STAMP))))
    target.parent.mkdir(exist_ok=True)
    for left in target.parent.glob(f"{_STAGED}*"):  # of a process that was killed
        if abs(time.time() - _mtime(left)) > _LEFT_SECONDS:
            shutil.rmtree(left, ignore_errors=True)
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=_STAGED) as folder:
        staged = Path(folder) / "copy"
        with contextlib.closing(sqlite3.connect(staged)) as copy:
            raw.backup(copy)
            copy.execute("PRAGMA journal_mode=DELETE")
        os.replace(staged, target)
    sync_folder(target.parent)
    return target


def _folder(path: Path) -> Path:
    return path.parent / "backups"


def _mtime(path: Path) -> float:
    with contextlib.suppress(OSError):
        return path.stat().st_mtime
    return 0.0
