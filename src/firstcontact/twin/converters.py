"""What the converters read during one pinch, piece by piece."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.layout import FINGERTIP_RATE, TAXELS, Finger
from firstcontact.twin.draw import PinchDraw
from firstcontact.twin.filter import ROUND, DeviceFilter
from firstcontact.twin.mechanics import BUFFER, CONTACT_FORCE, INDENTATION
from firstcontact.twin.noise import pickup
from firstcontact.twin.sensor import (
    SCAN,
    VelostatParameters,
    force_readings,
    open_reading,
    piezo_readings,
)

Sheets = tuple[VelostatParameters, VelostatParameters]


class Converters:
    """Both fingertips' converters through one pinch; their chance is drawn at once.

    Parameters
    ----------
    draw
        The pinch; uses up some of its chance.
    times
        Sampling instants of the longest pinch, s, shape (samples,).
    sheets
        Force arrays of index and thumb; those of the draw by default.
    """

    def __init__(
        self, draw: PinchDraw, times: NDArray[np.float64], sheets: Sheets | None = None
    ) -> None:
        self.sheets = draw.velostat if sheets is None else sheets
        self._shares = draw.shares
        self._felt = np.zeros((2, 2, TAXELS))
        self._done = 0
        picked, chatter = [], []
        for f in Finger:
            picked.append(pickup(draw.noise[f], times, draw.rng))
            chatter.append(self.sheets[f].noise * draw.rng.standard_normal(times.size))
        self._picked, self._chatter = picked, chatter

    def read(self, motion: NDArray[np.float64]) -> NDArray[np.uint16]:
        """Scans of the next samples.

        Parameters
        ----------
        motion
            As of :func:`firstcontact.twin.mechanics.integrate`, shape (n, 2, 3).

        Returns
        -------
        ndarray
            Shape (n, 6), in the order of :data:`firstcontact.twin.sensor.SCAN`.
        """
        here = slice(self._done, self._done + len(motion))
        scans = np.empty((len(motion), len(SCAN)), np.uint16)
        for f in Finger:
            scans[:, f] = piezo_readings(motion[:, f, BUFFER] + self._picked[f][here])
            # The array lies between pad and board: it feels the contact, not the mount.
            scans[:, 2 + f] = force_readings(
                motion[:, f, CONTACT_FORCE], self._shares[f], self.sheets[f],
                self._chatter[f][here], 1 / FINGERTIP_RATE, self._felt[f], self._done,
            )  # fmt: skip
            scans[:, 4 + f] = motion[:, f, INDENTATION] > 0
        self._done += len(motion)
        return scans


def settled_filter(scan: NDArray[np.uint16], sheets: Sheets) -> DeviceFilter:
    """A device that has been reading the unloaded sheets before its first scan, shape (6,)."""
    device = DeviceFilter()
    before = np.tile(scan, (ROUND, 1))
    before[:, 2:4] = [open_reading(v) for v in sheets]
    device.update(before)
    return device
