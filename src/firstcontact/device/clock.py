"""Sampling rate and sample times of a device, measured with this computer's monotonic clock.

Both are fitted to the least delayed blocks, because buffers delay blocks but never make them early.
The drift of the device's clock is measured, but signals are never corrected for it.
"""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block

#: Longest time over which the rate is fitted, s.
LONGEST = 600
#: Shortest time over which the rate is fitted, s.
LEAST = 5.0
#: The least delay within this time counts as no delay, s.
MEMORY = 10
#: Largest share by which the stamps run slower than the device's clock, to correct stamps that are
#: too late.
SLEW = 0.05
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


class _ArrivalTime(NamedTuple):
    delay: float
    sample: float
    host: float


class _FastestArrivals:
    """List of the least delayed arrival of a sample in each of the last ``seconds`` seconds.

    ``rate`` is the sampling rate, Hz.
    """

    def __init__(self, rate: float, seconds: int) -> None:
        self._rate = rate
        self.arrivals: deque[_ArrivalTime] = deque(maxlen=seconds + 1)

    def add(self, sample: int, host: float) -> bool:
        """Add the sample number ``sample``, which arrived at the time ``host``, s.

        Return True if this is the first arrival in a new second.
        """
        new = _ArrivalTime(host - sample / self._rate, float(sample), host)
        first = not self.arrivals or int(host) != int(self.arrivals[-1].host)
        if first:
            self.arrivals.append(new)
        elif new.delay < self.arrivals[-1].delay:
            self.arrivals[-1] = new
        return first

    def delay(self, since: float) -> float:
        """Return the least delay of the arrivals since the time ``since``, s.

        The delay is the arrival minus ``sample / rate``. Only differences of delays have a meaning.
        """
        return min(a.delay for a in self.arrivals if a.host >= since)


class ClockFit:
    """Measurement of a sampling rate by this computer's clock, from a line through arrival times.

    The result is :attr:`rate`, Hz; 0 until it is measured.
    """

    def __init__(self, rate: float) -> None:
        self._fastest = _FastestArrivals(rate, LONGEST)
        self.rate = 0.0

    def add(self, sample: int, host: float) -> None:
        if not self._fastest.add(sample, host):
            return
        fastest = np.array(self._fastest.arrivals)[:-1]  # complete seconds
        if len(fastest) >= 3 and fastest[-1, 2] - fastest[0, 2] >= LEAST:
            _, samples, times = (fastest - fastest[0]).T
            self.rate = max(float(np.polyfit(times, samples, 1)[0]), 0.0)


class RateCheck:
    """Comparison of a stream's measured sampling rate with the stated one, Hz."""

    def __init__(self, stated: float) -> None:
        self._stated = stated
        self._begin: tuple[float, float] | None = None
        self._rates: deque[float] = deque(maxlen=KEPT)

    @property
    def rate(self) -> float:
        return float(np.median(self._rates)) if self._rates else 0.0

    def add(self, end: float, seconds: float, *, behind: bool = False) -> bool:
        """Add samples up to number ``end`` at the time ``seconds``. Return True for a wrong rate.

        ``behind`` is True if the samples waited in a buffer, so that ``seconds`` is too late.
        """
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


class TransportDelay:
    """Extra delay of samples on their way to the host.

    It is measured from the least delay of the last ten seconds. All times are s of the host's
    ``time.monotonic()``.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._epoch: int | None = None
        self._fastest = _FastestArrivals(rate, MEMORY)
        self.least = 0.0  #: Time of sample 0 with the shortest delay, s of the host's clock.

    def add(self, block: Block, host: float) -> None:
        if block.epoch != self._epoch:
            self._epoch = block.epoch
            self._fastest = _FastestArrivals(self._rate, MEMORY)
        if self._fastest.add(block.end - 1, host):
            self.least = self._fastest.delay(host - MEMORY)
        else:
            self.least = min(self.least, self._fastest.arrivals[-1].delay)

    def host_time(self, sample: int) -> float:
        """Return the time at which a sample would arrive with the least delay, s."""
        return sample / self._rate + self.least

    def delay(self, sample: int, host: float) -> float:
        """Return the extra delay of a sample that arrived at the time ``host``, s."""
        return max(host - sample / self._rate - self.least, 0.0)


class DeviceClock:
    """Converter of sample numbers to s of this computer's ``time.monotonic()``.

    It follows the least delayed blocks of the last ten seconds. Times never run backwards.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._epoch: int | None = None
        self._transport = TransportDelay(rate)
        self._applied = 0.0
        self._end = 0
        self._last = -np.inf

    def stamps(self, block: Block, host: float) -> NDArray[np.float64]:
        """Add a block that arrived at ``host``, s. Return the time of each sample, (samples,)."""
        self._transport.add(block, host)
        target = self._transport.least
        offset = self._applied
        if block.epoch != self._epoch:
            self._epoch = block.epoch
            self._end = block.first_sample
            offset = max(target, self._last + (1 - block.first_sample) / self._rate)
            self._applied = offset
        elapsed = (block.end - self._end) / self._rate
        self._applied = offset + max(target - offset, -SLEW * elapsed)
        numbers = np.arange(block.first_sample, block.end)
        share = (numbers + 1 - self._end) / max(1, block.end - self._end)
        self._end = block.end
        times: NDArray[np.float64] = numbers / self._rate + (
            offset + share * (self._applied - offset)
        )
        self._last = float(times[-1])
        return times

    def host_time(self, sample: int, epoch: int) -> float:
        """Return the time of a sample, s. For another epoch, return the newest sample's time."""
        return sample / self._rate + self._applied if epoch == self._epoch else self._last
