"""Progress is a function that long work calls with a share in [0, 1] and a few words."""

from collections.abc import Callable

Progress = Callable[[float, str], None]


def silent(share: float, words: str) -> None:
    """Ignore the progress."""


def share(progress: Progress, start: float, end: float) -> Progress:
    """Map the [0, 1] of one step onto the part [start, end] of the whole."""
    return lambda value, words: progress(start + (end - start) * value, words)
