"""Sample numbers from time stamps: along a tracked line, not from each stamp by itself."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

#: Largest time stamp, s: three thousand years.
LARGEST_STAMP = 1e11
#: Chunks that the line is told from: some seconds.
KEPT = 100
#: Chunks before gaps are believed of stamps that jitter.
LEAST = 20
#: Stamps that scatter less than this, in samples, tell of each sample by itself.
STEADY = 0.25
#: ... where so many of the last steps do.
MOST = 0.7
TOLD = 300
#: ... and none of the last chunks came sooner than its samples can be taken, by so much.
SOONER = 0.5
#: A gap shows where stamps are later than the line by so many times their scatter ...
SIGMAS = 6.0
#: ... and by so many samples.
SMALLEST = 2.0


class StampedSamples:
    """Numbers samples that come with stamps, and finds what is missing between them.

    Where stamps are as regular as the samples, a gap of one is found where it is. Where they
    jitter, or whole chunks are stamped by when they were sent, the median of a chunk is held
    against a line through those before it, which follows the clock's drift. A gap shorter than the
    scatter of these medians cannot be told from it, and one is counted with the chunk behind the
    first that is late: what comes late once was held up, and nothing is lost.

    Parameters
    ----------
    rate
        Nominal, Hz.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._zero: float | None = None
        self._end = 0  # number of the next sample
        self._last = 0.0  # stamp of the newest
        self._centres: deque[tuple[float, float]] = deque(maxlen=KEPT)
        self._steps: deque[float] = deque(maxlen=TOLD)
        self._soonest: deque[float] = deque(maxlen=KEPT)  # step of each chunk
        self._late = 0  # samples that the chunk before was late by, not yet counted

    def numbers(self, stamps: NDArray[np.float64]) -> NDArray[np.int64]:
        """Numbers of the samples of the next chunk.

        Parameters
        ----------
        stamps
            Of each sample, by the sender's clock, s, shape (samples,), at least one. A sample with
            an unusable stamp (:func:`usable_stamps`) follows the one before it.

        Returns
        -------
        ndarray
            Shape (samples,), rising.
        """
        stamps = self._repaired(stamps)
        if self._zero is None:
            self._zero, self._last = float(stamps[0]), float(stamps[0]) - 1 / self._rate
        steps = np.diff(stamps, prepend=self._last) * self._rate - 1.0
        self._last = float(stamps[-1])
        self._steps.extend(np.abs(steps).tolist())
        places = np.arange(len(stamps), dtype=np.int64)
        self._soonest.append(float(steps.min()))
        # Most of them, not half: of stamps that jitter a few steps are always small. And a step
        # back is jitter, however regular the others are: one forward is then no gap by itself.
        steady = np.mean(np.array(self._steps) < STEADY) > MOST
        if steady and min(self._soonest) > -SOONER:
            self._late = 0
            lost = np.where(steps > 0.5, np.rint(steps), 0.0).astype(np.int64)
            numbers = self._end + places + np.cumsum(lost)
        else:
            numbers = self._end + places
            missing = self._missing(stamps, numbers)
            believed = min(missing, self._late)
            numbers += believed
            self._late = 0 if believed else missing
        self._end = int(numbers[-1]) + 1
        if self._late:  # whether it was held up or something lacks is not known yet
            return numbers
        late = (stamps - self._zero) * self._rate - numbers
        self._centres.append((float(numbers.mean()), float(np.median(late))))
        return numbers

    def _repaired(self, stamps: NDArray[np.float64]) -> NDArray[np.float64]:
        """The stamps, with unusable ones between or behind those beside them."""
        good = usable_stamps(stamps)
        if good.all():
            return stamps
        places = np.arange(len(stamps))
        if not good.any():
            return self._last + (places + 1) / self._rate
        # Along the stated rate, so that stamps at the ends are no standstill.
        late = np.interp(places, places[good], stamps[good] - places[good] / self._rate)
        repaired: NDArray[np.float64] = late + places / self._rate
        return repaired

    def _missing(self, stamps: NDArray[np.float64], numbers: NDArray[np.int64]) -> int:
        """Samples that a chunk is late by, beyond its jitter, by the line through those before."""
        assert self._zero is not None
        if len(self._centres) < LEAST:
            return 0
        places, late = np.array(self._centres).T
        slope, offset = np.polyfit(places - places[0], late, 1)
        rest = late - slope * (places - places[0]) - offset
        sigma = 1.4826 * float(np.median(np.abs(rest - np.median(rest))))
        # No less than the scatter of single stamps leaves of a median of so many.
        single = float(np.median(self._steps)) / (0.6745 * 2**0.5)
        sigma = max(sigma, 1.2533 * single / len(stamps) ** 0.5)
        here = float(np.median((stamps - self._zero) * self._rate - numbers))
        jump = here - float(slope * (numbers.mean() - places[0]) + offset)
        return round(jump) if jump > max(SIGMAS * sigma, SMALLEST) else 0


def usable_stamps(stamps: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return True for each time stamp that is finite and in range; shape (samples,)."""
    usable: NDArray[np.bool_] = np.abs(stamps) <= LARGEST_STAMP
    return usable
