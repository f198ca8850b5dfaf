"""Progress is a function that long work calls with a share in [0, 1] and a few words."""

from collections.abc import Callable

Progress = Callable[[float, str], None]


def silent(share: float, words: str) -> None:
    """Ignore the progress."""


def onwards(progress: Progress) -> Progress:
    """The same progress, but never backwards: steps that are repeated do not take it back."""
    furthest = 0.0

    def forward(value: float, words: str) -> None:
        nonlocal furthest
        furthest = max(furthest, value)
        progress(furthest, words)

    return forward


def share(progress: Progress, start: float, end: float) -> Progress:
    """Map the [0, 1] of one step onto the part [start, end] of the whole."""
    return lambda value, words: progress(start + (end - start) * value, words)
