"""Confirmation of first contacts: a contact whose signal rings or swells is withdrawn.

A latch reports the contact of each finger once in a closing, see
:mod:`firstcontact.contact._detector`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact._closing_start import closing_start
from firstcontact.contact._detector import (
    Detector,
    WindowDecisions,
    fired_windows,
    latch_window,
)
from firstcontact.contact._stream import WindowDetector, finite_runs
from firstcontact.core import Block, ChannelKind, Contact, Finger, Layout, Physical, Pinch
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
#: Time between two steady states of a closing, and the age of the newest sample of each, s. A
#: contact is detected before it is that old.
RESETTLED, SETTLED = 0.01, 0.008
#: Length of the pieces in which pinches are judged, s. Pieces after the last contact are not
#: judged.
PIECE = 0.05


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
        first, kept = self._end - len(self._past[-1]), self._past[-1]
        if begin < first:
            first, kept = self._past_first, np.concatenate(self._past)
        out: NDArray[np.float64] = kept[begin - first : begin - first + count]
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


class _Judge:
    """Decisions of a detector whose steady state follows a motor that becomes quieter.

    A motor is loudest when it starts, and the first steady state is measured soon after its start.
    So the steady state is measured again at intervals, until the first contact is confirmed.

    Parameters
    ----------
    detector
        Fitted or loaded detector.
    layout
        Columns of the blocks.
    resettles
        False to keep the first steady state, as the C code of the hand does.
    """

    def __init__(self, detector: Detector, layout: Layout, resettles: bool = True) -> None:
        detector.start(layout)
        self._detector = detector
        self._resettles = resettles
        # Other detectors do not announce their next decision: it may come with any sample.
        self.windowed = detector if isinstance(detector, WindowDetector) else None
        self.latch = ConfirmingLatch(layout)
        self._every, self._age = (samples_in(t, layout.rate) for t in (RESETTLED, SETTLED))
        #: Number of samples until the steady state is measured again.
        self._left = self._every
        #: True once a quieter steady state has replaced the first one.
        self.has_resettled = False

    def update(self, block: Block) -> Iterator[tuple[WindowDecisions, list[Contact | Withdrawal]]]:
        """Yield the decisions, contacts and withdrawals of each piece of a block.

        The pieces end where the steady state changes, so results do not depend on the sizes of
        blocks.
        """
        self.latch.remember(block)
        start = 0
        while start < len(block.data) or not start:
            stop = self._stop(block, start)
            piece = Block(block.data[start:stop], block.first_sample + start, block.epoch)
            decisions = self._detector.judge(piece)
            yield decisions, self.latch.update(piece, decisions)
            self._left -= stop - start
            start = max(stop, 1)
            if not self._left:
                self._left = self._every
                self._resettle(piece.end)

    def _stop(self, block: Block, start: int) -> int:
        """Return the end of the piece that begins at ``start``; both count from the block's start.

        The steady state can change only at the end of the piece.
        """
        if not self._resettles or self.windowed is None or self.latch.is_confirmed:
            return len(block.data)
        rest = Block(block.data[start:], block.first_sample + start, block.epoch)
        if self.windowed.restarts(rest):  # the steady state to compare with is not yet known
            return min(start + self._left, len(block.data))
        while start + self._left <= len(block.data):
            quiet = self._newest(block.first_sample + start + self._left)
            if quiet is not None and self.windowed.may_resettle(quiet):
                return start + self._left
            self._left += self._every
        return len(block.data)

    def _resettle(self, end: int) -> None:
        if self._resettles and self.windowed is not None and not self.latch.is_confirmed:
            quiet = self._newest(end)
            if quiet is not None:
                self.has_resettled |= self.windowed.resettle(quiet)

    def _newest(self, end: int) -> NDArray[np.float64] | None:
        assert self.windowed is not None
        return self.latch.newest(self.windowed.steady_samples, self._age, end)


class ContactListener:
    """Listener for the contacts of one closing: a detector with a :class:`ConfirmingLatch`.

    Parameters
    ----------
    detector
        Fitted or loaded detector.
    layout
        Columns of the blocks.
    resettles
        False to keep the first steady state of a closing, as the C code of the hand does.

    Raises
    ------
    InputError
        If the detector does not support this layout.
    """

    def __init__(self, detector: Detector, layout: Layout, *, resettles: bool = True) -> None:
        self._judge = _Judge(detector, layout, resettles)
        self._latch = self._judge.latch
        self._fingers = len(layout.vibration_fingers)

    @property
    def ended(self) -> bool:
        """True if no contact or withdrawal can follow in this closing."""
        return self._latch.is_confirmed and len(self._latch.latched) == self._fingers

    @property
    def is_confirmed(self) -> bool:
        """True if no contact can be withdrawn any more."""
        return self._latch.is_confirmed

    @property
    def due(self) -> int:
        """Number of samples until the next contact or withdrawal is possible."""
        windowed = self._judge.windowed
        due = 1 if windowed is None else windowed.due
        latch_due = self._latch.due
        return due if latch_due is None else min(due, latch_due)

    def update(self, block: Block) -> list[Contact | Withdrawal]:
        """Return the contacts and withdrawals that this block reveals, in order."""
        events = []
        for _, new in self._judge.update(block):
            events += new
            if self._latch.is_confirmed and self._judge.windowed is not None:
                self._judge.windowed.skip(self._latch.latched)
        return events


@dataclass(frozen=True, slots=True, eq=False)
class PinchDecisions:
    """Decisions of a detector in one pinch.

    Parameters
    ----------
    windows
        Decisions for the detector's windows, from the first of the pinch to the last that was
        judged.
    fixed_windows
        The same decisions, but relative to the first steady state of the pinch, as published.
    first
        First contact that is not withdrawn; None if there is none.
    """

    windows: WindowDecisions
    fixed_windows: WindowDecisions
    first: Contact | None


def judge_pinch(detector: Detector, pinch: Pinch, until: int) -> PinchDecisions:
    """Judge the windows of a pinch from its first sample on.

    All windows before ``until`` are judged. Further windows are judged until the first contact is
    confirmed, or to the end of the pinch.

    Parameters
    ----------
    detector
        Fitted or loaded detector.
    pinch
        Pinch, cut to begin at the start of its closing.
    until
        Number of the sample before which all windows are judged.

    Returns
    -------
    PinchDecisions
        Decisions for the judged windows, and the first contact in them that is not withdrawn.
        ``fixed_windows`` end at ``until``, or later if the steady state never changes.
    """
    judge = _Judge(detector, pinch.layout)
    windows: list[WindowDecisions] = []
    contacts: list[Contact] = []
    for piece in _pieces(_block(pinch), until, pinch.layout.rate):
        for decisions, events in judge.update(piece):
            windows.append(decisions)
            contacts = _standing(events, contacts)
        if contacts and judge.latch.is_confirmed:
            break
    arrays = ([getattr(part, f.name) for part in windows] for f in fields(WindowDecisions))
    judged = fixed = WindowDecisions(*map(np.concatenate, arrays))
    if judge.has_resettled:
        detector.start(pinch.layout)
        fixed = detector.judge(next(_pieces(_block(pinch), until, pinch.layout.rate)))
    return PinchDecisions(judged, fixed, next(iter(contacts), None))


def _standing(
    events: Sequence[Contact | Withdrawal], earlier: Sequence[Contact] = ()
) -> list[Contact]:
    """Return the contacts among ``earlier`` and ``events`` that no withdrawal removes."""
    contacts = list(earlier)
    for event in events:
        if isinstance(event, Contact):
            contacts.append(event)
        else:
            contacts.clear()
    return contacts


def _pieces(block: Block, until: int, rate: float) -> Iterator[Block]:
    """Yield the samples before ``until`` as one block, then the later ones in short blocks.

    Each block lasts ``PIECE`` seconds. The first is longer if ``until`` comes later, and the last
    can be shorter.
    """
    size = samples_in(PIECE, rate)
    end = max(until - block.first_sample, size)
    yield Block(block.data[:end], block.first_sample, block.epoch)
    for start in range(end, len(block.data), size):
        yield Block(block.data[start : start + size], block.first_sample + start, block.epoch)


def _block(pinch: Pinch, start: int | None = None) -> Block:
    first = pinch.first_sample if start is None else start
    return Block(pinch.data[first - pinch.first_sample :], first)


def detect(detector: Detector, pinch: Pinch, *, confirm: bool = True) -> list[Contact]:
    """Return all contacts in a pinch after the start of its closing, as in a live session.

    The start of the closing is found from this pinch alone. To use the other pinches of the rig as
    well, see :func:`firstcontact.contact._closing_start.cut_closings`.

    Parameters
    ----------
    detector
        Fitted or loaded detector.
    pinch
        Pinch.
    confirm
        False to return the detector's contacts without withdrawals, like a device that predicts by
        itself.
    """
    if not confirm:
        detector.start(pinch.layout)
        return detector.update(_block(pinch, closing_start(pinch).sample))
    return [contacts for contacts, _ in _listen(detector, pinch)][-1]


def first_contact(detector: Detector, pinch: Pinch) -> Contact | None:
    """Return the first contact of :func:`detect`, or None, without judging later samples.

    Parameters
    ----------
    detector
        Fitted or loaded detector.
    pinch
        Pinch.
    """
    contacts: list[Contact] = []
    for contacts, is_confirmed in _listen(detector, pinch):
        if contacts and is_confirmed:
            break
    return contacts[0] if contacts else None


def _listen(detector: Detector, pinch: Pinch) -> Iterator[tuple[list[Contact], bool]]:
    """Yield the contacts so far, and True if no contact can be withdrawn any more.

    The generator stops when no contact or withdrawal can follow in this closing.
    """
    block = _block(pinch, closing_start(pinch).sample)
    listener = ContactListener(detector, pinch.layout)
    contacts: list[Contact] = []
    for piece in _pieces(block, 0, pinch.layout.rate):
        contacts = _standing(listener.update(piece), contacts)
        yield contacts, listener.is_confirmed
        if listener.ended:
            return
