"""Small fitted networks: layers with rectified linear units between, kept as JSON and evaluated here."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

_ARRAYS = ("mean", "scale", "weights", "bias")


def read_networks(file: Path) -> dict[str, Any]:
    """A JSON file of networks, with float32 arrays for the lists of their numbers."""
    return json.loads(file.read_text(encoding="utf-8"), object_hook=_arrays)


def _arrays(entry: dict[str, Any]) -> dict[str, Any]:
    return {k: np.array(v, dtype=np.float32) if k in _ARRAYS else v for k, v in entry.items()}


def log_odds(net: Mapping[str, Any], inputs: np.ndarray) -> np.ndarray:
    """The outputs (c, o) float64 of a network for inputs (c, f), before the logistic function.

    The inputs are brought to mean 0 and deviation 1, and cut off at `clip` deviations where the network has that.
    """
    values = (inputs - net["mean"]) / net["scale"]
    values = np.clip(values, -net["clip"], net["clip"]) if "clip" in net else values
    for layer in net["layers"][:-1]:
        values = np.maximum(values @ layer["weights"] + layer["bias"], 0)
    return (values @ net["layers"][-1]["weights"] + net["layers"][-1]["bias"]).astype(np.float64)


def logistic(values: np.ndarray) -> np.ndarray:
    """1 / (1 + exp(-x))."""
    return 1 / (1 + np.exp(-values))
