"""Noise of the motor, gears, mains and electronics, simulated or recorded.

The forces act on the phalanx (finger bone) and reach the piezo through the same mechanics as a
contact. They are neither white nor Gaussian.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ChannelKind, FileError, Layout
from firstcontact.core.installation import load_compiled
from firstcontact.core.layout import FINGERTIP_RATE, PIEZO_OFFSET_VOLTS
from firstcontact.recording import read_recording
from firstcontact.signal import resample

#: Points of the noise force for each sample, joined by straight lines.
OVERSAMPLING = 4
_RATE = OVERSAMPLING * FINGERTIP_RATE
_kernels = load_compiled("firstcontact.twin._compiled")
#: Frequency band of friction, Hz.
RUBBING_BAND = (30.0, 1500.0)
#: Second-order sections of that Butterworth band-pass at the series' rate: designing it needs
#: ``scipy.signal``, whose import takes longer than all else at the start of the simulated hand.
RUBBING = np.array([
    (0.040731778822964124, 0.08146355764592825, 0.040731778822964124,
     1.0, -1.3592450581888862, 0.5234788018791424),
    (1.0, -2.0, 1.0, 1.0, -1.9865166936878746, 0.9866107698732742),
])  # fmt: skip


@dataclass(frozen=True, slots=True)
class MotorNoise:
    """Strengths of the noise forces on a phalanx (finger bone), N, and their rates, Hz."""

    rotor_rate: float = 170.0
    """Turns of the rotor per second at the closing speed."""
    rotor: float = 0.05
    """Amplitude of the tone at the rotor's frequency, N: imbalance and commutation. Harmonic k has
    1/k of it."""
    mesh_ratio: float = 9.7
    """Frequency of the gears, relative to the rotor. A second pair of gears has 0.31 of it."""
    mesh: float = 0.05
    """Amplitude of the tone at the frequency of the gears, N. The output shaft modulates it."""
    friction: float = 0.035
    """RMS of the friction noise between 30 Hz and 1.5 kHz, N."""
    wander: float = 0.35
    """Standard deviation of ln(loudness of the friction), which changes over 20 ms."""
    click_rate: float = 0.5
    """Number of random clicks of the gears per second. The condition sets it."""
    click: float = 0.35
    """Median peak force of a click, N: half sines of 0.3 to 1.2 ms, either sign."""
    mains_rate: float = 50.0
    """Mains frequency, 50 or 60 Hz. The condition sets it."""
    mains: float = 0.015
    """Amplitude of the torque ripple at twice the mains frequency, N."""
    hum: float = 0.0015
    """Amplitude of the mains hum in the piezo's wiring, V: half a converter step."""
    electronics: float = 0.0022
    """RMS of the noise of amplifier and converter, V: two thirds of a converter step (3.2 mV)."""

    def scaled(self, speed: float, loudness: float) -> MotorNoise:
        """Return the noise of a motor ``speed`` times as fast and ``loudness`` times as loud."""
        return replace(
            self,
            rotor_rate=self.rotor_rate * speed,
            rotor=self.rotor * loudness,
            mesh=self.mesh * loudness,
            friction=self.friction * loudness,
        )


@lru_cache(maxsize=8)
def _interpolation_places(n: int, dt: float) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return where ``n`` points in time lie between knots that are 20 ms apart, to interpolate.

    The first array holds the number of the knot before each point. The second holds the position
    between this knot (0) and the next one (1). ``dt`` is the time between points, s.
    """
    place = np.arange(n, dtype=np.float64) * dt / 0.02
    cell = place.astype(np.int64)
    return cell, np.asarray(place - cell)


def phalanx_force(
    noise: MotorNoise, duration: float, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return the random noise force on one phalanx (finger bone) over ``duration`` s, N."""
    n = math.ceil(duration * _RATE) + 2
    dt = 1 / _RATE
    white = rng.standard_normal(n + 200)
    rubbing = np.empty_like(white)
    _kernels.filtered(RUBBING, white, rubbing)
    rubbing = rubbing[200:]
    knots = rng.standard_normal(max(int(duration / 0.02), 2) + 2)
    cell, part = _interpolation_places(n, dt)
    slope = np.append(np.diff(knots), 0.0)
    envelope = np.exp(noise.wander * (slope[cell] * part + knots[cell]))
    # Share of white noise's amplitude in the band.
    share = math.sqrt(2 * (RUBBING_BAND[1] - RUBBING_BAND[0]) / _RATE)
    out = noise.friction * envelope * rubbing / share
    r = noise.rotor_rate * (1 + 0.004 * rng.standard_normal())
    rates = np.array([r, 2 * r, 3 * r, 0.31 * noise.mesh_ratio * r, noise.mesh_ratio * r,
                      2 * noise.mains_rate])  # fmt: skip
    amplitudes = np.array([noise.rotor, noise.rotor / 2, noise.rotor / 3, 0.6 * noise.mesh,
                           noise.mesh, noise.mains])  # fmt: skip
    depth = np.array([0.1, 0.1, 0.1, 0.6, 0.6, 0.0])
    phases = rng.uniform(0, 2 * math.pi, rates.size)
    # A rotating phasor for each line, and one for the slow shaft, which modulates the lines.
    lines = np.exp(1j * np.append(phases, phases[0]))
    turns = np.exp(2j * math.pi * dt * np.append(rates, r / 23))
    _kernels.tones(lines, turns, amplitudes, depth, out)
    for _ in range(rng.poisson(noise.click_rate * duration)):
        start = int(rng.uniform(0, n))
        length = max(int(rng.uniform(0.3e-3, 1.2e-3) * _RATE), 2)
        peak = noise.click * math.exp(0.5 * rng.standard_normal()) * rng.choice((-1.0, 1.0))
        shape = peak * np.sin(np.pi * np.arange(length) / length)
        stop = min(start + length, n)
        out[start:stop] += shape[: stop - start]
    return np.asarray(out)


