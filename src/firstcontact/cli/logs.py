"""What the package says on its log: to standard error with ``--verbose``, and into crash logs."""

from __future__ import annotations

import logging
import sys
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager

from firstcontact.core import one_line

#: Lines that a crash log holds.
KEPT = 200

_kept: deque[str] = deque(maxlen=KEPT)


class _Lines(logging.Handler):
    """Each record as one plain line: kept, and shown from a level on.

    Parameters
    ----------
    shown
        Level.
    """

    def __init__(self, shown: int) -> None:
        super().__init__()
        self._shown = shown
        self.formatter = logging.Formatter(
            "%(asctime)s.%(msecs)03dZ %(name)s: %(message)s", "%Y-%m-%dT%H:%M:%S"
        )
        self.formatter.converter = time.gmtime

    def emit(self, record: logging.LogRecord) -> None:
        """Take one."""
        line = one_line(self.format(record))
        _kept.append(line)
        if record.levelno >= self._shown:
            bars = sys.modules.get("tqdm")  # one that is drawn moves down, below the line
            (bars.tqdm.write if bars else print)(line, file=sys.stderr)


@contextmanager
def logged(verbose: bool) -> Iterator[None]:
    """Take what the package logs until the end of the block.

    Parameters
    ----------
    verbose
        Whether all of it goes to standard error, and not only warnings.
    """
    _kept.clear()
    logger = logging.getLogger("firstcontact")
    handler = _Lines(logging.INFO if verbose else logging.WARNING)
    before = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(before)


def kept() -> tuple[str, ...]:
    """The last lines of the block, or of the last one."""
    return tuple(_kept)
