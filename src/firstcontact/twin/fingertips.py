"""Both fingertips of a running twin: from motion to raw scans, without an end."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.layout import FINGERTIP_RATE, TAXELS
from firstcontact.twin.draw import PinchDraw
from firstcontact.twin.mechanics import BUFFER, CONTACT_FORCE, INDENTATION
from firstcontact.twin.sensor import SCAN, force_readings, piezo_readings


class Fingertips:
    """What the converters read as time goes on.

    Hum and sheets have a past, so nothing jumps where one pinch follows another.

    Parameters
    ----------
    draw
        The pinch whose sensors these are at first.
    rng
        Where hum's phase and the converters' noise come from.
    """

    def __init__(self, draw: PinchDraw, rng: np.random.Generator) -> None:
        self._rng = rng
        self._draw = draw
        self._phases = rng.uniform(0, 2 * math.pi, 2)
        self._felt = np.zeros((2, 2, TAXELS))
        #: Number of the next scan.
        self.sample = 0

    def take(self, draw: PinchDraw) -> None:
        """Go on with the sensors of another pinch of the same hand and session.

        A sheet repeats poorly from loading to loading. What is left of the last one
        conducts as it did, so that no reading jumps.
        """
        for f in range(2):
            old, new = self._draw.velostat[f], draw.velostat[f]
            self._felt[f] *= (old.conductance / new.conductance) ** (1 / new.exponent)
        self._draw = draw

    def read(self, motion: NDArray[np.float64]) -> NDArray[np.uint16]:
        """Scans of the next samples.

        Parameters
        ----------
        motion
            As of :meth:`firstcontact.twin.run.PinchRun.advance`, shape (n, 2, 3).

        Returns
        -------
        ndarray
            Shape (n, 6), in the order of :data:`firstcontact.twin.sensor.SCAN`.
        """
        n = len(motion)
        scans = np.empty((n, len(SCAN)), np.uint16)
        first = self.sample
        for f in range(2):
            noise, sheet = self._draw.noise[f], self._draw.velostat[f]
            # Turns since the start, without its whole ones: exact after days, too.
            turns = np.arange(first, first + n) * noise.mains_rate % FINGERTIP_RATE
            hum = noise.hum * np.sin(2 * math.pi * turns / FINGERTIP_RATE + self._phases[f])
            white = self._rng.standard_normal((2, n))
            scans[:, f] = piezo_readings(motion[:, f, BUFFER] + hum + noise.electronics * white[0])
            # The array lies between pad and board: it feels the contact, not the mount.
            scans[:, 2 + f] = force_readings(
                np.ascontiguousarray(motion[:, f, CONTACT_FORCE]), self._draw.shares[f], sheet,
                sheet.noise * white[1], 1 / FINGERTIP_RATE, self._felt[f], first,
            )  # fmt: skip
            scans[:, 4 + f] = motion[:, f, INDENTATION] > 0
        self.sample += n
        return scans
