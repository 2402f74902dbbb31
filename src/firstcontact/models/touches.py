"""Contacts with the signals around them, and optional hints: closing speed and object radius.

The baseline of a signal is its mean shortly before the contact. Valid samples are those that a
prediction may use: they end before the second finger's contact.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ChannelKind, ClosingSpeed, Contact, Dataset, Finger, Pinch
from firstcontact.core.layout import FINGERTIP_WINDOW
from firstcontact.core.physics import parse_radius
from firstcontact.models.values import Values
from firstcontact.signal import DeviceSmoothing, samples_in
from firstcontact.signal.windowing import BASELINE, BASELINE_GUARD

Signals = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class Touches:
    """Vibration signals around contacts, with closing speeds and object radii, a row per contact.

    Parameters
    ----------
    signals
        Vibration in V as the device sends it, with the baseline removed, shape (n, samples). Each
        signal lasts from ``BEFORE`` before the contact to ``LONGEST`` after it. Samples after
        ``valid`` are ignored.
    valid
        Number of samples from the contact to the second finger's contact or the end, shape (n,).
    fingers
        Finger of the contact, shape (n,): 0 is the index finger, 1 the thumb, -1 unknown.
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

    #: Length of the signal before the contact, s. It contains the noise of the moving motor.
    BEFORE: ClassVar[float] = 0.040
    #: Times after the contact at which the network predicts, and the first and last of them, s.
    TIMES: ClassVar[tuple[float, ...]] = tuple(n / 1000 for n in range(2, 16))
    SHORTEST: ClassVar[float] = TIMES[0]
    LONGEST: ClassVar[float] = FINGERTIP_WINDOW
    #: Times after the contact at which predictions are scored, ms.
    SCORED_MS: ClassVar[tuple[int, ...]] = (2, 3, 5, 8, 15)

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
        """Return contacts with these signals, and with unknown (NaN) speeds and radii."""
        unknown = np.full(len(signals), np.nan)
        return cls(signals, valid, fingers, unknown, unknown.copy(), unknown.copy(), rate)

    @classmethod
    def cut(
        cls, dataset: Dataset, contacts: Sequence[Contact | None]
    ) -> tuple[Touches, NDArray[np.intp]]:
        """Cut the signals around the first contacts of pinches.

        ``contacts`` holds the first contact of each pinch, None if unknown. Return the contacts
        with a usable signal, and the positions of their pinches in the dataset. Samples count as
        valid up to the second finger's contact, if the dataset contains it. Labels state speeds and
        shapes.
        """
        rate = dataset.layout.rate
        longest = samples_in(cls.LONGEST, rate)
        signals, fingers, positions, speeds, radii = [], [], [], [], []
        for place, (pinch, first) in enumerate(zip(dataset.pinches, contacts, strict=True)):
            signal = None if first is None else _signal(pinch, first)
            if first is None or signal is None:
                continue
            signals.append(signal)
            fingers.append(finger_number(first.finger))
            positions.append(place)
            speeds.append(speed_inputs(pinch.closing_speed))
            radii.append(parse_radius(pinch.label.shape))
        width = samples_in(cls.BEFORE, rate) + longest
        touches = cls.from_signals(
            np.array(signals, np.float32).reshape(-1, width),
            np.minimum(valid_samples(dataset, contacts), longest)[positions],
            np.array(fingers, np.intp),
            rate,
        )
        values, errors = np.array(speeds, np.float64).reshape(-1, 2).T
        touches = replace(
            touches, speeds=values, speed_errors=errors, radii=np.array(radii, np.float64)
        )
        return touches, np.array(positions, np.intp)

    @classmethod
    def cut_signal(cls, volts: NDArray[Any], start: int, rate: float) -> Signals | None:
        """Return the signal of one contact with its baseline removed, shape (samples,).

        ``volts`` is one vibration channel as the device sends it, and ``start`` the position of the
        contact in it. Missing samples after the contact become zeros. Return None if there are too
        few samples before or after the contact, a value is not finite, or the signal is constant.
        """
        lead, longest = samples_in(cls.BEFORE, rate), samples_in(cls.LONGEST, rate)
        segment = volts[max(start - lead, 0) : start + longest]
        if start < lead or len(segment) < lead + samples_in(cls.SHORTEST, rate):
            return None
        if not np.isfinite(segment).all() or np.ptp(segment) == 0.0:
            return None
        quiet_end = lead - samples_in(BASELINE_GUARD, rate)
        out = np.zeros(lead + longest, np.float32)
        out[: len(segment)] = segment - float(
            segment[quiet_end - samples_in(BASELINE, rate) : quiet_end].mean()
        )
        return out

    @classmethod
    def lengths(cls, rate: float) -> tuple[int, int]:
        """Return the smallest and largest number of samples for a prediction at ``rate``, Hz."""
        return samples_in(cls.SHORTEST, rate), samples_in(cls.LONGEST, rate)

    @classmethod
    def all_lengths(cls, rate: float) -> tuple[int, ...]:
        """Return all numbers of samples that predictions use at ``rate``, Hz, ascending."""
        return tuple(samples_in(time, rate) for time in cls.TIMES)

    @property
    def answerable(self) -> NDArray[np.bool_]:
        """Mask of the contacts with enough valid samples for a prediction, shape (n,)."""
        return self.valid >= self.lengths(self.rate)[0]

    @property
    def lead(self) -> int:
        """Number of samples before the contact in each signal."""
        return samples_in(self.BEFORE, self.rate)

    @property
    def waves(self) -> Signals:
        """Signals from the contact on, V, shape (n, samples after the contact)."""
        return self.signals[:, self.lead :]

    @property
    def arrays(self) -> tuple[NDArray[Any], ...]:
        """Arrays of the contacts, in the order in which the compiled functions take them."""
        hints = self.speeds, self.speed_errors, self.radii
        return self.signals, self.valid, self.fingers, *hints

    def take(self, rows: NDArray[Any]) -> Touches:
        """Return the contacts in these rows, given as positions or a boolean mask."""
        arrays = {f.name: getattr(self, f.name)[rows] for f in fields(self) if f.name != "rate"}
        return Touches(rate=self.rate, **arrays)

    def as_blocks(self) -> Touches:
        """Return a copy in which objects of unknown radius count as flat, such as blocks."""
        return replace(self, radii=np.where(np.isnan(self.radii), np.inf, self.radii))

    def until(self, samples: int) -> Touches:
        """Return a copy of the contacts in which at most this number of samples is valid."""
        return replace(self, valid=np.minimum(self.valid, samples))


