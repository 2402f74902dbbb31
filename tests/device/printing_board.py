"""Simulated board on a pseudo terminal that prints numbers in lines."""

import os
import threading
import time
import tty
from collections.abc import Callable
from pathlib import Path
from typing import Self


class PrintingBoard:
    """Board that prints lines at a constant rate, by its own clock.

    Parameters
    ----------
    link
        Name of its port: a link to the current pseudo terminal.
    line
        Function that returns the line of a sample by its number; an empty line stands for a lost
        sample.
    rate
        Lines per second.
    """

    def __init__(self, link: Path, line: Callable[[int], bytes], rate: float = 4936.0) -> None:
        self.link, self._line, self._rate = link, line, rate
        self._done = threading.Event()
        self._number = 0
        self._plug()
        self._thread = threading.Thread(target=self._print, daemon=True)

    @property
    def port(self) -> str:
        return str(self.link)

    @property
    def printed(self) -> int:
        return self._number

    @property
    def ends(self) -> bool:
        return self._done.is_set()

    def _plug(self) -> None:
        self._end, terminal = os.openpty()
        tty.setraw(terminal)
        os.set_blocking(self._end, False)
        self._other = terminal
        self.link.unlink(missing_ok=True)
        self.link.symlink_to(os.ttyname(terminal))

    def unplug(self) -> None:
        """Unplug the board. It continues to count."""
        ends = self._end, self._other
        self._end = self._other = -1
        self.link.unlink()
        for end in ends:
            os.close(end)

    def plug(self) -> None:
        self._plug()

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._done.set()
        self._thread.join()

    def _print(self) -> None:
        began = time.monotonic()
        unsent, is_accepted = b"", False
        # What waits goes on as fast as it is taken: the terminal holds 4 kB.
        while not self._done.wait(0.0 if unsent and is_accepted else 0.005):
            due = int((time.monotonic() - began) * self._rate)
            unsent += b"".join(self._line(n) for n in range(self._number, due))
            self._number = due
            try:
                unsent, is_accepted = unsent[os.write(self._end, unsent) :], True
            except BlockingIOError:
                is_accepted = False  # nobody reads: it waits in the board
            except OSError:
                unsent = b""
