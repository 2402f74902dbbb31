"""What the vibration sensors say with nothing touching and the motor at rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    Block,
    Calibration,
    ChannelKind,
    InputError,
    Layout,
    VibrationCalibration,
    finger_name,
)
from firstcontact.device._source import Arrival, Source

#: Rest is judged in parts of this length, s: whole periods of 50 and of 60 Hz.
PART = 0.1
#: A part is at rest if no sensor is louder than its quietest part by this factor. The
#: RMS of a part scatters by about 5 %; a running motor is twice as loud or more.
STEADY = 1.4
#: A taxel this far above its lowest level is loaded, V; so is one above ``LOADED``.
#: Velostat that was let go creeps back through the last of it within a second.
RISEN = 0.4
LOADED = 1.0
#: Rest that is measured before a session without a calibration, and the longest wait for it, s.
REST = 1.0
PATIENCE = 30.0
#: Longest wait for the next samples, s, as so many waits: a process that was stopped for longer
#: did not listen.
SILENCE, WAITS = 2.0, 4


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """One part of the stream; all shapes (fingers,)."""

    mean: NDArray[np.float64]
    rms: NDArray[np.float64]
    strip: NDArray[np.bool_]
    force: tuple[NDArray[np.float64], ...]  # of each finger: taxels, V

    @property
    def flat(self) -> NDArray[np.bool_]:
        return np.asarray(self.rms == 0.0)


class RestMeter:
    """Collects parts of a stream in which nothing touches and nothing moves.

    Parameters
    ----------
    layout
        The columns of the blocks.
    seconds
        How much rest is wanted, s; it need not be in one piece.

    Raises
    ------
    InputError
        The layout has no vibration channel.
    """

    def __init__(self, layout: Layout, seconds: float = 2.0) -> None:
        self._fingers = layout.vibration_fingers
        if not self._fingers:
            raise InputError("the layout has no vibration channel: there is no noise to measure")
        self._layout = layout
        self._length = max(2, round(PART * layout.rate))
        self._wanted = max(1, round(seconds / PART))
        self._every = tuple(range(layout.width))
        self._vibration = layout.columns(ChannelKind.VIBRATION)
        self._parts: list[_Part] = []
        self._waiting: NDArray[np.float64] | None = None
        self._next = (0, 0)
        self.samples = 0  #: seen so far

    def update(self, block: Block) -> None:
        """Take the next block; a part never reaches across a gap."""
        self.samples += len(block.data)
        x = self._layout.physical(block.data, self._every)
        if self._waiting is not None and (block.first_sample, block.epoch) == self._next:
            x = np.concatenate([self._waiting, x])
        self._next = (block.end, block.epoch)
        whole = len(x) // self._length * self._length
        for start in range(0, whole, self._length):
            self._parts.append(self._part(x[start : start + self._length]))
        self._waiting = x[whole:]

    @property
    def done(self) -> bool:
        """Whether enough rest was seen."""
        return int(self._at_rest().sum()) >= self._wanted

    def calibration(self) -> Calibration:
        """Noise floor and offset of each vibration sensor over all rest seen.

        Raises
        ------
        InputError
            There is not enough of it; says what is in the way.
        """
        rest = self._at_rest()
        if int(rest.sum()) < self._wanted:
            raise InputError(f"the noise floor cannot be measured: {'; '.join(self.in_the_way())}")
        parts = [p for p, at_rest in zip(self._parts, rest, strict=True) if at_rest]
        noise = np.sqrt(np.mean([p.rms**2 for p in parts], axis=0))
        offset = np.mean([p.mean for p in parts], axis=0)
        piezo = tuple(
            VibrationCalibration(f, float(n), float(o))
            for f, n, o in zip(self._fingers, noise, offset, strict=True)
        )
        return Calibration(piezo, created=datetime.now(UTC).isoformat(timespec="seconds"))

    def in_the_way(self) -> list[str]:
        """What has kept the fingers from resting, and what to do, finger by finger."""
        said = []
        faults = self._faults(self._parts)
        for column, finger in enumerate(self._fingers):
            flat, strip, force, loud = (fault[:, column].mean() for fault in faults)
            sensor = self._layout.vibration[column].sensor
            name = finger_name(finger)
            what = f"the {sensor}" if finger is None else f"the {name}'s {sensor}"
            # The plainest fault first: one closed strip explains a loud piezo, too.
            if flat > 0.5:
                said.append(f"{what} does not move at all: check its plug and buffer")
            elif max(strip, force) > 0 and max(strip, force) >= loud:
                fault = "strip is closed" if strip >= force else "force is above its unloaded level"
                said.append(f"the {name}'s {fault}: take away what it touches")
            elif loud > 0:
                remedy = (
                    "touch nothing, and quieten the surroundings"
                    if finger is None
                    else "stop the motor and keep the hand still"
                )
                said.append(f"{what} does not rest: {remedy}")
        return said or ["too few samples came: check the connection"]

    def _part(self, x: NDArray[np.float64]) -> _Part:
        piezo = x[:, list(self._vibration)]
        strip, force = [], []
        for finger in self._fingers:
            strips = self._layout.columns(ChannelKind.STRIP, finger)
            strip.append(bool((x[:, list(strips)] > 0).any()))
            force.append(x[:, list(self._layout.columns(ChannelKind.FORCE, finger))].mean(axis=0))
        rms = np.where(np.ptp(piezo, axis=0) > 0, piezo.std(axis=0), 0.0)
        return _Part(piezo.mean(axis=0), rms, np.array(strip), tuple(force))

    def _faults(self, parts: Sequence[_Part]) -> tuple[NDArray[np.bool_], ...]:
        """Flat, strip closed, force, loud; each of shape (parts, fingers)."""
        none = np.zeros((0, len(self._fingers)), np.bool_)
        if not parts:
            return none, none, none, none
        flat = np.array([p.flat for p in parts])
        strip = np.array([p.strip for p in parts])
        force = np.zeros_like(strip)
        for column in range(len(self._fingers)):
            levels = np.array([p.force[column] for p in parts])
            if levels.shape[1]:
                limit = np.minimum(levels.min(axis=0) + RISEN, LOADED)
                force[:, column] = (levels > limit).any(axis=1)
        rms = np.array([p.rms for p in parts])
        free = ~(flat | strip | force).any(axis=1)
        quietest = rms[free].min(axis=0) if free.any() else rms.min(axis=0)
        return flat, strip, force, rms > STEADY * quietest

    def _at_rest(self) -> NDArray[np.bool_]:
        """Which parts are at rest, shape (parts,)."""
        flat, strip, force, loud = self._faults(self._parts)
        return np.asarray(~(flat | strip | force | loud).any(axis=1))


def wait_for_arrivals(source: Source) -> list[Arrival]:
    """Read what comes next, at least one sample.

    Raises
    ------
    InputError
        No samples come for 2 s.
    """
    for _ in range(WAITS):
        if arrivals := source.read(SILENCE / WAITS):
            return arrivals
    raise InputError(
        f"{source.name} sends no samples: check its connection, or that the recording is long "
        "enough"
    )


def measure_noise(
    source: Source,
    seconds: float = REST,
    patience: float = PATIENCE,
) -> Calibration:
    """Measure the noise floor and offset of each vibration sensor of an open source.

    A hand that closes again and again is measured between its closings.

    Parameters
    ----------
    source
        Open.
    seconds
        How much rest is wanted, s of the device's time.
    patience
        How much longer to wait for it, s of the device's time.

    Raises
    ------
    InputError
        Something touches, a piezo does not rest or is dead, or no samples come:
        which finger, and what to do.
    """
    meter = RestMeter(source.descriptor.layout, seconds)
    most = (seconds + patience) * source.descriptor.layout.rate
    while not meter.done and meter.samples < most:
        for arrival in wait_for_arrivals(source):
            meter.update(arrival.block)
    return meter.calibration()
