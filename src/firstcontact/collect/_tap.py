"""A tap on each fingertip tells whether its sensor is connected, and whether both are alike."""

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

#: A tap rises this far above the noise floor, and above this voltage, V.
FACTOR = 10.0
LEAST = 0.02
#: Its peak is looked for over this time, s.
LASTS = 0.1
#: A tap with a finger or a pencil gives more than this, V, if the buffer works.
WEAK = 0.1
#: The two fingertips differ by less than this factor if they are built alike.
ALIKE = 3.0


class TapWatch:
    """Waits for a tap on one fingertip.

    Parameters
    ----------
    layout
        The columns of the blocks.
    calibration
        With the finger's noise floor.
    finger
        Whose.
    """

    def __init__(self, layout: Layout, calibration: Calibration, finger: Finger | None) -> None:
        self._layout = layout
        self._columns = layout.columns(ChannelKind.VIBRATION, finger)
        self._offset = next((p.offset for p in calibration.piezo if p.finger is finger), 0.0)
        self._limit = max(LEAST, FACTOR * (calibration.noise(finger) or 0.0))
        self._left: int | None = None
        self._peak = 0.0

    def update(self, block: Block) -> float | None:
        """Take the next samples: the peak, V, as soon as the tap is over."""
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
        Open.
    calibration
        With the finger's noise floor.
    finger
        Whose; None for a sensor that belongs to none.
    patience
        Longest wait, s of the device's time.

    Raises
    ------
    InputError
        No tap came, or no samples.
    """
    layout = source.descriptor.layout
    watch = TapWatch(layout, calibration, finger)
    left = patience * layout.rate
    source.read(0)  # what was felt before anybody was asked
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
        f"no tap on the {finger_name(finger)} was felt within {patience:g} s: tap harder, check "
        "the sensor's plug, or leave this out with --no-tap"
    )


def tap_warnings(calibration: Calibration) -> Sequence[str]:
    """What the taps say against the fingertips: one sentence each."""
    taps = {p.finger: p.tap for p in calibration.piezo if p.tap is not None}
    said = [
        f"the {finger_name(f)}'s tap gave only {tap:.3f} V: tap harder, or check pad and buffer"
        for f, tap in taps.items()
        # A sensor of no finger has neither our pad and buffer nor their volts.
        if f is not None and tap < WEAK
    ]
    if len(taps) == 2 and max(taps.values()) > ALIKE * min(taps.values()):
        loud = max(taps, key=lambda f: taps[f])
        said.append(
            f"the {finger_name(loud)}'s tap was {taps[loud] / min(taps.values()):.1f} times as "
            "loud as the other: tap both alike, or check the pads"
        )
    return said
