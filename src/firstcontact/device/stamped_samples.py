"""Numbering of samples by their time stamps, for senders that do not number samples."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

#: Largest usable time stamp, s: three thousand years.
LARGEST_STAMP = 1e11
#: Number of chunks that the line is fitted to: some seconds.
KEPT = 100
#: Number of chunks before gaps in jittering stamps are accepted.
LEAST = 20
#: A step between two stamps is steady if it is off by less than this, in samples.
STEADY = 0.25
#: Each stamp is used by itself if more than this share of the last steps is steady ...
MOST = 0.7
STEPS_KEPT = 300
#: ... and no step in memory is too short by this many samples or more.
EARLIEST = 0.5
#: A gap is detected if stamps are later than the line by this multiple of their scatter ...
SIGMAS = 6.0
#: ... and by this number of samples.
SMALLEST = 2.0


class StampedSamples:
    """Numbering of samples by their time stamps. Missing samples show as jumps of the number.

    ``rate`` is the stated sampling rate, Hz. A line through the stamps follows the sender's clock.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._zero: float | None = None
        self._end = 0  # number of the next sample
        self._last = 0.0  # stamp of the newest sample
        self._centres: deque[tuple[float, float]] = deque(maxlen=KEPT)
        self._steps: deque[float] = deque(maxlen=STEPS_KEPT)
        self._smallest_steps: deque[float] = deque(maxlen=KEPT)  # smallest step of each chunk
        self._late = 0  # delay of the last chunk in samples, not counted as lost yet

    def numbers(self, stamps: NDArray[np.float64]) -> NDArray[np.int64]:
        stamps = self._interpolate_unusable(stamps)
        if self._zero is None:
            self._zero, self._last = float(stamps[0]), float(stamps[0]) - 1 / self._rate
        steps = np.diff(stamps, prepend=self._last) * self._rate - 1.0
        self._last = float(stamps[-1])
        self._steps.extend(np.abs(steps).tolist())
        places = np.arange(len(stamps), dtype=np.int64)
        self._smallest_steps.append(float(steps.min()))
        # A half is not enough: some steps of jittering stamps are always small. A step back proves
        # jitter, however regular the other steps are. A step forward then does not prove a gap.
        steady = np.mean(np.array(self._steps) < STEADY) > MOST
        if steady and min(self._smallest_steps) > -EARLIEST:
            self._late = 0
            lost = np.where(steps > 0.5, np.rint(steps), 0.0).astype(np.int64)
            numbers = self._end + places + np.cumsum(lost)
        else:
            numbers = self._end + places
            missing = self._count_missing(stamps, numbers)
            accepted = min(missing, self._late)
            numbers += accepted
            self._late = 0 if accepted else missing
        self._end = int(numbers[-1]) + 1
        if self._late:  # delayed or lost? the next chunk decides
            return numbers
        lateness = (stamps - self._zero) * self._rate - numbers
        self._centres.append((float(numbers.mean()), float(np.median(lateness))))
        return numbers

    def _interpolate_unusable(self, stamps: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return time stamps, s, in which interpolated stamps replace the unusable ones."""
        good = usable_stamps(stamps)
        if good.all():
            return stamps
        places = np.arange(len(stamps))
        if not good.any():
            return self._last + (places + 1) / self._rate
        # Interpolate along the stated rate, so that stamps at both ends advance.
        offsets = np.interp(places, places[good], stamps[good] - places[good] / self._rate)
        repaired: NDArray[np.float64] = offsets + places / self._rate
        return repaired

    def _count_missing(self, stamps: NDArray[np.float64], numbers: NDArray[np.int64]) -> int:
        """Return the number of samples that are missing before some received samples.

        ``stamps`` are the time stamps of the received samples, s, and ``numbers`` their numbers if
        no sample is missing. Return 0 if jitter may explain the delay.
        """
        assert self._zero is not None
        if len(self._centres) < LEAST:
            return 0
        places, lateness = np.array(self._centres).T
        slope, offset = np.polyfit(places - places[0], lateness, 1)
        residuals = lateness - slope * (places - places[0]) - offset
        sigma = 1.4826 * float(np.median(np.abs(residuals - np.median(residuals))))
        # Lower bound: the scatter of single stamps divided by the root of the chunk's length.
        single = float(np.median(self._steps)) / (0.6745 * 2**0.5)
        sigma = max(sigma, 1.2533 * single / len(stamps) ** 0.5)
        chunk_lateness = float(np.median((stamps - self._zero) * self._rate - numbers))
        jump = chunk_lateness - float(slope * (numbers.mean() - places[0]) + offset)
        return round(jump) if jump > max(SIGMAS * sigma, SMALLEST) else 0


def usable_stamps(stamps: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return a mask of the time stamps, s, that are finite and in range, shape (samples,)."""
    usable: NDArray[np.bool_] = np.abs(stamps) <= LARGEST_STAMP
    return usable
