"""The device's samples on the host's clock, without jitter and never backwards."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block

#: The least delay of so much time past counts as no delay, s.
MEMORY = 10.0
#: How much faster or slower than the device's clock stamps may go to catch up ...
SLEW = 0.05
#: ... unless they are further off than this, s: then forward at once, backward
#: as far as stamps can still rise.
FAR = 0.25
STILL_RISING = 0.999


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
        #: (host time, what the host was behind sample / rate), rising in both.
        self._least: deque[tuple[float, float]] = deque()
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
            self._least.clear()
        late = host - (block.end - 1) / self._rate
        while self._least and self._least[-1][1] >= late:
            self._least.pop()
        self._least.append((host, late))
        while self._least[0][0] < host - MEMORY:
            self._least.popleft()
        return self._least[0][1]
