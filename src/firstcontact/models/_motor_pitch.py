"""Closing speed from the pitch of the motor before the contact.

The frequencies of rotor, gears and harmonics are proportional to the speed. On a logarithmic
frequency axis the whole spectrum therefore shifts by the logarithm of the speed. The shift relative
to the rig's usual spectrum gives the speed. The single lines need not be known.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TypedDict

import numpy as np
from numpy.typing import NDArray

from firstcontact import chain
from firstcontact.chain import LINES, TURN
from firstcontact.models._spec import Values
from firstcontact.models._touches import Signals, Touches
from firstcontact.signal import BASELINE_GUARD, samples_in

#: Frequency range of the motor's spectrum, Hz.
LOWEST, HIGHEST = 100.0, 2300.0
#: Distance between two points in ln(frequency).
STEP = float(np.log(HIGHEST / LOWEST)) / (LINES - 1)
#: Correlation between spectrum and reference above which a shift is trusted.
BELIEVED = 0.5
#: One count of the converter, V.
COUNT = 3.2e-3
_ROUNDS = 4

Spectra = NDArray[np.float32]


class Ear(TypedDict):
    """Constants of the spectrum: see ``fc_ear`` in C."""

    sine: NDArray[np.float32]
    fade: NDArray[np.float32]
    part: NDArray[np.float32]
    cell: NDArray[np.int32]


@lru_cache(maxsize=8)
def ear(rate: float) -> Ear:
    """Return the constants of the spectrum at a sampling rate."""
    quiet = samples_in(Touches.BEFORE, rate) - samples_in(BASELINE_GUARD, rate)
    place = np.geomspace(LOWEST, HIGHEST, LINES) * (TURN / rate)
    cell = np.minimum(place.astype(np.int32), TURN // 2 - 1).astype(np.int32)
    return {
        "sine": np.sin(2 * np.pi * np.arange(TURN // 4 + 1) / TURN).astype(np.float32),
        "fade": (np.hanning(quiet) / COUNT).astype(np.float32),
        "part": np.clip(place - cell, 0.0, 1.0).astype(np.float32),
        "cell": cell,
    }


def spectra(signals: Signals, rate: float) -> Spectra:
    """Return the peaks of the spectrum before each contact, relative to its smooth part.

    Parameters
    ----------
    signals
        As in :class:`firstcontact.models.Touches`, shape (n, samples).
    rate
        Sampling rate, Hz.

    Returns
    -------
    ndarray
        Natural logarithm of the power at points evenly spaced in ln(frequency), shape (n, LINES).
    """
    constants = ear(rate)
    return chain.spectra(signals[:, : len(constants["fade"])], **constants)


@dataclass(frozen=True, slots=True, eq=False)
class MotorPitch:
    """Spectrum of a rig's motor at its usual speed."""

    reference: Spectra
    usual: float

    @classmethod
    def fit(cls, heard: Spectra) -> MotorPitch:
        """Fit to the spectra before a rig's contacts, shape (n, LINES), with n at least 1."""
        reference = heard[np.argmax(heard.std(axis=1))]
        for _ in range(_ROUNDS):
            shift, alike = chain.shifts(heard, reference)
            weight = np.maximum(alike, 0.0) ** 2
            moved = [
                w * np.roll(spectrum, -s)
                for w, s, spectrum in zip(weight, shift.tolist(), heard, strict=True)
            ]
            total = np.sum(moved, axis=0, dtype=np.float64) / max(float(weight.sum()), 1e-9)
            reference = total.astype(np.float32)
        shift, _ = chain.shifts(heard, reference)
        return cls(reference, float(np.median(shift)) * STEP)

    def listen(self, heard: Spectra) -> tuple[Values, Values]:
        """Return the speed relative to the rig's usual speed."""
        shift, alike = chain.shifts(heard, self.reference)
        speed = shift.astype(np.float64) * STEP - self.usual
        return speed, np.clip(alike, 0.0, 1.0).astype(np.float64)
