"""Report of an unexpected error: one sentence, and a crash log to send."""

from __future__ import annotations

import os
import platform
import shlex
import tempfile
import traceback
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from firstcontact import __version__
from firstcontact.cli.logs import last_lines
from firstcontact.core import one_line, sanitize

#: Options with secret values.
SECRET = ("--token",)


def crash_report(error: BaseException, arguments: Sequence[str]) -> str:
    """Write a crash log. Return a sentence with the error and the path of the log."""
    summary = one_line(f"{type(error).__name__}: {error}".removesuffix(": "))
    cause = "memory ran out" if isinstance(error, MemoryError) else "an unexpected error occurred"
    path = _write(_text(error, arguments))
    if path is None:
        return f"{cause} ({summary}), and its log cannot be written: report this line"
    return f"{cause} ({summary}): please report it, and attach {path}"


def _text(error: BaseException, arguments: Sequence[str]) -> str:
    command, secrets = _redacted(arguments)
    lines = [
        "Please report this with the steps that led to it; `firstcontact info` describes your",
        "machine. Read this log before you send it: it holds your paths and names.",
        "",
        f"firstcontact {__version__}",
        f"Python {platform.python_version()}, {platform.platform()}",
        f"at {datetime.now(UTC).isoformat(timespec='seconds')}",
        f"command: {command}",
        "",
    ]
    text = "\n".join(lines) + "\n" + "".join(traceback.format_exception(error))
    if last_lines():
        text += "\n".join(["", "Last lines of its log:", "", *last_lines(), ""])
    for secret in secrets:
        text = text.replace(secret, "***")
    return sanitize(text)


def _redacted(arguments: Sequence[str]) -> tuple[str, list[str]]:
    """Return the command line with its secrets hidden, and a list of these secrets."""
    words, secrets = [], []
    hide = False
    for word in arguments:
        name, equals, value = word.partition("=")
        if hide and word:
            secrets.append(word)
            word = "***"
        elif name.replace("_", "-") in SECRET and value:
            secrets.append(value)
            word = f"{name}=***"
        hide = word.replace("_", "-") in SECRET and not equals
        words.append(word)
    return shlex.join(["firstcontact", *words]), secrets


def _write(text: str) -> Path | None:
    """Write a crash log."""
    name = f"firstcontact-{datetime.now(UTC):%Y%m%dT%H%M%S.%fZ}-{os.getpid()}.log"
    for folder in (_state, lambda: Path(tempfile.gettempdir())):
        try:
            place = folder()
            place.mkdir(parents=True, exist_ok=True)
            path = place / name
            # Readable by the user alone, and not through a link of another user.
            number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            with os.fdopen(number, "w", encoding="utf-8") as stream:
                stream.write(text)
        except (OSError, RuntimeError):  # RuntimeError: no home folder
            continue
        return path
    return None


def _state() -> Path:
    given = os.environ.get("XDG_STATE_HOME", "")
    home = Path(given) if os.path.isabs(given) else Path.home() / ".local" / "state"  # noqa: PTH117
    return home / "firstcontact"
