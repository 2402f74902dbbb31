"""Converters of both fingertips, which turn the motion into raw scans, piece by piece."""

from __future__ import annotations

import copy
import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FINGERTIP_RATE, TAXELS, Contact, Finger, first_closed_sample
from firstcontact.twin._draw import PinchDraw
from firstcontact.twin._mechanics import BUFFER, CONTACT_FORCE, INDENTATION
from firstcontact.twin._noise import pickup
from firstcontact.twin._sensor import SCAN, VelostatParameters, force_readings, piezo_readings

ForceSheets = tuple[VelostatParameters, VelostatParameters]
Pickup = tuple[NDArray[np.float64], NDArray[np.float64]]


class Fingertips(ABC):
    """Base class of the converters of both fingertips, which are unloaded at first."""

    def __init__(self, draw: PinchDraw, sheets: ForceSheets | None = None) -> None:
        self._draw = draw
        self.sheets = draw.velostat if sheets is None else sheets
        self.sample = 0
        self._sheet_state = np.zeros((2, 2, TAXELS))

    def fork(self) -> Self:
        """Return an independent copy in the same state, with the same noise."""
        other = copy.copy(self)
        other._sheet_state = self._sheet_state.copy()
        return other

    @abstractmethod
    def _pickup(self, samples: int) -> list[Pickup]:
        """Return the electrical noise of each fingertip's next samples."""

    def read(self, motion: NDArray[np.float64]) -> NDArray[np.uint16]:
        """Return the scans of the next samples."""
        scans = np.empty((len(motion), len(SCAN)), np.uint16)
        for f, (piezo, force) in enumerate(self._pickup(len(motion))):
            scans[:, f] = piezo_readings(motion[:, f, BUFFER] + piezo)
            # The array lies between pad and board, so the contact force loads it, not the mount's.
            scans[:, 2 + f] = force_readings(
                motion[:, f, CONTACT_FORCE], self._draw.shares[f], self.sheets[f], force,
                1 / FINGERTIP_RATE, self._sheet_state[f], self.sample,
            )  # fmt: skip
            scans[:, 4 + f] = motion[:, f, INDENTATION] > 0
        self.sample += len(motion)
        return scans


class PinchFingertips(Fingertips):
    """Converters for one pinch. Their noise is drawn in advance."""

    def __init__(
        self, draw: PinchDraw, times: NDArray[np.float64], sheets: ForceSheets | None = None
    ) -> None:
        super().__init__(draw, sheets)
        self._noise = []
        for f in range(2):
            phase = draw.rng.uniform(0, 2 * math.pi)
            angle = 2 * math.pi * draw.noise[f].mains_rate * times + phase
            self._noise.append(pickup(draw.noise[f], self.sheets[f].noise, angle, draw.rng))
        if draw.recorded is not None:
            piezos = draw.recorded.draw(len(times), draw.rng)
            self._noise = [(p, force) for p, (_, force) in zip(piezos, self._noise, strict=True)]

    def _pickup(self, samples: int) -> list[Pickup]:
        rows = slice(self.sample, self.sample + samples)
        return [(piezo[rows], force[rows]) for piezo, force in self._noise]


class StreamFingertips(Fingertips):
    """Converters of a running twin."""

    def __init__(self, draw: PinchDraw, rng: np.random.Generator) -> None:
        super().__init__(draw)
        self._rng = rng
        self._phases = rng.uniform(0, 2 * math.pi, 2)

    def take(self, draw: PinchDraw) -> None:
        """Continue with the sensors of another pinch of the same hand and session."""
        for f, (old, new) in enumerate(zip(self.sheets, draw.velostat, strict=True)):
            self._sheet_state[f] *= (old.conductance / new.conductance) ** (1 / new.exponent)
        self._draw, self.sheets = draw, draw.velostat

    def _pickup(self, samples: int) -> list[Pickup]:
        count = np.arange(self.sample, self.sample + samples)
        # Fraction of a turn since the start, exact even after days.
        turns = count * self._draw.noise[0].mains_rate % FINGERTIP_RATE
        angle = 2 * math.pi * turns / FINGERTIP_RATE
        return [
            pickup(noise, sheet.noise, angle + phase, self._rng)
            for noise, sheet, phase in zip(self._draw.noise, self.sheets, self._phases, strict=True)
        ]


def strip_contacts(
    scans: NDArray[np.uint16], first_sample: int = 0, earlier: Sequence[Contact] = ()
) -> list[Contact]:
    """Return the contacts that the strips show in ``scans``, in order of time."""
    return mask_contacts(scans[:, 4:6] != 0, first_sample, earlier)


def mask_contacts(
    closed: NDArray[np.bool_], first_sample: int, earlier: Sequence[Contact]
) -> list[Contact]:
    """Return the contacts in order of time, from a mask of closed strips, shape (n, 2)."""
    contacts = []
    for f in () if len(earlier) == 2 else Finger:
        sample = first_closed_sample(closed[:, f], first_sample)
        if sample is not None and all(c.finger != f for c in earlier):
            contacts.append(Contact(f, sample, sample))
    return sorted(contacts, key=lambda c: c.sample)
