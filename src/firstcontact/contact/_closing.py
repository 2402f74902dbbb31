"""Closings of a hand in a stream, with their contacts. Live sessions and recorders use them."""

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
    """Start of a closing at this sample."""

    sample: int
    epoch: int


@dataclass(frozen=True, slots=True, eq=False)
class ClosingSamples:
    """Samples of a closing, with the contacts detected in them."""

    block: Block
    contacts: tuple[Contact, ...]


@dataclass(frozen=True, slots=True)
class ClosingEnded:
    """End of a closing before this sample.

    ``whole`` is False if samples are missing after it, so the closing did not end by itself.
    """

    sample: int
    epoch: int
    whole: bool


Stage = ClosingBegan | ClosingSamples | ClosingEnded


class Closings:
    """Splitter that cuts a stream into closings and detects the contacts in each.

    From the start of a closing, the detector gets the same samples as from a pinch cut out there.
    So
    live and offline results agree.

    Parameters
    ----------
    layout
        Columns of the blocks.
    detector
        Fitted or loaded detector.
    calibration
        Calibration with the noise floors, see :class:`firstcontact.contact._gate.ClosingGate`.

    Raises
    ------
    InputError
        If the detector does not support this layout.
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
        """True if the noise floors are known. Without them each epoch is one closing."""
        return self._gate.has_floors

    @property
    def open(self) -> bool:
        """True during a closing."""
        return self._open

    @property
    def end(self) -> int:
        """Number of the next sample."""
        return self._end

    @property
    def due(self) -> int | None:
        """Number of samples until the next contact can be known; None without one."""
        if not self._open or self._latched == self._fingers:
            return None
        # Other detectors do not announce their next decision: it may come with any sample.
        return self._detector.due if isinstance(self._detector, WindowDetector) else 1

    def update(self, block: Block) -> Iterator[Stage]:
        """Process the next block and yield its events in order, each as soon as it is known.

        The caller must exhaust this iterator before the next block.
        """
        # Without a motor, the gate must know of a contact before REARM has passed. Short pieces do
        # that.
        for start in range(0, max(1, len(block.data)), self._piece):
            data = block.data[start : start + self._piece]
            yield from self._process(Block(data, block.first_sample + start, block.epoch))

    def _process(self, block: Block) -> Iterator[Stage]:
        follows = block.first_sample == self._end and block.epoch == self._epoch
        self._end, self._epoch_before, self._epoch = block.end, self._epoch, block.epoch
        position = block.first_sample
        # A closing continues up to the gate's next decision. Its contacts need not wait for that.
        if self._open and follows and len(block.data) <= self._gate.undecided + 1:
            yield from self._extend(block, position, block.end)
            position = block.end
        for event in self._gate.update(block):
            if event.turn is Turn.SHUTS:
                if follows:
                    yield from self._extend(block, position, event.sample)
                    position = max(position, event.sample)
                yield ClosingEnded(event.sample, self._epoch_before, follows)
                self._open = False
            else:
                position = event.sample
                self._detector.start(self._layout)
                self._latched = 0
                self._open = True
                yield ClosingBegan(event.sample, block.epoch)
        yield from self._extend(block, position, block.end)

    def _extend(self, block: Block, start: int, stop: int) -> Iterator[ClosingSamples]:
        """Pass the samples of the closing to the detector."""
        if not self._open or start >= stop:
            return
        first = start - block.first_sample
        piece = Block(block.data[first : stop - block.first_sample], start, block.epoch)
        contacts: list[Contact] = []
        # After both contacts nothing is left to detect.
        if self._latched < self._fingers:
            contacts = self._detector.update(piece)
            self._latched += len(contacts)
            for contact in contacts:
                self._gate.touched(contact.sample)
        yield ClosingSamples(piece, tuple(contacts))
