"""Measurement of the vibration sensors' noise floor, without contact and with the motor at rest.

The stream is divided into parts of 0.1 s (:data:`PART`). Each part counts as at rest or not.
"""

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

#: Length of the parts of a stream that are each judged as at rest or not, s: whole periods of 50
#: and 60 Hz.
PART = 0.1
#: A part is at rest if no sensor's RMS exceeds its smallest RMS by this factor. The RMS of parts at
#: rest scatters by about 5 %. A running motor doubles it or more.
STEADY = 1.4
#: A taxel is loaded if it is above its lowest level by this, V, or above ``LOADED``. Unloaded
#: Velostat creeps back below it within a second.
RISEN = 0.4
LOADED = 1.0
#: Rest that is measured before a session without a calibration, and the longest wait for it, s.
REST = 1.0
PATIENCE = 30.0
#: Longest wait for samples, s, and the number of waits that it is divided into. Time in which this
#: process was stopped is not counted as waiting.
SILENCE, WAITS = 2.0, 4


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """Statistics of one part of the stream. All shapes are (fingers,)."""

    mean: NDArray[np.float64]
    rms: NDArray[np.float64]
    strip: NDArray[np.bool_]
    force: tuple[NDArray[np.float64], ...]  # level of each finger's taxels, V

    @property
    def flat(self) -> NDArray[np.bool_]:
        return np.asarray(self.rms == 0.0)


class RestMeter:
    """Meter of the vibration sensors' noise in a stream. It uses only the parts at rest."""

    def __init__(self, layout: Layout, seconds: float = 2.0) -> None:
        self._fingers = layout.vibration_fingers
        if not self._fingers:
            raise InputError(
                "the source has no vibration channel, so there is no noise to measure: leave the "
                "calibration out"
            )
        self._layout = layout
        self._length = max(2, round(PART * layout.rate))
        self._wanted = max(1, round(seconds / PART))
        self._every = tuple(range(layout.width))
        self._vibration = layout.columns(ChannelKind.VIBRATION)
        self._parts: list[_Part] = []
        self._waiting: NDArray[np.float64] | None = None
        self._next = (0, 0)
        self.samples = 0  #: number of samples so far

    def update(self, block: Block) -> None:
        """Process the next block. A part never spans a gap."""
        self.samples += len(block.data)
        x = self._layout.physical(block.data, self._every)
        if self._waiting is not None and (block.first_sample, block.epoch) == self._next:
            x = np.concatenate([self._waiting, x])
        self._next = (block.end, block.epoch)
        end = len(x) // self._length * self._length
        for start in range(0, end, self._length):
            self._parts.append(self._part(x[start : start + self._length]))
        self._waiting = x[end:]

    @property
    def is_sufficient(self) -> bool:
        """Return True once enough of the stream was at rest."""
        return int(self._rest_mask().sum()) >= self._wanted

    def calibration(self) -> Calibration:
        """Return noise floor and offset of each vibration sensor over all parts at rest so far."""
        at_rest = self._rest_mask()
        if int(at_rest.sum()) < self._wanted:
            raise InputError(f"the noise floor cannot be measured: {'; '.join(self.obstacles())}")
        parts = [p for p, is_rest in zip(self._parts, at_rest, strict=True) if is_rest]
        noise = np.sqrt(np.mean([p.rms**2 for p in parts], axis=0))
        offset = np.mean([p.mean for p in parts], axis=0)
        piezo = tuple(
            VibrationCalibration(f, float(n), float(o))
            for f, n, o in zip(self._fingers, noise, offset, strict=True)
        )
        return Calibration(piezo, created=datetime.now(UTC).isoformat(timespec="seconds"))

    def obstacles(self) -> list[str]:
        """Return one message for each finger that is not at rest: the reason and the remedy."""
        messages = []
        faults = self._faults(self._parts)
        for column, finger in enumerate(self._fingers):
            flat, strip, force, loud = (fault[:, column].mean() for fault in faults)
            sensor = self._layout.vibration[column].sensor
            name = finger_name(finger)
            sensor_name = f"the {sensor}" if finger is None else f"the {name}'s {sensor}"
            # Report the most basic fault first: a closed strip also explains a loud piezo.
            if flat > 0.5:
                messages.append(f"{sensor_name} is constant: check its plug and buffer")
            elif max(strip, force) > 0 and max(strip, force) >= loud:
                fault = "strip is closed" if strip >= force else "force is above its unloaded level"
                messages.append(f"the {name}'s {fault}: remove what it touches")
            elif loud > 0:
                remedy = (
                    "touch nothing, and reduce noise nearby"
                    if finger is None
                    else "stop the motor and keep the hand still"
                )
                messages.append(f"{sensor_name} is not at rest: {remedy}")
        return messages or ["too few samples: check the connection"]

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
        """Return four masks of faults, each of shape (parts, fingers)."""
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

    def _rest_mask(self) -> NDArray[np.bool_]:
        """Return True for each part at rest, shape (parts,)."""
        flat, strip, force, loud = self._faults(self._parts)
        return np.asarray(~(flat | strip | force | loud).any(axis=1))


def wait_for_arrivals(source: Source) -> list[Arrival]:
    """Return the next samples, at least one.

    Raises
    ------
    InputError
        No samples arrive within 2 s.
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
    """Measure noise floor and offset of each vibration sensor of an open source.

    A hand that closes repeatedly is measured between its closings.

    Parameters
    ----------
    source
        Open source.
    seconds
        Time at rest that the measurement needs, s of the device's time.
    patience
        Longest time that may pass beyond ``seconds``, s of the device's time.

    Raises
    ------
    InputError
        There is a contact, a piezo is loud or dead, or no samples arrive. The message names the
        finger and the remedy.
    """
    meter = RestMeter(source.descriptor.layout, seconds)
    most = (seconds + patience) * source.descriptor.layout.rate
    while not meter.is_sufficient and meter.samples < most:
        for arrival in wait_for_arrivals(source):
            meter.update(arrival.block)
    return meter.calibration()
