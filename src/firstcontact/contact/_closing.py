"""The closings in a stream and the contacts in each: what live and record share."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass

from firstcontact.contact._detector import Detector
from firstcontact.contact._gate import REARM, ClosingGate, Turn
from firstcontact.contact._stream import WindowDetector
from firstcontact.core import Block, Calibration, Contact, Layout
from firstcontact.signal import samples_in


@dataclass(frozen=True, slots=True)
class ClosingBegan:
    """A closing began with this sample."""

    sample: int
    epoch: int


@dataclass(frozen=True, slots=True, eq=False)
class ClosingSamples:
    """Samples of a closing, and the contacts that they made known."""

    block: Block
    contacts: tuple[Contact, ...]


@dataclass(frozen=True, slots=True)
class ClosingEnded:
    """A closing ended before this sample.

    ``whole`` is False where samples are missing behind it: it did not end by itself.
    """

    sample: int
    epoch: int
    whole: bool


Stage = ClosingBegan | ClosingSamples | ClosingEnded


class Closings:
    """Cuts a stream into closings and finds the contacts in each.

    From the sample at which a closing begins the detector sees exactly what it
    would see of a pinch cut out there, so that live and offline agree.

    Parameters
    ----------
    layout
        The columns of the blocks.
    detector
        Fitted or loaded.
    calibration
        With the noise floors, see :class:`firstcontact.contact._gate.ClosingGate`.

    Raises
    ------
    InputError
        When the detector cannot be used with this layout.
    """

    def __init__(
        self, layout: Layout, detector: Detector, calibration: Calibration | None = None
    ) -> None:
        detector.start(layout)
        self._layout = layout
        self._fingers = len(layout.vibration_fingers)
        self._detector = detector
        self._gate = ClosingGate(layout, calibration)
        by_hand = None in layout.vibration_fingers
        self._piece = samples_in(REARM / 2, layout.rate) if by_hand else sys.maxsize
        self._open = False
        self._end = 0
        self._epoch = self._epoch_before = 0
        self._latched = 0

    @property
    def has_floors(self) -> bool:
        """Whether the noise floors are known; without them each epoch is one closing."""
        return self._gate.has_floors

    @property
    def open(self) -> bool:
        """Whether a closing is going on."""
        return self._open

    @property
    def end(self) -> int:
        """Number of the sample that would come next."""
        return self._end

    @property
    def due(self) -> int | None:
        """So many more samples can tell of another contact; None where none is to come."""
        if not self._open or self._latched == self._fingers:
            return None
        # Whoever does not tell when its next verdict is due may give one with every sample.
        return self._detector.due if isinstance(self._detector, WindowDetector) else 1

    def update(self, block: Block) -> Iterator[Stage]:
        """Take the next block: what happened in it, in order, each as soon as it is known.

        What this gives must be gone through to its end before the next block.
        """
        # Without a motor the gate is to know of each contact before what comes so long after it.
        for start in range(0, max(1, len(block.data)), self._piece):
            data = block.data[start : start + self._piece]
            yield from self._take(Block(data, block.first_sample + start, block.epoch))

    def _take(self, block: Block) -> Iterator[Stage]:
        follows = block.first_sample == self._end and block.epoch == self._epoch
        self._end, self._epoch_before, self._epoch = block.end, self._epoch, block.epoch
        place = block.first_sample
        # A closing goes on up to where the gate decides next: who waits for its
        # contacts does not have to wait for the gate.
        if self._open and follows and len(block.data) <= self._gate.undecided + 1:
            yield from self._go_on(block, place, block.end)
            place = block.end
        for event in self._gate.update(block):
            if event.turn is Turn.SHUTS:
                if follows:
                    yield from self._go_on(block, place, event.sample)
                    place = max(place, event.sample)
                yield ClosingEnded(event.sample, self._epoch_before, follows)
                self._open = False
            else:
                place = event.sample
                self._detector.start(self._layout)
                self._latched = 0
                self._open = True
                yield ClosingBegan(event.sample, block.epoch)
        yield from self._go_on(block, place, block.end)

    def _go_on(self, block: Block, start: int, stop: int) -> Iterator[ClosingSamples]:
        """Feed what belongs to the closing."""
        if not self._open or start >= stop:
            return
        first = start - block.first_sample
        piece = Block(block.data[first : stop - block.first_sample], start, block.epoch)
        contacts: list[Contact] = []
        # With both fingers on the object there is nothing left to detect.
        if self._latched < self._fingers:
            contacts = self._detector.update(piece)
            self._latched += len(contacts)
            for contact in contacts:
                self._gate.touched(contact.sample)
        yield ClosingSamples(piece, tuple(contacts))
