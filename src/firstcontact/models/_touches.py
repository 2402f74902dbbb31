"""Contacts with their signal so far, and optional hints: closing speed and object radius.

The baseline of a signal is its mean shortly before the contact. Valid samples are those that a
prediction may use: they end before the second contact.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    FINGERTIP_WINDOW,
    ChannelKind,
    ClosingSpeed,
    Contact,
    Dataset,
    Finger,
    InputError,
    Pinch,
    parse_float,
)
from firstcontact.signal import BASELINE, BASELINE_GUARD, DeviceSmoothing, samples_in

#: Length of the signal before the contact that is used, s. It contains the motor's noise.
BEFORE = 0.040
#: Earliest and latest time after the contact for predictions, s.
SHORTEST = 0.002
LONGEST = FINGERTIP_WINDOW
#: Time between two predictions live, s.
STEP = 0.001
#: Times after the contact at which predictions are scored, ms.
TIMES = (2, 3, 5, 8, 15)

Signals = NDArray[np.float32]
Values = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Touches:
    """Contacts of single fingers, with signals and hints. Arrays share their first axis.

    Parameters
    ----------
    signals
        Vibration in V as the device sends it, with the baseline removed, shape (n, samples). Each
        signal lasts from ``BEFORE`` before the contact to ``LONGEST`` after it. Samples after
        ``valid`` are ignored.
    valid
        Number of valid samples from the contact on, up to the second contact, shape (n,).
    fingers
        Number of the finger, -1 if unknown, shape (n,).
    speeds
        Closing speed measured by the hand, m/s, NaN if unknown, shape (n,).
    speed_errors
        Relative standard error of these speeds; NaN stands for an exact speed, shape (n,).
    radii
        Radius of the object at the contact, m; infinite for a flat object, NaN if unknown, shape
        (n,).
    rate
        Sampling rate, Hz.
    """

    signals: Signals
    valid: NDArray[np.intp]
    fingers: NDArray[np.intp]
    speeds: Values
    speed_errors: Values
    radii: Values
    rate: float

    def __len__(self) -> int:
        return len(self.signals)

    @classmethod
    def from_signals(
        cls, signals: Signals, valid: NDArray[np.intp], fingers: NDArray[np.intp], rate: float
    ) -> Touches:
        """Return the contacts with unknown speed and radius."""
        unknown = np.full(len(signals), np.nan)
        return cls(signals, valid, fingers, unknown, unknown.copy(), unknown.copy(), rate)

    @property
    def answerable(self) -> NDArray[np.bool_]:
        """Mask of the contacts with enough valid samples for a prediction, shape (n,)."""
        return self.valid >= lengths(self.rate)[0]

    @property
    def lead(self) -> int:
        """Number of samples before each contact."""
        return samples_in(BEFORE, self.rate)

    @property
    def waves(self) -> Signals:
        """Signals from the contacts on, shape (n, samples)."""
        return self.signals[:, self.lead :]

    def take(self, rows: NDArray[Any]) -> Touches:
        """Return the contacts at these positions, or where a mask is true."""
        arrays = {f.name: getattr(self, f.name)[rows] for f in fields(self) if f.name != "rate"}
        return Touches(rate=self.rate, **arrays)

    def until(self, samples: int) -> Touches:
        """Return the contacts with their valid samples limited to this number."""
        return replace(self, valid=np.minimum(self.valid, samples))


def lengths(rate: float) -> tuple[int, int]:
    """Return the smallest and largest number of samples that a prediction uses."""
    return samples_in(SHORTEST, rate), samples_in(LONGEST, rate)


def cut_touch(volts: NDArray[Any], start: int, rate: float) -> Signals | None:
    """Cut the signal of one contact and subtract its baseline.

    Parameters
    ----------
    volts
        One vibration channel as the device sends it, V, shape (samples,).
    start
        Position of the contact. Missing samples after it become zeros.
    rate
        Sampling rate, Hz.

    Returns
    -------
    ndarray or None
        Signal, shape (samples,). None if there are too few samples before or after the contact, a
        value is not finite, or the signal is constant.
    """
    lead, longest = samples_in(BEFORE, rate), samples_in(LONGEST, rate)
    segment = volts[max(start - lead, 0) : start + longest]
    if start < lead or len(segment) < lead + lengths(rate)[0]:
        return None
    if not np.isfinite(segment).all() or np.ptp(segment) == 0.0:
        return None
    out = np.zeros(lead + longest, np.float32)
    out[: len(segment)] = segment - compute_baseline(segment, rate)
    return out


def compute_baseline(segment: NDArray[Any], rate: float) -> float:
    """Return the baseline, V, of a signal that begins ``BEFORE`` before its contact."""
    quiet_end = samples_in(BEFORE, rate) - samples_in(BASELINE_GUARD, rate)
    return float(segment[quiet_end - samples_in(BASELINE, rate) : quiet_end].mean())


def cut_touches(
    dataset: Dataset,
    contacts: Sequence[Contact | None],
    seconds: Sequence[Contact | None] | None = None,
) -> tuple[Touches, NDArray[np.intp]]:
    """Cut the contacts of pinches.

    Parameters
    ----------
    dataset
        The pinches.
    contacts
        First contact of each pinch; None if unknown.
    seconds
        Second contacts; by default those known from the pinches. Samples from the second contact on
        are not valid. A pinch has no valid samples if its first contact is not before the second.

    Returns
    -------
    touches : Touches
        Contacts of the pinches with a usable signal.
    which : ndarray
        Positions of these pinches in the dataset, shape (n,).
    """
    valid = np.minimum(
        valid_samples(dataset, contacts, seconds), samples_in(LONGEST, dataset.layout.rate)
    )
    signals, fingers, positions, speeds = [], [], [], []
    for place, (pinch, first) in enumerate(zip(dataset.pinches, contacts, strict=True)):
        signal = None if first is None else _signal(pinch, first)
        if first is None or signal is None:
            continue
        signals.append(signal)
        fingers.append(finger_number(first.finger))
        positions.append(place)
        speeds.append(speed_inputs(pinch.closing_speed))
    rate = dataset.layout.rate
    width = samples_in(BEFORE, rate) + samples_in(LONGEST, rate)
    touches = Touches.from_signals(
        np.array(signals, np.float32).reshape(-1, width),
        valid[positions],
        np.array(fingers, np.intp),
        rate,
    )
    values, errors = np.array(speeds, np.float64).reshape(-1, 2).T
    return replace(touches, speeds=values, speed_errors=errors), np.array(positions, np.intp)


def moments(rate: float) -> tuple[int, ...]:
    """Return the numbers of samples after a contact at which the network predicts."""
    first, last = round(SHORTEST / STEP), round(LONGEST / STEP)
    return tuple(samples_in(n * STEP, rate) for n in range(first, last + 1))


def speed_inputs(measured: ClosingSpeed | None) -> tuple[float, float]:
    """Return a speed, m/s, and its relative error for :class:`Touches`; NaN without a speed."""
    if measured is None:
        return math.nan, math.nan
    return measured.speed, measured.error / measured.speed


def valid_samples(
    dataset: Dataset,
    contacts: Sequence[Contact | None],
    seconds: Sequence[Contact | None] | None = None,
) -> NDArray[np.intp]:
    """Return the number of samples after each first contact in which only that finger touches."""
    second_contacts = [p.second for p in dataset.pinches] if seconds is None else list(seconds)
    out = np.zeros(len(dataset), np.intp)
    triples = zip(dataset.pinches, contacts, second_contacts, strict=True)
    for place, (pinch, first, second) in enumerate(triples):
        if first is not None:
            end = pinch.first_sample + len(pinch.data)
            end = end if second is None else min(end, second.sample)
            out[place] = max(end - first.sample, 0)
    return out


def finger_number(finger: Finger | None) -> int:
    """Return the number of a finger; -1 for None."""
    return -1 if finger is None else list(Finger).index(finger)


def _signal(pinch: Pinch, contact: Contact) -> Signals | None:
    columns = pinch.layout.columns(ChannelKind.VIBRATION, contact.finger)
    if not columns:
        return None
    volts = pinch.layout.physical(pinch.data, columns)
    smooth = DeviceSmoothing(pinch.layout, columns).update(volts)
    return cut_touch(smooth[:, 0], contact.sample - pinch.first_sample, pinch.layout.rate)


#: Shape hint of a flat object.
FLAT = "flat"
#: Smallest and largest radius of a hint, mm. The training had no smaller radii, and objects with
#: larger radii are as good as flat.
LEAST, MOST = 5.0, 200.0


def parse_radius(text: str) -> float:
    """Return the radius, m, that a hint states: "flat" (infinite) or a number in mm.

    An empty hint gives NaN.

    Raises
    ------
    InputError
        The hint is neither "flat" nor a number, or the radius is outside the training range.
    """
    word = text.strip().lower()
    if not word:
        return math.nan
    if word == FLAT:
        return math.inf
    try:
        radius = parse_float(word.removesuffix("mm"))
    except ValueError:
        radius = math.nan
    if not LEAST <= radius <= MOST:
        raise InputError(
            f"the shape of the object {text.strip()!r} is not known: give {FLAT}, or a radius "
            f"from {LEAST:g} to {MOST:g} mm"
        )
    return radius / 1000


def in_words(radius: float | None) -> str:
    """Return a radius as the text of a hint; "" for None or NaN."""
    if radius is None or math.isnan(radius):
        return ""
    return FLAT if math.isinf(radius) else f"radius {1000 * radius:g} mm"
