"""Standard output and error of the command, as plain text."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO, cast

from firstcontact.core import ESCAPE_ERRORS, sanitize

#: Errors of an output whose reader or terminal is gone.
GONE = (errno.EPIPE, errno.EIO, errno.ENXIO, errno.EBADF)


class Output:
    r"""Text stream that escapes control characters."""

    def __init__(self, stream: TextIO, raises: bool = False) -> None:
        self.failed: OSError | None = None
        self._stream = stream
        self._raises = raises
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors=ESCAPE_ERRORS)

    def write(self, text: str) -> int:
        """Write plain text."""
        start = text[:1] if text.startswith("\r") else ""
        try:
            self._stream.write(start + sanitize(text[len(start) :]))
        except OSError as error:
            self._lost(error)
        return len(text)

    def flush(self) -> None:
        """Write buffered text."""
        try:
            self._stream.flush()
        except OSError as error:
            self._lost(error)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    @property
    def gone(self) -> bool:
        """True if the program that reads the stream has closed it."""
        return self.failed is not None and self.failed.errno in GONE

    def _lost(self, error: OSError) -> None:
        self.failed = self.failed or error
        # Buffered text would raise again when the program ends.
        with suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())
            os.close(nowhere)
        if self._raises:
            raise error


@contextmanager
def outputs(raises: bool = False) -> Iterator[tuple[Output, Output]]:
    """Send all printed text through an :class:`Output`."""
    former = sys.stdin, sys.stdout, sys.stderr
    # The next files that are opened would get the numbers of closed descriptors.
    stdin, stdout, stderr = (s or _nowhere(mode) for s, mode in zip(former, "rww", strict=True))
    out, err = Output(stdout, raises), Output(stderr)
    sys.stdin, sys.stdout, sys.stderr = stdin, cast(TextIO, out), cast(TextIO, err)
    try:
        yield out, err
    finally:
        err.flush()
        with suppress(OSError):
            out.flush()
        sys.stdin, sys.stdout, sys.stderr = former


def _nowhere(mode: str) -> TextIO:
    # It gets the lowest free number: 0, 1, 2 in this order, where one is closed.
    return cast(TextIO, open(os.devnull, mode, encoding="utf-8"))  # noqa: PTH123


def reader_gone() -> bool:
    """Return True if the program that reads standard output has closed it."""
    return isinstance(sys.stdout, Output) and sys.stdout.gone
