"""Taps on a fingertip: where they are, their level, first swing, clipping and decay."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from firstcontact.collect.calibration import FACTOR, LEAST
from firstcontact.core import Layout
from firstcontact.core.layout import PIEZO_OFFSET_VOLTS

Volts = NDArray[np.float64]

#: Share of the converter's range from which on a tap is clipped. The device's smoothing keeps short
#: peaks below the rail.
CLIPPED = 0.9
#: Duration of a tap, s before and after its begin, and least time between the begins of two taps.
BEFORE, AFTER = 0.02, 0.06
APART = 0.2
#: Parts of a tap whose vibration is compared, s after its begin.
LOUD, TAIL = (0.0, 0.004), (0.008, 0.020)
#: Time between their middles, s.
BETWEEN = (sum(TAIL) - sum(LOUD)) / 2
#: Share of the peak that counts as the first swing. A tool touches softly before it pushes.
SWING = 0.25
#: Least vibration of a tap, as a multiple of the noise, at which its decay can be measured.
CLEAR = 5.0


class Tap(NamedTuple):
    volts: Volts
    """Vibration columns around the tap, V from the level at rest, shape (samples, columns)."""
    is_clipped: bool


class TapMeasures(NamedTuple):
    """Measures of several taps on one finger; arrays have a value for each vibration column."""

    number: int
    clipped: int
    peak: Volts
    """Median peak, V. Clipped taps count if all are clipped."""
    loudness: Volts
    """Median peak up to the first clipped tap, V. Later taps are gentler on request."""
    swing: Volts
    """Median sign of the first swing."""
    decay: Volts
    """Time constant of the vibration above a few hundred hertz, s; NaN if the taps are too weak."""


def find_taps(layout: Layout, x: Volts, rest: Volts) -> list[Tap]:
    """Return the complete taps in vibration columns, on any finger, given the columns at rest."""
    offset = np.median(rest, axis=0)
    limit = np.maximum(LEAST, FACTOR * rest.std(axis=0))
    before, after, apart = (round(t * layout.rate) for t in (BEFORE, AFTER, APART))
    loud = np.flatnonzero((np.abs(x - offset) > limit).any(axis=1))
    rail = np.array([PIEZO_OFFSET_VOLTS if c.unit == "V" else 1.0 for c in layout.vibration])
    taps: list[Tap] = []
    last = -apart
    for begin in map(int, loud):
        if begin - last < apart:
            continue
        last = begin
        if begin >= before and begin + after <= len(x):
            piece = x[begin - before : begin + after]
            is_clipped = bool((np.abs(piece) > CLIPPED * rail).any())
            taps.append(Tap(piece - offset, is_clipped))
    return taps


def measure_taps(layout: Layout, taps: Sequence[Tap], rest: Volts) -> TapMeasures:
    """Measure taps, given the vibration columns at rest."""
    clipped = sum(t.is_clipped for t in taps)
    usable = [t.volts for t in taps if not t.is_clipped] or [t.volts for t in taps]
    columns = rest.shape[1]
    if not usable:
        nothing = np.zeros(columns)
        return TapMeasures(0, 0, nothing, nothing, nothing, np.full(columns, math.nan))
    volts = np.array(usable)
    peaks = np.abs(volts).max(axis=1)
    first = (np.abs(volts) >= SWING * peaks[:, None]).argmax(axis=1)
    end = next((k + 1 for k, tap in enumerate(taps) if tap.is_clipped), len(taps))
    before = [np.abs(tap.volts).max(axis=0) for tap in taps[:end]]
    swings = np.sign(np.take_along_axis(volts, first[:, None], axis=1)[:, 0])
    return TapMeasures(
        len(taps), clipped, np.median(peaks, axis=0), np.median(before, axis=0),
        np.sign(swings.sum(axis=0)), _decay(layout, usable, rest),
    )  # fmt: skip


def _decay(layout: Layout, taps: Sequence[Volts], rest: Volts) -> Volts:
    """Return the time constant of the taps' vibration in each column.

    The second difference suppresses the finger's swing on its drive at 59 Hz.
    """
    noise = np.diff(rest, 2, axis=0).var(axis=0)

    def power(part: tuple[float, float]) -> Volts:
        first, end = (round((BEFORE + t) * layout.rate) for t in part)
        pieces = np.array([np.diff(t[first - 2 : end], 2, axis=0) for t in taps])
        return np.asarray((pieces**2).mean(axis=(0, 1)))

    loud, tail = power(LOUD), power(TAIL)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.sqrt(np.clip(tail - noise, 0.0, None) / np.maximum(loud - noise, 1e-30))
        decay = np.where(ratio < 1, BETWEEN / -np.log(ratio), math.inf)
    return np.where(loud > CLEAR**2 * noise, decay, math.nan)
