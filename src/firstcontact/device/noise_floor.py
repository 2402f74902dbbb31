"""Measurement of the vibration sensors' noise while the hand rests without contact."""

from __future__ import annotations

import logging
from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    Block,
    Calibration,
    ChannelKind,
    DeviceError,
    Layout,
    VibrationCalibration,
    finger_name,
)
from firstcontact.core.plausible import same_signal_warning
from firstcontact.device.source import Arrival, Source

_log = logging.getLogger("firstcontact.device")

#: Length of the parts of a stream that are each judged as at rest or not, s: whole periods of 50
#: and 60 Hz.
PART = 0.1
#: A part is at rest if each sensor's RMS is within this factor of its level at rest. The RMS of
#: parts at rest scatters by about 5 %. A running motor doubles it or more.
STEADY = 1.4
#: Number of parts that must agree on the level of rest. Fewer are from a dropout or a fade-in.
AGREEING = 5
#: Time after which a level of rest is forgotten, s. So an input whose gain rises is measured, too.
RECENT = 5.0
#: Smallest range of a signal, as a share of its largest value. A resampler leaves less on a
#: constant.
RIPPLE = 1e-5
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


class RestMeter:
    """Meter of the vibration sensors' noise. It uses only the parts of a stream that are at rest.

    Feed it by :meth:`update` until :attr:`is_sufficient` (``seconds`` of rest), then call
    :meth:`calibration`.
    """

    def __init__(self, layout: Layout, seconds: float = 2.0) -> None:
        self._fingers = fingers = layout.vibration_fingers
        if not fingers:
            raise DeviceError(
                "the source has no vibration channel, so there is no noise to measure: leave the "
                "calibration out"
            )
        self._layout = layout
        self._length = max(2, round(PART * layout.rate))
        self._wanted = max(1, round(seconds / PART))
        self._vibration = list(layout.columns(ChannelKind.VIBRATION))
        self._strips = [list(layout.columns(ChannelKind.STRIP, f)) for f in fingers]
        self._taxels = [list(layout.columns(ChannelKind.FORCE, f)) for f in fingers]
        self._waiting = np.zeros((0, layout.width))
        self._next = (0, 0)
        #: For each part: mean and RMS of the piezos, closed strips, and mean of each column.
        self._means, self._rms = np.zeros((2, 0, len(fingers)))
        self._closed = np.zeros((0, len(fingers)), np.bool_)
        self._levels = np.zeros((0, layout.width))
        self.samples = 0  #: number of samples so far

    def update(self, block: Block) -> None:
        """Process the next block of samples. Gaps between blocks are allowed."""
        self.samples += len(block.data)
        x = self._layout.physical(block.data, tuple(range(self._layout.width)))
        if (block.first_sample, block.epoch) == self._next:
            x = np.concatenate([self._waiting, x])
        self._next = (block.end, block.epoch)
        count = len(x) // self._length
        self._waiting = x[count * self._length :]
        if not count:
            return
        parts = x[: count * self._length].reshape(count, self._length, -1)
        piezos = parts[:, :, self._vibration]
        is_flat = np.ptp(piezos, axis=1) <= RIPPLE * np.abs(piezos).max(axis=1)
        rms = np.where(is_flat, 0.0, piezos.std(axis=1))
        closed = [(parts[:, :, strips] > 0).any(axis=(1, 2)) for strips in self._strips]
        self._means = np.concatenate([self._means, piezos.mean(axis=1)])
        self._rms = np.concatenate([self._rms, rms])
        self._closed = np.concatenate([self._closed, np.stack(closed, axis=1)])
        self._levels = np.concatenate([self._levels, parts.mean(axis=1)])

    @property
    def is_sufficient(self) -> bool:
        return int(self._at_rest().sum()) >= self._wanted

    def calibration(self) -> Calibration:
        """Return the noise and the offset of each vibration sensor over the parts at rest.

        Raises DeviceError with the :meth:`obstacles` if there are too few such parts.
        """
        if not self.is_sufficient:
            faults = "; ".join(self.obstacles())
            raise DeviceError(f"the noise floor cannot be measured, because {faults}")
        at_rest = self._at_rest()
        noise = np.sqrt(np.mean(self._rms[at_rest] ** 2, axis=0))
        offset = self._means[at_rest].mean(axis=0)
        piezo = tuple(
            VibrationCalibration(f, float(n), float(o))
            for f, n, o in zip(self._fingers, noise, offset, strict=True)
        )
        return Calibration(piezo, created=datetime.now(UTC).isoformat(timespec="seconds"))

    def obstacles(self) -> list[str]:
        """Return the reason and the remedy for each finger that is not at rest, as sentences."""
        messages: list[str] = []
        silent: list[str] = []
        for column, finger in enumerate(self._fingers):
            faults = self._disturbances()[:, :, column]
            flat, strip, force, loud = faults.mean(axis=1) if faults.size else np.zeros(4)
            sensor = self._layout.vibration[column].sensor
            name = finger_name(finger)
            sensor_name = f"the {sensor}" if finger is None else f"the {name}'s {sensor}"
            # Report the most basic fault first: a closed strip also explains a loud piezo.
            if flat > 0.5:
                number = self._vibration[column] + 1
                silent.append(
                    f"{sensor_name} (channel {number}) is silent or constant: check its plug and "
                    "buffer, or leave the channel out"
                )
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
        # While a sensor is silent, no part is at rest, so the others need no remedy.
        return (
            silent
            or messages
            or ["few samples came: check the connection, or that the recording is long enough"]
        )

    def _disturbances(self) -> NDArray[np.bool_]:
        """Return a mask of the reasons why parts are not at rest, shape (4, parts, fingers).

        The four reasons are a constant signal, a closed strip, a force, and a noise that differs
        from the noise at rest.
        """
        flat = self._rms == 0.0
        if not len(flat):
            return np.zeros((4, *flat.shape), np.bool_)
        is_loaded = self._levels > np.minimum(self._levels.min(axis=0) + RISEN, LOADED)
        loaded = np.stack([is_loaded[:, taxels].any(axis=1) for taxels in self._taxels], axis=1)
        free = ~(flat | self._closed | loaded).any(axis=1)
        free &= np.arange(len(free)) >= len(free) - RECENT / PART
        level = self._quiet_level(np.sort(self._rms[free] if free.any() else self._rms, axis=0))
        is_loud = (STEADY * self._rms < level) | (self._rms > STEADY * level)
        return np.stack([flat, self._closed, loaded, is_loud])

    def _quiet_level(self, rms: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the RMS of each sensor at rest, shape (sensors,).

        ``rms`` has the RMS in each part of the stream in rising order, shape (parts, sensors). The
        result is the lowest RMS that several parts share, or else the lowest of all.
        """
        others = min(AGREEING, len(rms)) - 1
        is_shared = rms[others:] <= STEADY * rms[: len(rms) - others]
        # If no level is shared, argmax gives 0, the lowest.
        return np.asarray(np.take_along_axis(rms, is_shared.argmax(axis=0)[None], axis=0)[0])

    def _at_rest(self) -> NDArray[np.bool_]:
        return np.asarray(~self._disturbances().any(axis=(0, 2)))


def wait_for_arrivals(source: Source) -> list[Arrival]:
    """Return the next samples, at least one. Raise DeviceError if none arrive within 2 s."""
    for _ in range(WAITS):
        if source.ended:
            break
        if arrivals := source.read(SILENCE / WAITS):
            return arrivals
    raise DeviceError(
        f"{source.name} sends no samples: check its connection, or that the recording is long "
        "enough"
    )


def measure_noise(source: Source, seconds: float = REST, patience: float = PATIENCE) -> Calibration:
    """Measure the noise and the offset of each vibration sensor of an open source.

    Wait until the hand was at rest for ``seconds`` s. Raise DeviceError if it was not within
    ``patience`` s more. Log a warning if both signals are the same.
    """
    layout = source.descriptor.layout
    meter, columns = RestMeter(layout, seconds), layout.columns(ChannelKind.VIBRATION)
    signals = [np.zeros((0, len(columns)))]
    least, most = (s * source.descriptor.layout.rate for s in (seconds, seconds + patience))
    while not meter.is_sufficient and meter.samples < most:
        if source.ended and meter.samples >= least:
            break
        for arrival in wait_for_arrivals(source):
            meter.update(arrival.block)
            signals.append(arrival.block.data[:, columns])
    names = [layout.column_names[column] for column in columns]
    if doubt := same_signal_warning(names, np.concatenate(signals), is_noise=True):
        _log.warning("%s: %s", source.name, doubt)
    return meter.calibration()
