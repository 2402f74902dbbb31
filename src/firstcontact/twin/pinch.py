"""One pinch of the twin: mechanics, then what the fingertip makes of it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.layout import FINGERTIP_RATE, TAXELS, Finger, fingertip_layout
from firstcontact.core.pinch import Contact, Label, Pinch
from firstcontact.twin.draw import PinchDraw
from firstcontact.twin.filter import ROUND, DeviceFilter
from firstcontact.twin.mechanics import BUFFER, CONTACT_FORCE, INDENTATION
from firstcontact.twin.noise import pickup
from firstcontact.twin.run import SUBSTEPS, PinchRun
from firstcontact.twin.sensor import SCAN, force_readings, open_reading, piezo_readings

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
    scans = np.empty((times.size, len(SCAN)), np.uint16)
    for f in Finger:
        volts = out[:, f, BUFFER] + pickup(draw.noise[f], times, draw.rng)
        scans[:, f] = piezo_readings(volts)
        v = draw.velostat[f]
        chatter = v.noise * draw.rng.standard_normal(times.size)
        # The array lies between pad and board: it feels the contact, not the mount.
        scans[:, 2 + f] = force_readings(
            out[:, f, CONTACT_FORCE], draw.shares[f], v, chatter, 1 / FINGERTIP_RATE,
            np.zeros((2, TAXELS)), 0,
        )  # fmt: skip
        scans[:, 4 + f] = out[:, f, INDENTATION] > 0
    return scans


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
    device = DeviceFilter()
    # The device has been reading the unloaded sheets before the first sample.
    before = np.tile(scans[0], (ROUND, 1))
    before[:, 2:4] = [open_reading(v) for v in draw.velostat]
    device.update(before)
    data = device.update(scans)
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
