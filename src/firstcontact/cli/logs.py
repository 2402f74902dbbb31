"""Log of the program: printed with ``--verbose``, and written to a file after a crash."""

from __future__ import annotations

import logging
import platform
import shlex
import sys
import tempfile
import time
import traceback
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from firstcontact import __version__
from firstcontact.core.text import one_line, sanitize, summarize_error

#: Option with a secret value.
SECRET = "--token"  # noqa: S105  # the option's name, no secret

#: Last lines of the log, for a crash log.
_lines: deque[str] = deque(maxlen=200)


class _Handler(logging.Handler):
    """Log handler that stores each record as a line of text.

    It also prints records of at least the level ``level_shown`` to standard error.
    """

    def __init__(self, level_shown: int) -> None:
        super().__init__()
        self._shown = level_shown
        self.formatter = logging.Formatter(
            "%(asctime)s.%(msecs)03dZ %(name)s: %(message)s", "%Y-%m-%dT%H:%M:%S"
        )
        self.formatter.converter = time.gmtime

    def emit(self, record: logging.LogRecord) -> None:
        line = one_line(self.format(record))
        _lines.append(line)
        if record.levelno >= self._shown:
            bars = sys.modules.get("tqdm")  # moves a progress bar below the line
            (bars.tqdm.write if bars else print)(line, file=sys.stderr)


@contextmanager
def logged(verbose: bool) -> Iterator[None]:
    """Keep the package's log records within the ``with`` block, and print them if ``verbose``.

    Warnings are always printed.
    """
    _lines.clear()
    logger = logging.getLogger("firstcontact")
    handler = _Handler(logging.INFO if verbose else logging.WARNING)
    former = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(former)


def crash_report(error: BaseException, arguments: Sequence[str]) -> str:
    """Write a crash log. Return a sentence with the error and the path of the log."""
    cause = "memory ran out" if isinstance(error, MemoryError) else "an unexpected error occurred"
    cause = f"{cause} ({one_line(summarize_error(error))})"
    text = (
        "Please report this with the steps that led to it; `firstcontact info` describes your\n"
        "machine. Read this log before you send it: it holds your paths and names.\n\n"
        f"firstcontact {__version__}\n"
        f"Python {platform.python_version()}, {platform.platform()}\n"
        f"command: {shlex.join(['firstcontact', *arguments])}\n\n"
        f"{''.join(traceback.format_exception(error))}"
    )
    if _lines:
        text += "\n".join(["\nLast lines of its log:\n", *_lines, ""])
    for word, following in zip(arguments, [*arguments[1:], ""], strict=True):
        option, _, value = word.partition("=")
        if option == SECRET and (secret := value or following):
            text = text.replace(secret, "***")
    try:
        # Only the user can read this file.
        with tempfile.NamedTemporaryFile(
            "w", encoding="utf-8", prefix="firstcontact-", suffix=".log", delete=False
        ) as stream:
            stream.write(sanitize(text))
    except OSError:
        return f"{cause}, and its log cannot be written: report this line"
    return f"{cause}: please report it, and attach {Path(stream.name)}"
