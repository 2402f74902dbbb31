"""How much may be asked: so many at once, and so many a second."""

from __future__ import annotations

import time
from collections.abc import Callable


class Allowance:
    """A token bucket.

    Parameters
    ----------
    at_once
        What may be taken in one go, after a pause.
    a_second
        What comes back, Hz.
    clock
        Gives the time, s.
    """

    def __init__(
        self, at_once: int, a_second: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._most = float(at_once)
        self._rate = a_second
        self._clock = clock
        self._left = self._most
        self._seen = clock()

    def take(self) -> float:
        """Take one: 0.0, or how long until there is one, s; then none was taken."""
        now = self._clock()
        self._left = min(self._most, self._left + (now - self._seen) * self._rate)
        self._seen = now
        if self._left < 1.0:
            return (1.0 - self._left) / self._rate
        self._left -= 1.0
        return 0.0
