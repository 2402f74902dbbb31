"""Confirmation of first contacts: a contact whose signal rings or swells is withdrawn.

A latch reports the contact of each finger once in a closing, see
:mod:`firstcontact.contact._detector`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact._detector import WindowDecisions, fired_windows, latch_window
from firstcontact.contact._stream import finite_runs
from firstcontact.core import Block, ChannelKind, Contact, Finger, Layout, Physical
from firstcontact.signal import DeviceSmoothing, samples_in

#: Time after a first contact at which it is confirmed or withdrawn, s.
CONFIRMED = 0.003
#: Length of the newest part of that time, s. Its RMS over that before the contact is the level.
LASTING = 0.002
#: Least level of a push, and the level above which no click is assumed.
FAINT, CLEAR = 4.0, 20.0
#: Largest mean change of a push within ``LAG`` (s), relative to its mean deviation from the signal
#: before it. A finger that pushes gives 0.1 to 0.2, a tone of 300 Hz 0.35, and a click 0.4 to 1.3.
ROUGHEST, LAG = 0.35, 0.0002
#: The signal before the contact is taken from BEFORE to GUARD before it, s.
BEFORE, GUARD = 0.017, 0.001
#: Length of the newest part of a closing that is stored, s. It is longer than the times above and
#: the delay of a decision together.
KEPT = 0.1


@dataclass(frozen=True, slots=True)
class Withdrawal:
    """First contact that the signal after it did not confirm.

    Parameters
    ----------
    contact
        Withdrawn contact.
    decided
        Last sample that the decision depends on.
    """

    contact: Contact
    decided: int


class ConfirmingLatch:
    """Latch of the fingers in one closing. It withdraws a first contact that does not last.

    A finger that meets an object pushes for milliseconds. A click of the gears or a burst of
    interference changes faster, and a swell of the motor is faint. So a first contact is withdrawn
    after 3 ms if its signal is faint or changes faster than a push. A signal 20 times louder than
    the motor is confirmed, however fast it changes. All later contacts are withdrawn with the first
    one, and the fingers can report contacts again. Without a motor, as for a sensor that a person
    moves, no contact is withdrawn.

    The result does not depend on the sizes of the blocks.

    Parameters
    ----------
    layout
        Columns of the blocks.

    Attributes
    ----------
    latched
        Fingers that reported a contact. A withdrawal removes them.
    is_confirmed
        True once no contact can be withdrawn any more.
    """

    def __init__(self, layout: Layout) -> None:
        self._layout, self._rate = layout, layout.rate
        self._fingers = layout.vibration_fingers
        self._volts = Physical(layout, layout.columns(ChannelKind.VIBRATION))
        self._smoothing = DeviceSmoothing(layout)
        self._past: list[NDArray[np.float64]] = []
        self._past_first = self._end = self._epoch = 0
        self._first: Contact | None = None  # waiting for its confirmation
        self._not_before = 0  # earlier onsets repeat the withdrawn contact
        self.latched: set[Finger | None] = set()
        self.is_confirmed = None in layout.vibration_fingers

    @property
    def due(self) -> int | None:
        """Number of samples until the first contact is confirmed or withdrawn.

        None if no contact waits for its confirmation.
        """
        return None if self._first is None else self._due_sample(self._first) + 1 - self._end

    def remember(self, block: Block) -> None:
        """Store the samples of a block, unless no contact can be withdrawn any more."""
        if self.is_confirmed:
            return
        if block.first_sample != self._end or block.epoch != self._epoch:
            self._smoothing = DeviceSmoothing(self._layout)
            self._past, self._past_first = [], block.first_sample
            if self._first is not None:  # samples that would decide are lost: the contact stands
                self.is_confirmed, self._first = True, None
        self._past.append(self._smoothed(self._volts(block.data)))
        self._end, self._epoch = block.end, block.epoch
        oldest = block.first_sample - samples_in(KEPT, self._rate)
        while self._past_first + len(self._past[0]) < oldest:
            self._past_first += len(self._past.pop(0))

    def update(self, block: Block, decisions: WindowDecisions) -> list[Contact | Withdrawal]:
        """Return the contacts and withdrawals that a block reveals, in order.

        Parameters
        ----------
        block
            Samples that :meth:`remember` has stored.
        decisions
            Decisions for the windows that the block completes.
        """
        events: list[Contact | Withdrawal] = []
        for end, onsets in fired_windows(decisions):
            events += self._confirm(end + 1)
            later = [
                onset if onset is None or onset >= self._not_before else None for onset in onsets
            ]
            contacts = latch_window(end, later, self._fingers, self.latched)
            if contacts and not self.is_confirmed and self._first is None:
                self._first = contacts[0]
            events += contacts
        return events + self._confirm(block.end)

    def newest(self, count: int, age: int, end: int) -> NDArray[np.float64] | None:
        """Return the smoothed samples before sample ``end - age``, V; None if there are too few.

        Parameters
        ----------
        count
            Number of samples.
        age
            Number of samples between the last returned sample and ``end``.
        end
            Number of the sample from which ``age`` counts back.

        Returns
        -------
        ndarray or None
            Shape (count, fingers).
        """
        begin = end - age - count
        if begin < self._past_first or not self._past:
            return None
        first, samples = self._end - len(self._past[-1]), self._past[-1]
        if begin < first:
            first, samples = self._past_first, np.concatenate(self._past)
        out: NDArray[np.float64] = samples[begin - first : begin - first + count]
        return out

    def _due_sample(self, contact: Contact) -> int:
        """Return the last sample that the confirmation of a contact depends on."""
        return max(contact.sample + samples_in(CONFIRMED, self._rate) - 1, contact.decided)

    def _confirm(self, end: int) -> list[Withdrawal]:
        """Confirm or withdraw the first contact if the samples before ``end`` suffice."""
        first = self._first
        if first is None or self._due_sample(first) >= end:
            return []
        self._first = None
        if self._pushes(first):
            self.is_confirmed = True
            self._past = []
            return []
        self.latched.clear()
        self._not_before = first.sample + 1
        return [Withdrawal(first, self._due_sample(first))]

    def _pushes(self, contact: Contact) -> bool:
        """Return True if the signal after a contact is a push, or much louder than the motor."""
        x = np.concatenate(self._past)[:, self._fingers.index(contact.finger)]
        place = contact.sample - self._past_first
        start = max(place - samples_in(BEFORE, self._rate), 0)
        earlier = x[start : place - samples_in(GUARD, self._rate)]
        if not len(earlier):
            return True
        later = x[place : place + samples_in(CONFIRMED, self._rate)]
        return bool(is_push(earlier, later, self._rate))

    def _smoothed(self, volts: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return smoothed samples. Smoothing restarts after samples that are not finite."""
        if np.isfinite(volts).all():  # nearly always, and quicker
            return self._smoothing.update(volts)
        out, end = np.full(volts.shape, np.nan), 0
        for begin, run in finite_runs(volts, 0):
            if begin != end:
                self._smoothing = DeviceSmoothing(self._layout)
            end = begin + len(run)
            out[begin:end] = self._smoothing.update(run)
        if end != len(volts):
            self._smoothing = DeviceSmoothing(self._layout)
        return out


def is_push(
    earlier: NDArray[np.float64], later: NDArray[np.float64], rate: float
) -> NDArray[np.bool_]:
    """Return a mask of the contacts whose signal looks like that of a finger that pushes.

    A contact after a constant signal, or with samples that are not finite, counts as a push.

    Parameters
    ----------
    earlier
        Signals in the ``BEFORE`` seconds before each contact without the last ``GUARD``, shape
        (..., samples).
    later
        Signals in the ``CONFIRMED`` seconds from each contact on, shape (..., samples).
    rate
        Sampling rate, Hz.
    """
    later = later - earlier.mean(axis=-1, keepdims=True)
    lag = max(1, samples_in(LAG, rate))
    change = np.abs(later[..., lag:] - later[..., :-lag]).sum(axis=-1) / later.shape[-1]
    is_rough = change > ROUGHEST * np.abs(later).mean(axis=-1)
    newest = np.sqrt(np.mean(later[..., -samples_in(LASTING, rate) :] ** 2, axis=-1))
    least = np.where(is_rough, CLEAR, FAINT) * earlier.std(axis=-1)
    return np.asarray(~(newest <= least) | (np.ptp(earlier, axis=-1) == 0.0))
