"""From a contact to the window that a stiffness is read from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block, ChannelKind, Contact, Dataset, Layout, Physical
from firstcontact.signal._savgol import SavitzkyGolay
from firstcontact.signal._smoothing import DeviceSmoothing

#: The baseline is the mean of this much quiet before the contact, s ...
BASELINE = 0.020
#: ... that ends this long before it, s: a detected contact may be a little late.
BASELINE_GUARD = 0.002
#: With less quiet than this, s, a window has no baseline and is refused.
BASELINE_LEAST = 0.002
#: So long before the newest sample a contact may lie when a stream is told of it, s.
MEMORY = 0.050


def samples_in(duration: float, rate: float) -> int:
    """Whole samples in a duration, rounded: 15 ms at 4936 Hz are 74."""
    return round(duration * rate)


class Conditioner:
    """What is done to a vibration before a window is cut from it.

    Exponential smoothing where the device has not done it already (never
    twice), then Savitzky–Golay. Output i belongs to input i and comes
    :attr:`lookahead` samples later.

    Parameters
    ----------
    layout
        Says at what rate the samples come and what was done to them.
    columns
        Which of its columns come; by default those of vibration.
    """

    def __init__(self, layout: Layout, columns: tuple[int, ...] | None = None) -> None:
        self._smoothing = DeviceSmoothing(layout, columns)
        self._savgol = SavitzkyGolay()

    @property
    def lookahead(self) -> int:
        """Samples after the current one that its output needs."""
        return self._savgol.lookahead

    def update(self, volts: NDArray[Any]) -> NDArray[np.float64]:
        """Condition the next samples, (n, channels) to (m, channels)."""
        return self._savgol.update(self._smoothing.update(volts))


def cut(
    conditioned: NDArray[np.float64], start: int, length: int, rate: float
) -> NDArray[np.float32] | None:
    """Cut one window and take its baseline off.

    Parameters
    ----------
    conditioned
        One vibration channel after the :class:`Conditioner`, shape (samples,), V.
    start
        Position of the contact.
    length
        Samples in the window.
    rate
        Sampling rate, Hz.

    Returns
    -------
    ndarray or None
        Shape (length, 1); None when the window or its baseline is not whole,
        not finite, or when it does not move at all (an unplugged sensor).
    """
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
    """Windows of the fingers that touched, one a pinch.

    Parameters
    ----------
    dataset
        The pinches.
    contacts
        Where each pinch's window starts, and on which finger; None where no
        contact is known.
    duration
        Length of the windows, s.
    conditioned
        Whether the signal goes through the :class:`Conditioner`; without it, it is as the
        device sent it.

    Returns
    -------
    windows : ndarray
        Shape (pinches kept, samples, 1), V.
    kept : ndarray
        Shape (pinches,). Not kept: no contact, a finger without a sensor, a
        window that the pinch does not hold whole (with the look-ahead of the
        filter and at least 2 ms of quiet before it), one that is not finite
        or constant.

    Raises
    ------
    ValueError
        When there are not as many contacts as pinches.
    """
    if len(contacts) != len(dataset):
        raise ValueError(f"{len(contacts)} contacts for {len(dataset)} pinches")
    kept = np.zeros(len(dataset), dtype=np.bool_)
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
        window = cut(signal[:, 0], contact.sample - pinch.first_sample, length, pinch.layout.rate)
        if window is not None:
            kept[i] = True
            windows.append(window)
    if not windows:
        return np.zeros((0, length, 1), dtype=np.float32), kept
    return np.stack(windows), kept


@dataclass(frozen=True, slots=True, eq=False)
class ContactWindow:
    """A window as it becomes complete in a stream.

    Parameters
    ----------
    contact
        The contact that it starts at.
    duration
        Its length, s.
    samples
        Shape (samples, 1), V, baseline removed.
    complete
        Number of the device sample after whose arrival it was complete; the
        look-ahead of the filter is in it.
    """

    contact: Contact
    duration: float
    samples: NDArray[np.float32]
    complete: int


class WindowStream:
    """The live form of :func:`contact_windows`: the same numbers, block by block.

    Parameters
    ----------
    layout
        The columns of the blocks.
    durations
        Lengths of the windows, s; each contact gives one of each.
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
        #: Windows refused: across a gap, not finite, constant, or told too late.
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
        """So many more samples complete the next window; None where none has begun."""
        ends = [self._complete(contact, n) + 1 - self._end for contact, n in self._pending]
        return min(ends, default=None)

    def update(self, block: Block, contacts: Sequence[Contact] = ()) -> list[ContactWindow]:
        """Take the next block, and the contacts that were found in it.

        A block that does not follow the one before drops the windows begun:
        none is ever made across a gap.

        Returns
        -------
        list of ContactWindow
            Those that this block completed, in the order of their contacts, shorter ones first.
        """
        if block.first_sample != self._end or block.epoch != self._epoch:
            self._restart(block.first_sample, block.epoch)
        conditioned = self._conditioner.update(self._volts(block.data))
        self._past = np.concatenate([self._past, conditioned])
        self._end = block.end
        self._pending += [(contact, n) for contact in contacts for n in range(len(self._lengths))]
        done = []
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
                done.append(ContactWindow(contact, self.durations[n], window, complete))
        self._forget()
        return done

    def _complete(self, contact: Contact, n: int) -> int:
        return contact.sample + self._lengths[n] - 1 + self._conditioner.lookahead

    def _window(self, contact: Contact, length: int) -> NDArray[np.float32] | None:
        start = contact.sample - self._past_first
        if contact.finger not in self._fingers or start < 0:
            return None
        column = self._fingers.index(contact.finger)
        return cut(self._past[:, column], start, length, self.layout.rate)

    def _forget(self) -> None:
        surplus = len(self._past) - self._remember
        # Dropped in lumps: moving the rest for every block would cost more.
        if surplus > self._remember:
            self._past = self._past[surplus:].copy()
            self._past_first += surplus
