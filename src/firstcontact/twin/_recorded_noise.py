"""Recorded noise of a real sensor at rest, for simulated pinches."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FINGERTIP_RATE, PIEZO_OFFSET_VOLTS, ChannelKind, InputError, Layout
from firstcontact.recording import read_recording
from firstcontact.signal import resample

#: Shortest usable recording, s.
LEAST = 2.0
#: A part louder than the median part by this factor is not at rest.
LOUD = 4.0


@dataclass(frozen=True, slots=True, eq=False)
class RecordedNoise:
    """Recorded noise of vibration sensors at rest, at the fingertip's rate, not smoothed."""

    volts: NDArray[np.float64]
    name: str
    digest: str

    @property
    def description(self) -> str:
        """Description of the noise, for the header of a recording."""
        return (
            f"noise of {self.name} (sha256 {self.digest}) in place of the modelled electronics "
            "and hum, from places that the seed draws"
        )

    def draw(
        self, samples: int, rng: np.random.Generator
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Draw a stretch of noise for index and thumb, V."""
        starts = rng.integers(0, max(1, len(self.volts) - samples + 1), 2)
        if self.volts.shape[1] > 1:
            starts[1] = starts[0]
        index, thumb = (
            np.take(self.volts[:, f % self.volts.shape[1]], start + np.arange(samples), mode="wrap")
            for f, start in enumerate(starts)
        )
        return index, thumb


def read_noise(path: Path) -> RecordedNoise:
    """Read the noise from a recording of sensors at rest.

    The longest stretch without a gap is used. The device's smoothing is undone, because the twin
    smooths again. Recordings at other rates are resampled to the fingertip's rate.

    Raises
    ------
    InputError
        The file is no recording, or is too short or not at rest. Or its unit is neither V nor full
        scale (taken as 1.65 V).
    """
    recording = read_recording(path)
    layout = recording.header.layout
    units = {c.unit for c in layout.vibration}
    if not units <= {"V", "full scale"}:
        raise InputError(
            f"{path} is in {', '.join(sorted(units))}, but the noise must be in V: import the "
            "recording again with its unit"
        )
    data = max((s.data for s in recording.stretches), key=len, default=None)
    if data is None or len(data) < LEAST * layout.rate:
        raise InputError(
            f"{path} has less than {LEAST:g} s without a gap: record the sensor at rest for longer"
        )
    volts = resample(_unsmoothed(layout, data), layout.rate, FINGERTIP_RATE)
    volts -= volts.mean(axis=0)
    part = round(0.1 * FINGERTIP_RATE)
    parts = volts[: len(volts) // part * part].reshape(-1, part, volts.shape[1]).std(axis=1)
    usual = np.median(parts, axis=0)
    if not usual.all() or (parts > LOUD * usual).any():
        raise InputError(
            f"{path} is not at rest throughout, or its sensor gives no signal: record the sensor "
            "while nothing touches it and nothing moves"
        )
    return RecordedNoise(volts, path.name, hashlib.sha256(path.read_bytes()).hexdigest())


def _unsmoothed(layout: Layout, data: NDArray[Any]) -> NDArray[np.float64]:
    """Return the vibration, V, without the device's exponential smoothing, (samples, channels)."""
    columns = layout.columns(ChannelKind.VIBRATION)[:2]
    channels = layout.vibration[: len(columns)]
    volts = layout.physical(data, columns)
    volts *= [PIEZO_OFFSET_VOLTS if c.unit == "full scale" else 1.0 for c in channels]
    alphas = np.array([c.smoothing_alpha for c in channels])
    previous = np.concatenate([volts[:1], volts[:-1]])
    out: NDArray[np.float64] = (volts - (1 - alphas) * previous) / alphas
    return out
