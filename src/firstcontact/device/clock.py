"""The device's clock against the host's."""

from __future__ import annotations

from collections import deque

import numpy as np

#: One point is kept for so long a stretch, s: the one that was delayed least.
BUCKET = 1.0
#: Points that the fit is made of.
POINTS = 600
#: Shortest time that a rate is told from, s.
LEAST = 5.0


class ClockFit:
    """How many samples come per second of the host's clock.

    A line through the arrivals that were delayed least, one a second: what waits
    in buffers is late, never early.

    Parameters
    ----------
    rate
        Nominal, Hz.
    """

    def __init__(self, rate: float) -> None:
        self.nominal = rate
        self._points: deque[tuple[float, float]] = deque(maxlen=POINTS)
        self._best: tuple[float, float, float] | None = None  # delay, samples, host
        self._bucket = 0
        self._rate = 0.0

    def add(self, sample: int, host: float) -> None:
        """A sample had arrived at a time of the host's clock, s."""
        delay = host - sample / self.nominal
        bucket = int(host / BUCKET)
        if self._best is None or bucket != self._bucket:
            if self._best is not None:
                self._points.append(self._best[1:])
                self._fit()
            self._best = (delay, float(sample), host)
            self._bucket = bucket
        elif delay < self._best[0]:
            self._best = (delay, float(sample), host)

    @property
    def rate(self) -> float:
        """Samples per second of the host's clock, Hz; 0 before it can be told."""
        return self._rate

    @property
    def drift(self) -> float:
        """Of the device's clock against its nominal rate, parts per million."""
        return 1e6 * (self._rate / self.nominal - 1.0) if self._rate else 0.0

    def _fit(self) -> None:
        points = np.array(self._points)
        if len(points) < 3 or points[-1, 1] - points[0, 1] < LEAST:
            return
        samples, host = (points - points[0]).T
        slope = float(np.polyfit(host, samples, 1)[0])
        self._rate = max(slope, 0.0)
