"""Where the window keeps things: settings, recent files, the default study. `CONCORD_HOME` overrides the folder."""

import os
from collections.abc import Iterable
from pathlib import Path

from PySide6.QtCore import QSettings

MOST_RECENT = 8


def data_folder() -> Path:
    """The user's own data folder of Concord, made if missing where that is possible."""
    import platformdirs

    return Path(os.environ.get("CONCORD_HOME") or platformdirs.user_data_dir("concord"))


def default_study() -> Path:
    """The study file that votes go to as long as no other was chosen."""
    return data_folder() / "my votes.db"


def settings() -> QSettings:
    """What is remembered between two starts."""
    return QSettings(str(data_folder() / "window.ini"), QSettings.Format.IniFormat)


def with_recent(known: Iterable[tuple[str, str]], pair: tuple[str, str]) -> list[tuple[str, str]]:
    """The list of recent pairs with this one first and no pair twice."""
    return [pair, *(old for old in known if old != pair)][:MOST_RECENT]


def recent_pairs() -> list[tuple[str, str]]:
    """Pairs of files opened lately, newest first."""
    flat = settings().value("recent", [], list)
    flat = [str(path) for path in flat] if isinstance(flat, list) else []
    return list(zip(flat[::2], flat[1::2], strict=False))


def remember_pair(source: str, target: str) -> None:
    """Put a pair first in the recent files."""
    pairs = with_recent(recent_pairs(), (source, target))
    settings().setValue("recent", [path for pair in pairs for path in pair])
