"""One pinch of the twin: mechanics, then what the fingertip makes of it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.layout import FINGERTIP_RATE, Finger, fingertip_layout
from firstcontact.core.pinch import Contact, Label, Pinch
from firstcontact.twin.converters import Converters, settled_filter
from firstcontact.twin.draw import PinchDraw
from firstcontact.twin.run import SUBSTEPS, PinchRun

#: Length of a pinch, s.
DURATION = 0.3
#: Samples before the first that let the vibration build up.
BURN_IN = 100
_LAYOUT = fingertip_layout()


def mechanics_of(
    draw: PinchDraw, duration: float = DURATION, substeps: int = SUBSTEPS
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Integrate a drawn pinch.

    Returns
    -------
    tuple
        Sampling instants (s, the first contact at ``draw.timing.first``), shape
        (samples,), and :func:`firstcontact.twin.mechanics.integrate`'s output,
        shape (samples, 2, 3).
    """
    run = PinchRun(draw, duration, BURN_IN, substeps=substeps)
    out = run.advance(run.times.size)
    return run.times[BURN_IN:] - BURN_IN / FINGERTIP_RATE, out[BURN_IN:]


def pinch_scans(draw: PinchDraw, duration: float = DURATION) -> NDArray[np.uint16]:
    """What the converters read during one pinch, shape (samples, 6), in the order of ``SCAN``."""
    times, out = mechanics_of(draw, duration)
    return Converters(draw, times).read(out)


def simulate_pinch(
    draw: PinchDraw, label: Label, first_sample: int = 0, duration: float = DURATION
) -> Pinch:
    """What the device sends for one pinch.

    Parameters
    ----------
    draw
        The chance in it.
    label
        What is pinched.
    first_sample
        Sample number of the first sample.
    duration
        Length, s.

    Returns
    -------
    Pinch
        int16, :func:`firstcontact.core.layout.fingertip_layout`; its truth is
        read off the strips.
    """
    scans = pinch_scans(draw, duration)
    data = settled_filter(scans[0], draw.velostat).update(scans)
    truth = []
    for f in Finger:
        closed = scans[:, 4 + f]
        if closed.any():
            sample = first_sample + int(np.argmax(closed))
            truth.append(Contact(f, sample, sample))
    truth.sort(key=lambda c: (c.sample, math.inf if c.finger != _first(draw) else 0))
    return Pinch(data, _LAYOUT, label, first_sample, tuple(truth))


def _first(draw: PinchDraw) -> Finger:
    return Finger.INDEX if draw.timing.first_is_index else Finger.THUMB
