"""Rules for samples that every live source keeps: usable values and the stated rate."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Largest sample: that of 32-bit integers. Filters and recordings have room for more.
LARGEST_SAMPLE = 2.0**31
#: Largest difference between the stated and the measured rate, as a share.
TOLERANCE = 0.02
#: A difference of this share shows at once.
OBVIOUS = 0.3
#: Shortest window in which samples are counted, s.
WINDOW = 0.25
#: Windows for an obvious difference, windows for any other, and windows that are kept.
FEW, ENOUGH, KEPT = 4, 8, 40
#: Standard errors of the measured rate that the tolerance is widened by.
SIGMAS = 4.0


def usable_samples(values: NDArray[Any]) -> NDArray[np.bool_]:
    """Return True for each sample whose values are all finite and in range.

    Parameters
    ----------
    values
        Samples before any filter, shape (samples, channels).

    Returns
    -------
    ndarray
        Shape (samples,).
    """
    usable: NDArray[np.bool_] = (np.abs(values) <= LARGEST_SAMPLE).all(axis=1)
    return usable


class RateCheck:
    """Measured rate of a stream against its stated rate.

    The rate is the median over windows of a quarter of a second. A stall of this process, the
    burst behind it and a gap each spoil a window or two, and leave the median as it is. Jitter
    widens the tolerance by the standard error of the median.

    Parameters
    ----------
    stated
        Rate, Hz.
    """

    def __init__(self, stated: float) -> None:
        self._stated = stated
        self._begin: tuple[float, float] | None = None
        self._rates: deque[float] = deque(maxlen=KEPT)

    @property
    def rate(self) -> float:
        """Measured rate, Hz; 0 before the first window ends."""
        return float(np.median(self._rates)) if self._rates else 0.0

    def add(self, end: float, seconds: float) -> bool:
        """Count samples up to a time. Return True if the rate differs from the stated one.

        Parameters
        ----------
        end
            Number of samples so far.
        seconds
            Time of the last one, s.
        """
        if self._begin is None or seconds < self._begin[1]:
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
