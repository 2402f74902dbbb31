"""The device's clock against the host's: how fast it runs, and when its samples were taken.

Both are read off the blocks that were least delayed on their way: what waits in buffers is late,
never early.
"""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block

#: The rate is fitted to so much time past, s.
LONGEST = 600
#: And told from no less than this, s.
LEAST = 5.0
#: The least delay of so much time past counts as no delay, s.
MEMORY = 10
#: How much faster or slower than the device's clock stamps may go to catch up ...
SLEW = 0.05
#: ... unless they are further off than this, s: then forward at once, backward
#: as far as stamps can still rise.
FAR = 0.25
STILL_RISING = 0.999


class _Arrived(NamedTuple):
    """When a sample had arrived at the host, s, and how long after its turn in the count."""

    delay: float
    sample: float
    host: float


class _LeastDelayed:
    """The arrival that was delayed least, of each of the last seconds.

    Parameters
    ----------
    rate
        Nominal rate of the samples, Hz.
    seconds
        How many are kept besides the one that is going on.
    """

    def __init__(self, rate: float, seconds: int) -> None:
        self._rate = rate
        self.arrivals: deque[_Arrived] = deque(maxlen=seconds + 1)

    def add(self, sample: int, host: float) -> bool:
        """Take the next arrival; whether it is the first of another second."""
        new = _Arrived(host - sample / self._rate, float(sample), host)
        first = not self.arrivals or int(host) != int(self.arrivals[-1].host)
        if first:
            self.arrivals.append(new)
        elif new.delay < self.arrivals[-1].delay:
            self.arrivals[-1] = new
        return first

    def delay(self, since: float) -> float:
        """The least delay of what arrived since then, s."""
        return min(a.delay for a in self.arrivals if a.host >= since)


class ClockFit:
    """How many samples come per second of the host's clock: a line through the arrivals.

    Parameters
    ----------
    rate
        Nominal, Hz.

    Attributes
    ----------
    rate
        Samples per second of the host's clock, Hz; 0 before it can be told.
    """

    def __init__(self, rate: float) -> None:
        self._arrived = _LeastDelayed(rate, LONGEST)
        self.rate = 0.0

    def add(self, sample: int, host: float) -> None:
        """A sample had arrived at a time of the host's clock, s."""
        if not self._arrived.add(sample, host):
            return
        over = np.array(self._arrived.arrivals)[:-1]  # seconds
        if len(over) >= 3 and over[-1, 2] - over[0, 2] >= LEAST:
            _, samples, times = (over - over[0]).T
            self.rate = max(float(np.polyfit(times, samples, 1)[0]), 0.0)


class TransportDelay:
    """Delay of samples on their way to the host, beyond that of the least delayed blocks.

    A block cannot arrive before its last sample was taken. So the least delayed block of the last
    ten seconds counts as not delayed. The shortest way through the cable is not known and is not
    in the delay.

    Parameters
    ----------
    rate
        Nominal rate of the samples, Hz.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._epoch: int | None = None
        self._arrived = _LeastDelayed(rate, MEMORY)
        self._least = 0.0

    def add(self, block: Block, host: float) -> None:
        """Take the next block, which arrived at a time of the host's clock, s."""
        if block.epoch != self._epoch:
            self._epoch = block.epoch
            self._arrived = _LeastDelayed(self._rate, MEMORY)
        self._arrived.add(block.end - 1, host)
        self._least = self._arrived.delay(host - MEMORY)

    def of(self, sample: int, host: float) -> float:
        """Return the delay, s, of a sample that was there at a time of the host's clock."""
        return max(host - sample / self._rate - self._least, 0.0)


class DeviceClock:
    """Times of samples, from their numbers and from when blocks arrived.

    A block cannot arrive before its last sample was taken. So the blocks that
    were least delayed in the last ten seconds tell when sample 0 would have
    been; all others are stamped by their sample numbers. A device whose clock is
    wrong by 100 parts per million is followed to within a millisecond. The
    shortest way through the cable is not known and stays in the stamps.

    Parameters
    ----------
    rate
        Nominal rate of the samples, Hz.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._epoch: int | None = None
        self._arrived = _LeastDelayed(rate, MEMORY)
        self._applied = 0.0
        self._end = 0
        self._last = -np.inf

    def stamps(self, block: Block, host: float) -> NDArray[np.float64]:
        """Host time of each sample of the next block.

        Parameters
        ----------
        block
            Of at least one sample; follows those before it in its epoch.
        host
            When it arrived, s.

        Returns
        -------
        ndarray
            Shape (samples,), s; rising, from call to call, too.
        """
        target = self._target(block, host)
        before = self._applied
        if block.epoch != self._epoch:
            self._epoch = block.epoch
            self._end = block.first_sample
            before = max(target, self._last + (1 - block.first_sample) / self._rate)
            self._applied = before
        elapsed = (block.end - self._end) / self._rate
        wanted = target - before
        up = np.inf if wanted > FAR else SLEW * elapsed
        down = (STILL_RISING if wanted < -FAR else SLEW) * elapsed
        self._applied = before + min(max(wanted, -down), up)
        places = np.arange(block.first_sample, block.end)
        share = (places + 1 - self._end) / max(1, block.end - self._end)
        self._end = block.end
        times: NDArray[np.float64] = places / self._rate + (
            before + share * (self._applied - before)
        )
        self._last = float(times[-1])
        return times

    def at(self, sample: int, epoch: int) -> float:
        """Host time of a sample, s; of another epoch than the newest, that of the newest sample."""
        return sample / self._rate + self._applied if epoch == self._epoch else self._last

    def _target(self, block: Block, host: float) -> float:
        if block.epoch != self._epoch:
            self._arrived = _LeastDelayed(self._rate, MEMORY)
        self._arrived.add(block.end - 1, host)
        return self._arrived.delay(host - MEMORY)
