"""What becomes of a study's rows when it is given to strangers: no codes, comments, times of the day or folders."""

import json
import re
import secrets
import uuid
from collections.abc import Callable, Mapping, Sequence
from pathlib import PurePosixPath, PureWindowsPath
from typing import Any

from ..results.proposals import canonical
from ..storage.payloads import read_payload
from .tombstones import day

Cells = dict[str, Any]
Rows = list[Cells]


class Unchanged:
    """Every row as it is."""

    def rows(self, table: str, rows: Rows) -> Rows:
        """What becomes of the rows of one table."""
        return rows


class Anonymous(Unchanged):
    """Codes are v01, v02, … in a random order, and all else that leads back to a volunteer goes.

    The result is a study of its own, under new ids: it cannot be merged into the one that it came from, nor compared
    with returned packets. What counts and who answered what together stay as they were: a volunteer's events are numbered
    anew, in their order.
    """

    def __init__(self, codes: Sequence[str], *, comments: bool = False) -> None:
        shuffled = sorted(codes, key=lambda _: secrets.token_bytes(16))
        digits = max(2, len(str(len(shuffled))))
        self.codes = {code: f"v{number:0{digits}}" for number, code in enumerate(shuffled, start=1)}
        self.comments = comments
        self._changes: Mapping[str, Callable[[Rows], Rows]] = {
            "study": self._study, "item": _items, "run": _runs, "volunteer": self._volunteers, "event": self._events,
            "assignment": self._assignments, "forgotten": lambda rows: [],
        }  # fmt: skip

    def rows(self, table: str, rows: Rows) -> Rows:
        """What becomes of the rows of one table."""
        return self._changes.get(table, lambda same: same)(rows)

    def _study(self, rows: Rows) -> Rows:
        def renamed(value: Any) -> Any:
            return self.codes.get(value, value) if isinstance(value, str) else value

        settings = {name: value for name, value in json.loads(rows[0]["settings"]).items() if name not in ("tops_up", "family")}
        clean = canonical(_walked(_without_folders(settings), renamed))
        return [rows[0] | {"id": str(uuid.uuid4()), "seed": secrets.token_hex(16), "settings": clean}]

    def _volunteers(self, rows: Rows) -> Rows:
        changed = [
            row | {"code": self.codes[row["code"]], "seed": secrets.token_hex(16), "created_at": day(row["created_at"])}
            for row in rows
        ]
        return sorted(changed, key=lambda row: row["code"])

    def _assignments(self, rows: Rows) -> Rows:
        return [row | {"volunteer": self.codes[row["volunteer"]], "made_at": day(row["made_at"])} for row in rows]

    def _events(self, rows: Rows) -> Rows:
        new = {row["uuid"]: str(uuid.uuid4()) for row in rows}
        counts: dict[str, int] = {}
        changed = []
        for row in sorted(rows, key=lambda row: (row["clock"], row["created_at"], row["uuid"])):
            code = self.codes[row["volunteer"]]
            counts[code] = counts.get(code, 0) + 1
            changed.append(row | {
                "uuid": new[row["uuid"]], "supersedes": new.get(row["supersedes"]), "volunteer": code, "clock": counts[code],
                "comment": row["comment"] if self.comments else "", "created_at": day(row["created_at"]),
                "presentation": _plain(row["presentation"]),
            })  # fmt: skip
        return sorted(changed, key=lambda row: (row["clock"], row["uuid"]))


def _items(rows: Rows) -> Rows:
    return [row | {"payload": _nameless(row["payload"])} for row in rows]


def _runs(rows: Rows) -> Rows:
    return [row | {name: _nameless(row[name]) for name in ("source", "target", "parameters")} for row in rows]


def _nameless(text: str) -> str:
    return canonical(_without_folders(read_payload(text)))


def _without_folders(value: Any) -> Any:
    """JSON whose paths are the names of files alone."""
    return _walked(value, lambda one: _name(one) if isinstance(one, str) and len(one) < 4096 else one)


def _name(text: str) -> str:
    """The last part of what looks like a path, any other text as it is."""
    if re.match(r"[A-Za-z]:[\\/]|\\\\", text):
        return PureWindowsPath(text).name
    return PurePosixPath(text).name if re.match(r"[~.]{0,2}/|[^/\n]+/[^\n]*\.\w{1,5}$", text) else text


def _walked(value: Any, change: Callable[[Any], Any]) -> Any:
    """JSON with every single value changed."""
    if isinstance(value, dict):
        return {name: _walked(content, change) for name, content in value.items()}
    if isinstance(value, list):
        return [_walked(content, change) for content in value]
    return change(value)


def _plain(presentation: str) -> str:
    """How an item was shown, as far as it is numbers and yes or no."""
    shown = read_payload(presentation)
    return canonical({name: value for name, value in shown.items() if isinstance(value, int | float)})
