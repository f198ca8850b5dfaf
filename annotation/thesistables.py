"""A study's votes as the thesis's Tables 3.1 and 3.2 take them."""

import json
from pathlib import Path

from engine.errors import BadInput
from engine.evaluation.tables import Table
from engine.evaluation.thesis_tables import SetPrecision

from .precision import ALL_SETS, Proposed, ballots, precision_table, proposed
from .study import open_study
from .tabletext import as_table, row_name

NAME_IN_FOLDER = "study.db"


def voted_precision(path: Path) -> tuple[list[SetPrecision], Table] | None:
    """Precision by majority of each method and set of shapes, and the modern table; None where `path` is no study.

    A study is a file, or a folder that holds a study.db. Raises `BadInput` where it cannot be read or holds no shapes.
    """
    file = path / NAME_IN_FOLDER if path.is_dir() else path
    if not file.is_file():
        return None
    with open_study(file, backup=False) as handle:
        results, votes = proposed(handle), ballots(handle)
        layers: dict[tuple[str, str, str], set[int]] = {}
        for result in results:
            layers.setdefault(result[:3], set()).update(_layers(result))
        rows = [row for row in precision_table(handle) if row.set_name == ALL_SETS or layers.get(row[:3])]
    if not rows:
        raise BadInput(f"The study {file} holds no results of shapes; add some with `concord study add`.")
    found = [
        SetPrecision(row_name(row), row.set_name or "–", float("nan") if row.micro is None else row.micro, row.pairs,
                     next(iter(layers[row[:3]])) if len(layers[row[:3]]) == 1 else 0)
        for row in rows
        if row.set_name != ALL_SETS
    ]  # fmt: skip
    return found, as_table(rows, votes)


def _layers(result: Proposed) -> list[int]:
    """The number of layers that a result of shapes was made with; nothing for puzzles."""
    layers = json.loads(result.parameters).get("layers")
    return [layers] if isinstance(layers, int) else []
