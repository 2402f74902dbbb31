"""Windows of signal after a contact, the input of the window models.

The baseline of a window is the mean of the quiet signal shortly before its contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block, ChannelKind, Contact, Dataset, Layout, Physical
from firstcontact.signal._filters import DeviceSmoothing, SavitzkyGolay

#: Longest quiet part before the contact whose mean (the quiet level) is subtracted, s.
BASELINE = 0.020
#: Time between this quiet part and the contact, s, because a detector may be a little late.
BASELINE_GUARD = 0.002
#: Shortest quiet part, s. Windows with less quiet are refused.
BASELINE_LEAST = 0.002
#: Longest time from a contact to the newest sample when the contact is passed to a stream, s.
MEMORY = 0.050


def samples_in(duration: float, rate: float) -> int:
    """Return the number of whole samples in a duration, rounded: 15 ms at 4936 Hz are 74."""
    return round(duration * rate)


class Conditioner:
    """Filters before windows are cut: smoothing (unless the device did it) and Savitzky-Golay."""

    lookahead = SavitzkyGolay.lookahead

    def __init__(self, layout: Layout, columns: tuple[int, ...] | None = None) -> None:
        self._smoothing = DeviceSmoothing(layout, columns)
        self._savgol = SavitzkyGolay()

    def update(self, volts: NDArray[Any]) -> NDArray[np.float64]:
        """Filter the next samples (n, channels). Return the new outputs, shape (m, channels)."""
        return self._savgol.update(self._smoothing.update(volts))


def cut_window(
    conditioned: NDArray[np.float64], start: int, length: int, rate: float
) -> NDArray[np.float32] | None:
    """Cut one window and subtract the quiet level before it."""
    quiet_end = start - samples_in(BASELINE_GUARD, rate)
    quiet_start = max(0, quiet_end - samples_in(BASELINE, rate))
    if quiet_end - quiet_start < max(1, samples_in(BASELINE_LEAST, rate)):
        return None
    if start + length > len(conditioned):
        return None
    window = conditioned[start : start + length] - conditioned[quiet_start:quiet_end].mean()
    if not np.isfinite(window).all() or np.ptp(window) == 0.0:
        return None
    out: NDArray[np.float32] = window.astype(np.float32)[:, None]
    return out


def contact_windows(
    dataset: Dataset,
    contacts: Sequence[Contact | None],
    duration: float,
    *,
    conditioned: bool = True,
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Cut a window of signal after each contact, one per pinch. Window models use them as input.

    Parameters
    ----------
    dataset
        The pinches.
    contacts
        Contact of each pinch, at which its window starts; None for a pinch without contact.
    duration
        Length of the windows, s.
    conditioned
        True to smooth the signal first, as the package's window models need it; False to use it
        as the device sent it.

    Returns
    -------
    windows : ndarray
        Vibration of the contact's finger minus its mean before the contact, in the channel's unit
        (V for piezos), shape (pinches with a window, samples, 1).
    kept : ndarray
        Boolean mask of the pinches with a window, shape (pinches,). A window needs a contact and a
        sensor on that finger. The pinch must contain the window, the look-ahead of the filter, and
        at least 2 ms of signal that end 2 ms before the contact. The window must be finite and not
        constant.
    """
    has_window = np.zeros(len(dataset), dtype=np.bool_)
    windows: list[NDArray[np.float32]] = []
    length = 0
    for i, (pinch, contact) in enumerate(zip(dataset.pinches, contacts, strict=True)):
        length = samples_in(duration, pinch.layout.rate)
        if contact is None:
            continue
        columns = pinch.layout.columns(ChannelKind.VIBRATION, contact.finger)
        if not columns:
            continue
        volts = pinch.layout.physical(pinch.data, columns)
        signal = Conditioner(pinch.layout, columns).update(volts) if conditioned else volts
        window = cut_window(
            signal[:, 0], contact.sample - pinch.first_sample, length, pinch.layout.rate
        )
        if window is not None:
            has_window[i] = True
            windows.append(window)
    if not windows:
        return np.zeros((0, length, 1), dtype=np.float32), has_window
    return np.stack(windows), has_window


