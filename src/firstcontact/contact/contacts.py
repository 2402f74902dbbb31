"""Contacts that a detector reports in a closing, live or in a recorded pinch."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from firstcontact.chain import Chain, ChainEvent, EventKind, build_image
from firstcontact.chain.constants import DetectorKind
from firstcontact.contact.closing_start import closing_start
from firstcontact.contact.detector import Detector, WindowDecisions
from firstcontact.core import Block, Calibration, Contact, Layout, Pinch
from firstcontact.signal import samples_in

#: Length of the pieces in which pinches are judged, s. Pieces after the last contact are not
#: judged.
PIECE = 0.05
#: Samples from the first contact after which the chain would end a closing: more than any has.
ENDLESS = 1 << 30


def contact_chain(
    detector: Detector,
    layout: Layout,
    calibration: Calibration | None = None,
    *,
    keeps_first_state: bool = False,
    is_traced: bool = False,
) -> Chain:
    """Return a C chain that detects closings of the hand, and the contacts in them.

    A closing lasts until the motor rests. ``keeps_first_state`` measures the motor's noise only
    once, and ``is_traced`` stores the decision for each window.
    """
    constants = detector.chain_constants(layout.rate)
    return Chain(
        build_image(layout.rate, constants, after=ENDLESS / layout.rate),
        layout,
        calibration,
        detector=detector if constants.kind == DetectorKind.PYTHON else None,
        keeps_first_state=keeps_first_state,
        is_traced=is_traced,
    )


def contact_of(event: ChainEvent, layout: Layout) -> Contact:
    return Contact(layout.vibration_fingers[event.channel], event.sample, event.known)


@dataclass(frozen=True, slots=True, eq=False)
class PinchDecisions:
    """Decisions of a detector for all windows of one pinch, and its first contact."""

    windows: WindowDecisions
    #: The same decisions, but relative to the first steady state of the pinch, as published.
    fixed_windows: WindowDecisions
    #: First contact that is not withdrawn.
    first: Contact | None


def judge_pinch(detector: Detector, pinch: Pinch, until: int) -> PinchDecisions:
    """Apply a detector to all windows of a pinch, at least up to the sample ``until``."""
    layout = pinch.layout
    chain = contact_chain(detector, layout, is_traced=True)
    windows: list[tuple[int, ...]] = []
    contacts: list[Contact] = []
    pieces = list(_pieces(_block(pinch), until, layout.rate))
    for piece in pieces:
        contacts = _remaining_contacts(chain.take(piece), layout, contacts)
        windows += chain.windows
        if contacts and chain.is_confirmed:
            break
    fixed = judge_windows(detector, layout, pieces[0])
    return PinchDecisions(_decisions(windows, layout), fixed, next(iter(contacts), None))


def judge_windows(detector: Detector, layout: Layout, *blocks: Block) -> WindowDecisions:
    """Apply a detector to all windows of a closing, given as consecutive blocks of samples.

    The motor's noise is measured only once, at the start.
    """
    chain = contact_chain(detector, layout, keeps_first_state=True, is_traced=True)
    windows: list[tuple[int, ...]] = []
    for block in blocks:
        chain.take(block)
        windows += chain.windows
    return _decisions(windows, layout)


def _decisions(windows: Sequence[tuple[int, ...]], layout: Layout) -> WindowDecisions:
    """Return the detector's decisions for windows, from the rows that the chain stores for them."""
    rows = np.array(windows, np.int64).reshape(-1, 1 + len(layout.vibration_fingers))
    return WindowDecisions(rows[:, 0], rows[:, 1:] >= 0, rows[:, 1:])


def _remaining_contacts(
    events: Sequence[ChainEvent], layout: Layout, earlier: Sequence[Contact] = ()
) -> list[Contact]:
    """Return the contacts ``earlier``, followed by those that ``events`` report.

    An event that withdraws a contact removes all contacts before it.
    """
    contacts = list(earlier)
    for event in events:
        if event.kind == EventKind.CONTACT_FOUND:
            contacts.append(contact_of(event, layout))
        elif event.kind == EventKind.CONTACT_WITHDRAWN:
            contacts.clear()
    return contacts


def _pieces(block: Block, until: int, rate: float) -> Iterator[Block]:
    """Yield the samples of a block before number ``until``, then the rest in pieces of ``PIECE`` s.

    The first part has at least the length of a piece.
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
    """Return all contacts in a recorded pinch, detected as in a live session.

    Samples before the hand starts to close are not used. This start is detected from this pinch
    alone; :func:`firstcontact.contact.closing_start.cut_closings` uses other pinches as well.

    Parameters
    ----------
    detector
        Detector that needs no training, or that is trained.
    pinch
        Pinch with its samples before the contact.
    confirm
        True to cancel a contact if later samples show that it was false, as a live session does.
        False to return such contacts, too. The motor's noise is then measured only once, when the
        hand starts to close.
    """
    chain = contact_chain(detector, pinch.layout, keeps_first_state=not confirm)
    return _remaining_contacts(chain.take(_block(pinch, closing_start(pinch).sample)), pinch.layout)


def first_contact(detector: Detector, pinch: Pinch) -> Contact | None:
    """Return the first contact in a recorded pinch, as :func:`detect` returns it, or None."""
    chain = contact_chain(detector, pinch.layout)
    contacts: list[Contact] = []
    for piece in _pieces(_block(pinch, closing_start(pinch).sample), 0, pinch.layout.rate):
        contacts = _remaining_contacts(chain.take(piece), pinch.layout, contacts)
        if contacts and chain.is_confirmed:
            break
    return contacts[0] if contacts else None
