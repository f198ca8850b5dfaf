"""A file of results of either kind as a run of a study: `matches.json` of shapes, `solution.json` of a puzzle."""

import json
from pathlib import Path

from engine.errors import BadInput

from ..records import Run
from .matchesfile import read_matches
from .puzzlejoins import solution_run


def read_results(path: Path | str, set_name: str = "") -> Run:
    """The run that a file holds; the pictures of a puzzle are read again, to be kept in the study.

    Raises `BadInput` in one sentence for anything else.
    """
    if not _schema(Path(path)).startswith("concord.solution/"):
        return read_matches(path, set_name)
    from engine.puzzles.reopening import reopen

    found = reopen(path)
    if not len(found.solution.joins):
        raise BadInput(f"{path} has no joins to be judged; give a solution in which pieces touch.")
    return solution_run(found.puzzle, found.solution, set_name, guided=found.guided)


def _schema(path: Path) -> str:
    """What a file says that it is; nothing where it says nothing."""
    try:
        content = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return ""
    return str(content.get("schema", "")) if isinstance(content, dict) else ""
