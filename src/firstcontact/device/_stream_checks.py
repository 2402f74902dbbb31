"""Checks of live samples: usable values and the stated rate."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Largest usable sample, the limit of 32-bit integers. Filters and recordings can hold larger
#: values.
LARGEST_SAMPLE = 2.0**31
#: Largest difference between the stated and the measured rate, as a share.
TOLERANCE = 0.02
#: Relative difference between the rates from which on ``FEW`` windows prove it.
OBVIOUS = 0.3
#: Shortest window in which samples are counted, s.
WINDOW = 0.25
#: Number of windows that prove an obvious difference, number that proves a smaller one, and largest
#: number of windows in memory.
FEW, ENOUGH, KEPT = 4, 8, 40
#: Number of standard errors of the measured rate by which the tolerance is widened.
SIGMAS = 4.0


def usable_samples(values: NDArray[Any]) -> NDArray[np.bool_]:
    """Return True for each sample whose values are all finite and at most ``LARGEST_SAMPLE``."""
    usable: NDArray[np.bool_] = (np.abs(values) <= LARGEST_SAMPLE).all(axis=1)
    return usable


class RateCheck:
    """Measured rate of a stream, compared with its stated rate."""

    def __init__(self, stated: float) -> None:
        self._stated = stated
        self._begin: tuple[float, float] | None = None
        self._rates: deque[float] = deque(maxlen=KEPT)

    @property
    def rate(self) -> float:
        """Measured rate, Hz; 0 before the first quarter of a second has passed."""
        return float(np.median(self._rates)) if self._rates else 0.0

    def add(self, end: float, seconds: float, *, behind: bool = False) -> bool:
        """Add samples up to a time. Return True if the measured rate differs from the stated."""
        if behind or self._begin is None or seconds < self._begin[1]:
            self._begin = end, seconds
            return False
        if seconds - self._begin[1] < WINDOW:
            return False
        self._rates.append((end - self._begin[0]) / (seconds - self._begin[1]))
        self._begin = end, seconds
        return self._differs()

    def _differs(self) -> bool:
        rates = np.array(self._rates)
        if len(rates) < FEW:
            return False
        median = float(np.median(rates))
        scatter = 1.4826 * float(np.median(np.abs(rates - median)))
        error = 1.2533 * scatter / len(rates) ** 0.5
        tolerance = TOLERANCE if len(rates) >= ENOUGH else OBVIOUS
        return bool(abs(median - self._stated) > tolerance * self._stated + SIGMAS * error)
