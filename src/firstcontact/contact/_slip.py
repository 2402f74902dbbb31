"""What a slip detector is, and one that hears it: the pad rubs, and goes on rubbing."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfilt

from firstcontact.core import Block, ChannelKind, Layout, Physical
from firstcontact.signal import samples_in

#: Below this the hand swings with what it holds, and motors hum, Hz.
LOWEST = 400.0
#: Loudness is judged over pieces of this length, s,
PIECE = 0.0025
#: and a slip is as loud as that in so many pieces one after the other: a knock is not.
PIECES = 4
#: The rest of a hold is learned from its first so long, s;
LEARNED = 0.1
#: then it is followed this slowly, s.
FOLLOWED = 1.0
#: A slip that goes on is told again after so long, s.
AGAIN = 0.05
#: Of the mean square, over that of the rest: by one alarm a minute of quiet holds of one hand of
#: the twin, and by no slip (``benchmarks/slip.py``).
THRESHOLD = 1.5


class SlipDetector(ABC):
    """Tells from the vibration of a held object that it slips, block by block."""

    #: Under which it is registered.
    name: ClassVar[str]

    @abstractmethod
    def start(self, layout: Layout) -> None:
        """A stream of this layout begins; nothing is held."""

    @abstractmethod
    def hold(self) -> None:
        """From the next sample on something is held; said again where the hold has changed."""

    @abstractmethod
    def release(self) -> None:
        """Nothing is held any more."""

    @abstractmethod
    def update(self, block: Block) -> list[int]:
        """Take the next block.

        Returns
        -------
        list of int
            Numbers of samples with which a slip was known, or known to go on.
        """


class PowerSlipDetector(SlipDetector):
    """Both fingers together are louder than at rest, above 400 Hz, for 10 ms on end.

    Causal; how a stream is cut into blocks changes nothing. What shakes for less than 7.5 ms is no
    slip. A motor that starts to run is as loud as a slip: say :meth:`hold` again after an order.

    Parameters
    ----------
    threshold
        Mean square over that of the rest.
    """

    name = "power"

    def __init__(self, threshold: float = THRESHOLD) -> None:
        self.threshold = threshold

    def start(self, layout: Layout) -> None:
        """A stream of this layout begins; nothing is held."""
        columns = layout.columns(ChannelKind.VIBRATION)
        self._volts = Physical(layout, columns)
        self._sections = np.asarray(
            butter(2, min(LOWEST, 0.2 * layout.rate), "highpass", fs=layout.rate, output="sos")
        )
        self._state = np.zeros((len(self._sections), 2, len(columns)))
        self._piece = samples_in(PIECE, layout.rate)
        self._learned = round(LEARNED / PIECE)
        self._follow = PIECE / FOLLOWED
        self._again = round(AGAIN / PIECE)
        self._first = True
        self._next = 0
        self._epoch = 0
        self.release()

    def hold(self) -> None:
        """Learn the rest anew from the next sample on."""
        self._held = True
        self._part = np.zeros((0, self._state.shape[2]))
        self._rest: NDArray[np.float64] | None = None
        self._sum = np.zeros(self._state.shape[2])
        self._count = 0
        self._loud: list[float] = []
        self._silent = 0
        #: Of the newest piece: how loud it and those before it were at least; NaN while unknown.
        self.loudness = float("nan")

    def release(self) -> None:
        """Nothing is held any more."""
        self.hold()
        self._held = False

    def update(self, block: Block) -> list[int]:
        """Take the next block; where samples are missing the rest is learned anew."""
        follows = block.first_sample == self._next and block.epoch == self._epoch
        self._next, self._epoch = block.end, block.epoch
        if not len(block.data):
            return []
        volts = self._volts(block.data)
        if self._first or not follows:
            self._first = False
            # As if the first sample had gone on for ever before.
            self._state[:] = 0.0
            gain = self._sections[:, :3].sum(axis=1) / self._sections[:, 3:].sum(axis=1)
            assert np.allclose(gain, 0.0), "a high-pass stops what stands still"
            self._offset = volts[0].copy()
            if self._held:
                self.hold()
        high, self._state = sosfilt(self._sections, volts - self._offset, axis=0, zi=self._state)
        if not self._held:
            return []
        begin = block.end - len(block.data) - len(self._part)
        self._part = np.concatenate([self._part, high])
        found = []
        done = 0
        while done + self._piece <= len(self._part):
            power = np.mean(self._part[done : done + self._piece] ** 2, axis=0)
            done += self._piece
            if self._slips(power):
                found.append(begin + done - 1)
        self._part = self._part[done:]
        return found

    def _slips(self, power: NDArray[np.float64]) -> bool:
        """Whether a slip is known, or known to go on, with this piece."""
        if self._rest is None:
            self._sum += power
            self._count += 1
            if self._count == self._learned:
                self._rest = np.maximum(self._sum / self._count, np.finfo(float).tiny)
            return False
        over = power / self._rest
        self._loud = [*self._loud[1 - PIECES :], float(over.mean())]
        self._silent = max(self._silent - 1, 0)
        if len(self._loud) < PIECES:
            return False
        self.loudness = min(self._loud)
        if self.loudness <= self.threshold:
            self._rest *= 1.0 + self._follow * (np.minimum(over, 2.0) - 1.0)
            return False
        if self._silent:
            return False
        self._silent = self._again
        return True
