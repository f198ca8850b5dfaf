"""Faults that nobody foresaw: a plain sentence for the volunteer, and where it happened for whoever looks into it."""

import platform
import re
from pathlib import PurePath

from annotation.storage.stamps import app_version

UNKNOWN = (
    "Something went wrong here; what was saved before is safe. Please try again. If it does not help, copy the details "
    "and send them to whoever gave you this."
)
_FRAME = re.compile(r'\s*File "(.+)", line (\d+), in (\S+)')
_ERROR = re.compile(r"[A-Za-z_][\w.]*(?:Error|Exception|BadInput|BadParameter|Timeout|NotFound)\b")
_OWN_WORDS = "sqlite3."  # its messages name tables and columns, never what these hold


def unforeseen(sentence: str) -> bool:
    """Whether a sentence of `jobs.explain` is that of a fault without a sentence of its own."""
    return "should not have" in sentence


def unknown_trouble(sentence: str) -> str:
    """What to say of a fault that has no sentence of its own, without its technical part."""
    return UNKNOWN if unforeseen(sentence) else sentence


def fault_report(details: str) -> str:
    """The kinds of errors and the lines where they were raised, without the values that their messages may hold.

    A volunteer can read it, too: messages quote files, queries and what a study holds.
    """
    lines = [f"Concord {app_version()}, Python {platform.python_version()}, {platform.system()}"]
    for line in details.splitlines():
        frame, error = _FRAME.match(line), _ERROR.match(line)
        if frame:
            lines.append(f"  {'/'.join(PurePath(frame[1]).parts[-3:])}:{frame[2]} in {frame[3]}")
        elif error:
            lines.append(line if line.startswith(_OWN_WORDS) else error[0])
    return "\n".join(lines)
