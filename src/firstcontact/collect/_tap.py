"""Taps on the fingertips, which show that the sensors are connected and equally sensitive."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from firstcontact.core import (
    Block,
    Calibration,
    ChannelKind,
    Finger,
    InputError,
    Layout,
    finger_name,
)
from firstcontact.device import Source, wait_for_arrivals

#: Least peak of a tap, as a multiple of the noise floor, and in V. Both are required.
FACTOR = 10.0
LEAST = 0.02
#: Duration over which the peak is searched, s.
LASTS = 0.1
#: Weakest tap with a finger or a pencil on a working buffer, V.
WEAK = 0.1
#: Largest ratio between the taps of two fingertips that are built alike.
ALIKE = 3.0


class TapWatch:
    """Search for a tap on one fingertip."""

    def __init__(self, layout: Layout, calibration: Calibration, finger: Finger | None) -> None:
        self._layout = layout
        self._columns = layout.columns(ChannelKind.VIBRATION, finger)
        self._offset = next((p.offset for p in calibration.piezo if p.finger is finger), 0.0)
        self._limit = max(LEAST, FACTOR * (calibration.noise(finger) or 0.0))
        self._left: int | None = None
        self._peak = 0.0

    def update(self, block: Block) -> float | None:
        """Process the next samples. Return the tap's peak (V) once it is over; None before."""
        volts = np.abs(self._layout.physical(block.data, self._columns)[:, 0] - self._offset)
        if self._left is None:
            above = np.flatnonzero(volts > self._limit)
            if not len(above):
                return None
            volts = volts[above[0] :]
            self._left = round(LASTS * self._layout.rate)
        if self._left > 0 and len(volts):
            self._peak = max(self._peak, float(volts[: self._left].max()))
            self._left -= len(volts)
        return self._peak if self._left <= 0 else None


def wait_for_tap(
    source: Source, calibration: Calibration, finger: Finger | None, patience: float = 20.0
) -> Calibration:
    """Wait for a tap on a fingertip and put its peak into the calibration.

    Parameters
    ----------
    source
        An open source.
    calibration
        Calibration with the finger's noise floor.
    finger
        Finger that is tapped; None for a sensor that belongs to no finger.
    patience
        Longest wait, s by the device's clock.

    Raises
    ------
    InputError
        No tap or no samples came in time.
    """
    layout = source.descriptor.layout
    watch = TapWatch(layout, calibration, finger)
    left = patience * layout.rate
    source.read(0)  # drop the samples from before the request
    while left > 0:
        for arrival in wait_for_arrivals(source):
            left -= len(arrival.block.data)
            peak = watch.update(arrival.block)
            if peak is not None:
                piezo = tuple(
                    replace(p, tap=peak) if p.finger is finger else p for p in calibration.piezo
                )
                return replace(calibration, piezo=piezo)
    raise InputError(
        f"no tap was measured at the {finger_name(finger)} within {patience:g} s: tap harder, "
        "check the sensor's plug, or leave the tap test out",
        parameter="tap",
    )


def tap_warnings(calibration: Calibration) -> Sequence[str]:
    """Return sentences about taps that are too weak or too different."""
    taps = {p.finger: p.tap for p in calibration.piezo if p.tap is not None}
    warnings = [
        f"the {finger_name(f)}'s tap gave only {tap:.3f} V: tap harder, or check pad and buffer"
        for f, tap in taps.items()
        # ``WEAK`` holds for a fingertip's pad and buffer, which a sensor of no finger lacks.
        if f is not None and tap < WEAK
    ]
    if len(taps) == 2 and max(taps.values()) > ALIKE * min(taps.values()):
        loud = max(taps, key=lambda f: taps[f])
        warnings.append(
            f"the {finger_name(loud)}'s tap was {taps[loud] / min(taps.values()):.1f} times as "
            "loud as the other: tap both alike, or check the pads"
        )
    return warnings
