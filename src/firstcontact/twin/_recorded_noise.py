"""Noise of a real sensor at rest, to be put under simulated pinches."""

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

#: Less than this is too little to draw from, s.
LEAST = 2.0
#: What is louder than so many times the usual tenth of a second is no rest.
LOUD = 4.0


@dataclass(frozen=True, slots=True, eq=False)
class RecordedNoise:
    """What vibration sensors said at rest, at the fingertip's rate, before any smoothing.

    Parameters
    ----------
    volts
        Around 0, shape (samples, 1 or 2): of both fingers the same sensor, or one each.
    name
        Of the file.
    digest
        SHA-256 of the file, hexadecimal.
    """

    volts: NDArray[np.float64]
    name: str
    digest: str

    @property
    def said(self) -> str:
        """What a header says of it."""
        return (
            f"noise of {self.name} (sha256 {self.digest}) in place of the modelled electronics "
            "and hum, from places that the seed draws"
        )

    def draw(
        self, samples: int, rng: np.random.Generator
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Noise of index and thumb for a stretch: of two sensors at the same time, V.

        Where the recording is too short for it, it goes round.
        """
        starts = rng.integers(0, max(1, len(self.volts) - samples + 1), 2)
        if self.volts.shape[1] > 1:
            starts[1] = starts[0]
        index, thumb = (
            np.take(self.volts[:, f % self.volts.shape[1]], start + np.arange(samples), mode="wrap")
            for f, start in enumerate(starts)
        )
        return index, thumb


def read_noise(path: Path) -> RecordedNoise:
    """A recording of sensors at rest.

    The longest stretch without a gap is taken. A smoothing that the device did is undone, since
    the twin's does it again; another rate is brought to the fingertip's by the causal resampler.

    Raises
    ------
    InputError
        It is no recording, in another unit than V or full scale (which stands for 1.65 V), too
        short, or not at rest.
    """
    recording = read_recording(path)
    layout = recording.header.layout
    units = {c.unit for c in layout.vibration}
    if not units <= {"V", "full scale"}:
        raise InputError(
            f"{path} is in {', '.join(sorted(units))}: its noise is needed in V, so import it with "
            "its unit"
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
            f"{path} is not at rest throughout, or its sensor is dead: record it with nothing "
            "touching and nothing moving"
        )
    return RecordedNoise(volts, path.name, hashlib.sha256(path.read_bytes()).hexdigest())


def _unsmoothed(layout: Layout, data: NDArray[Any]) -> NDArray[np.float64]:
    """Vibration in V as it was before the device's exponential smoothing, shape (samples, n)."""
    columns = layout.columns(ChannelKind.VIBRATION)[:2]
    channels = layout.vibration[: len(columns)]
    volts = layout.physical(data, columns)
    volts *= [PIEZO_OFFSET_VOLTS if c.unit == "full scale" else 1.0 for c in channels]
    alphas = np.array([c.smoothing_alpha for c in channels])
    before = np.concatenate([volts[:1], volts[:-1]])
    out: NDArray[np.float64] = (volts - (1 - alphas) * before) / alphas
    return out
