"""What items show and other values of a study, read from texts in its file, which a stranger may have written."""

import json
from collections.abc import Mapping
from typing import Any

from engine.errors import BadInput

DAMAGED = "What this study holds of a match or a result is damaged; use a backup, or ask for the file again."


def read_payload(text: str) -> dict[str, Any]:
    """The payload of an item, or another object of names and values; raises `BadInput` where the text is none."""
    try:
        payload = json.loads(text)
    except (ValueError, RecursionError):
        payload = None
    if not isinstance(payload, dict):
        raise BadInput(DAMAGED)
    return payload


def two_sides(payload: Mapping[str, Any]) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
    """The source and the target of an item of shapes; raises `BadInput` where one lacks its mesh, file or segments."""
    return _side(payload.get("source")), _side(payload.get("target"))


def _side(side: Any) -> Mapping[str, Any]:
    kinds = {"sha256": str, "file": str, "segments": list}
    if not isinstance(side, dict) or not all(isinstance(side.get(name), kind) for name, kind in kinds.items()):
        raise BadInput(DAMAGED)
    return side
