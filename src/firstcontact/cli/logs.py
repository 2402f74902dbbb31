"""Log of the package: to standard error with ``--verbose``, and into crash logs."""

from __future__ import annotations

import logging
import sys
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager

from firstcontact.core import one_line

#: Number of lines in a crash log.
KEPT = 200

_kept: deque[str] = deque(maxlen=KEPT)


class _Lines(logging.Handler):
    """Handler that keeps each log record as one line of text, and prints the important records."""

    def __init__(self, level_shown: int) -> None:
        super().__init__()
        self._shown = level_shown
        self.formatter = logging.Formatter(
            "%(asctime)s.%(msecs)03dZ %(name)s: %(message)s", "%Y-%m-%dT%H:%M:%S"
        )
        self.formatter.converter = time.gmtime

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a log record. Print it if its level is high enough."""
        line = one_line(self.format(record))
        _kept.append(line)
        if record.levelno >= self._shown:
            bars = sys.modules.get("tqdm")  # moves a progress bar below the line
            (bars.tqdm.write if bars else print)(line, file=sys.stderr)


@contextmanager
def logged(verbose: bool) -> Iterator[None]:
    """Keep and print the package's log records until the end of the ``with`` block."""
    _kept.clear()
    logger = logging.getLogger("firstcontact")
    handler = _Lines(logging.INFO if verbose else logging.WARNING)
    former = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(former)


def last_lines() -> tuple[str, ...]:
    """Return the last lines of the log, at most ``KEPT``."""
    return tuple(_kept)
