"""Hand of the running twin, which takes commands over the twin's serial line."""

from __future__ import annotations

from contextlib import suppress
from math import inf
from typing import Self

from firstcontact.core import ClosingSpeed, Command, InputError
from firstcontact.device import CLOSE_ORDER, Source, order_text
from firstcontact.grasp import Begins, Hand, HandError, HandLimits
from firstcontact.twin import Drive

#: Highest rate of commands, Hz: the twin makes its samples 5 ms at a time.
RATE = 200.0


class TwinHand(Hand):
    """Hand that sends each command as an order to the twin for the current closing."""

    name = "twin"
    limits = HandLimits(speed=Drive().speed, force=Drive().force, rate=RATE, watchdog=inf)
    real = False
    begins = Begins.OTHERS | Begins.HURRY
    of_source = name

    def __init__(self, source: Source) -> None:
        self._source = source
        self._open = False

    def send(self, command: Command) -> None:
        """Send the command as an order."""
        self._order(order_text(command))

    def start(self) -> None:
        """Begin the next closing immediately. A present closing ends before."""
        self._order(CLOSE_ORDER)

    def closing_speed(self, sample_time: float, host_time: float) -> ClosingSpeed | None:
        """Return the closing speed before a contact, from the positions of the twin's drives."""
        if not self._open:
            return None
        rate = self._source.descriptor.layout.rate
        try:
            return self._source.closing_speed(round(sample_time * rate), epoch=0)
        except InputError as error:
            raise HandError(str(error)) from error

    def release(self) -> None:
        """Open the hand."""
        if not self._open:
            return
        # A twin that has ended holds nothing.
        with suppress(InputError):
            self._source.order(order_text(None))

    def close(self) -> None:
        """Release the hand. The source stays open."""
        self.release()
        self._open = False

    def _order(self, text: str) -> None:
        if not self._open:
            raise HandError(f"the hand {self.name!r} is not open: use it in a with block")
        try:
            self._source.order(text)
        except InputError as error:
            raise HandError(str(error)) from error

    def __enter__(self) -> Self:
        if self._source.descriptor.source != "twin":
            raise HandError(f"{self._source.name} is not the twin: use --device twin")
        self._open = True
        return self
