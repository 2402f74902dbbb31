"""Output of a command to its terminal or pipe, which may be closed at any time."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, TextIO, cast

from firstcontact.core.text import ESCAPE_ERRORS, sanitize

if TYPE_CHECKING:
    from firstcontact.core import Dataset

#: Errors of an output whose reader or terminal is gone.
GONE = (errno.EPIPE, errno.EIO, errno.ENXIO, errno.EBADF)


class Output:
    """Text stream that escapes control characters, and drops text once its reader has gone."""

    def __init__(self, stream: TextIO, raises: bool = False) -> None:
        self.failed: OSError | None = None
        self._stream = stream
        self._raises = raises
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors=ESCAPE_ERRORS)

    def write(self, text: str) -> int:
        start = text[:1] if text.startswith("\r") else ""
        with self._loss_noted():
            self._stream.write(start + sanitize(text[len(start) :]))
        return len(text)

    def flush(self) -> None:
        with self._loss_noted():
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    @property
    def gone(self) -> bool:
        """True if the program that reads the stream has closed it."""
        return self.failed is not None and self.failed.errno in GONE

    @contextmanager
    def _loss_noted(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            self.failed = self.failed or error
            # Buffered text would raise again when the program ends.
            with suppress(OSError, ValueError), _nowhere("w") as nowhere:
                os.dup2(nowhere.fileno(), self._stream.fileno())
            if self._raises:
                raise


@contextmanager
def outputs(raises: bool = False) -> Iterator[tuple[Output, Output]]:
    """Replace standard output and standard error by :class:`Output` within the ``with`` block.

    With ``raises``, writing to a closed standard output raises OSError.
    """
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
    return cast(TextIO, open(os.devnull, mode, encoding="utf-8"))  # noqa: PTH123


def reader_gone() -> bool:
    """Return True if the program that reads standard output has closed it."""
    return isinstance(sys.stdout, Output) and sys.stdout.gone


def print_losses(dataset: Dataset) -> None:
    """Print a warning for each part of the recordings that could not be loaded."""
    for sentence in dataset.losses:
        print(f"warning: {sentence}")
