"""Signal of a contact in a stream of blocks, cut at each millisecond from 2 to 15."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block, ChannelKind, ClosingSpeed, Contact, Layout, Physical
from firstcontact.models._touches import (
    BEFORE,
    LONGEST,
    SHORTEST,
    Signals,
    Touches,
    compute_baseline,
    cut_touch,
    finger_number,
    lengths,
    speed_inputs,
)
from firstcontact.signal import MEMORY, DeviceSmoothing, samples_in

#: Time between two predictions, s.
STEP = 0.001


def moments(rate: float) -> tuple[int, ...]:
    """Return the numbers of samples after a contact at which the network predicts."""
    first, last = round(SHORTEST / STEP), round(LONGEST / STEP)
    return tuple(samples_in(n * STEP, rate) for n in range(first, last + 1))


class TouchStream:
    """Stream that cuts one contact block by block, like :func:`firstcontact.models.cut_touches`.

    A stream handles one contact, because a closing has one first contact. It needs no look-ahead: a
    result is available with the last sample that it needs.

    Parameters
    ----------
    layout
        Columns of the blocks.
    radius
        Radius of the object, m: infinite for a flat one, NaN if unknown.
    """

    def __init__(self, layout: Layout, radius: float = np.nan) -> None:
        self._layout = layout
        self._radius = radius
        #: Measured closing speed before the contact; None without one.
        self.speed: ClosingSpeed | None = None
        self._columns = layout.columns(ChannelKind.VIBRATION)
        self._fingers = layout.vibration_fingers
        self._volts = Physical(layout, self._columns)
        self._remember = samples_in(BEFORE + MEMORY + LONGEST, layout.rate)
        self._contact: Contact | None = None
        self._left: tuple[int, ...] = moments(layout.rate)
        self._signal: Signals | None = None  # signal of the contact so far
        self._cut = 0  # number of its samples after the contact
        self._baseline = 0.0
        self._longest = lengths(layout.rate)[1]
        #: Reason why further predictions are missing; "" if none is missing.
        self.refused = ""
        self._restart(0, 0)

    def _restart(self, first_sample: int, epoch: int) -> None:
        if self._contact is not None and self._left:
            self._refuse("samples after the contact were lost")
        self._smoothing = DeviceSmoothing(self._layout, self._columns)
        self._past = np.zeros((0, len(self._columns)))
        self._end = first_sample
        self._epoch = epoch

    @property
    def ended(self) -> bool:
        """True if no further prediction will come."""
        return not self._left

    @property
    def due(self) -> int | None:
        """Number of samples until the next prediction; None without a contact or after the last."""
        if self._contact is None or not self._left:
            return None
        return self._contact.sample + self._left[0] - self._end

    def withdraw(self) -> None:
        """Discard the contact, and wait for another contact."""
        self._contact = self._signal = self.speed = None
        self._left, self._cut, self.refused = moments(self._layout.rate), 0, ""

    def update(self, block: Block, contact: Contact | None = None) -> Touches | None:
        """Process the next block, and the contact if the block has one.

        Returns
        -------
        Touches or None
            One row for each millisecond after the contact that these samples completed, the
            shortest first; None if they completed none. In each row, samples after the row's
            millisecond are not valid.
        """
        counts = self.advance(block, contact)
        return self.touches(counts) if counts else None

    def advance(self, block: Block, contact: Contact | None = None) -> tuple[int, ...]:
        """Process samples as :meth:`update` does.

        Returns
        -------
        tuple of int
            Moments that these samples completed, each as its number of samples after the contact.
        """
        if not self._left:
            return ()
        if block.first_sample != self._end or block.epoch != self._epoch:
            self._restart(block.first_sample, block.epoch)
        smooth = self._smoothing.update(self._volts(block.data))
        self._past = np.concatenate([self._past[-self._remember :], smooth])
        self._end = block.end
        if contact is not None:
            self._contact = contact
        return self._complete()

    def touches(self, counts: Sequence[int]) -> Touches:
        """Return the contact once per item of ``counts``, with that many valid samples at most."""
        assert self._signal is not None
        assert self._contact is not None
        return self._touches(self._contact, self._signal, np.array(counts, np.intp))

    @property
    def wave(self) -> Signals:
        """Signal from the contact on, valid up to the last completed moment, shape (samples,)."""
        assert self._signal is not None
        return self._signal[len(self._signal) - self._longest :]

    def approach(self) -> Touches | None:
        """Return the contact with only the signal before it; None without a contact.

        Use it for results that depend only on the signal before the contact.
        """
        contact = self._contact
        if contact is None or contact.finger not in self._fingers:
            return None
        shortest = lengths(self._layout.rate)[0]
        start = len(self._past) - (self._end - contact.sample)
        if start < 0:
            return None
        column = self._past[:start, self._fingers.index(contact.finger)]
        column = np.concatenate([column, np.zeros(self._longest)])
        signal = cut_touch(column, start, self._layout.rate)
        return None if signal is None else self._touches(contact, signal, np.array([shortest]))

    def _signal_until(self, contact: Contact, available: int) -> Signals | None:
        """Return the signal of the contact so far; None if it cannot be used."""
        start = len(self._past) - available
        if contact.finger not in self._fingers or start < 0:
            return None
        rate = self._layout.rate
        column = self._past[:, self._fingers.index(contact.finger)]
        longest = self._longest
        if self._signal is None:
            self._signal = cut_touch(column, start, rate)
            self._baseline = compute_baseline(
                column[max(start - samples_in(BEFORE, rate), 0) :], rate
            )
        else:  # add what is new
            until = min(available, longest)
            new = column[start + self._cut : start + until]
            self._signal[len(self._signal) - longest :][self._cut : until] = new - self._baseline
            if not np.isfinite(new).all():
                return None
        self._cut = min(available, longest)
        return self._signal

    def _touches(self, contact: Contact, signal: Signals, valid: NDArray[np.intp]) -> Touches:
        n = len(valid)
        speed, error = speed_inputs(self.speed)
        return Touches(
            signals=signal[None].repeat(n, axis=0),
            valid=valid,
            fingers=np.full(n, finger_number(contact.finger), np.intp),
            speeds=np.full(n, speed),
            speed_errors=np.full(n, error),
            radii=np.full(n, self._radius),
            rate=self._layout.rate,
        )

    def _complete(self) -> tuple[int, ...]:
        contact = self._contact
        if contact is None:
            return ()
        available = self._end - contact.sample
        counts = tuple(n for n in self._left if n <= available)
        if not counts:
            return ()
        if self._signal_until(contact, available) is None:
            self._refuse(
                "there is too little signal before the contact, or the piezo gives no signal"
            )
            return ()
        self._left = self._left[len(counts) :]
        return counts

    def _refuse(self, why: str) -> None:
        self.refused, self._left = why, ()
