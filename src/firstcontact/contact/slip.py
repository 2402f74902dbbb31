"""Slip detectors: they detect from the fingers' vibration that a held object slides."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block, ChannelKind, Layout, Physical
from firstcontact.signal import samples_in

#: Lowest frequency, Hz. Below it the hand swings and motors hum.
LOWEST = 400.0
#: Length of the pieces in which loudness is measured, s.
PIECE = 0.0025
#: Number of consecutive loud pieces that make a slip. A knock is shorter.
PIECES = 4
#: Time at the start of a hold in which the rest level is learned, s.
LEARNED = 0.1
#: Time constant with which the rest level then adapts, s.
FOLLOWED = 1.0
#: Interval between reports of a slip that continues, s.
AGAIN = 0.05
#: Mean square relative to rest above which a piece is loud. It was chosen for one false alarm per
#: minute of quiet holds with one simulated hand, without any slip data
#: (``benchmarks/scores/slip.py``).
THRESHOLD = 1.5


class SlipDetector(ABC):
    """Base class of slip detectors, which detect from vibration that a held object slides."""

    #: Name on the command line and in the registry :data:`SLIP_DETECTORS`.
    name: ClassVar[str]

    @abstractmethod
    def start(self, layout: Layout) -> None:
        """Prepare for a new stream of samples with this layout. The hand holds no object yet."""

    @abstractmethod
    def hold(self) -> None:
        """Start to detect slips: from the next sample on, the hand holds an object.

        Call this method again after each command to the hand.
        """

    @abstractmethod
    def release(self) -> None:
        """Stop to detect slips: the hand holds no object any more."""

    @abstractmethod
    def update(self, block: Block) -> list[int]:
        """Process the next block. Return the device's numbers of samples that show a slip."""


@dataclass(slots=True)
class _Hold:
    """State of a slip detector while the hand holds an object.

    It stores the newest samples, and the power of the vibration without slip.
    """

    part: NDArray[np.float64]  # samples of the piece in progress
    sum: NDArray[np.float64]
    count: int = 0
    rest: NDArray[np.float64] | None = None
    loud: list[float] = field(default_factory=list)  # loudness of the newest pieces
    silent: int = 0  # pieces until a slip that continues is reported again


class PowerSlipDetector(SlipDetector):
    """Slip detector that fires if the fingers are loud above 400 Hz for 10 ms without a break.

    The loudness is the mean of both fingers. The detector is causal, and block sizes do not matter.
    A vibration shorter than 7.5 ms is no slip. A starting motor is as loud as a slip, so call
    :meth:`hold` again after each command to the hand.
    """

    name = "power"

    def __init__(self, threshold: float = THRESHOLD) -> None:
        self.threshold = threshold
        #: Least loudness of the newest pieces relative to rest; NaN while unknown.
        self.loudness = float("nan")
        self._volts: Physical | None = None
        self._piece = 1  # length of a piece in samples
        self._sections, self._state = np.zeros((0, 6)), np.zeros((0, 2, 0))
        self._offset = np.zeros(0)
        self._next: tuple[int, int] | None = None  # epoch and number of the next sample
        self._held: _Hold | None = None

    def start(self, layout: Layout) -> None:
        from scipy.signal import butter  # slow to import, and only some sessions detect slips

        columns = layout.columns(ChannelKind.VIBRATION)
        self._volts = Physical(layout, columns)
        self._sections = np.asarray(
            butter(2, min(LOWEST, 0.2 * layout.rate), "highpass", fs=layout.rate, output="sos")
        )
        self._state = np.zeros((len(self._sections), 2, len(columns)))
        self._piece = samples_in(PIECE, layout.rate)
        self._next = None
        self.release()

    def hold(self) -> None:
        """Start to detect slips. The level without slip is learned from the next samples first."""
        fingers = self._state.shape[2]
        self._held = _Hold(np.zeros((0, fingers)), np.zeros(fingers))
        self.loudness = float("nan")

    def release(self) -> None:
        self._held = None
        self.loudness = float("nan")

    def update(self, block: Block) -> list[int]:
        """Process the next block. Return the device's numbers of samples that show a slip.

        After missing samples, the level without slip is learned again.
        """
        from scipy.signal import sosfilt

        if not len(block.data):
            return []
        follows = self._next == (block.epoch, block.first_sample)
        self._next = block.epoch, block.end
        assert self._volts is not None, "start a stream first"
        volts = self._volts(block.data)
        if not follows:
            # Start the filter as if the first sample had always been there.
            self._state[:] = 0.0
            self._offset = volts[0].copy()
            if self._held is not None:
                self.hold()
        high, self._state = sosfilt(self._sections, volts - self._offset, axis=0, zi=self._state)
        hold = self._held
        if hold is None:
            return []
        begin = block.end - len(block.data) - len(hold.part)
        part = np.concatenate([hold.part, high])
        whole = len(part) // self._piece * self._piece
        hold.part = part[whole:]
        return [
            begin + start + self._piece - 1
            for start in range(0, whole, self._piece)
            if self._slips(hold, np.mean(part[start : start + self._piece] ** 2, axis=0))
        ]

    def _slips(self, hold: _Hold, power: NDArray[np.float64]) -> bool:
        """Return True at the start of a slip, and every 50 ms while the slip continues.

        ``power`` is that of the newest piece (2.5 ms) of samples, V², shape (fingers,).
        """
        if hold.rest is None:
            hold.sum += power
            hold.count += 1
            if hold.count == round(LEARNED / PIECE):
                hold.rest = np.maximum(hold.sum / hold.count, np.finfo(float).tiny)
            return False
        ratio = power / hold.rest
        hold.loud = [*hold.loud[1 - PIECES :], float(ratio.mean())]
        hold.silent = max(hold.silent - 1, 0)
        if len(hold.loud) < PIECES:
            return False
        self.loudness = min(hold.loud)
        if self.loudness <= self.threshold:
            hold.rest *= 1.0 + PIECE / FOLLOWED * (np.minimum(ratio, 2.0) - 1.0)
            return False
        if hold.silent:
            return False
        hold.silent = round(AGAIN / PIECE)
        return True
