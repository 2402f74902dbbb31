"""Closing speed from the pitch of the motor before the contact.

The frequencies of rotor, gears and harmonics are proportional to the speed. On a logarithmic
frequency axis the whole spectrum therefore shifts by the logarithm of the speed. The shift relative
to the rig's usual spectrum gives the speed. The single lines need not be known.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import kernels
from firstcontact.models._spec import Values
from firstcontact.models._touches import BEFORE, Signals
from firstcontact.signal import BASELINE_GUARD, samples_in

#: Frequency range of the motor's spectrum, Hz, and its number of points.
LOWEST, HIGHEST, POINTS = 100.0, 2300.0, 400
#: Distance between two points in ln(frequency).
STEP = float(np.log(HIGHEST / LOWEST)) / (POINTS - 1)
#: Largest shift of the search, points: a factor of two in speed.
FARTHEST = 88
#: Correlation between spectrum and reference above which a shift is trusted.
BELIEVED = 0.5
#: One count of the converter, V.
COUNT = 3.2e-3
_FFT = 2048
_SMOOTH = 61
_FLOOR = -1.0
_ROUNDS = 4

Spectra = NDArray[np.float64]


def spectra(signals: Signals, lead: int, rate: float) -> Spectra:
    """Return the peaks of the spectrum before each contact, relative to its smooth part.

    Parameters
    ----------
    signals
        As in :class:`firstcontact.models._touches.Touches`, shape (n, samples).
    lead
        Number of samples before the contact.
    rate
        Sampling rate, Hz. If the rate is below 4.6 kHz, the highest frequencies are missing and
        count as silent.

    Returns
    -------
    ndarray
        Natural logarithm of the power at points evenly spaced in ln(frequency), shape (n, POINTS).
    """
    quiet = signals[:, : quiet_samples(lead, rate)].astype(np.float64)
    quiet = (quiet - quiet.mean(axis=1, keepdims=True)) * _fade(quiet.shape[1])
    power = np.abs(np.fft.rfft(quiet, _FFT, axis=1)) ** 2
    # In squared counts of the converter: the 1e-3 added below is then far below any noise.
    power = power / COUNT**2
    cell, part = _places(rate)
    level = np.log(power[:, cell] * (1 - part) + power[:, cell + 1] * part + 1e-3)
    # As numpy.pad with mode="edge", which takes longer than the Fourier transform.
    first = level[:, :1].repeat(_SMOOTH // 2 + 1, axis=1)
    last = level[:, -1:].repeat(_SMOOTH // 2, axis=1)
    padded = np.concatenate([first, level, last], axis=1)
    sums = np.cumsum(padded, axis=1)
    lines = np.maximum(level - (sums[:, _SMOOTH:] - sums[:, :-_SMOOTH]) / _SMOOTH, _FLOOR)
    out: Spectra = lines - lines.mean(axis=1, keepdims=True)
    return out


def quiet_samples(lead: int, rate: float) -> int:
    """Return the number of samples before the contact that are guaranteed to contain no contact."""
    return lead - samples_in(BASELINE_GUARD, rate)


@lru_cache(maxsize=8)
def _fade(samples: int) -> NDArray[np.float64]:
    return np.hanning(samples)


@lru_cache(maxsize=8)
def _places(rate: float) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Return the spectral line below each point of the axis, and the fraction to the next line."""
    place = np.geomspace(LOWEST, HIGHEST, POINTS) * (_FFT / rate)
    cell = np.minimum(place.astype(np.intp), _FFT // 2 - 1)
    return cell, np.clip(place - cell, 0.0, 1.0)


def ear_constants(rate: float) -> dict[str, float | NDArray[np.generic]]:
    """Return the constants of :meth:`MotorPitch.listen` for export to C."""
    heard = quiet_samples(samples_in(BEFORE, rate), rate)
    cell, part = _places(rate)
    angles = 2 * np.pi * np.arange(_FFT + _FFT // 4) / _FFT
    even = np.sqrt((POINTS - np.arange(FARTHEST + 1)) * POINTS)
    return {
        "turn": np.sin(angles).astype(np.float32),
        "fade": (np.hanning(heard) / COUNT).astype(np.float32),
        "cell": cell.astype(np.int16),
        "part": part.astype(np.float32),
        "each": (1.0 / even).astype(np.float32),
        "step": STEP,
    }


@lru_cache(maxsize=8)
def _compiled_ear(module: ModuleType, lead: int, rate: float) -> Any:
    """Return the constants with which the compiled kernel finds the motor's pitch.

    Return None if ``lead``, the number of samples before the contact, is too large for it.
    """
    if quiet_samples(lead, rate) > _FFT:
        return None
    cell, part = _places(rate)
    turn = np.sin(2 * np.pi * np.arange(_FFT + _FFT // 4) / _FFT)
    return module.ear(_fade(quiet_samples(lead, rate)), cell.astype(np.int32), part, turn)


@dataclass(frozen=True, slots=True, eq=False)
class MotorPitch:
    """Spectrum of a rig's motor at its usual speed.

    Parameters
    ----------
    reference
        Spectrum, shape (POINTS,).
    usual
        Median shift of the rig's own contacts relative to the reference.
    """

    reference: NDArray[np.float64]
    usual: float

    @classmethod
    def fit(cls, heard: Spectra) -> MotorPitch:
        """Fit to the spectra before a rig's contacts, shape (n, POINTS), with n at least 1."""
        reference = heard[np.argmax(heard.std(axis=1))]
        for _ in range(_ROUNDS):
            shift, alike = _shifts(heard, reference)
            weight = np.maximum(alike, 0.0) ** 2
            moved = [
                w * np.roll(spectrum, -round(s / STEP))
                for w, s, spectrum in zip(weight, shift, heard, strict=True)
            ]
            reference = np.sum(moved, axis=0) / max(float(weight.sum()), 1e-9)
        shift, _ = _shifts(heard, reference)
        return cls(reference, float(np.median(shift)))

    def listen_to_one(self, signals: Signals, lead: int, rate: float) -> tuple[Values, Values]:
        """Return :meth:`listen` for one contact, with the arguments of :func:`spectra`.

        Compiled kernels, if they exist, take a tenth of NumPy's time. Their results differ by
        rounding only.
        """
        module = kernels()
        ear = None if module is None else _compiled_ear(module, lead, rate)
        if module is None or ear is None:
            return self.listen(spectra(signals, lead, rate))
        heard = np.ascontiguousarray(signals[0, : quiet_samples(lead, rate)], np.float32)
        shift, alike = module.listen(ear, np.ascontiguousarray(self.reference, np.float64), heard)
        return np.full(1, shift * STEP - self.usual), np.full(1, min(max(alike, 0.0), 1.0))

    def listen(self, heard: Spectra) -> tuple[Values, Values]:
        """Return the speed relative to the rig's usual speed.

        Returns
        -------
        speed, alike : ndarray
            ln(speed / usual speed), and correlation with the reference, between 0 and 1. If the
            correlation is below ``BELIEVED``, the speed is a guess. Shape (n,).
        """
        shift, alike = _shifts(heard, self.reference)
        return shift - self.usual, np.clip(alike, 0.0, 1.0)


def _shifts(heard: Spectra, reference: NDArray[np.float64]) -> tuple[Values, Values]:
    """Return the shift in ln(frequency) with the highest correlation, and that correlation."""
    size = 2 * POINTS
    product = np.fft.irfft(
        np.fft.rfft(heard, size, axis=1) * np.conj(np.fft.rfft(reference, size)), size, axis=1
    )
    near = np.concatenate([product[:, -FARTHEST:], product[:, : FARTHEST + 1]], axis=1)
    shifts = np.arange(-FARTHEST, FARTHEST + 1)
    near = near / np.sqrt((POINTS - np.abs(shifts)) * POINTS)
    near = near / (heard.std(axis=1, keepdims=True) * reference.std() + 1e-9)
    best = near.argmax(axis=1)
    return shifts[best] * STEP, near[np.arange(len(near)), best]
