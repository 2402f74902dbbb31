"""Simulated hand of the running twin, commanded over the twin's own line."""

from __future__ import annotations

from contextlib import suppress
from math import inf
from typing import Self

from firstcontact.core import Command, InputError
from firstcontact.device import Source, order_text
from firstcontact.grasp import Hand, HandError, HandLimits
from firstcontact.twin import Drive

#: Highest rate of commands, Hz: the twin makes its samples 5 ms at a time.
RATE = 200.0


class TwinHand(Hand):
    """Each command is an order to the twin, about the closing that is going on.

    A hand that is at rest or opens takes no command; the twin says so in a marker, and goes on
    with its next closing as it would have.

    Parameters
    ----------
    source
        The twin's, open when the hand is and as long.
    """

    name = "twin"
    limits = HandLimits(speed=Drive().speed, force=Drive().force, rate=RATE, watchdog=inf)
    real = False
    of_source = name

    def __init__(self, source: Source) -> None:
        self._source = source
        self._open = False

    def send(self, command: Command) -> None:
        """Order."""
        if not self._open:
            raise HandError(f"the hand {self.name!r} is not open")
        try:
            self._source.order(order_text(command))
        except InputError as error:
            raise HandError(str(error)) from error

    def release(self) -> None:
        """Open."""
        if not self._open:
            return
        # A twin that is gone has let go.
        with suppress(InputError):
            self._source.order(order_text(None))

    def close(self) -> None:
        """Release; the source stays open."""
        self.release()
        self._open = False

    def __enter__(self) -> Self:
        if self._source.descriptor.source != "twin":
            raise HandError(f"{self._source.name} is not the twin: use --device twin")
        self._open = True
        return self
