"""Ctrl-C and SIGTERM as a request, so that what is being written can be finished."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Stop:
    """Whether the process was asked to stop.

    Attributes
    ----------
    requested
        A signal came.
    gently
        While it is true a signal is only noted, for a loop that looks at
        ``requested``; otherwise it raises KeyboardInterrupt where the program is.
    """

    def __init__(self) -> None:
        self.requested = False
        self.gently = False

    def _take(self, number: int, frame: FrameType | None) -> None:
        again, self.requested = self.requested, True
        # A second signal must not disturb the finishing that the first began.
        if not self.gently and not again:
            raise KeyboardInterrupt


@contextmanager
def stopping() -> Iterator[Stop]:
    """Take Ctrl-C and SIGTERM until the end of the block."""
    stop = Stop()
    before = {number: signal.signal(number, stop._take) for number in SIGNALS}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
