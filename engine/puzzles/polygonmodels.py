"""The fitted numbers behind the probabilities of polygon joins.

`polygonmodels.json` is written by `tests/benchmarks/puzzle_polygons.py fit`: logistic models of one measure each,
fitted to pictures with known truth.
"""

import json
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

FILE = Path(__file__).with_name("polygonmodels.json")


class Model(NamedTuple):
    """Of one measure: `form` (k+1, k+1) the upper triangle of the quadratic form of a contact's log odds, `contest`
    (7,) the weights of what the rivals say, `placed` (5,) those of what the assembled neighbours say, `base` the log
    odds of a candidate before it is looked at."""

    form: np.ndarray
    contest: np.ndarray
    placed: np.ndarray
    base: float


@lru_cache(maxsize=1)
def _numbers() -> dict[str, dict[str, list[float]]]:
    return json.loads(FILE.read_text(encoding="utf-8"))


def model_of(measure: str) -> Model:
    """The fitted model of a measure."""
    numbers = _numbers()[measure]
    return Model(
        triangle(np.array(numbers["form"])),
        np.array(numbers["contest"]),
        np.array(numbers["placed"]),
        numbers["base"][0],
    )


def triangle(numbers: np.ndarray) -> np.ndarray:
    """The upper triangle, row by row, as a square matrix."""
    k = int((np.sqrt(8 * len(numbers) + 1) - 1) / 2)
    form = np.zeros((k, k))
    form[np.triu_indices(k)] = numbers
    return form
