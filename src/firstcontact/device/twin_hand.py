"""Driver for the hand of the twin (simulated hand), over its simulated serial line."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from math import inf
from typing import Self

from firstcontact.core import Command, InputError
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.device.source import Source
from firstcontact.device.twin_words import CLOSE_ORDER, order_text
from firstcontact.grasp import Hand, HandError, HandLimits
from firstcontact.grasp.hand import Begins
from firstcontact.twin.drive import EVERY, Drive

#: Highest rate of commands, Hz: the twin makes its samples 5 ms at a time.
RATE = 200.0


class TwinHand(Hand):
    """Driver for the twin's hand. It sends each command as an order for the current closing."""

    name = "twin"
    limits = HandLimits(speed=Drive().speed, force=Drive().force, rate=RATE, watchdog=inf)
    real = False
    begins = Begins.OTHERS | Begins.HURRY
    of_source = name
    position_rate = FINGERTIP_RATE / EVERY

    def __init__(self, source: Source) -> None:
        self._source = source
        self._open = False

    def send(self, command: Command) -> None:
        self._order(order_text(command))

    def start(self) -> None:
        self._order(CLOSE_ORDER)

    def positions_since(self, since: float, host_zero: float) -> Sequence[tuple[float, float]]:
        """Return (time, s; travel, m) pairs later than ``since``, s of the samples' clock.

        ``host_zero`` is not used, because the twin reports positions on the samples' clock.
        """
        if not self._open:
            return ()
        try:
            return self._source.positions_since(since)
        except InputError as error:
            raise HandError(str(error)) from error

    def release(self) -> None:
        if not self._open:
            return
        with suppress(InputError):  # a twin that has ended holds nothing
            self._source.order(order_text(None))

    def close(self) -> None:
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
