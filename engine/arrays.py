"""Checks at the door: arrays are converted once, checked once and made read-only."""

from typing import Any

import numpy as np

from .errors import BadInput


def frozen_array(value: Any, dtype: Any, shape: tuple[int | None, ...], what: str) -> np.ndarray:
    """A read-only array of the given dtype; `None` in `shape` stands for any length. Raises `BadInput`."""
    array = np.array(value, dtype=dtype, order="C")
    fits = array.ndim == len(shape) and all(want in (None, have) for want, have in zip(shape, array.shape, strict=True))
    if not fits:
        wanted = "(" + ", ".join("n" if n is None else str(n) for n in shape) + ")"
        raise BadInput(f"{what} must have the shape {wanted}, not {array.shape}.")
    array.setflags(write=False)
    return array
