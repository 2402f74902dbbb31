"""Standard output and error of the command: plain text, whoever reads it or not."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO, cast

from firstcontact.core import LACKING, plain

#: Whoever read this has had enough, or the terminal is closed.
GONE = (errno.EPIPE, errno.EIO, errno.ENXIO, errno.EBADF)


class Output:
    r"""A text stream through which no control characters go.

    Newlines and tabs pass, and a carriage return that begins what is written, as a progress bar
    does; all else becomes text such as ``\u001b``. When the stream cannot be written any more,
    what is written later goes nowhere.

    Parameters
    ----------
    stream
        Where to.
    raises
        Whether the first write that fails raises; otherwise ``failed`` says it, and whoever
        writes goes on.

    Attributes
    ----------
    failed
        Why it cannot be written; None while it can.
    """

    def __init__(self, stream: TextIO, raises: bool = False) -> None:
        self.failed: OSError | None = None
        self._stream = stream
        self._raises = raises
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors=LACKING)

    def write(self, text: str) -> int:
        """Write plain text."""
        start = text[:1] if text.startswith("\r") else ""
        try:
            self._stream.write(start + plain(text[len(start) :]))
        except OSError as error:
            self._lost(error)
        return len(text)

    def flush(self) -> None:
        """Write what waits."""
        try:
            self._stream.flush()
        except OSError as error:
            self._lost(error)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    @property
    def gone(self) -> bool:
        """Whether nobody reads it any more."""
        return self.failed is not None and self.failed.errno in GONE

    def _lost(self, error: OSError) -> None:
        self.failed = self.failed or error
        # What waits in the stream would raise again when the program ends.
        with suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())
            os.close(nowhere)
        if self._raises:
            raise error


@contextmanager
def outputs(raises: bool = False) -> Iterator[tuple[Output, Output]]:
    """Have all that is printed go through an :class:`Output`.

    Parameters
    ----------
    raises
        Of standard output; what cannot be said on standard error never raises.
    """
    before = sys.stdin, sys.stdout, sys.stderr
    # Descriptors that are closed would be those of the next files that are opened.
    stdin, stdout, stderr = (s or _nowhere(mode) for s, mode in zip(before, "rww", strict=True))
    out, err = Output(stdout, raises), Output(stderr)
    sys.stdin, sys.stdout, sys.stderr = stdin, cast(TextIO, out), cast(TextIO, err)
    try:
        yield out, err
    finally:
        err.flush()
        with suppress(OSError):
            out.flush()
        sys.stdin, sys.stdout, sys.stderr = before


def _nowhere(mode: str) -> TextIO:
    # The lowest number that is free: 0, 1, 2 in this order, where one is closed.
    return cast(TextIO, open(os.devnull, mode, encoding="utf-8"))  # noqa: PTH123


def reader_gone() -> bool:
    """Whether nobody reads standard output any more."""
    return isinstance(sys.stdout, Output) and sys.stdout.gone