def speed_inputs(measured: ClosingSpeed | None) -> tuple[float, float]:
    """Return a closing speed (m/s) and its relative standard error, as used in :class:`Touches`.

    Both are NaN if no speed was measured.
    """
    if measured is None:
        return math.nan, math.nan
    return measured.speed, measured.error / measured.speed


def valid_samples(dataset: Dataset, contacts: Sequence[Contact | None]) -> NDArray[np.intp]:
    """Return the number of samples from each first contact to the second or the end, (pinches,).

    It is 0 for a pinch without a contact.
    """
    out = np.zeros(len(dataset), np.intp)
    for place, (pinch, first) in enumerate(zip(dataset.pinches, contacts, strict=True)):
        if first is not None:
            end = pinch.first_sample + len(pinch.data)
            end = end if pinch.second is None else min(end, pinch.second.sample)
            out[place] = max(end - first.sample, 0)
    return out


def finger_number(finger: Finger | None) -> int:
    """Return 0 for the index finger, 1 for the thumb, -1 for None."""
    return -1 if finger is None else list(Finger).index(finger)


def _signal(pinch: Pinch, contact: Contact) -> Signals | None:
    columns = pinch.layout.columns(ChannelKind.VIBRATION, contact.finger)
    if not columns:
        return None
    volts = pinch.layout.physical(pinch.data, columns)
    smooth = DeviceSmoothing(pinch.layout, columns).update(volts)
    return Touches.cut_signal(smooth[:, 0], contact.sample - pinch.first_sample, pinch.layout.rate)
