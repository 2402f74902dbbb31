"""Source of prepared samples, and a generator of a hand's closings."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block, Calibration, Finger, VibrationCalibration, fingertip_layout
from firstcontact.device import Arrival, Descriptor, Health, Source
from firstcontact.recording import Marker

LAYOUT = fingertip_layout()
RATE = LAYOUT.rate
#: Of the piezos at rest, V; the running motor is three times as loud.
FLOOR = 0.005
CALIBRATION = Calibration(tuple(VibrationCalibration(f, FLOOR) for f in Finger))
UNLOADED = 2000


class MemorySource(Source):
    """Source of prepared samples. Tests can add more while it is read."""

    name = "memory"
    descriptor = Descriptor(LAYOUT, "test", "made up", "", "synthetic")
    health = Health(True)

    def __init__(self, arrivals: Sequence[Arrival] = (), at_a_time: int = 20) -> None:
        self.marks: list[str] = []
        self.orders: list[str] = []
        self.left = list(arrivals)
        self._at_a_time = at_a_time

    @property
    def ended(self) -> bool:
        return not self.left

    def read(self, timeout: float, least: int = 1) -> list[Arrival]:
        taken, self.left = self.left[: self._at_a_time], self.left[self._at_a_time :]
        count = sum(len(a.block.data) for a in taken)
        self.health = replace(self.health, samples=self.health.samples + count)
        return taken

    def mark(self, text: str) -> None:
        self.marks.append(text)

    def order(self, text: str) -> None:
        self.orders.append(text)

    def close(self) -> None:
        self.left = []

    def __enter__(self) -> Self:
        return self


@dataclass(frozen=True)
class Touch:
    """Sample numbers of the events in one closing."""

    motor: int
    contacts: dict[Finger, int]


def samples(seconds: float) -> int:
    return round(seconds * RATE)


class Hand:
    """Generator of raw samples of a hand that closes repeatedly.

    ``strips`` are the fingers whose strips work. ``silent`` are the fingers whose piezo does not
    respond to a touch. ``loud`` scales the signal of the touch.
    """

    def __init__(self, seed: int = 0) -> None:
        self._rng = np.random.default_rng(seed)
        self._phases: list[NDArray[np.float64]] = []
        self.at = 0

    def phase(self, seconds: float, loud: float) -> NDArray[np.float64]:
        """Append some seconds to the columns: two piezos, V; two loads, 0 to 1; two strips."""
        out = np.zeros((samples(seconds), 6))
        out[:, :2] = loud * FLOOR * self._rng.standard_normal((len(out), 2))
        self._phases.append(out)
        self.at += len(out)
        return out

    def pause(self, seconds: float = 0.4) -> None:
        self.phase(seconds, 1.0)

    def close(
        self,
        *,
        strips: Sequence[Finger] = tuple(Finger),
        silent: Sequence[Finger] = (),
        loud: float = 1.0,
        offset: float = 0.015,
        late_strip: float = 0.0,
    ) -> Touch:
        motor = self.at
        self.phase(0.2, 3.0)
        contact_sample = self.at
        touching = self.phase(0.12, 3.0)
        first_finger = Finger(int(self._rng.integers(2)))
        starts = {first_finger: 0, first_finger.other: samples(offset)}
        t = np.arange(len(touching)) / RATE
        ring = 0.3 * loud * np.exp(-t / 0.01) * np.sin(2 * np.pi * 150 * t)
        for finger, start in starts.items():
            n = len(t) - start
            if finger not in silent:
                touching[start:, finger] += ring[:n]
            if finger in strips:
                touching[start + samples(late_strip) :, 4 + finger] = 1
            touching[start:, 2 + finger] = np.minimum(t[:n] / 0.05, 1.0)
        hold = self.phase(0.3, 1.0)
        hold[:, 2:4] = 1
        hold[:, [4 + f for f in strips]] = 1
        opening = self.phase(0.25, 3.0)
        opening[:, 2:4] = np.exp(-np.arange(len(opening)) / RATE / 0.03)[:, None]
        self.pause()
        return Touch(motor, {f: contact_sample + start for f, start in starts.items()})

    def raw(self) -> NDArray[np.int16]:
        """Return the whole signal as the device sends it."""
        x = np.concatenate(self._phases)
        out = np.zeros((len(x), 16), dtype=np.int16)
        piezo = LAYOUT.channels[0]
        out[:, :2] = np.clip(x[:, :2] / piezo.scale + piezo.offset, 0, 32_736)
        out[:, 2:8] = (UNLOADED + 8000 * x[:, 2])[:, None]
        out[:, 8:14] = (UNLOADED + 8000 * x[:, 3])[:, None]
        out[:, 14:] = x[:, 4:]
        return out


def arrivals(
    data: NDArray[np.int16],
    length: int = 50,
    markers: Sequence[Marker] = (),
    first: int = 0,
    epoch: int = 0,
) -> list[Arrival]:
    """Cut samples into blocks. Attach the markers to their blocks."""
    cut_arrivals = []
    for start in range(0, len(data), length):
        block = Block(data[start : start + length], first + start, epoch)
        block_markers = tuple(m for m in markers if block.first_sample <= m.sample < block.end)
        cut_arrivals.append(Arrival(block, 0.0, block_markers))
    return cut_arrivals
