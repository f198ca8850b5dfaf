"""How long a question was looked at: all the time since it was shown, and that in which somebody was there."""

import time
from collections.abc import Callable

LONGEST_PAUSE = 60.0  # seconds after the last key or movement that still count


class Watch:
    """Measures one question after the other. It runs by a clock that nobody can set back."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._away = False
        self.start()

    def start(self) -> None:
        """A question is shown now."""
        self._began = self._last = self._clock()
        self._active = 0.0

    def touch(self) -> None:
        """A key, a click, a movement of the mouse."""
        now = self._clock()
        if not self._away:
            self._active += min(now - self._last, LONGEST_PAUSE)
        self._last = now

    def leave(self) -> None:
        """Another window came to the front, or something else is read in this one."""
        self.touch()
        self._away = True

    def come_back(self) -> None:
        """The question is in front again."""
        self.touch()
        self._away = False

    def read(self) -> tuple[int, int]:
        """Milliseconds since the question was shown, and those in which somebody was there."""
        self.touch()
        return round((self._last - self._began) * 1000), round(self._active * 1000)
