"""Text to a stream that may go away."""

from __future__ import annotations

import os
from contextlib import suppress
from typing import TextIO


def write_now(stream: TextIO, text: str) -> None:
    """Write and flush.

    Raises
    ------
    OSError
        Who listened is gone (BrokenPipeError), or it cannot be written. What waits in the
        stream is thrown away: it would raise again when the program ends.
    """
    try:
        stream.write(text)
        stream.flush()
    except OSError:
        with suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)
        raise