@dataclass(frozen=True, slots=True, eq=False)
class ContactWindow:
    """Window of one contact, cut from a stream.

    Parameters
    ----------
    contact, duration
        Contact at the start of the window, and length of the window, s.
    samples
        Samples of the window minus the signal's mean before the contact, in the channel's unit (V
        for piezos), shape (samples, 1).
    complete
        Device number of the last sample that the window and its smoothing filter needed.
    """

    contact: Contact
    duration: float
    samples: NDArray[np.float32]
    complete: int


class WindowStream:
    """Streaming form of :func:`contact_windows`: cuts windows after contacts from blocks.

    Parameters
    ----------
    layout
        Columns of the blocks.
    durations
        Lengths of the windows, s. One window of each length is cut after each contact.
    """

    def __init__(self, layout: Layout, durations: Sequence[float]) -> None:
        self.layout = layout
        self.durations = tuple(sorted(durations))
        self._lengths = [samples_in(d, layout.rate) for d in self.durations]
        self._columns = layout.columns(ChannelKind.VIBRATION)
        self._fingers = layout.vibration_fingers
        self._volts = Physical(layout, self._columns)
        longest = max(self._lengths, default=0)
        self._remember = longest + samples_in(MEMORY + BASELINE + BASELINE_GUARD, layout.rate)
        #: Number of windows that were refused: they span a gap, are not finite or constant, or
        #: their contact was reported too late.
        self.refused = 0
        self._pending: list[tuple[Contact, int]] = []
        self._restart(0, 0)

    def _restart(self, first_sample: int, epoch: int) -> None:
        self.refused += len(self._pending)
        self._pending = []
        self._conditioner = Conditioner(self.layout)
        self._past = np.zeros((0, len(self._columns)))
        self._past_first = first_sample
        self._end = first_sample
        self._epoch = epoch

    @property
    def due(self) -> int | None:
        """Number of samples until the next window is complete; None if no window is waiting."""
        ends = [self._complete(contact, n) + 1 - self._end for contact, n in self._pending]
        return min(ends, default=None)

    def withdraw(self) -> None:
        """Drop all incomplete windows, because their contact turned out to be false."""
        self._pending = []

    def update(self, block: Block, contacts: Sequence[Contact] = ()) -> list[ContactWindow]:
        """Process the next block and the contacts in it. Return the windows that are now complete.

        If samples are missing before the block, all incomplete windows are dropped, so that no
        window spans a gap.
        """
        if block.first_sample != self._end or block.epoch != self._epoch:
            self._restart(block.first_sample, block.epoch)
        conditioned = self._conditioner.update(self._volts(block.data))
        self._past = np.concatenate([self._past, conditioned])
        self._end = block.end
        self._pending += [(contact, n) for contact in contacts for n in range(len(self._lengths))]
        complete_windows = []
        for pending in list(self._pending):
            contact, n = pending
            complete = self._complete(contact, n)
            if complete >= self._end:
                continue
            self._pending.remove(pending)
            window = self._window(contact, self._lengths[n])
            if window is None:
                self.refused += 1
            else:
                complete_windows.append(ContactWindow(contact, self.durations[n], window, complete))
        self._forget()
        return complete_windows

    def _complete(self, contact: Contact, n: int) -> int:
        return contact.sample + self._lengths[n] - 1 + self._conditioner.lookahead

    def _window(self, contact: Contact, length: int) -> NDArray[np.float32] | None:
        start = contact.sample - self._past_first
        if contact.finger not in self._fingers or start < 0:
            return None
        column = self._fingers.index(contact.finger)
        return cut_window(self._past[:, column], start, length, self.layout.rate)

    def _forget(self) -> None:
        surplus = len(self._past) - self._remember
        # Removing samples in large lumps is cheaper than moving the rest for every block.
        if surplus > self._remember:
            self._past = self._past[surplus:].copy()
            self._past_first += surplus
