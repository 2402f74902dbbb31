"""Contacts that a detector reports in a closing: live, or in a recorded pinch."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields

import numpy as np

from firstcontact.contact._closing_start import closing_start
from firstcontact.contact._confirmation import ConfirmingLatch, Withdrawal
from firstcontact.contact._detector import Detector, WindowDecisions
from firstcontact.contact._stream import WindowDetector
from firstcontact.core import Block, Contact, Layout, Pinch
from firstcontact.signal import samples_in

#: Time between two steady states of a closing, and the age of the newest sample of each, s. A
#: contact is detected earlier than that, so no steady state contains its signal.
RESETTLED, SETTLED = 0.01, 0.008
#: Length of the pieces in which pinches are judged, s. Pieces after the last contact are not
#: judged.
PIECE = 0.05


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

    @property
    def _following(self) -> WindowDetector | None:
        """The detector if its steady state can still change, else None."""
        return self.windowed if self._resettles and not self.latch.is_confirmed else None

    def _stop(self, block: Block, start: int) -> int:
        """Return the end of the piece that begins at ``start``; both count from the block's start.

        The steady state can change only at the end of the piece.
        """
        detector = self._following
        if detector is None:
            return len(block.data)
        remainder = Block(block.data[start:], block.first_sample + start, block.epoch)
        if detector.restarts(remainder):  # the steady state to compare with is not yet known
            return min(start + self._left, len(block.data))
        while start + self._left <= len(block.data):
            end = block.first_sample + start + self._left
            quiet = self.latch.newest(detector.steady_samples, self._age, end)
            if quiet is not None and detector.may_resettle(quiet):
                return start + self._left
            self._left += self._every
        return len(block.data)

    def _resettle(self, end: int) -> None:
        detector = self._following
        if detector is not None:
            quiet = self.latch.newest(detector.steady_samples, self._age, end)
            if quiet is not None:
                self.has_resettled |= detector.resettle(quiet)


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
        ``fixed_windows`` end at ``until`` or after ``PIECE`` s, whichever is later; if the steady
        state never changes, they are ``windows``.
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
    """Yield a pinch in pieces of ``PIECE`` s. The last can be shorter.

    The first piece ends at sample ``until`` if that is later.
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