class PhalanxNoise:
    """Noise forces on both phalanges (finger bones), scaled by the motor's loudness."""

    dt = 1 / _RATE

    def __init__(
        self, noises: Iterable[MotorNoise], duration: float, rng: np.random.Generator,
        loudness: float,
    ) -> None:  # fmt: skip
        self.points = np.stack([phalanx_force(n, duration, rng) for n in noises])
        self.loudness = self._reached = loudness
        self._shaped = 0  # number of points with their loudness applied

    def scale_until(self, until: float) -> None:
        """Scale the noise forces up to the time ``until``, s, by the motor's loudness."""
        stop = min(int(until / self.dt) + 2, self.points.shape[1])
        if stop > self._shaped and not self._reached == self.loudness == 1.0:
            slope = np.linspace(self._reached, self.loudness, stop - self._shaped + 1)[1:]
            self.points[:, self._shaped : stop] *= slope
        self._shaped = max(self._shaped, stop)
        self._reached = self.loudness


def electrical_noise(
    noise: MotorNoise, sheet: float, angle: NDArray[np.float64], rng: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the electrical noise in a fingertip's piezo and in its force sheet, V, (n,) each.

    ``sheet`` is the standard deviation of the noise in the sheet, V. ``angle`` holds the phase of
    the mains at each sample, rad, shape (n,).
    """
    white = rng.standard_normal((2, angle.size))
    return noise.hum * np.sin(angle) + noise.electronics * white[0], sheet * white[1]


#: Shortest usable recording, s.
LEAST = 2.0
#: A part louder than the median part by this factor is not at rest.
LOUD = 4.0


@dataclass(frozen=True, slots=True, eq=False)
class RecordedNoise:
    """Noise that real vibration sensors recorded at rest, resampled to the fingertips' rate.

    The exponential smoothing of the device is removed.
    """

    volts: NDArray[np.float64]
    name: str
    digest: str

    @property
    def description(self) -> str:
        return (
            f"noise of {self.name} (sha256 {self.digest}) in place of the modelled electronics "
            "and hum, from places that the seed draws"
        )

    def draw(
        self, samples: int, rng: np.random.Generator
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return random sections of the noise for index finger and thumb, V, (samples,) each."""
        starts = rng.integers(0, max(1, len(self.volts) - samples + 1), 2)
        if self.volts.shape[1] > 1:
            starts[1] = starts[0]
        index, thumb = (
            np.take(self.volts[:, f % self.volts.shape[1]], start + np.arange(samples), mode="wrap")
            for f, start in enumerate(starts)
        )
        return index, thumb


def read_noise(path: Path) -> RecordedNoise:
    recording = read_recording(path)
    layout = recording.header.layout
    units = {c.unit for c in layout.vibration}
    if not units <= {"V", "full scale"}:
        raise FileError(
            f"{path} is in {', '.join(sorted(units))}, but the noise must be in V: import the "
            "recording again with its unit"
        )
    data = max((s.data for s in recording.stretches), key=len, default=None)
    if data is None or len(data) < LEAST * layout.rate:
        raise FileError(
            f"{path} has less than {LEAST:g} s without a gap: record the sensor at rest for longer"
        )
    volts = resample(_undo_smoothing(layout, data), layout.rate, FINGERTIP_RATE)
    volts -= volts.mean(axis=0)
    part = round(0.1 * FINGERTIP_RATE)
    parts = volts[: len(volts) // part * part].reshape(-1, part, volts.shape[1]).std(axis=1)
    usual = np.median(parts, axis=0)
    if not usual.all() or (parts > LOUD * usual).any():
        raise FileError(
            f"{path} is not at rest throughout, or its sensor gives no signal: record the sensor "
            "while nothing touches it and nothing moves"
        )
    return RecordedNoise(volts, path.name, hashlib.sha256(path.read_bytes()).hexdigest())


def _undo_smoothing(layout: Layout, data: NDArray[Any]) -> NDArray[np.float64]:
    """Return the vibration, V, shape (samples, channels), without the device's smoothing."""
    columns = layout.columns(ChannelKind.VIBRATION)[:2]
    channels = layout.vibration[: len(columns)]
    volts = layout.physical(data, columns)
    volts *= [PIEZO_OFFSET_VOLTS if c.unit == "full scale" else 1.0 for c in channels]
    alphas = np.array([c.smoothing_alpha for c in channels])
    previous = np.concatenate([volts[:1], volts[:-1]])
    out: NDArray[np.float64] = (volts - (1 - alphas) * previous) / alphas
    return out
