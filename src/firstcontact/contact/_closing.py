"""Splitter of a stream into closings with their contacts, for live sessions and recorders."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from firstcontact.contact._confirmation import Withdrawal
from firstcontact.contact._detector import Detector
from firstcontact.contact._gate import ClosingGate, Turn
from firstcontact.contact._listener import ContactListener
from firstcontact.core import Block, Calibration, Contact, Layout


@dataclass(frozen=True, slots=True)
class ClosingBegan:
    """Start of a closing. ``sample`` is its first sample."""

    sample: int
    epoch: int


@dataclass(frozen=True, slots=True, eq=False)
class ClosingSamples:
    """Samples of a closing, with the contacts detected in them.

    Parameters
    ----------
    block
        Samples of the closing.
    contacts
        Contacts that ``block`` revealed.
    withdrawn
        First contact of the closing if ``block`` disproved it, else None. All later contacts are
        withdrawn with it. The closing continues as if there had been no contact.
    """

    block: Block
    contacts: tuple[Contact, ...]
    withdrawn: Contact | None = None


@dataclass(frozen=True, slots=True)
class ClosingEnded:
    """End of a closing. ``sample`` is the first sample after the closing.

    ``is_complete`` is False if missing samples or a new epoch cut the closing off.
    """

    sample: int
    epoch: int
    is_complete: bool


Stage = ClosingBegan | ClosingSamples | ClosingEnded


class Closings:
    """Splitter that cuts a stream into closings and detects the contacts in each.

    In each closing, the detector gets the same samples as from a recording. So live and offline
    results agree.

    Parameters
    ----------
    layout
        Columns of the blocks.
    detector
        Fitted or loaded detector.
    calibration
        Calibration with the noise floors, see :class:`firstcontact.contact._gate.ClosingGate`.
    resettles
        See :class:`firstcontact.contact.ContactListener`.

    Raises
    ------
    InputError
        If the detector does not support this layout.
    """

    def __init__(
        self,
        layout: Layout,
        detector: Detector,
        calibration: Calibration | None = None,
        *,
        resettles: bool = True,
    ) -> None:
        self._layout = layout
        self._detector = detector
        self._resettles = resettles
        self._listener = self._listen()
        self._gate = ClosingGate(layout, calibration)
        self._by_hand = None in layout.vibration_fingers
        self._open = False
        self._end = 0
        self._epoch = 0

    def _listen(self) -> ContactListener:
        return ContactListener(self._detector, self._layout, resettles=self._resettles)

    @property
    def has_floors(self) -> bool:
        """True if the noise floors are known. Without them each epoch is one closing."""
        return self._gate.has_floors

    @property
    def refused(self) -> int:
        """Number of motor starts since the last closing began that were taken for a held object."""
        return self._gate.refused

    @property
    def open(self) -> bool:
        """True during a closing."""
        return self._open

    @property
    def end(self) -> int:
        """Number of the first sample after the last block."""
        return self._end

    @property
    def due(self) -> int | None:
        """Number of samples until the next contact or withdrawal; None if none can follow."""
        return None if not self._open or self._listener.ended else self._listener.due

    def update(self, block: Block) -> Iterator[Stage]:
        """Process the next block and yield its events in order, each as soon as it is known.

        The caller must exhaust this iterator before the next block.
        """
        start = 0
        while not start or start < len(block.data):
            # A contact can change the gate's next decision, so the gate must know of it before.
            stop = start + self._gate.undecided + 1 if self._by_hand else len(block.data)
            piece = Block(block.data[start:stop], block.first_sample + start, block.epoch)
            yield from self._process(piece)
            start = max(stop, 1)

    def _process(self, block: Block) -> Iterator[Stage]:
        follows = block.first_sample == self._end and block.epoch == self._epoch
        epoch, self._epoch, self._end = self._epoch, block.epoch, block.end
        position = block.first_sample
        # The gate cannot end the closing before its next decision, so contacts need not wait for
        # it.
        if self._open and follows and len(block.data) <= self._gate.undecided + 1:
            yield from self._extend(block, position, block.end)
            position = block.end
        for event in self._gate.update(block):
            if event.turn is Turn.SHUTS:
                if follows:
                    yield from self._extend(block, position, event.sample)
                    position = max(position, event.sample)
                yield ClosingEnded(event.sample, epoch, follows)
                self._open = False
            else:
                # Only the first event can belong to the samples before a gap.
                follows, epoch = True, block.epoch
                position = event.sample
                self._listener = self._listen()
                self._open = True
                yield ClosingBegan(event.sample, block.epoch)
        yield from self._extend(block, position, block.end)

    def _extend(self, block: Block, start: int, stop: int) -> Iterator[ClosingSamples]:
        """Yield the samples ``start`` to ``stop`` of a block, with the contacts in them."""
        if not self._open or start >= stop:
            return
        first = start - block.first_sample
        piece = Block(block.data[first : stop - block.first_sample], start, block.epoch)
        # After both contacts nothing is left to detect.
        events = [] if self._listener.ended else self._listener.update(piece)
        for event in events:
            if isinstance(event, Contact):
                self._gate.touched(event.sample)
        yield from _stages(piece, events)


def _stages(block: Block, events: Sequence[Contact | Withdrawal]) -> Iterator[ClosingSamples]:
    """Yield a block with its contacts. Cut it after each withdrawal of a contact."""
    contacts: list[Contact] = []
    for event in events:
        if isinstance(event, Contact):
            contacts.append(event)
            continue
        count = event.decided + 1 - block.first_sample
        yield ClosingSamples(
            Block(block.data[:count], block.first_sample, block.epoch),
            tuple(contacts),
            event.contact,
        )
        block = Block(block.data[count:], event.decided + 1, block.epoch)
        contacts = []
    yield ClosingSamples(block, tuple(contacts))
